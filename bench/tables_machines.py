#!/usr/bin/env python3
"""Measures one picture on many machines, and models more of them: bench/results/many-machines.md. As root, network
namespaces with addresses and folders of their own stand for machines; otherwise all ranks are on one. With `large`, it
renders what does not fit into a small memory instead, ten processor minutes with 45 GB of temporary files:
bench/results/many-machines-large.md. Figures go to bench/results/many-machines.json as they are measured, and a run
that was interrupted goes on from them.

usage: tables_machines.py [large] [PROGRAM]
"""
import json
import os
import pathlib
import platform
import re
import signal
import statistics
import subprocess
import sys
import tempfile
import time

from figures import processor_seconds

ROOT = pathlib.Path(__file__).resolve().parent.parent
IS_LARGE = sys.argv[1:2] == ["large"]
KEPT = ROOT / "bench/results/many-machines.json"
PROGRAM = pathlib.Path((sys.argv[1 + IS_LARGE:] or [ROOT / "build/release/bin/glowworm"])[0]).resolve()
SIZE, PIXELS = "320x180", 320 * 180
SHARED = ["render", "builtin:atrium", "--size", SIZE, "--precision", "float", "-q"]
FEW = ["--gather", "4", "--photons", "20k", "--threads", "1"]
MACHINES, TRAFFIC_SAMPLES = 3, 8
NODE_CORES, NETWORK = 32, 1.25e9  # of the model: cores, and bytes a second into rank 0
BIG_PIXELS, BIG_SAMPLES = 7680 * 4320, 1000  # 8K
BIG_SLOTS = BIG_PIXELS * BIG_SAMPLES
LARGE = (("100 million photons", 4000,
          ["--size", "64x64", "--gather", "4", "--photons", "100M", "--filter", "off", "-o", "a.exr"]),
         ("16384 x 16384 pixels", 2000,
          ["--size", "16384x16384", "--integrator", "photons", "--photons", "100k", "-o", "a.exr", "-o", "a.png"]))
AGENT = """#!/bin/bash
host=$1; shift
exec ip netns exec gwm$((${host##*.} - 1)) unshare -m -u bash -c \
  "hostname machine${host##*.}; mount -t tmpfs own /mnt; cd /mnt; $*"
"""


def run(arguments, **more):
    """Runs the program; returns its processor seconds."""
    before = processor_seconds()
    subprocess.run([PROGRAM, *arguments], check=True, **more)
    return processor_seconds() - before


def ip(words, check=True):
    subprocess.run(["ip", *words.split()], check=check, stderr=None if check else subprocess.DEVNULL)


def remove_machines():
    for i in range(MACHINES):
        ip(f"netns del gwm{i}", check=False)


def make_machines():
    """Namespaces gwm0 and so on, with the addresses 10.77.1.1 and so on, on one bridge."""
    remove_machines()
    ip("netns add gwm0")
    ip("-n gwm0 link set lo up")
    ip("-n gwm0 link add br0 type bridge")
    ip("-n gwm0 addr add 10.77.1.1/24 dev br0")
    ip("-n gwm0 link set br0 up")
    for i in range(1, MACHINES):
        ip(f"netns add gwm{i}")
        ip(f"link add gwp{i} netns gwm0 type veth peer name eth0 netns gwm{i}")
        ip(f"-n gwm0 link set gwp{i} master br0 up")
        ip(f"-n gwm{i} addr add 10.77.1.{i + 1}/24 dev eth0")
        ip(f"-n gwm{i} link set eth0 up")
        ip(f"-n gwm{i} link set lo up")


def mpirun(folder, ranks, arguments):
    """Starts the program as ranks, each on its own machine if there are any."""
    words = ["mpirun", "--allow-run-as-root", "--oversubscribe", "--bind-to", "none", "-n", str(ranks)]
    if os.geteuid() == 0:
        agent = folder / "agent"
        agent.write_text(AGENT, encoding="utf-8")
        agent.chmod(0o755)
        hosts = ",".join(f"10.77.1.{i + 1}:1" for i in range(ranks))
        words = ["ip", "netns", "exec", "gwm0", *words, "-H", hosts, "-wdir", str(folder), "--mca", "plm_rsh_agent",
                 str(agent), "--mca", "btl", "tcp,self", "--mca", "btl_tcp_if_include", "10.77.1.0/24", "--mca",
                 "oob_tcp_if_include", "10.77.1.0/24"]
    return subprocess.Popen([*words, str(PROGRAM), *arguments], cwd=folder, stderr=subprocess.DEVNULL)


def ranks_of(output):
    """Processes of a render by rank."""
    found = {}
    for entry in pathlib.Path("/proc").iterdir():
        try:
            if entry.name.isdigit() and (entry / "comm").read_text().strip() == "glowworm" and \
                    output.encode() in (entry / "cmdline").read_bytes():
                rank = re.search(rb"OMPI_COMM_WORLD_RANK=(\d+)", (entry / "environ").read_bytes())
                if rank:
                    found[int(rank[1])] = int(entry.name)
        except OSError:
            pass
    return found


def peak_megabytes(process):
    try:
        text = pathlib.Path(f"/proc/{process}/status").read_text(encoding="utf-8")
        return int(re.search(r"VmHWM:\s+(\d+)", text)[1]) / 1e3
    except (OSError, TypeError):
        return 0


def sent_bytes(machine):
    out = subprocess.run(["ip", "netns", "exec", f"gwm{machine}", "cat", "/sys/class/net/eth0/statistics/tx_bytes"],
                         capture_output=True, text=True, check=True)
    return int(out.stdout)


def part_of_atrium(folder, part, *more):
    """Arguments that render a part of 1280x720 pixels with 16 samples."""
    return ["render", "builtin:atrium", "--size", "1280x720", "--samples", "16", "--part", part, "-q", *more, "-o",
            folder / f"{part.replace('/', '-of-')}.part"]


def repeated_by_parts(folder):
    """Returns the processor seconds that each part of a render repeats but for film and files, without --share and
    with a folder that holds the photons: medians of parts with hardly any pixels, which have the photons of the whole
    picture."""
    few = ["--pixel-bounds", "0,0,16,16"]
    shared = [*few, "--share", folder / "share"]
    run(part_of_atrium(folder, "1/16", *shared))
    runs = [[run(part_of_atrium(folder, "1/16", *more)) for more in (few, shared)] for _ in range(3)]
    return [statistics.median(column) for column in zip(*runs)]


def efficiency(folder):
    """Returns the processor seconds of one render, and rows of the work efficiency of eight parts of it: how they run,
    that, and the size of the shared folder. The first part and two others are rendered, and stand for all; the one render
    is the mean of one before them and one after."""
    def one():
        return run(["render", "builtin:atrium", "--size", "1280x720", "--samples", "16", "-q", "-o", folder / "a.exr"])

    before, parts = one(), []
    for name, more in (("without `--share`", []), ("with `--share`", ["--share", folder / "share8"])):
        first, *others = (run(part_of_atrium(folder, f"{i}/8", *more)) for i in (1, 4, 8))
        size = sum(file.stat().st_size for file in pathlib.Path(more[1]).rglob("*.share")) if more else 0
        parts.append((name, first + 7 * statistics.mean(others), size))
    whole = (before + one()) / 2
    return whole, [(name, whole / seconds, size) for name, seconds, size in parts]


def traffic(folder):
    """Returns a row for each rank: bytes sent for a sample of a pixel, and peak megabytes."""
    peaks = {}
    before = [sent_bytes(i) for i in range(1, MACHINES)] if os.geteuid() == 0 else []
    job = mpirun(folder, MACHINES, [*SHARED, *FEW, "--samples", str(TRAFFIC_SAMPLES), "-o", "traffic.exr"])
    while job.poll() is None:
        for rank, process in ranks_of("traffic.exr").items():
            peaks[rank] = max(peaks.get(rank, 0), peak_megabytes(process))
        time.sleep(0.1)
    sent = [sent_bytes(i) - b for i, b in zip(range(1, MACHINES), before)]
    return [(rank, sent[rank - 1] / 1e6 if rank and sent else None, peaks[rank]) for rank in sorted(peaks)]


def measured(name, measure, *arguments):
    """What measure() returned in this run or an interrupted one."""
    kept = json.loads(KEPT.read_text(encoding="utf-8")) if KEPT.exists() else {}
    if name not in kept:
        print(f"{name} ...", flush=True)
        kept[name] = measure(*arguments)
        KEPT.write_text(json.dumps(kept, indent=1), encoding="utf-8")
    return kept[name]


def fault(folder, name, harm, heal=lambda rank: None):
    """Renders by ranks, of which rank 1 is harmed, and healed after the end. Returns mpirun's status, its seconds after
    that, and whether the picture, if need be after --resume, has the bits of one process."""
    arguments = [*SHARED, *FEW, "--samples", "64", "-o", f"{name}.exr", f"--resume={name}.checkpoint"]
    if not (folder / "alone.exr").exists():
        run([*SHARED, *FEW, "--samples", "64", "-o", folder / "alone.exr"])
    job = mpirun(folder, MACHINES, arguments)
    while 1 not in ranks_of(f"{name}.exr") or not (folder / f"{name}.checkpoint").exists():
        if job.poll() is not None:
            sys.exit(f"{name}: the render ended before its first checkpoint")
        time.sleep(0.1)
    start = time.monotonic()
    rank = ranks_of(f"{name}.exr")[1]
    harm(rank)
    while job.poll() is None and not (folder / f"{name}.exr").exists() and time.monotonic() < start + 900:
        time.sleep(0.1)
    seconds = time.monotonic() - start
    try:
        status = job.wait(120)
    except subprocess.TimeoutExpired:  # mpirun waits for the machine
        status = None
        job.kill()
        job.wait()
    for process in [rank, *ranks_of(f"{name}.exr").values()]:
        try:
            os.kill(process, signal.SIGKILL)
        except ProcessLookupError:
            pass
    heal(rank)
    if not (folder / f"{name}.exr").exists():
        run(arguments, cwd=folder)
    compared = subprocess.run([PROGRAM, "compare", folder / f"{name}.exr", folder / "alone.exr"], capture_output=True,
                              text=True, check=True).stdout
    return status, seconds, re.search(r"largest\s+0\n", compared) is not None


def faults(folder):
    """Returns rows of what fault() returns."""
    harms = [("killed (SIGKILL)", "killed", lambda rank: os.kill(rank, signal.SIGKILL)),
             ("stopped (SIGSTOP)", "stopped", lambda rank: os.kill(rank, signal.SIGSTOP))]
    if os.geteuid() == 0:
        harms.append(("cut off (link down)", "cut", lambda rank: ip("-n gwm0 link set gwp1 down"),
                      lambda rank: ip("-n gwm0 link set gwp1 up")))
    return [(name, measured(name, fault, folder, *harm)) for name, *harm in harms]


def full_disk(folder):
    """Renders with all files on a disk that is too small for them, and again with room. Returns rows: what is written,
    the first status, the message, and whether the second picture has the bits of one process."""
    if os.geteuid() != 0:
        return []
    rows = []
    disk = folder / "disk"
    disk.mkdir()
    few = [*SHARED, *FEW, "--samples", "8"]
    run([*few, "-o", folder / "few.exr"])
    for name, more, output in (("a picture, with `--resume`", [f"--resume={disk}/a.checkpoint"], "a.exr"),
                               ("a part", ["--part", "1/1"], "a.part"),
                               ("film and photons, with `--memory 60M`", ["--memory", "60M"], "a.exr")):
        render = [PROGRAM, *few, *more, "-o", disk / output]
        subprocess.run(["mount", "-t", "tmpfs", "-o", "size=200k", "small", disk], check=True)
        try:
            first = subprocess.run(render, capture_output=True, text=True, env={**os.environ, "TMPDIR": str(disk)},
                                   check=False)
            subprocess.run(["mount", "-o", "remount,size=2g", disk], check=True)
            run(render[1:], env={**os.environ, "TMPDIR": str(disk)})
            if output.endswith(".part"):
                run(["merge", disk / output, "-q", "-o", disk / "a.exr", "--precision", "float"])
            compared = subprocess.run([PROGRAM, "compare", disk / "a.exr", folder / "few.exr"], capture_output=True,
                                      text=True, check=True).stdout
        finally:
            subprocess.run(["umount", disk], check=True)
        message = next((line for line in first.stderr.splitlines() if str(disk) in line), "")
        rows.append((name, first.returncode, message.replace(str(disk), "/disk").strip(),
                     re.search(r"largest\s+0\n", compared) is not None))
    return rows


def film_bytes(folder):
    """Returns the bytes of a pixel in the film of a task of four samples."""
    run([*SHARED, *FEW, "--samples", "4", "--part", "1/1", "-o", folder / "film.part"])
    return (folder / "film.part").stat().st_size / PIXELS


def films_of(samples, most):
    """The films that ranks send for each tile: tasks double their samples up to the most."""
    films = done = 0
    while done < samples:
        done += min(max(done, 1), most)
        films += 1
    return films


def merge(folder):
    """Returns the seconds, peak megabytes and processor seconds of merging 2 and 16 parts of 3840 x 2160 pixels."""
    rows = []
    for i in range(1, 17):
        run(["render", "builtin:cornell", "--size", "3840x2160", "--samples", "16", "--integrator", "photons",
             "--photons", "20k", "--aov", "albedo,normal,depth,direct,indirect,position,object-id", "--part", f"{i}/16",
             "-q", "-o", folder / f"{i}.part"])
    for count in (2, 16):
        parts = [str(folder / f"{i + 1}.part") for i in range(count)]
        out = subprocess.run(["/usr/bin/time", "-f", "%e %M %U %S", PROGRAM, "merge", *parts, "-q", "-o",
                              folder / "merged.exr"], capture_output=True, text=True, check=True).stderr.split()
        rows.append((count, float(out[-4]), float(out[-3]) / 1e3, float(out[-2]) + float(out[-1])))
    return rows


def text_of(repeated, efficient, rows, film, faulty, full, merged):
    """@param repeated processor seconds that parts repeat, without and with --share
    @param film bytes of a pixel in a film"""
    parts, shared = repeated
    whole, eight = efficient
    each = (whole - parts) / (1280 * 720 * 16)

    def seconds(again, nodes):
        return (again + each * BIG_SLOTS / nodes) / NODE_CORES

    films = films_of(BIG_SAMPLES, BIG_SAMPLES // 4)
    receiving = BIG_PIXELS * films * film / NETWORK
    adding = BIG_PIXELS * films / NODE_CORES * (merged[1][3] - merged[0][3]) / (merged[1][0] - merged[0][0]) / (3840 * 2160)
    one = seconds(parts, 1)
    big = [(n, seconds(parts, n), max(receiving, adding) if n > 1 else 0, seconds(shared, n))
           for n in (1, 16, 256, 4096)]
    lines = [
        "# One picture on many machines", "",
        f"Written by `bench/tables_machines.py` on {platform.machine()}, {os.cpu_count()} cores.", "",
        "## Parts", "",
        f"Each part repeats {parts:.2f} processor seconds (loading, photons, map, guides), and with `--share` "
        f"{shared:.2f}, where the folder holds the photons; film and files come on top. A sample of a pixel of the "
        f"atrium takes {each * 1e6:.1f} us. One render of 1280x720 pixels with 16 samples, and eight parts of it:", "",
        "| eight parts, one after another | one render's processor seconds over those of all parts | MB in the folder |",
        "| --- | ---: | ---: |",
        *(f"| {name} | {share:.2f} | {f'{size / 1e6:.0f}' if size else ''} |" for name, share, size in eight), "",
        "| parts of 3840x2160 pixels merged, with 7 layers | s | MB | processor s |", "| ---: | ---: | ---: | ---: |",
        *(f"| {n} | {s:.1f} | {m:.0f} | {cpu:.1f} |" for n, s, m, cpu in merged), "",
        "`merge` holds one film and blocks of a part, so its memory does not grow with the parts.", "",
        "## Ranks", "",
        f"{MACHINES} ranks, atrium, {SIZE}, {TRAFFIC_SAMPLES} samples. Photons are not sent: without `--share`, each rank "
        "traces all.", "",
        "| rank | MB sent | peak MB |", "| ---: | ---: | ---: |",
        *(f"| {r} | {'' if sent is None else f'{sent:.1f}'} | {peak:.0f} |" for r, sent, peak in rows), "",
        f"A task is sent as the sums of its samples, compressed: {film:.0f} bytes for a pixel of the atrium, whatever "
        f"the number of samples. All tasks of one sample would be {PIXELS * TRAFFIC_SAMPLES * film / 1e6:.1f} MB here.", "",
        "## Faults", "",
        "| rank 1 of 3 is | status of mpirun | s until the picture is there, or mpirun ends | same bits, by --resume if "
        "it did not finish |",
        "| --- | ---: | ---: | --- |",
        *(f"| {name} | {'none within 120 s' if status is None else status} | {s:.0f} | "
          f"{'yes' if same else 'no'} |" for name, (status, s, same) in faulty), "",
        "| on a full disk | status | first message | same bits when there is room |",
        "| --- | ---: | --- | --- |",
        *(f"| {name} | {status} | {message} | {'yes' if same else 'no'} |" for name, status, message, same in full), "",
        "## Model", "",
        f"A picture of 7680x4320 pixels with 1000 samples, on nodes of {NODE_CORES} such cores, and a network that "
        f"brings {NETWORK / 1e9:.2f} GB/s to rank 0:", "",
        "| nodes | computing, s | rank 0's films, s | ranks, efficiency | parts, efficiency | with `--share` |",
        "| ---: | ---: | ---: | ---: | ---: | ---: |",
        *(f"| {n} | {c:.0f} | {r:.0f} | {one / n / max(c, r):.2f} | {one / n / c:.2f} | {one / n / s:.2f} |"
          for n, c, r, s in big), "",
        f"Ranks send {films} films of each tile, whose tasks double their samples up to a quarter of all. Rank 0 "
        f"receives them in {receiving:.0f} s, and adds them on {NODE_CORES} cores in {adding:.0f} s, if a pixel takes as "
        f"long as in a merge. So ranks stop scaling at {one / max(receiving, adding):.0f} nodes; collecting films in a "
        "tree would move that point. Parts send nothing; what they "
        "repeat bounds them, and merging, which a tree of `merge -o x.part` divides. With `--share`, each part reads "
        f"{eight[1][2] / 1e6:.0f} MB more: {4096 * eight[1][2] / 1e9:.0f} GB in all for 4096 nodes, which the server "
        "of the folder must bring.", ""]
    return "\n".join(lines)


def large(folder):
    """Returns rows of renders larger than their memory: name, --memory and peak megabytes, the most gigabytes in
    temporary files, processor and wall seconds."""
    rows = []
    for name, megabytes, arguments in LARGE:
        start = time.monotonic()
        job = subprocess.Popen(["nice", PROGRAM, "render", "builtin:cornell", "--samples", "1", *arguments, "--memory",
                                f"{megabytes}M", "-q", "--stats", "a.json"], cwd=folder)
        _, status, used = os.wait4(job.pid, 0)
        if status:
            sys.exit(f"{name}: failed")
        on_disk = json.loads((folder / "a.json").read_text(encoding="utf-8"))["memory_bytes"]["on_disk"]
        rows.append((name, megabytes, used.ru_maxrss * 1024 / 1e6, on_disk / 1e9, used.ru_utime + used.ru_stime,
                     time.monotonic() - start))
    return rows


def text_of_large(rows):
    return "\n".join([
        "# Renders larger than their memory", "",
        f"Written by `bench/tables_machines.py large` on {platform.machine()}, {os.cpu_count()} cores. `--memory` limits "
        "the scene, and what the render holds beside it.", "",
        "| Cornell box, one sample | `--memory`, MB | peak MB of the process | GB in files | processor s | s |",
        "| --- | ---: | ---: | ---: | ---: | ---: |",
        *(f"| {name} | {memory} | {peak:.0f} | {disk:.1f} | {cpu:.0f} | {wall:.0f} |"
          for name, memory, peak, disk, cpu, wall in rows), ""])


def main():
    if IS_LARGE:
        with tempfile.TemporaryDirectory() as name:
            text = text_of_large(large(pathlib.Path(name)))
        (ROOT / "bench/results/many-machines-large.md").write_text(text, encoding="utf-8")
        return
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        if os.geteuid() == 0:
            make_machines()
        try:
            rows = measured("traffic", traffic, folder)
            film = measured("film", film_bytes, folder)
            faulty = faults(folder)
            full = measured("full disk", full_disk, folder)
            merged = measured("merge", merge, folder)
            repeated = measured("repeated", repeated_by_parts, folder)
            eight = measured("efficiency", efficiency, folder)
        finally:
            if os.geteuid() == 0:
                remove_machines()
    out = ROOT / "bench/results/many-machines.md"
    out.write_text(text_of(repeated, eight, rows, film, faulty, full, merged), encoding="utf-8")
    KEPT.unlink()


if __name__ == "__main__":
    main()
