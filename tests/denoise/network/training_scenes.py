#!/usr/bin/python3
"""Scenes at random, to train a denoiser on; needs numpy.

    tests/denoise/network/training_scenes.py FOLDER --count 300 [--first 0]

Scene N is FOLDER/N.gltf, with N.hdr if an environment lights it, and N.txt has the options of `raygraph render`,
one a line. The number is the seed: it says all of the scene.
"""
import argparse
import math
import pathlib
import struct
import sys
import zlib

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "scenes"))
from gltf_writer import GltfWriter, png_file  # noqa: E402

TEXELS = 256


def noise(random, size, cells, octaves=4, gain=0.5):
    """Value noise in 0..1, size x size, periodic."""
    total, weight = numpy.zeros((size, size)), 0.0
    for octave in range(octaves):
        n = min(cells * 2**octave, size)
        grid = random.random((n, n))
        at = numpy.arange(size) * n / size
        first = at.astype(int)
        part = at - first
        part = part * part * (3 - 2 * part)
        first, then = first % n, (first + 1) % n
        rows = grid[first] * (1 - part)[:, None] + grid[then] * part[:, None]
        total += gain**octave * (rows[:, first] * (1 - part) + rows[:, then] * part)
        weight += gain**octave
    return total / weight


def pattern(random):
    """A field in 0..1 with edges or without."""
    kind = random.choice(["noise", "steps", "checker", "stripes", "bricks", "spots"])
    y, x = numpy.mgrid[0:TEXELS, 0:TEXELS] / TEXELS
    n = int(random.integers(2, 12))
    if kind == "noise":
        return numpy.clip(2 * noise(random, TEXELS, n) - 0.5, 0, 1)
    if kind == "steps":
        return numpy.floor(5 * noise(random, TEXELS, n, 3)) / 4
    if kind == "checker":
        return (numpy.floor(2 * n * x) + numpy.floor(2 * n * y)) % 2
    if kind == "stripes":
        return 0.5 + 0.5 * numpy.sign(numpy.sin(2 * math.pi * n * (x + random.integers(0, 3) * y)))
    if kind == "bricks":
        row = numpy.floor(2 * n * y)
        u, v = (n * x + 0.5 * (row % 2)) % 1, (2 * n * y) % 1
        tint = random.random((2 * n, n + 1))[row.astype(int), numpy.floor(n * x + 0.5 * (row % 2)).astype(int)]
        return numpy.where((u < 0.06) | (v < 0.12), 0, 0.4 + 0.6 * tint)
    points = random.random((4 * n, 2))
    squared = numpy.full(x.shape, numpy.inf)
    for px, py in points:
        dx, dy = abs(x - px), abs(y - py)
        squared = numpy.minimum(squared, numpy.minimum(dx, 1 - dx) ** 2 + numpy.minimum(dy, 1 - dy) ** 2)
    return (squared < random.uniform(0.001, 0.008)).astype(float)


def texture(writer, rgb):
    rows = (255 * numpy.clip(rgb, 0, 1) + 0.5).astype(numpy.uint8)
    raw = b"".join(b"\0" + row.tobytes() for row in rows)
    header = struct.pack(">IIBBBBB", rows.shape[1], rows.shape[0], 8, 2, 0, 0, 0)
    image = writer.image("", png_file(header, zlib.compress(raw, 1)))
    return {"index": writer.add("textures", {"source": image})}


def color(random, darkest=0.03):
    """Reflectances; most are dull."""
    value, chroma = random.uniform(darkest, 0.9), random.uniform(0, 0.8) ** 1.5
    rgb = value * (1 - chroma * random.random(3))
    return [float(x) for x in rgb]


def material(random, writer, glass=0.12, metal=0.25):
    """The number of a random material."""
    fields, extensions = {}, {}
    rgb = color(random)
    draw = random.random()
    if draw < glass:
        return writer.glass("", float(random.uniform(1.2, 1.8)), None,
                            (rgb, float(random.uniform(0.1, 2))) if random.random() < 0.5 else None,
                            roughnessFactor=float(random.choice([0, 0, 0.15, 0.3])))
    is_metal = draw < glass + metal
    roughness = float(random.choice([random.uniform(0, 0.15), random.uniform(0.15, 0.5), random.uniform(0.5, 1)]))
    if is_metal:
        rgb = [0.3 + 0.7 * x for x in rgb]
    if random.random() < 0.6:
        field, other = pattern(random)[..., None], numpy.array(color(random))
        encoded = numpy.clip(field * numpy.array(rgb) + (1 - field) * other, 0, 1) ** (1 / 2.2)
        fields["baseColorTexture"], rgb = texture(writer, encoded), [1, 1, 1]
    fields.update(metallicFactor=1 if is_metal else 0, roughnessFactor=roughness)
    if random.random() < 0.35:
        rough = pattern(random) * random.uniform(0.2, 1) + random.uniform(0, 0.4)
        metallic = pattern(random) if random.random() < 0.5 else numpy.ones_like(rough)
        planes = numpy.stack([numpy.ones_like(rough), rough, metallic], -1)
        writer_fields = writer.material("", rgb, None, extensions, **fields)
        pbr = writer.root["materials"][writer_fields]["pbrMetallicRoughness"]
        pbr.update(metallicRoughnessTexture=texture(writer, planes), roughnessFactor=1)
        if metallic.min() < 1:
            pbr["metallicFactor"] = 1
        number = writer_fields
    else:
        number = writer.material("", rgb, None, extensions, **fields)
    if random.random() < 0.3:
        height = noise(random, TEXELS, int(random.integers(4, 24)), 4) * random.uniform(1, 6)
        dx, dy = (numpy.roll(height, -1, axis) - numpy.roll(height, 1, axis) for axis in (1, 0))
        normal = numpy.stack([-dx, dy, numpy.full_like(dx, 0.5)], -1)
        normal /= numpy.linalg.norm(normal, axis=-1, keepdims=True)
        writer.root["materials"][number]["normalTexture"] = texture(writer, 0.5 * normal + 0.5)
    writer.root["materials"][number]["doubleSided"] = True
    return number


def grid(function, across, along):
    """Positions, texture coordinates and triangles of a patch; function(u, v) returns three planes."""
    v, u = numpy.mgrid[0:along + 1, 0:across + 1]
    u, v = u / across, v / along
    positions = numpy.stack(function(u, v), -1).reshape(-1, 3)
    first = (numpy.arange(along)[:, None] * (across + 1) + numpy.arange(across)).ravel()
    a, b, c, d = first, first + 1, first + across + 2, first + across + 1
    triangles = numpy.concatenate([numpy.stack([a, b, c], -1), numpy.stack([a, c, d], -1)])
    return positions, numpy.stack([u, v], -1).reshape(-1, 2), triangles


def smooth_normals(positions, triangles):
    a, b, c = (positions[triangles[:, i]] for i in range(3))
    faces = numpy.cross(b - a, c - a)
    normals = numpy.zeros_like(positions)
    for i in range(3):
        numpy.add.at(normals, triangles[:, i], faces)
    # Seams of closed patches have equal positions twice
    keys = {}
    for i, key in enumerate(map(tuple, numpy.round(positions, 5).tolist())):
        keys.setdefault(key, []).append(i)
    for same in keys.values():
        if len(same) > 1:
            normals[same] = normals[same].sum(0)
    lengths = numpy.linalg.norm(normals, axis=1, keepdims=True)
    return numpy.where(lengths > 1e-12, normals / numpy.maximum(lengths, 1e-12), [0, 1, 0])


def primitive(writer, shape, number, is_flat=False, repeat=1.0):
    positions, uvs, triangles = shape
    if is_flat:
        positions, uvs = positions[triangles].reshape(-1, 3), uvs[triangles].reshape(-1, 2)
        triangles = numpy.arange(len(positions)).reshape(-1, 3)
        a, b, c = (positions[i::3] for i in range(3))
        faces = numpy.cross(b - a, c - a)
        faces /= numpy.maximum(numpy.linalg.norm(faces, axis=1, keepdims=True), 1e-12)
        normals = numpy.repeat(faces, 3, 0)
    else:
        normals = smooth_normals(positions, triangles)
    return writer.primitive(positions.tolist(), triangles.tolist(), number, normals.tolist(),
                            [(repeat * uvs).tolist()])


def box(size):
    parts, first = [[], [], []], 0
    for axis in range(3):
        for sign in (-1, 1):
            def side(u, v, axis=axis, sign=sign):
                planes = [None] * 3
                planes[axis] = numpy.full_like(u, 0.5 * sign * size[axis])
                planes[(axis + 1) % 3] = sign * (u - 0.5) * size[(axis + 1) % 3]
                planes[(axis + 2) % 3] = (v - 0.5) * size[(axis + 2) % 3]
                return planes
            positions, uvs, triangles = grid(side, 1, 1)
            for part, values in zip(parts, (positions, uvs, triangles + first)):
                part.append(values)
            first += len(positions)
    return tuple(numpy.concatenate(part) for part in parts)


def shape(random):
    """A shape about 1 across around the origin, and whether its faces are flat."""
    kind = random.choice(["sphere", "box", "torus", "lathe", "rock", "sticks"])
    if kind == "box":
        return box(random.uniform(0.2, 1, 3)), True
    if kind == "torus":
        small = random.uniform(0.05, 0.2)
        return grid(lambda u, v: (
            (0.5 - small + small * numpy.cos(2 * math.pi * v)) * numpy.cos(2 * math.pi * u),
            small * numpy.sin(2 * math.pi * v),
            -(0.5 - small + small * numpy.cos(2 * math.pi * v)) * numpy.sin(2 * math.pi * u)), 48, 24), False
    if kind == "lathe":
        knots = numpy.concatenate([[0], random.uniform(0.1, 0.5, 6), [0]])
        def turned(u, v):
            radius = numpy.interp(v, numpy.linspace(0, 1, 8), knots)
            return (radius * numpy.cos(2 * math.pi * u), v - 0.5, -radius * numpy.sin(2 * math.pi * u))
        return grid(turned, 40, 42), False
    if kind == "sticks":
        parts, first = [[], [], []], 0
        for _ in range(int(random.integers(4, 16))):
            positions, uvs, triangles = box([random.uniform(0.01, 0.05), random.uniform(0.5, 1.2),
                                             random.uniform(0.01, 0.05)])
            turn = rotation(random)
            for part, values in zip(parts, (positions @ turn.T + random.uniform(-0.3, 0.3, 3), uvs,
                                            triangles + first)):
                part.append(values)
            first += len(positions)
        return tuple(numpy.concatenate(part) for part in parts), True
    is_rock = kind == "rock"
    bumps = noise(random, 64, 3, 3) if is_rock else None
    def ball(u, v):
        radius = 0.5
        if is_rock:
            ring = bumps[(v * 63).astype(int) % 64, (u * 64).astype(int) % 64]
            radius = 0.25 + 0.5 * (ring * numpy.sin(math.pi * v) + 0.5 * (1 - numpy.sin(math.pi * v)))
        return (radius * numpy.sin(math.pi * v) * numpy.cos(2 * math.pi * u), -radius * numpy.cos(math.pi * v),
                -radius * numpy.sin(math.pi * v) * numpy.sin(2 * math.pi * u))
    n = int(random.choice([10, 16, 24])) if is_rock else 48
    return grid(ball, n, n // 2), is_rock and bool(random.random() < 0.6)


def rotation(random):
    """A matrix of random rotation."""
    q, r = numpy.linalg.qr(random.normal(size=(3, 3)))
    q = q * numpy.sign(numpy.diag(r))
    return q if numpy.linalg.det(q) > 0 else -q


def sky(random):
    """Radiance of an environment, 256 x 128: a gradient, clouds, lamps or a sun, and ground."""
    height, width = 128, 256
    v = (numpy.arange(height) + 0.5) / height * math.pi
    u = (numpy.arange(width) + 0.5) / width * 2 * math.pi
    directions = numpy.stack([numpy.sin(v)[:, None] * numpy.cos(u), numpy.cos(v)[:, None] + 0 * u,
                              numpy.sin(v)[:, None] * numpy.sin(u)], -1)
    up = directions[..., 1:2]
    zenith, horizon, ground = (numpy.array(color(random, 0.1)) for _ in range(3))
    picture = numpy.where(up > 0, horizon + (zenith - horizon) * numpy.abs(up) ** 0.5, ground * 0.5)
    clouds = noise(random, 256, 4, 5)[:height, :, None]
    picture = picture * (0.3 + 1.4 * clouds ** random.uniform(0.5, 3))
    for _ in range(int(random.integers(0, 5))):
        toward = random.normal(size=3)
        toward[1] = abs(toward[1])
        toward /= numpy.linalg.norm(toward)
        width_of = 10 ** random.uniform(-3.5, -1)
        lobe = numpy.exp((directions @ toward - 1) / width_of)[..., None]
        picture = picture + lobe * numpy.array(color(random, 0.5)) * random.uniform(0.2, 1.5) / width_of ** 0.7
    return picture * random.uniform(0.3, 1.5)


def hdr_file(rgb):
    """Radiance's format, without run lengths."""
    largest = numpy.maximum(rgb.max(-1), 1e-30)
    mantissa, exponent = numpy.frexp(largest)
    texels = numpy.clip(rgb * (mantissa * 256 / largest)[..., None], 0, 255)
    texels = numpy.concatenate([texels, numpy.clip(exponent + 128, 0, 255)[..., None]], -1).astype(numpy.uint8)
    # Rows as wide as this must say that they are run-length encoded: each run is of literal values
    rows = []
    for row in texels:
        width = len(row)
        rows.append(bytes((2, 2, width >> 8, width & 255)))
        for channel in range(4):
            for start in range(0, width, 128):
                part = row[start:start + 128, channel]
                rows.append(bytes((len(part),)) + part.tobytes())
    return b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % rgb.shape[:2] + b"".join(rows)


def scene(number):
    """The text of the glTF file, the environment or None, and options of `render`."""
    random = numpy.random.default_rng(number)
    writer = GltfWriter()
    setting = random.choice(["room", "open", "object", "lamps"], p=[0.35, 0.25, 0.25, 0.15])
    is_inside = setting in ("room", "lamps")
    options = []

    def place(primitives, matrix, offset):
        columns = numpy.eye(4)
        columns[:3, :3], columns[:3, 3] = matrix, offset
        writer.node(mesh=writer.mesh("", primitives), matrix=[float(x) for x in columns.T.ravel()])

    def lamp(center, size, radiance):
        rgb = [float(x) for x in radiance * numpy.array(color(random, 0.6))]
        number_of = writer.material("", [0.5] * 3, rgb)
        shape_of = box([size, 0.02 * size, size * random.uniform(0.3, 1)]) if random.random() < 0.6 else grid(
            lambda u, v: (0.5 * size * numpy.sin(math.pi * v) * numpy.cos(2 * math.pi * u),
                          -0.5 * size * numpy.cos(math.pi * v),
                          -0.5 * size * numpy.sin(math.pi * v) * numpy.sin(2 * math.pi * u)), 24, 12)
        place([primitive(writer, shape_of, number_of)], numpy.eye(3), center)

    size = numpy.array([random.uniform(3, 6), random.uniform(2.4, 4), random.uniform(3, 6)])
    if is_inside:
        open_side = int(random.integers(0, 8))
        for axis in range(3):
            for sign in (-1, 1):
                if 2 * axis + (sign > 0) == open_side and axis != 1:
                    continue  # a wall is missing: light comes from outside
                def wall(u, v, axis=axis, sign=sign):
                    planes = [None] * 3
                    planes[axis] = numpy.full_like(u, 0.5 * sign * size[axis])
                    planes[(axis + 1) % 3] = sign * (0.5 - u) * size[(axis + 1) % 3]
                    planes[(axis + 2) % 3] = (v - 0.5) * size[(axis + 2) % 3]
                    return planes
                place([primitive(writer, grid(wall, 1, 1), material(random, writer, 0, 0.08), True,
                                 float(random.uniform(1, 4)))], numpy.eye(3), [0, 0.5 * size[1], 0])
    elif setting == "open" or random.random() < 0.6:
        hills = noise(random, 64, 3, 4)
        height = random.choice([0, 0, random.uniform(0.2, 2)])
        def ground(u, v):
            return (12 * (u - 0.5), height * (hills[(v * 63).astype(int), (u * 63).astype(int)] - 0.5),
                    12 * (0.5 - v))
        place([primitive(writer, grid(ground, 63, 63), material(random, writer, 0, 0.1),
                         bool(random.random() < 0.5), float(random.uniform(1, 8)))], numpy.eye(3), [0, 0, 0])

    reach = 0.35 * min(size[0], size[2]) if is_inside else (2.0 if setting == "open" else 0.6)
    for _ in range(int(random.integers(1, 4) if setting == "object" else random.integers(3, 12))):
        parts, is_flat = shape(random)
        scale = random.uniform(0.3, 1.3)
        center = [random.uniform(-reach, reach), scale * random.uniform(0.3, 0.8), random.uniform(-reach, reach)]
        place([primitive(writer, parts, material(random, writer), is_flat, float(random.uniform(1, 3)))],
              scale * rotation(random), center)

    if setting == "room":
        for _ in range(int(random.integers(1, 4))):
            lamp([random.uniform(-reach, reach), size[1] * random.uniform(0.85, 0.98),
                  random.uniform(-reach, reach)], random.uniform(0.05, 1.2), 10 ** random.uniform(0.5, 2))
    if setting == "lamps":
        for _ in range(int(random.integers(12, 60))):
            lamp([random.uniform(-0.45, 0.45) * size[0], random.uniform(0.1, 0.95) * size[1],
                  random.uniform(-0.45, 0.45) * size[2]], random.uniform(0.02, 0.12),
                 10 ** random.uniform(0.5, 2.3))
    if random.random() < 0.25:
        writer.point_light([1, 1, 1], float(10 ** random.uniform(0, 1.5)),
                           [float(x) for x in random.uniform(-1, 1, 3) + [0, 2, 0]])
    environment = None
    if not is_inside or open_side < 6 and random.random() < 0.7:
        environment = sky(random)
    elif random.random() < 0.5:
        options += ["--background", "0,0,0"]
    else:
        options += ["--background", ",".join(f"{x:.3f}" for x in random.uniform(0, 0.5, 3))]

    target = numpy.array([random.uniform(-0.3, 0.3) * reach, random.uniform(0.3, 0.8),
                          random.uniform(-0.3, 0.3) * reach])
    angle = random.uniform(0, 2 * math.pi)
    distance = 0.42 * min(size[0], size[2]) if is_inside else random.uniform(1.2, 2.2) * (reach + 0.4)
    eye = [distance * math.cos(angle), random.uniform(0.5, 0.8) * size[1] if is_inside else
           random.uniform(0.5, 1.5) * distance * 0.6 + 0.3, distance * math.sin(angle)]
    numbers = [*eye, *target, 0, 1, 0, random.uniform(30, 75)]
    options += ["--camera", " ".join(f"{x:.4f}" for x in numbers)]
    if random.random() < 0.15:
        options += ["--aperture", f"{random.uniform(0.01, 0.06):.4f}"]
    return writer.text(), environment, options


def write(folder, number):
    text, environment, options = scene(number)
    (folder / f"{number}.gltf").write_text(text)
    if environment is not None:
        (folder / f"{number}.hdr").write_bytes(hdr_file(environment))
        options += ["--env", str(folder / f"{number}.hdr")]
    (folder / f"{number}.txt").write_text("\n".join(options) + "\n")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--count", type=int, required=True)
    parser.add_argument("--first", type=int, default=0)
    arguments = parser.parse_args()
    arguments.folder.mkdir(exist_ok=True)
    for number in range(arguments.first, arguments.first + arguments.count):
        write(arguments.folder, number)


if __name__ == "__main__":
    main()
