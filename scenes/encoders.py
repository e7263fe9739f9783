"""Encoders of compressed meshes (Draco, meshopt) and of textures (KTX2, DDS, BCn, UASTC)."""

import struct
import zlib

from gltf_writer import png_file, stored


# Compressed meshes: each encoder writes the simplest form of its format, with every number in full.

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


# Files of textures as GPUs store them, and WebP, from texels: each encoder writes one simple form of its
# format exactly, so that what is decoded is known to the last bit.

class BitWriter:
    """Bits from the lowest of the first byte upwards."""

    def __init__(self):
        self.value, self.count = 0, 0

    def put(self, value, count):
        self.value |= value << self.count
        self.count += count
        return self

    def put_code(self, word, count):
        """The highest bit first, as prefix codes are written."""
        for i in reversed(range(count)):
            self.put(word >> i & 1, 1)

    def bytes(self, size=None):
        return self.value.to_bytes(size or (self.count + 7) // 8, "little")


# Blocks of 4 x 4 texels have two colors: a list of (first color, second color, 16 bits: which of them).


def wide(value, bits):
    """A number of 5 or 6 bits as the nearest one of 8."""
    most = (1 << bits) - 1
    return (510 * value + most) // (2 * most)


def color565(color):
    narrow = lambda value, most: (2 * most * value + 255) // 510
    return narrow(color[0], 31) << 11 | narrow(color[1], 63) << 5 | narrow(color[2], 31)


def bc1_block(first, second, bits, alphas=None):
    """With `alphas`, texels of alpha 0 are left out: black, as the format has it."""
    a, b = color565(first), color565(second)
    if (a < b) != (alphas is not None and 0 in alphas):
        a, b, bits = b, a, [1 - bit for bit in bits]
    codes = [3 if alphas and alpha == 0 else bit for bit, alpha in zip(bits, alphas or [255] * 16)]
    return struct.pack("<HHI", a, b, sum(code << 2 * i for i, code in enumerate(codes)))


def bc4_block(values):
    """Of at most two values."""
    high, low = max(values), min(values)
    codes = sum((0 if value == high else 1) << 3 * i for i, value in enumerate(values))
    return bytes((high, low)) + codes.to_bytes(6, "little")


def bc2_block(first, second, bits, alphas):
    return sum(alpha >> 4 << 4 * i for i, alpha in enumerate(alphas)).to_bytes(8, "little") + bc1_block(
        first, second, bits)


def bc3_block(first, second, bits, alphas):
    return bc4_block(alphas) + bc1_block(first, second, bits)


def bc7_block(first, second, bits):
    """Mode 6: colors of odd numbers, opaque."""
    if bits[0]:
        first, second, bits = second, first, [1 - bit for bit in bits]
    writer = BitWriter().put(0x40, 7)
    for channel in range(4):
        for color in (first, second):
            writer.put((tuple(color) + (255,))[channel] >> 1, 7)
    writer.put(3, 2)
    for i, bit in enumerate(bits):
        writer.put(15 * bit, 3 if i == 0 else 4)
    return writer.bytes(16)


def uastc_block(first, second, bits):
    """Mode 1: two colors of 8 bits a channel, weights of 2 bits. Hints for other formats are left 0."""
    if bits[0]:
        first, second, bits = second, first, [1 - bit for bit in bits]
    writer = BitWriter().put(0b110101, 6).put(0, 15)
    for channel in range(3):
        for color in (first, second):
            writer.put(color[channel], 8)
    for i, bit in enumerate(bits):
        writer.put(3 * bit, 1 if i == 0 else 2)
    return writer.bytes(16)


def dds(size, texels, four_cc=b"", dxgi=0, masks=(0xFF, 0xFF00, 0xFF0000, 0xFF000000)):
    """A square texture: named by four letters, by DirectX's number, or plain by the masks of 32 bits."""
    name = b"DX10" if dxgi else four_cc
    kind = struct.pack("<II4s5I", 32, 4, name, 0, 0, 0, 0, 0) if name else struct.pack(
        "<8I", 32, 0x41, 0, 32, *masks)
    header = b"DDS " + struct.pack("<4I56x", 124, 0x1007, size, size) + kind + struct.pack("<I16x", 0x1000)
    return header + (struct.pack("<5I", dxgi, 3, 0, 1, 0) if dxgi else b"") + texels


def zstd(data):
    """A frame of Zstandard of one block, not compressed; less than 64 KiB."""
    size = struct.pack("<BH", 0x60, len(data) - 256)
    return b"\x28\xb5\x2f\xfd" + size + (len(data) << 3 | 1).to_bytes(3, "little") + data


ETC1S, UASTC = 163, 166  # color models without a Vulkan format


def ktx2(size, level, vk_format=0, model=1, samples=((0, 0, 8), (1, 8, 8), (2, 16, 8), (15, 24, 8)),
         block=(1, 1, 4), supercompression=0, global_data=b""):
    """A square texture. `samples`: channel, offset and length in bits; `block`: width and height in texels,
    bytes. Supercompression: 1 BasisLZ, 2 Zstandard."""
    is_blocks = block[0] > 1
    descriptor = struct.pack("<II", 0, 2 | 24 + 16 * len(samples) << 16)
    descriptor += struct.pack("<BBBB", model, 1, 2, 0)  # BT.709, sRGB, straight alpha
    descriptor += bytes((block[0] - 1, block[1] - 1, 0, 0, 0 if supercompression else block[2])) + bytes(7)
    for channel, offset, length in samples:
        upper = 0xFFFFFFFF if is_blocks else (1 << length) - 1
        # Alpha is never sRGB.
        linear = 0x10 if channel == 15 else 0
        descriptor += struct.pack("<HBBIII", offset, length - 1, channel | linear, 0, 0, upper)
    descriptor = struct.pack("<I", len(descriptor) + 4) + descriptor
    global_at = 104 + len(descriptor)
    global_at += -global_at % 8
    level_at = global_at + len(global_data)
    level_at += -level_at % 16
    inflated = 0 if supercompression == 1 else len(level)
    stored_level = zstd(level) if supercompression == 2 else level
    head = b"\xabKTX 20\xbb\r\n\x1a\n" + struct.pack(
        "<9I", vk_format, 1, size, size, 0, 0, 1, 1, supercompression)
    head += struct.pack("<4I2Q", 104, len(descriptor), 0, 0, global_at if global_data else 0,
                        len(global_data))
    head += struct.pack("<3Q", level_at, len(stored_level), inflated) + descriptor
    head = head.ljust(global_at, b"\0") + global_data
    return head.ljust(level_at, b"\0") + stored_level


class PrefixCode:
    """All symbols by nearly the same number of bits; canonical."""

    def __init__(self, count):
        longest = max(1, (count - 1).bit_length())
        short = (1 << longest) - count
        self.lengths = [longest - 1 if i < short and longest > 1 else longest for i in range(count)]
        self.words, word = [0] * count, 0
        for length in range(1, longest + 1):
            for i in range(count):
                if self.lengths[i] == length:
                    self.words[i] = word
                    word += 1
            word <<= 1

    def put(self, writer, symbol):
        writer.put_code(self.words[symbol], self.lengths[symbol])

    def put_table(self, writer):
        lengths = PrefixCode(21)
        writer.put(len(self.lengths), 14).put(21, 5)
        for symbol in (17, 18, 19, 20, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15, 16):
            writer.put(lengths.lengths[symbol], 3)
        for length in self.lengths:
            lengths.put(writer, length)


# The largest of ETC1's modifiers of brightness, by the table's number.
MODIFIERS = (8, 17, 29, 42, 60, 80, 106, 183)


def etc1s(size, blocks):
    """A square texture in BasisLZ. `blocks`: (color of 5 bits a channel, table, 16 bits: brighter or darker
    by the table's largest modifier). Every block has a color and a pattern of its own."""
    plain = PrefixCode(32)
    colors = BitWriter()
    for code in (plain, plain, plain, PrefixCode(8)):
        code.put_table(colors)
    colors.put(0, 1)
    last, last_table = (16, 16, 16), 0
    for color, table, _ in blocks:
        PrefixCode(8).put(colors, table - last_table & 7)
        for now, before in zip(color, last):
            plain.put(colors, now - before & 31)
        last, last_table = color, table
    patterns = BitWriter().put(0, 2).put(1, 1)
    for _, _, bits in blocks:
        for i, bit in enumerate(bits):
            patterns.put(3 * bit, 2)
    history = 64
    codes = predictions, steps, places, runs = [PrefixCode(count) for count in (
        257, len(blocks), len(blocks) + history + 1, 64)]
    tables = BitWriter()
    for code in codes:
        code.put_table(tables)
    tables.put(history, 13)
    across = size // 4
    level = BitWriter()
    last = 0
    for block in range(len(blocks)):
        if block % across % 2 == 0 and block // across % 2 == 0:
            predictions.put(level, 255)  # none of the four is predicted by a neighbor
        steps.put(level, (block - last) % len(blocks))
        places.put(level, block)
        last = block
    parts = [part.bytes() for part in (colors, patterns, tables)]
    head = struct.pack("<HH4I", len(blocks), len(blocks), *map(len, parts), 0)
    image = struct.pack("<5I", 0, 0, len(level.bytes()), 0, 0)
    return ktx2(size, level.bytes(), model=ETC1S, samples=((0, 0, 64),), block=(4, 4, 0), supercompression=1,
                global_data=head + image + b"".join(parts))


def webp(rows):
    """Lossless WebP of RGBA texels: every channel by a code whose words all have 8 bits."""
    writer = BitWriter().put(0x2F, 8).put(len(rows[0]) - 1, 14).put(len(rows) - 1, 14).put(1, 1).put(0, 3)
    writer.put(0, 3)  # no transforms, no cache of colors, one set of codes
    for _ in range(4):  # green, red, blue, alpha: 256 words of length 8, and no lengths of runs
        writer.put(0, 1).put(8, 4)
        for symbol in (17, 18, 0, 1, 2, 3, 4, 5, 16, 6, 7, 8):
            writer.put(1 if symbol == 8 else 0, 3)
        writer.put(1, 1).put(3, 3).put(256 - 2, 8)
    writer.put(1, 1).put(0, 3)  # distances: none
    for row in rows:
        for texel in row:
            for channel in (1, 0, 2, 3):
                writer.put_code(texel[channel], 8)
    data = writer.bytes()
    data += bytes(len(data) % 2)
    return b"RIFF" + struct.pack("<I", 12 + len(data)) + b"WEBPVP8L" + struct.pack("<I", len(data)) + data


def png_palette(rows):
    colors = sorted({texel[:3] for row in rows for texel in row})
    raw = b"".join(b"\0" + bytes(colors.index(texel[:3]) for texel in row) for row in rows)
    plain = png_file(struct.pack(">IIBBBBB", len(rows[0]), len(rows), 8, 3, 0, 0, 0), stored(raw))
    table = b"PLTE" + bytes(channel for color in colors for channel in color)
    chunk = struct.pack(">I", len(table) - 4) + table + struct.pack(">I", zlib.crc32(table))
    at = plain.index(b"IDAT") - 4
    return plain[:at] + chunk + plain[at:]


def png_wide(rows):
    """16 bits a channel, RGBA, each byte twice."""
    raw = b"".join(b"\0" + bytes(c for texel in row for c in texel for _ in range(2)) for row in rows)
    return png_file(struct.pack(">IIBBBBB", len(rows[0]), len(rows), 16, 6, 0, 0, 0), stored(raw))
