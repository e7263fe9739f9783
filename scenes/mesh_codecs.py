"""Compressed meshes: each encoder writes the simplest form of its format, with every number in full."""

import struct


def zigzag(value):
    return value * 2 if value >= 0 else -value * 2 - 1


def varint(value):
    data = bytearray()
    while value > 127:
        data.append(value & 127 | 128)
        value >>= 7
    return bytes(data + bytes((value,)))


def meshopt_attributes(data, stride):
    """Version 0 of meshoptimizer's codec of vertices: byte by byte, differences to the vertex before, in
    groups of 16 of 8 bits each, or none where all are 0."""
    vertices = [data[i:i + stride] for i in range(0, len(data), stride)]
    last = vertices[0]
    result = bytearray((0xA0,))
    size = min(256, 8192 // stride & ~15)
    for start in range(0, len(vertices), size):
        block = vertices[start:start + size]
        groups = (len(block) + 15) // 16
        for k in range(stride):
            changes, before = [], last[k]
            for vertex in block:
                change = (vertex[k] - before + 128) % 256 - 128
                changes.append(zigzag(change))
                before = vertex[k]
            changes += [0] * (16 * groups - len(changes))
            parts = [bytes(changes[16 * g:16 * g + 16]) for g in range(groups)]
            header = bytearray((groups + 3) // 4)
            for g, part in enumerate(parts):
                header[g // 4] |= (3 if any(part) else 0) << 2 * (g % 4)
            result += header + b"".join(part for part in parts if any(part))
        last = block[-1]
    return bytes(result) + bytes(max(0, 32 - stride)) + vertices[0]


def meshopt_triangles(indices):
    """Version 1 of meshoptimizer's codec of triangles: every index as the difference to the one before."""
    result, last = bytearray((0xE1,)), 0
    result += b"\xff" * (len(indices) // 3)
    for i, index in enumerate(indices):
        if i % 3 == 0:
            result.append(0xFF)
        result += varint(zigzag(index - last))
        last = index
    return bytes(result + bytes(16))


DRACO_FLOAT, DRACO_POSITION, DRACO_NORMAL, DRACO_TEXCOORD = 9, 0, 1, 3


def draco(triangles, attributes):
    """Version 2.2, sequential: indices and values as they are. `attributes`: (kind, rows of floats); the
    place in the list is the id. Less than 256 vertices."""
    count = len(attributes[0][1])
    data = b"DRACO" + bytes((2, 2, 1, 0, 0, 0)) + varint(len(triangles)) + varint(count) + b"\x01"
    data += bytes(index for triangle in triangles for index in triangle) + bytes((1, len(attributes)))
    for i, (kind, rows) in enumerate(attributes):
        data += bytes((kind, DRACO_FLOAT, len(rows[0]), 0, i))
    data += bytes(len(attributes))  # how each is encoded: generic
    return data + b"".join(struct.pack(f"<{len(row)}f", *row) for _, rows in attributes for row in rows)
