"""The EXR files that Glowworm writes, and small ones that it reads (OpenEXR's 'Technical Introduction' and
'OpenEXR File Layout'). Blender has no function that gives a script the layers of a file."""
import struct
import zlib

import numpy

_TYPES = {0: '<u4', 1: '<f2', 2: '<f4'}


def _text(data, at):
    end = data.index(0, at)
    return data[at:end].decode(), end + 1


def _attributes(data):
    """The attributes of the header as (type, bytes), and the offset after them."""
    found, at = {}, 8
    while data[at]:
        name, at = _text(data, at)
        kind, at = _text(data, at)
        size, = struct.unpack_from('<i', data, at)
        found[name] = kind, data[at + 4:at + 4 + size]
        at += 4 + size
    return found, at + 1


def _channels(data):
    """The name and the type of each channel, in the order of the file."""
    found, at = [], 0
    while data[at]:
        name, at = _text(data, at)
        found.append((name, _TYPES[struct.unpack_from('<i', data, at)[0]]))
        at += 16
    return found


def _unzipped(data, size):
    """Undoes ZIP compression: deflate, then differences, then two interleaved halves."""
    if len(data) == size:
        return data
    steps = numpy.frombuffer(zlib.decompress(data), 'u1').astype('i8')
    steps[1:] -= 128
    values = (numpy.cumsum(steps) & 255).astype('u1')
    out = numpy.empty(size, 'u1')
    half = (size + 1) // 2
    out[0::2], out[1::2] = values[:half], values[half:]
    return out.tobytes()


def read(path):
    """Reads a file of scan lines, not compressed or by ZIP.

    Returns the channels as a dictionary of float32 arrays (height x width, first row on top), and the attributes of type
    string.
    """
    with open(path, 'rb') as file:
        data = file.read()
    attributes, at = _attributes(data)
    compression = attributes['compression'][1][0]
    lines_of_block = {0: 1, 2: 1, 3: 16}.get(compression)
    if lines_of_block is None:
        raise ValueError(f'{path}: compression {compression} is not supported')
    x0, y0, x1, y1 = struct.unpack('<4i', attributes['dataWindow'][1])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    channels = _channels(attributes['channels'][1])
    bytes_of_line = sum(numpy.dtype(kind).itemsize for _, kind in channels) * width
    out = {name: numpy.empty((height, width), 'f4') for name, _ in channels}
    blocks = (height + lines_of_block - 1) // lines_of_block
    for offset in struct.unpack_from(f'<{blocks}Q', data, at):
        line, size = struct.unpack_from('<2i', data, offset)
        first = line - y0
        count = min(lines_of_block, height - first)
        block = data[offset + 8:offset + 8 + size]
        if compression:
            block = _unzipped(block, bytes_of_line * count)
        place = 0
        for row in range(first, first + count):
            for name, kind in channels:
                out[name][row] = numpy.frombuffer(block, kind, width, place)
                place += numpy.dtype(kind).itemsize * width
    texts = {name: value.decode() for name, (kind, value) in attributes.items() if kind == 'string'}
    return out, texts


def write(path, pixels):
    """Writes height x width x 3 float32 values, first row on top, without compression."""
    height, width = pixels.shape[:2]

    def attribute(name, kind, value):
        return name.encode() + b'\0' + kind.encode() + b'\0' + struct.pack('<i', len(value)) + value

    window = struct.pack('<4i', 0, 0, width - 1, height - 1)
    names = b''.join(name + b'\0' + struct.pack('<iiii', 2, 0, 1, 1) for name in (b'B', b'G', b'R'))
    header = struct.pack('<ii', 20000630, 2) + attribute('channels', 'chlist', names + b'\0')
    header += attribute('compression', 'compression', b'\0') + attribute('lineOrder', 'lineOrder', b'\0')
    header += attribute('dataWindow', 'box2i', window) + attribute('displayWindow', 'box2i', window)
    header += attribute('pixelAspectRatio', 'float', struct.pack('<f', 1))
    header += attribute('screenWindowCenter', 'v2f', struct.pack('<2f', 0, 0))
    header += attribute('screenWindowWidth', 'float', struct.pack('<f', 1)) + b'\0'
    start, step = len(header) + 8 * height, 8 + 12 * width
    with open(path, 'wb') as file:
        file.write(header + struct.pack(f'<{height}Q', *(start + y * step for y in range(height))))
        for y in range(height):
            row = numpy.ascontiguousarray(pixels[y, :, ::-1].T, '<f4')
            file.write(struct.pack('<2i', y, 12 * width) + row.tobytes())
