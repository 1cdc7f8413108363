"""Cryptomatte's names and metadata (Friedman and Jones, "Fully Automatic ID Mattes with Support for Motion Blur and
Transparency", 2015; "Cryptomatte Specification", 1.2.0)."""


def _rotated(value, bits):
    return ((value << bits) | (value >> (32 - bits))) & 0xffffffff


def murmur3(data):
    """MurmurHash3_x86_32 of bytes, with the seed 0."""
    value, whole = 0, len(data) // 4 * 4
    for at in range(0, whole, 4):
        word = int.from_bytes(data[at:at + 4], 'little') * 0xcc9e2d51 & 0xffffffff
        value ^= _rotated(word, 15) * 0x1b873593 & 0xffffffff
        value = (_rotated(value, 13) * 5 + 0xe6546b64) & 0xffffffff
    if whole < len(data):
        word = int.from_bytes(data[whole:], 'little') * 0xcc9e2d51 & 0xffffffff
        value ^= _rotated(word, 15) * 0x1b873593 & 0xffffffff
    value ^= len(data)
    for shift, factor in ((16, 0x85ebca6b), (13, 0xc2b2ae35)):
        value = (value ^ (value >> shift)) * factor & 0xffffffff
    return value ^ (value >> 16)


def renamed(texts, layer):
    """The metadata of a file for a render layer: Blender looks mattes up by the layer's name and the pass's."""
    keys = {key.split('/')[1] for key in texts if key.startswith('cryptomatte/')}
    out = {}
    for key in keys:
        name = f'{layer}.{texts[f"cryptomatte/{key}/name"]}'
        new = f'cryptomatte/{murmur3(name.encode()):08x}'[:len('cryptomatte/') + 7]
        out[f'{new}/name'] = name
        for item in ('hash', 'conversion', 'manifest'):
            out[f'{new}/{item}'] = texts[f'cryptomatte/{key}/{item}']
    return out
