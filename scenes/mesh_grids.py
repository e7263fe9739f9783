"""Test pictures of the ways in which a file may store its meshes: the same relief, or the same set of small
reliefs, from each of them beside the plain one."""

import math
import struct

from gltf_writer import ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER, FLOAT, UNSIGNED_INT, UNSIGNED_SHORT, png
from mesh_codecs import (DRACO_NORMAL, DRACO_POSITION, DRACO_TEXCOORD, draco, meshopt_attributes,
                         meshopt_triangles)
from test_grid import TestGrid
from texture_grids import blocks, texels_of

BYTE, UNSIGNED_BYTE, SHORT = 5120, 5121, 5122
SIDE = 9
COUNT = SIDE * SIDE


class Relief:
    """A square of side 1 with bumps. All numbers are such that 8 bits hold them exactly, but texture
    coordinates, which need not be exact to show the same texels."""

    def __init__(self):
        heights = [[(3 * x * x + 5 * y * y + 2 * x * y) % 7 for x in range(SIDE)] for y in range(SIDE)]
        cells = [(x, y) for y in range(SIDE) for x in range(SIDE)]
        self.steps = [(8 * x - 32, 8 * y - 32, heights[y][x]) for x, y in cells]  # of 1/64
        self.positions = [tuple(value / 64 for value in step) for step in self.steps]
        at = lambda x, y: heights[min(max(y, 0), SIDE - 1)][min(max(x, 0), SIDE - 1)]
        self.normal_steps = [(3 * (at(x - 1, y) - at(x + 1, y)), 3 * (at(x, y - 1) - at(x, y + 1)), 90)
                             for x, y in cells]
        lengths = [math.sqrt(sum(value * value for value in step)) for step in self.normal_steps]
        self.normal_steps = [tuple(round(127 * value / length) for value in step)
                             for step, length in zip(self.normal_steps, lengths)]
        lengths = [math.sqrt(sum(value * value for value in step)) for step in self.normal_steps]
        self.normals = [tuple(value / length for value in step)
                        for step, length in zip(self.normal_steps, lengths)]
        self.uvs = [(x / 8, 1 - y / 8) for x, y in cells]
        self.triangles = []
        for y in range(SIDE - 1):
            for x in range(SIDE - 1):
                a = y * SIDE + x
                self.triangles += [(a, a + 1, a + SIDE + 1), (a, a + SIDE + 1, a + SIDE)]


def stored_as(writer, data, stride, component, kind, count, is_normalized=False, offset=0, view=None,
              target=ARRAY_BUFFER, bounds=None):
    """An accessor over bytes, or over a view that is there. A stride of 0: the accessor's own."""
    if view is None:
        while len(writer.buffer) % 4:
            writer.buffer.append(0)
        fields = {"buffer": 0, "byteOffset": len(writer.buffer), "byteLength": len(data)}
        if stride:
            fields["byteStride"] = stride
        if target:
            fields["target"] = target
        view = writer.add("bufferViews", fields)
        writer.buffer += data
    accessor = {"bufferView": view, "byteOffset": offset, "componentType": component, "count": count,
                "type": kind}
    if is_normalized:
        accessor["normalized"] = True
    if bounds:
        accessor["min"], accessor["max"] = bounds
    return writer.add("accessors", accessor)


def bounds_of(rows):
    return [min(column) for column in zip(*rows)], [max(column) for column in zip(*rows)]


def quantized(writer, relief, position_type, code, with_bytes):
    """Positions as whole numbers of 1/64 (the node scales them back), normals and coordinates of 8 bits."""
    stride = 8 if code == "h" else 4
    rows = [struct.pack(f"<3{code}", *step).ljust(stride, b"\0") for step in relief.steps]
    position = stored_as(writer, b"".join(rows), stride, position_type, "VEC3", COUNT,
                         bounds=bounds_of(relief.steps))
    rows = [struct.pack("<3bx", *step) for step in relief.normal_steps]
    normal = stored_as(writer, b"".join(rows), 4, BYTE, "VEC3", COUNT, True)
    scale, code, component = (255, "2B2x", UNSIGNED_BYTE) if with_bytes else (65535, "2H", UNSIGNED_SHORT)
    rows = [struct.pack("<" + code, *(round(scale * value) for value in uv)) for uv in relief.uvs]
    uv = stored_as(writer, b"".join(rows), 4, component, "VEC2", COUNT, True)
    writer.extensions.add("KHR_mesh_quantization")
    return {"POSITION": position, "NORMAL": normal, "TEXCOORD_0": uv}


def meshopt(writer, relief, extension, indices_of_32_bits):
    """The compressed bytes are in a view of the file's buffer; what the views name else is not there."""
    writer.extensions.add(extension)
    vertices = b"".join(struct.pack("<8f", *p, *n, *uv)
                        for p, n, uv in zip(relief.positions, relief.normals, relief.uvs))
    flat = [index for triangle in relief.triangles for index in triangle]
    index_bytes = 4 if indices_of_32_bits else 2
    views = []
    for data, mode, stride, count, target in (
            (meshopt_attributes(vertices, 32), "ATTRIBUTES", 32, COUNT, ARRAY_BUFFER),
            (meshopt_triangles(flat), "TRIANGLES", index_bytes, len(flat), ELEMENT_ARRAY_BUFFER)):
        while len(writer.buffer) % 4:
            writer.buffer.append(0)
        fallback = {"byteLength": count * stride, "extensions": {extension: {"fallback": True}}}
        writer.more_buffers.append(fallback)
        view = {"buffer": len(writer.more_buffers), "byteLength": count * stride, "target": target,
                "extensions": {extension: {"buffer": 0, "byteOffset": len(writer.buffer),
                                           "byteLength": len(data), "byteStride": stride, "count": count,
                                           "mode": mode}}}
        if mode == "ATTRIBUTES":
            view["byteStride"] = stride
        views.append(writer.add("bufferViews", view))
        writer.buffer += data
    over = lambda offset, kind, bounds=None: stored_as(writer, b"", 0, FLOAT, kind, COUNT, offset=offset,
                                                       view=views[0], bounds=bounds)
    component = UNSIGNED_INT if indices_of_32_bits else UNSIGNED_SHORT
    return {"attributes": {"POSITION": over(0, "VEC3", bounds_of(relief.positions)),
                           "NORMAL": over(12, "VEC3"), "TEXCOORD_0": over(24, "VEC2")},
            "indices": stored_as(writer, b"", 0, component, "SCALAR", len(flat), view=views[1])}


def draco_primitive(writer, relief):
    writer.extensions.add("KHR_draco_mesh_compression")
    data = draco(relief.triangles, [(DRACO_POSITION, relief.positions), (DRACO_NORMAL, relief.normals),
                                    (DRACO_TEXCOORD, relief.uvs)])
    view = writer.add("bufferViews", {"buffer": 0, "byteOffset": len(writer.buffer), "byteLength": len(data)})
    writer.buffer += data
    low, high = bounds_of(relief.positions)
    accessor = lambda component, kind, count, **more: writer.add("accessors", {
        "componentType": component, "type": kind, "count": count, **more})
    return {"attributes": {"POSITION": accessor(FLOAT, "VEC3", COUNT, min=low, max=high),
                           "NORMAL": accessor(FLOAT, "VEC3", COUNT),
                           "TEXCOORD_0": accessor(FLOAT, "VEC2", COUNT)},
            "indices": accessor(UNSIGNED_SHORT, "SCALAR", 3 * len(relief.triangles)),
            "extensions": {"KHR_draco_mesh_compression": {
                "bufferView": view, "attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}}}}


def sparse(writer, relief, plain):
    """Positions of a flat square, with those of the relief where they are another."""
    flat = [(x, y, 0.0) for x, y, _ in relief.positions]
    base = writer.accessor(flat, 3)
    changed = [i for i, (_, _, z) in enumerate(relief.positions) if z != 0]
    accessors = writer.root["accessors"]
    index, value = writer.accessor(changed, 1, UNSIGNED_SHORT), writer.accessor(
        [relief.positions[i] for i in changed], 3)
    # Views of sparse data have no target.
    views = [accessors[i]["bufferView"] for i in (index, value)]
    del accessors[value], accessors[index]
    for view in views:
        del writer.root["bufferViews"][view]["target"]
    accessors[base].update(zip(("min", "max"), bounds_of(relief.positions)))
    accessors[base]["sparse"] = {"count": len(changed),
                                 "indices": {"bufferView": views[0], "componentType": UNSIGNED_SHORT},
                                 "values": {"bufferView": views[1]}}
    return {**plain, "attributes": {**plain["attributes"], "POSITION": base}}


def strip(writer, relief, plain):
    """Rows of triangles joined by ones without area."""
    indices = []
    for y in range(SIDE - 1):
        row = [index for x in range(SIDE) for index in ((y + 1) * SIDE + x, y * SIDE + x)]
        indices += ([indices[-1], row[0]] if indices else []) + row
    return {**plain, "mode": 5, "indices": writer.accessor(indices, 1, UNSIGNED_SHORT, ELEMENT_ARRAY_BUFFER)}


def without_indices(writer, relief, material):
    flat = [index for triangle in relief.triangles for index in triangle]
    at = lambda rows: [rows[i] for i in flat]
    return {"attributes": {"POSITION": writer.accessor(at(relief.positions), 3, has_bounds=True),
                           "NORMAL": writer.accessor(at(relief.normals), 3),
                           "TEXCOORD_0": writer.accessor(at(relief.uvs), 2)}, "material": material}


def placements():
    """Of 3 x 3 tiles: translation, rotation about z, scale."""
    result = []
    for i in range(9):
        angle = math.pi / 2 * (i % 4)
        result.append(((i % 3 / 3 - 1 / 3, i // 3 / 3 - 1 / 3, 0.05 * i),
                       (0, 0, round(math.sin(angle / 2), 7), round(math.cos(angle / 2), 7)),
                       (0.3 - 0.01 * i, 0.2 + 0.01 * i, 0.5)))
    return result


def meshes_grid():
    cells = ["BYTES", "SHORTS", "EXT MOPT", "KHR MOPT", "DRACO", "SPARSE", "STRIP", "NO INDEX", "INSTANCES",
             "MIRROR"]
    grid = TestGrid(cells=cells, across=5, front=0.0)
    writer, relief = grid.writer, Relief()
    picture = png([[texel[:3] for texel in row] for row in texels_of(blocks())])
    texture = grid.texture(writer.image("picture", picture))
    material = writer.material("picture", [1, 1, 1], baseColorTexture={"index": texture})
    plain = writer.primitive(relief.positions, relief.triangles, material, relief.normals, [relief.uvs])
    scaled = {"scale": [1 / 64] * 3}
    for i, (attributes, fields) in enumerate((
            (quantized(writer, relief, BYTE, "b", True), scaled),
            (quantized(writer, relief, SHORT, "h", False), scaled))):
        grid.place(i, 0, {**plain, "attributes": attributes}, **fields)
    grid.place(2, 0, {**meshopt(writer, relief, "EXT_meshopt_compression", False), "material": material})
    grid.place(3, 0, {**meshopt(writer, relief, "KHR_meshopt_compression", True), "material": material})
    grid.place(4, 0, {**draco_primitive(writer, relief), "material": material})
    grid.place(0, 1, sparse(writer, relief, plain))
    grid.place(1, 1, strip(writer, relief, plain))
    grid.place(2, 1, without_indices(writer, relief, material))
    for i in range(8):
        grid.expect(i % 5, i // 5, plain)
    columns = list(zip(*placements()))
    names = ("TRANSLATION", "ROTATION", "SCALE")
    instances = {}
    for name, rows in zip(names, columns):
        data = b"".join(struct.pack(f"<{len(row)}f", *row) for row in rows)
        kind = "VEC4" if name == "ROTATION" else "VEC3"
        instances[name] = stored_as(writer, data, 0, FLOAT, kind, len(rows), target=None)
    writer.extensions.add("EXT_mesh_gpu_instancing")
    grid.place(3, 1, plain, extensions={"EXT_mesh_gpu_instancing": {"attributes": instances}})
    grid.expect_nodes(3, 1, plain, placements())
    mirrored = [(-x, y, z) for x, y, z in relief.positions], [(-x, y, z) for x, y, z in relief.normals]
    grid.place(4, 1, plain, scale=[-1, 1, 1])
    grid.expect(4, 1, writer.primitive(mirrored[0], [(a, c, b) for a, b, c in relief.triangles], material,
                                       mirrored[1], [relief.uvs]))
    half = math.radians(-25)
    writer.punctual_light({"type": "directional"}, (1, 1, 1), 4,
                          rotation=[round(math.sin(half), 6), 0, 0, round(math.cos(half), 6)])
    return grid.text()
