"""Scenes that show materials."""

import math

from gltf_writer import GltfWriter
from light_scenes import looking
from shapes import box_quads, floor_quad, icosphere, lathe


def glass_sphere():
    """A smooth sphere of radius 1 of clear glass, index 1.5, alone: nothing of an environment of one radiance
    is lost on it."""
    writer = GltfWriter()
    positions, triangles = icosphere(4)
    glass = writer.glass("glass", 1.5)
    mesh = writer.mesh("sphere", [writer.primitive(positions, triangles, glass, normals=positions)])
    writer.node(name="sphere", mesh=mesh)
    writer.camera("camera", (0, 0, 4), math.radians(40), aspect=1)
    return writer.text()


def material_row():
    """Spheres of radius 0.45: red plastic, gold, and glass from front to back, roughness 0 to 1 from left to
    right in steps of 1/6, under a lamp."""
    writer = GltfWriter()
    positions, triangles = icosphere(4)
    shape = writer.primitive(positions, triangles, 0, normals=positions)

    def row(kind, z, material):
        for i in range(7):
            roughness = round(i / 6, 4)
            primitive = {**shape, "material": material(f"{kind} {roughness}", roughness)}
            writer.node(name=f"{kind} {roughness}", mesh=writer.mesh(f"{kind} {roughness}", [primitive]),
                        translation=[i - 3, 0.45, z], scale=[0.45, 0.45, 0.45])

    row("plastic", 1.1, lambda name, roughness: writer.material(
        name, [0.6, 0.05, 0.04], roughnessFactor=roughness))
    row("gold", 0, lambda name, roughness: writer.material(
        name, [1.0, 0.766, 0.336], roughnessFactor=roughness, metallicFactor=1))
    row("glass", -1.1, lambda name, roughness: writer.glass(name, 1.5, roughnessFactor=roughness))
    ground = writer.material("ground", [0.4, 0.4, 0.4])
    wall = writer.material("wall", [0.3, 0.4, 0.5])
    lamp = writer.material("lamp", [0, 0, 0], [12, 12, 12])
    back = [((-8, 0, -3), (8, 0, -3), (8, 5, -3), (-8, 5, -3))]
    writer.node(name="ground", mesh=writer.mesh("ground", [writer.quads([floor_quad(8, 8)], ground)]))
    writer.node(name="wall", mesh=writer.mesh("wall", [writer.quads(back, wall)]))
    above = [tuple(reversed(floor_quad(3, 0.5, 4.0)))]
    writer.node(name="lamp", mesh=writer.mesh("lamp", [writer.quads(above, lamp)]), translation=[0, 0, 1.5])
    eye = (0, 4.5, 8)
    writer.camera("camera", eye, math.radians(28), aspect=1.6, rotation=looking(eye, (0, 0.35, 0)))
    return writer.text()


def furnace_row():
    """Five spheres of radius 0.45 of white metal, roughness 0.2 to 1 from left to right in steps of 0.2, alone:
    in an environment of one radiance those that lose nothing cannot be seen."""
    writer = GltfWriter()
    positions, triangles = icosphere(4)
    shape = writer.primitive(positions, triangles, 0, normals=positions)
    for i in range(5):
        roughness = round((i + 1) / 5, 1)
        name = f"white metal {roughness}"
        material = writer.material(name, [1, 1, 1], roughnessFactor=roughness, metallicFactor=1)
        mesh = writer.mesh(name, [{**shape, "material": material}])
        writer.node(name=name, mesh=mesh, translation=[i - 2, 0, 0], scale=[0.45, 0.45, 0.45])
    writer.camera("camera", (0, 0, 12), 2.0 * math.atan(0.055), aspect=4)
    return writer.text()


def thin_films():
    """Spheres of radius 0.4 under a thin film, 100 to 1000 nm thick from left to right in steps of 150, of index
    1.2, 1.6 and 2 from back to front: three rows of black metal behind three rows of black plastic."""
    writer = GltfWriter()
    positions, triangles = icosphere(3)
    shape = writer.primitive(positions, triangles, 0, normals=positions)
    for row in range(6):
        kind, ior = ("metal", "plastic")[row // 3], (1.2, 1.6, 2.0)[row % 3]
        for column in range(7):
            thickness = 100 + 150 * column
            name = f"{kind} {ior} {thickness} nm"
            material = writer.material(name, [0.01] * 3, roughnessFactor=0.15, metallicFactor=1 - row // 3,
                                       extensions={"KHR_materials_iridescence": {
                                           "iridescenceFactor": 1, "iridescenceIor": ior,
                                           "iridescenceThicknessMaximum": thickness}})
            mesh = writer.mesh(name, [{**shape, "material": material}])
            writer.node(name=name, mesh=mesh, translation=[column - 3, 0.4, row - 2.5], scale=[0.4] * 3)
    ground = writer.material("ground", [0.3, 0.3, 0.3])
    writer.node(name="ground", mesh=writer.mesh("ground", [writer.quads([floor_quad(10, 10)], ground)]))
    eye = (0, 9, 9)
    writer.camera("camera", eye, math.radians(31), aspect=1.25, rotation=looking(eye, (0, 0, 0.25)))
    return writer.text()


def nested_dielectrics():
    """A tumbler 12 cm high (glass, index 1.5), a drink in it (1.33, amber) whose surface runs inside the
    glass, and a cube of ice (1.31) half out of the drink. Priorities: glass 3, ice 2, drink 1; the higher one
    is there."""
    writer = GltfWriter()
    glass = writer.glass("glass", 1.5, priority=3)
    ice = writer.glass("ice", 1.31, priority=2)
    drink = writer.glass("drink", 1.33, priority=1, attenuation=([0.9, 0.45, 0.1], 0.03))
    outer, inner, floor, height, level = 0.04, 0.036, 0.01, 0.12, 0.08
    within = 0.038  # between the walls: where the glass meets the drink there is one surface, the glass's

    def turned(name, profile, material):
        positions, normals, triangles = lathe(profile, 96)
        writer.node(name=name, mesh=writer.mesh(name, [
            writer.primitive(positions, triangles, material, normals=normals)]))

    turned("tumbler", [(0, 0), (outer, 0), (outer, height), (inner, height), (inner, floor), (0, floor)],
           glass)
    turned("drink", [(0, 0.005), (within, 0.005), (within, level), (0, level)], drink)
    half = 0.014
    cube = writer.mesh("ice", [writer.quads(box_quads((-half, -half, -half), (half, half, half)), ice)])
    writer.node(name="ice", mesh=cube, translation=[0.004, level, 0.003], rotation=[0.2, 0.4, 0.1, 0.888819])
    table = writer.material("table", [0.55, 0.5, 0.45])
    lamp = writer.material("lamp", [0, 0, 0], [15, 15, 15])
    top = [floor_quad(0.6, 0.6, -0.0005)]
    writer.node(name="table", mesh=writer.mesh("table", [writer.quads(top, table)]))
    above = [tuple(reversed(floor_quad(0.12, 0.12)))]
    writer.node(name="lamp", mesh=writer.mesh("lamp", [writer.quads(above, lamp)]),
                translation=[-0.1, 0.5, -0.05])
    eye = (0.05, 0.17, 0.32)
    writer.camera("camera", eye, math.radians(30), aspect=1, rotation=looking(eye, (0, 0.055, 0)))
    return writer.text()
