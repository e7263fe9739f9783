"""Scenes that are easy or hard by their lights."""

import colorsys
import math

from gltf_writer import GltfWriter, rounded
from shapes import Picker, box_quads, floor_quad, icosphere


def small_light():
    """The corner of a room, a block in it, lit by a sphere of radius 2 cm alone: of ten thousand paths a few
    find it by chance."""
    writer = GltfWriter()
    white = writer.material("white", [0.7, 0.7, 0.7])
    blue = writer.material("blue", [0.2, 0.3, 0.6])
    red = writer.material("red", [0.65, 0.2, 0.15])
    bulb = writer.material("bulb", [0, 0, 0], [800, 720, 600])
    floor = [((0, 0, 2), (2, 0, 2), (2, 0, 0), (0, 0, 0))]
    left = [((0, 0, 2), (0, 0, 0), (0, 2, 0), (0, 2, 2))]
    back = [((0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0))]
    writer.node(name="corner", mesh=writer.mesh("corner", [
        writer.quads(floor, white), writer.quads(left, red), writer.quads(back, white)]))
    writer.node(name="block", mesh=writer.mesh("block", [
        writer.quads(box_quads((0.5, 0, 0.4), (1.0, 0.5, 0.8)), blue)]))
    positions, triangles = icosphere(1)
    sphere = writer.mesh("bulb", [writer.primitive(positions, triangles, bulb, normals=positions)])
    writer.node(name="bulb", mesh=sphere, translation=[1.1, 0.9, 1.1], scale=[0.02, 0.02, 0.02])
    writer.camera("camera", (2.6, 1.6, 3.0), math.radians(38), aspect=1,
                  rotation=looking((2.6, 1.6, 3.0), (0.75, 0.6, 0.6)))
    return writer.text()


def looking(eye, target):
    """The rotation (x, y, z, w) of a camera that looks from eye to target, its x axis level."""
    d = [target[i] - eye[i] for i in range(3)]
    turn = math.atan2(-d[0], -d[2]) / 2.0
    tilt = math.atan2(d[1], math.sqrt(d[0] * d[0] + d[2] * d[2])) / 2.0
    return (math.cos(turn) * math.sin(tilt), math.sin(turn) * math.cos(tilt),
            -math.sin(turn) * math.sin(tilt), math.cos(turn) * math.cos(tilt))


def terrace():
    """A wall and a few things on a floor under a sun, a lamp and a spot: shadows of every kind, a corner that
    the sky hardly reaches, and a pane of frosted glass."""
    writer = GltfWriter()
    stone = writer.material("stone", [0.55, 0.52, 0.48])
    plaster = writer.material("plaster", [0.7, 0.66, 0.6])
    red = writer.material("red plastic", [0.5, 0.05, 0.04], roughnessFactor=0.25)
    gold = writer.material("gold", [1.0, 0.77, 0.34], roughnessFactor=0.35, metallicFactor=1)
    pane = writer.material("frosted", [0.85, 0.95, 1.0], None, {
        "KHR_materials_transmission": {"transmissionFactor": 1}}, roughnessFactor=0.3)
    writer.node(name="floor", mesh=writer.mesh("floor", [writer.quads([floor_quad(4, 3)], stone)]))
    writer.node(name="wall", mesh=writer.mesh("wall", [
        writer.quads(box_quads((-4, 0, -3.3), (4, 2.2, -3)), plaster)]))
    posts = [quad for i in range(5) for quad in box_quads((-3.2 + 0.5 * i, 0, -1.4), (-3.1 + 0.5 * i, 1.4, -1.3))]
    writer.node(name="posts", mesh=writer.mesh("posts", [writer.quads(posts, plaster)]))
    writer.node(name="block", mesh=writer.mesh("block", [
        writer.quads(box_quads((1.6, 0, -2.2), (2.6, 1.2, -1.4)), stone)]))
    positions, triangles = icosphere(4)
    for name, material, place, size in (("ball", red, [-0.2, 0.5, -0.6], 0.5), ("bead", gold, [0.9, 0.3, 0.2], 0.3),
                                        ("globe", gold, [-1.6, 0.25, 0.7], 0.25)):
        sphere = writer.mesh(name, [writer.primitive(positions, triangles, material, normals=positions)])
        writer.node(name=name, mesh=sphere, translation=place, scale=[size] * 3)
    writer.node(name="pane", mesh=writer.mesh("pane", [
        writer.quads(box_quads((0.3, 0, 0.72), (1.9, 1.1, 0.74)), pane)]))
    writer.punctual_light({"type": "directional"}, [1, 0.93, 0.8], 2.2,
                          rotation=rounded(looking((3, 4, 2.5), (0, 0, 0)), 8))
    writer.punctual_light({"type": "spot", "spot": {"innerConeAngle": 0.25, "outerConeAngle": 0.5}},
                          [0.5, 0.7, 1], 20, translation=[-3.2, 2.6, 1.5],
                          rotation=rounded(looking((-3.2, 2.6, 1.5), (-1.8, 0, -0.6)), 8))
    writer.point_light([1, 0.6, 0.3], 2.5, (2.1, 1.7, -0.9))
    eye = (1.2, 2.3, 5.6)
    writer.camera("camera", eye, math.radians(36), aspect=1.6, rotation=looking(eye, (0, 0.35, -0.4)))
    return writer.text()


def hue(share, saturation):
    return colorsys.hsv_to_rgb(share % 1.0, saturation, 1.0)


def shard(pick):
    """A small triangle somewhere above the floor, its front within 70 degrees of downwards."""
    while True:
        down = (pick(-1, 1), pick(-1, -0.34), pick(-1, 1))
        length = math.sqrt(sum(x * x for x in down))
        if length <= 1.0 and down[1] / length < -0.342:
            break
    n = [x / length for x in down]
    level = math.sqrt(n[1] * n[1] + n[2] * n[2])
    u = (0.0, n[2] / level, -n[1] / level)
    v = (n[1] * u[2] - n[2] * u[1], n[2] * u[0] - n[0] * u[2], n[0] * u[1] - n[1] * u[0])
    size = pick(0.03, 0.15)
    center = (pick(-15, 15), pick(0.3, 2.5), pick(-15, 15))
    corners = ((1.0, 0.0), (-0.5, 0.8660254), (-0.5, -0.8660254))
    return [tuple(round(center[i] + size * (a * u[i] + b * v[i]), 5) for i in range(3)) for a, b in corners]


def many_lights():
    """2,000 emissive triangles of 40 colors and strengths and 200 point lights over a floor of 30 by 30
    meters, with walls and columns between them: each place is lit by few of them."""
    writer = GltfWriter()
    pick = Picker(7)
    ground = writer.material("ground", [0.6, 0.6, 0.6])
    stone = writer.material("stone", [0.5, 0.45, 0.4])
    writer.node(name="floor", mesh=writer.mesh("floor", [writer.quads([floor_quad(15, 15)], ground)]))
    walls = [((-6, 0, -9), (-5.7, 3, 5)), ((3, 0, -2), (11, 3, -1.7)), ((-13, 0, -6.3), (-8, 3, -6))]
    places = ((0, 6), (4, 4), (8, 7), (-3, -5), (1, -8), (9, -9))
    columns = [((x, 0, z), (x + 0.5, 3, z + 0.5)) for x, z in places]
    occluders = [quad for lower, upper in walls + columns for quad in box_quads(lower, upper)]
    writer.node(name="occluders", mesh=writer.mesh("occluders", [writer.quads(occluders, stone)]))
    primitives = []
    for i in range(40):
        radiance = 2.0 * 100.0 ** (i / 39.0)  # 2 to 200
        color = [radiance * c for c in hue(0.382 * i, 0.6)]
        light = writer.material(f"light {i}", [0, 0, 0], color)
        corners = [corner for _ in range(50) for corner in shard(pick)]
        triangles = [(3 * k, 3 * k + 1, 3 * k + 2) for k in range(50)]
        primitives.append(writer.primitive(corners, triangles, light))
    writer.node(name="shards", mesh=writer.mesh("shards", primitives))
    for i in range(200):
        place = (pick(-15, 15), pick(0.3, 2.5), pick(-15, 15))
        writer.point_light(hue(0.618 * i, 0.5), 0.02 * 100.0 ** pick(0, 1), place)
    eye = (0, 9, 21)
    writer.camera("camera", eye, math.radians(45), aspect=1.5, rotation=looking(eye, (0, 0, 1)))
    return writer.text()
