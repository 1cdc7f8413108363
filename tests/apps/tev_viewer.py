#!/usr/bin/env python3
"""Stands in for the viewer tev: reads its published protocol (github.com/Tom94/tev, README and src/Ipc.cpp), written
from that description alone and not from Glowworm's own code. Prints its port, takes one client, refuses what tev would
refuse, and at the end prints 'NAME WIDTH HEIGHT CREATED UPDATED CHANNELS...' and writes the channels as float32 rows.
usage: tev_viewer.py OUT_FILE"""
import socket
import struct
import sys

CREATE, UPDATE_V3 = 4, 6


class Fields:
    def __init__(self, payload):
        self.payload, self.at = payload, 0

    def take(self, kind, count=1):
        size = struct.calcsize("<" + kind * count)
        if self.at + size > len(self.payload):
            sys.exit("a packet ends early")
        values = struct.unpack_from("<" + kind * count, self.payload, self.at)
        self.at += size
        return values if count > 1 else values[0]

    def text(self):
        end = self.payload.index(b"\0", self.at)
        value = self.payload[self.at:end].decode()
        self.at = end + 1
        return value


def receive(client, count):
    data = b""
    while len(data) < count:
        more = client.recv(min(1 << 20, count - len(data)))
        if not more:
            return data
        data += more
    return data


def create(fields, images):
    fields.take("?")
    name = fields.text()
    width, height, count = fields.take("i", 3)
    channels = [fields.text() for _ in range(count)]
    if fields.at != len(fields.payload) or width < 1 or height < 1 or count < 1:
        sys.exit("CreateImage is not as published")
    images[name] = (width, height, {c: bytearray(4 * width * height) for c in channels})


def update(fields, images):
    fields.take("?")
    width, height, channels = images[fields.text()]
    count = fields.take("i")
    names = [fields.text() for _ in range(count)]
    x, y, w, h = fields.take("i", 4)
    offsets = [fields.take("q") for _ in range(count)]
    strides = [fields.take("q") for _ in range(count)]
    if x < 0 or y < 0 or x + w > width or y + h > height:
        sys.exit("UpdateImage reaches over the picture")
    floats = max(o + (w * h - 1) * s + 1 for o, s in zip(offsets, strides))
    if len(fields.payload) - fields.at != 4 * floats:
        sys.exit("UpdateImage carries another number of pixels than it says")
    data = struct.unpack_from("<%df" % floats, fields.payload, fields.at)
    for name, offset, stride in zip(names, offsets, strides):
        for row in range(h):
            first = offset + row * w * stride
            values = data[first:first + w * stride:stride]
            struct.pack_into("<%df" % w, channels[name], 4 * ((y + row) * width + x), *values)


def main():
    images, counts, last = {}, {CREATE: 0, UPDATE_V3: 0}, None
    server = socket.create_server(("127.0.0.1", 0))
    print(server.getsockname()[1], flush=True)
    client, _ = server.accept()
    while True:
        head = receive(client, 4)
        if not head:
            break
        # The length counts its own four bytes.
        payload = receive(client, struct.unpack("<I", head)[0] - 4)
        fields = Fields(payload)
        kind = fields.take("b")
        if kind not in counts:
            sys.exit("a packet of kind %d" % kind)
        (create if kind == CREATE else update)(fields, images)
        counts[kind] += 1
    (name, (width, height, channels)), = images.items()
    with open(sys.argv[1], "wb") as out:
        for samples in channels.values():
            out.write(samples)
    print(name, width, height, counts[CREATE], counts[UPDATE_V3], *channels)


main()
