"""relMSE of a picture against another, by numpy alone: `error_of.py REFERENCE.exr PICTURE.exr...`."""
import struct
import sys
import zlib

import numpy


def read_planes(path):
    """The channels of a scanline OpenEXR file, uncompressed or ZIP, by name."""
    data = open(path, "rb").read()
    at, header = 8, {}
    while data[at]:
        name, kind, rest = data[at:].split(b"\0", 2)
        at += len(name) + len(kind) + 2
        size = struct.unpack_from("<I", data, at)[0]
        header[name.decode()] = data[at + 4 : at + 4 + size]
        at += 4 + size
    at += 1
    channels, rest = [], header["channels"]
    while rest[0]:
        name, rest = rest.split(b"\0", 1)
        channels.append((name.decode(), struct.unpack_from("<I", rest)[0]))
        rest = rest[16:]
    x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    lines = {0: 1, 2: 1, 3: 16}[header["compression"][0]]
    types = {0: "<u4", 1: "<f2", 2: "<f4"}
    row_size = sum(numpy.dtype(types[kind]).itemsize for _, kind in channels) * width
    planes = {name: numpy.zeros((height, width)) for name, _ in channels}
    for offset in struct.unpack_from(f"<{-(-height // lines)}Q", data, at):
        y, size = struct.unpack_from("<ii", data, offset)
        count = min(lines, height - (y - y0))
        block = data[offset + 8 : offset + 8 + size]
        if size < row_size * count:
            deltas = numpy.frombuffer(zlib.decompress(block), numpy.uint8).astype(numpy.int64)
            deltas[1:] -= 128
            halves = (numpy.cumsum(deltas) & 255).astype(numpy.uint8)
            middle = (len(halves) + 1) // 2
            whole = numpy.empty_like(halves)
            whole[0::2], whole[1::2] = halves[:middle], halves[middle:]
            block = whole.tobytes()
        at_byte = 0
        for row in range(y - y0, y - y0 + count):
            for name, kind in channels:
                planes[name][row] = numpy.frombuffer(block, types[kind], width, at_byte)
                at_byte += width * numpy.dtype(types[kind]).itemsize
    return planes


def read_rgb(path):
    """R, G, B of such a file."""
    planes = read_planes(path)
    names = {name.split(".")[-1]: name for name in reversed(channels_of_color(planes))}
    return numpy.stack([planes[names[c]] for c in "RGB"], -1)


def channels_of_color(planes):
    """Those of the picture itself first: `R` before `albedo.R`."""
    return sorted((n for n in planes if n.split(".")[-1] in ("R", "G", "B")), key=lambda n: (n.count("."), n))


def squares(reference, picture):
    """Per pixel: the mean over R, G, B of (x - r)^2 / (r^2 + 0.01)."""
    r, x = read_rgb(reference), read_rgb(picture)
    return ((x - r) ** 2 / (r**2 + 0.01)).mean(-1)


def error_of(reference, picture):
    """relMSE of all pixels, and without the worst 0.1 % of them."""
    sorted_squares = numpy.sort(squares(reference, picture).ravel())
    return sorted_squares.mean(), sorted_squares[: int(len(sorted_squares) * 0.999)].mean()


if __name__ == "__main__":
    for name in sys.argv[2:]:
        print("{}: relMSE {:.6f}, trimmed {:.6f}".format(name, *error_of(sys.argv[1], name)))
