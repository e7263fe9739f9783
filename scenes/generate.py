#!/usr/bin/env python3
"""Writes every scene of this folder.

    generate.py            writes the files beside this script
    generate.py --check    compares them with what would be written; exit code 1 and names when they differ

Needs Python's standard library alone. The bytes are the same on every machine.
"""

import math
import pathlib
import sys

sys.dont_write_bytecode = True

from gltf_writer import GltfWriter, png
from grids import (
    diffuse_transmission_grid, films_grid, layers_grid, meshes_grid, scattering_grid,
    texture_coordinates_grid, texture_formats_grid, variants_grid)
from lit_scenes import (
    cornell, furnace_row, glass_sphere, many_lights, material_row, nested_dielectrics,
    points_and_lines, small_light, terrace, thin_films)
from shapes import Picker, box_quads, icosphere


def furnace_sphere():
    """A Lambert sphere of radius 1 and albedo 0.8: five times subdivided icosahedron, smooth normals."""
    writer = GltfWriter()
    positions, triangles = icosphere(5)
    material = writer.material("white", [0.8] * 3)
    mesh = writer.mesh("sphere", [writer.primitive(positions, triangles, material, normals=positions)])
    writer.node(name="sphere", mesh=mesh)
    writer.camera("camera", (0, 0, 4), math.radians(40))
    return writer.text()


def closed_box(albedo):
    """A closed cube of side 2 about the origin, fronts inwards, that emits radiance 1; camera inside."""
    writer = GltfWriter()
    material = writer.material("wall", [albedo] * 3, [1.0, 1.0, 1.0])
    mesh = writer.mesh("box", [writer.quads(box_quads((-1, -1, -1), (1, 1, 1), is_inward=True), material)])
    writer.node(name="box", mesh=mesh)
    writer.camera("camera", (0.1, 0.2, 0.3), math.radians(60))
    return writer.text()


# Strokes of the picture, as cells of a 32 x 32 grid: (x, y, width, height) from the top left corner.
LETTER_F = ((10, 9, 4, 18), (14, 9, 8, 4), (14, 16, 6, 4))
U_ARROW = ((8, 3, 9, 2), (17, 0, 2, 8), (19, 1, 2, 6), (21, 2, 2, 4), (23, 3, 2, 2))  # on top, to the right
V_ARROW = tuple((y, x, height, width) for x, y, width, height in U_ARROW)  # along the left edge, downwards
DARK, LIGHT = (40, 40, 40), (230, 230, 230)
RED, GREEN, BLUE, YELLOW = (220, 30, 30), (30, 180, 30), (30, 60, 220), (240, 220, 30)
MAGENTA, CYAN = (220, 30, 220), (30, 200, 200)


def orientation_picture():
    """64 x 64: F in the middle; corners red, green / blue, yellow; arrows: magenta along u, cyan along v."""
    size, cell = 64, 2
    rows = [[LIGHT] * size for _ in range(size)]

    def fill(x, y, width, height, color):
        for row in rows[y * cell:(y + height) * cell]:
            row[x * cell:(x + width) * cell] = [color] * (width * cell)

    for x, y, color in ((0, 0, RED), (26, 0, GREEN), (0, 26, BLUE), (26, 26, YELLOW)):
        fill(x, y, 6, 6, color)
    for strokes, color in ((LETTER_F, DARK), (U_ARROW, MAGENTA), (V_ARROW, CYAN)):
        for stroke in strokes:
            fill(*stroke, color)
    return png(rows)


def texture_orientation():
    """Six quads of side 2 in the plane z = 0, in two rows, and two marks: red at +x, green at +y."""
    writer = GltfWriter()
    image = writer.image("orientation", orientation_picture())
    repeat = writer.add("samplers", {"magFilter": 9728, "minFilter": 9728, "wrapS": 10497, "wrapT": 10497})
    mirror = writer.add("samplers", {"magFilter": 9728, "minFilter": 9728, "wrapS": 33648, "wrapT": 33648})
    clamp = writer.add("samplers", {"magFilter": 9729, "minFilter": 9729, "wrapS": 33071, "wrapT": 33071})
    plain, mirrored, smooth = (
        writer.add("textures", {"sampler": sampler, "source": image}) for sampler in (repeat, mirror, clamp))

    def emissive(name, texture, texcoord=0):
        return writer.material(name, [0, 0, 0], [1, 1, 1],
                               emissiveTexture={"index": texture, "texCoord": texcoord})

    # Of the corners bottom left, bottom right, top right, top left.
    upright = ((0, 1), (1, 1), (1, 0), (0, 0))
    turned = ((1, 1), (1, 0), (0, 0), (0, 1))  # the picture a quarter turn clockwise
    wide = ((-0.5, 1.5), (1.5, 1.5), (1.5, -0.5), (-0.5, -0.5))
    corners = ((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0))

    def quad(name, material, *texcoords):
        primitive = writer.primitive(corners, ((0, 1, 2), (0, 2, 3)), material, [(0, 0, 1)] * 4, texcoords)
        return writer.mesh(name, [primitive])

    base = writer.material("base color", [1, 1, 1], baseColorTexture={"index": plain})
    emitting = quad("emission", emissive("emission", plain), upright)
    writer.node(name="emission", mesh=emitting, translation=[-2.5, 1.25, 0])
    writer.node(name="base color", mesh=quad("base color", base, upright), translation=[0, 1.25, 0])
    writer.node(name="second texture coordinates, a quarter turn", translation=[2.5, 1.25, 0],
                mesh=quad("turned", emissive("turned", plain, 1), upright, turned))
    writer.node(name="repeat", mesh=quad("repeat", emissive("repeat", plain), wide),
                translation=[-2.5, -1.25, 0])
    writer.node(name="mirrored repeat", mesh=quad("mirror", emissive("mirror", mirrored), wide),
                translation=[0, -1.25, 0])
    writer.node(name="clamped, linear", mesh=quad("clamp", emissive("clamp", smooth), wide),
                translation=[2.5, -1.25, 0])
    # The first quad through a node that mirrors x: the picture reads backwards, its front still faces +z.
    writer.node(name="mirroring node", mesh=emitting, translation=[-4.5, 0, 0], scale=[-0.5, 0.5, 0.5])

    def mark(name, color, x, y):
        primitive = writer.quads([[(x + dx / 5, y + dy / 5, 0) for dx, dy, _ in corners]],
                                 writer.material(name, [0, 0, 0], color))
        writer.node(name=name, mesh=writer.mesh(name, [primitive]))

    mark("+x", [1, 0, 0], 4.5, 0)
    mark("+y", [0, 1, 0], 0, 2.75)
    writer.camera("camera", (0, 0, 10), 2.0 * math.atan(0.32), aspect=1.6)
    return writer.text()


def checker_floor():
    """A floor of squares, half a meter each, to the horizon; a mirror ball and a rough one."""
    writer = GltfWriter()
    squares = [[LIGHT if (x // 8 + y // 8) % 2 else DARK for x in range(64)] for y in range(64)]
    texture = writer.add("textures", {"source": writer.image("squares", png(squares))})
    floor = writer.material("squares", [1, 1, 1], baseColorTexture={"index": texture})
    mirror = writer.material("mirror", [0.9, 0.9, 0.9], metallicFactor=1, roughnessFactor=0)
    rough = writer.material("rough", [0.9, 0.8, 0.6], metallicFactor=1, roughnessFactor=0.3)
    corners = ((-400, 0, 20), (400, 0, 20), (400, 0, -780), (-400, 0, -780))
    primitive = writer.primitive(corners, ((0, 1, 2), (0, 2, 3)), floor, [(0, 1, 0)] * 4,
                                 [((0, 200), (200, 200), (200, 0), (0, 0))])
    writer.node(name="floor", mesh=writer.mesh("floor", [primitive]))
    positions, triangles = icosphere(4)
    for name, material, x in (("mirror", mirror, -1.2), ("rough", rough, 1.2)):
        ball = writer.primitive(positions, triangles, material, normals=positions)
        writer.node(name=name, mesh=writer.mesh(name, [ball]), translation=[x, 1, -6])
    writer.camera("camera", (0, 1.6, 1), math.radians(45))
    return writer.text()


def instanced_field():
    """10,000 nodes of one mesh on a plain under a lamp: 100 rows with 100 children each."""
    writer = GltfWriter()
    stone = writer.material("stone", [0.6, 0.55, 0.5])
    ground = writer.material("ground", [0.3, 0.35, 0.25])
    lamp = writer.material("lamp", [0, 0, 0], [6, 5.5, 5])
    obelisk = box_quads((-0.3, 0, -0.3), (0.3, 1, 0.3))
    # The top drawn in: no two faces alike.
    obelisk = [[(x * 0.6, y, z * 0.4) if y == 1 else (x, y, z) for x, y, z in quad] for quad in obelisk]
    mesh = writer.mesh("obelisk", [writer.quads(obelisk, stone)])
    pick = Picker()
    for row in range(100):
        children = []
        for column in range(100):
            turn = pick(0, math.pi) / 2
            children.append(writer.node(
                is_root=False, mesh=mesh, translation=rounded2((column - 49.5, 0, pick(-.2, .2))),
                rotation=[0, round(math.sin(turn), 4), 0, round(math.cos(turn), 4)],
                scale=rounded2((1, pick(0.3, 2), 1))))
        writer.node(name=f"row {row}", translation=[0, 0, row - 49.5], children=children)
    plain = [((-60, 0, 60), (60, 0, 60), (60, 0, -60), (-60, 0, -60))]
    sky = [((-20, 40, -20), (20, 40, -20), (20, 40, 20), (-20, 40, 20))]
    writer.node(name="ground", mesh=writer.mesh("ground", [writer.quads(plain, ground)]))
    writer.node(name="lamp", mesh=writer.mesh("lamp", [writer.quads(sky, lamp)]))
    tilt = math.radians(-25) / 2
    writer.camera("camera", (0, 30, 68), math.radians(45), rotation=(math.sin(tilt), 0, 0, math.cos(tilt)))
    return writer.text()


def rounded2(values):
    return [int(v) if v == int(v) else v for v in (round(value, 2) for value in values)]


SCENES = {
    "cornell.gltf": cornell,
    "furnace_sphere.gltf": furnace_sphere,
    "closed_box_a50.gltf": lambda: closed_box(0.5),
    "closed_box_a80.gltf": lambda: closed_box(0.8),
    "texture_orientation.gltf": texture_orientation,
    "checker_floor.gltf": checker_floor,
    "instanced_field.gltf": instanced_field,
    "small_light.gltf": small_light,
    "many_lights.gltf": many_lights,
    "terrace.gltf": terrace,
    "glass_sphere.gltf": glass_sphere,
    "material_row.gltf": material_row,
    "furnace_row.gltf": furnace_row,
    "nested_dielectrics.gltf": nested_dielectrics,
    "thin_films.gltf": thin_films,
    "points_and_lines.gltf": points_and_lines,
    "scattering_grid.gltf": scattering_grid,
    "diffuse_transmission_grid.gltf": diffuse_transmission_grid,
    "texture_formats_grid.gltf": texture_formats_grid,
    "texture_coordinates_grid.gltf": texture_coordinates_grid,
    "variants_grid.gltf": variants_grid,
    "layers_grid.gltf": layers_grid,
    "films_grid.gltf": films_grid,
    "meshes_grid.gltf": meshes_grid,
}


def main():
    folder = pathlib.Path(__file__).resolve().parent
    is_check = sys.argv[1:] == ["--check"]
    if sys.argv[1:] and not is_check:
        sys.exit(f"usage: {sys.argv[0]} [--check]")
    stale = []
    for name, make in SCENES.items():
        data = make().encode("ascii")
        path = folder / name
        if not is_check:
            path.write_bytes(data)
        elif not path.exists() or path.read_bytes() != data:
            stale.append(name)
    if stale:
        sys.exit(f"not as generated: {', '.join(stale)}; run scenes/generate.py")


if __name__ == "__main__":
    main()
