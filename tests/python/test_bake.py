"""bake(): scenes with their light in textures."""
import json
import struct
import subprocess

import pytest

import glowworm

QUICK = dict(atlas=64, samples=1, gather=4, photons=5000, progress=False)


def document(path):
    """The JSON of a GLB file."""
    content = path.read_bytes()
    assert content[:4] == b"glTF"
    (size,) = struct.unpack_from("<I", content, 12)
    return json.loads(content[20 : 20 + size])


def test_bakes_as_the_command_line_does(program, cornell, tmp_path):
    glowworm.bake(cornell, tmp_path / "ours.glb", **QUICK)
    words = "--atlas 64 --samples 1 --gather 4 --photons 5000 -q -o theirs.glb".split()
    subprocess.run([program, "bake", "builtin:cornell", *words], cwd=tmp_path, check=True)
    ours, theirs = document(tmp_path / "ours.glb"), document(tmp_path / "theirs.glb")
    for file in (ours, theirs):
        del file["asset"]["extras"]["glowworm"]["command"]
    assert ours == theirs
    size = ours["buffers"][0]["byteLength"]
    assert (tmp_path / "ours.glb").read_bytes()[-size:] == (tmp_path / "theirs.glb").read_bytes()[-size:]


def test_writes_every_format(cornell, tmp_path):
    shares = []
    for format in ("unlit", "lightmap", "vertex"):
        glowworm.bake(cornell, tmp_path / "a.glb", format=format, **{**QUICK, "progress": shares.append})
        primitives = [p for mesh in document(tmp_path / "a.glb")["meshes"] for p in mesh["primitives"]]
        light = "COLOR_0" if format == "vertex" else "TEXCOORD_1"
        assert any(light in primitive["attributes"] for primitive in primitives)
    assert all(0 <= share <= 1 for share in shares)


def test_refuses_what_makes_no_sense(cornell, tmp_path):
    for match, options in [
        ("probes", dict(format="probes")),
        ("direct", dict(light="direct")),
        ("atlas is 7", dict(atlas=7)),
        ("texels_per_metre", dict(texels_per_metre=-1)),
    ]:
        with pytest.raises(glowworm.Error, match=match):
            glowworm.bake(cornell, tmp_path / "a.glb", **{**QUICK, **options})
    with pytest.raises(glowworm.Error, match="missing"):
        glowworm.bake(cornell, tmp_path / "missing" / "a.glb", **QUICK)
    assert list(tmp_path.iterdir()) == []
