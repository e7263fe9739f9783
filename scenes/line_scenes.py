"""A scene of points and lines, as scanners and CAD programs write them."""

import colorsys
import math

from gltf_writer import GltfWriter, rounded
from light_scenes import looking
from shapes import icosphere

POINTS, LINES, LINE_LOOP, LINE_STRIP = range(4)


def edges(triangles):
    """Each edge once."""
    return sorted({(min(a, b), max(a, b)) for t in triangles for a, b in zip(t, t[1:] + t[:1])})


def moved(positions, scale, offset):
    return [tuple(rounded([scale * x + o for x, o in zip(p, offset)], 5)) for p in positions]


def spiral_sphere(count):
    """Points spread evenly over the unit sphere, along a spiral."""
    turn = math.pi * (3.0 - math.sqrt(5.0))
    points = []
    for i in range(count):
        y = 1.0 - (2.0 * i + 1.0) / count
        ring = math.sqrt(1.0 - y * y)
        points.append((ring * math.cos(turn * i), y, ring * math.sin(turn * i)))
    return points


def points_and_lines():
    """A scanned ball (POINTS, a color each), a wire frame of brass (LINES), a spring whose color changes along
    it (LINE_STRIP) and a glowing ring (LINE_LOOP) on a floor with a back wall, under a lamp."""
    writer = GltfWriter()
    white = writer.material("white", [0.8, 0.8, 0.8])
    wall = [(-4, 0, -2), (4, 0, -2), (4, 5, -2), (-4, 5, -2)]
    floor = [(-4, 0, 4), (4, 0, 4), (4, 0, -2), (-4, 0, -2)]
    writer.node(name="room", mesh=writer.mesh("room", [writer.quads([floor, wall], white)]))

    def drawn(name, mode, positions, material, colors=None, indices=None):
        primitive = writer.lines(mode, positions, material, colors, indices)
        writer.node(name=name, mesh=writer.mesh(name, [primitive]))

    scan = spiral_sphere(2500)
    paint = [tuple(rounded(colorsys.hsv_to_rgb(0.55 + 0.35 * p[1], 0.7, 0.9), 3)) for p in scan]
    chalk = writer.material("chalk", [0.9, 0.9, 0.9])
    drawn("scan", POINTS, moved(scan, 0.7, (-1.6, 0.75, 0)), chalk, paint)

    brass = writer.material("brass", [0.9, 0.6, 0.25], metallicFactor=1, roughnessFactor=0.25)
    positions, triangles = icosphere(1)
    drawn("frame", LINES, moved(positions, 0.7, (0, 0.75, 0)), brass,
          indices=[i for edge in edges(triangles) for i in edge])

    glaze = writer.material("glaze", [1, 1, 1], roughnessFactor=0.15)
    steps = 240
    spring = [(math.cos(t), 2.0 * i / steps - 1.0, math.sin(t))
              for i in range(steps + 1) for t in [10.0 * math.pi * i / steps]]
    fade = [tuple(rounded((0.9 - 0.8 * i / steps, 0.1 + 0.3 * i / steps, 0.1 + 0.8 * i / steps), 3))
            for i in range(steps + 1)]
    drawn("spring", LINE_STRIP, moved(spring, 0.6, (1.6, 0.68, 0)), glaze, fade)

    glow = writer.material("glow", [0, 0, 0], [3.0, 1.8, 0.6])
    ring = [(math.cos(t), 0, math.sin(t)) for i in range(72) for t in [2.0 * math.pi * i / 72]]
    drawn("ring", LINE_LOOP, moved(ring, 0.9, (0, 0.02, 1.3)), glow)

    lamp = writer.material("lamp", [0, 0, 0], [8.0, 8.0, 8.0])
    square = [(-1, 4, 0.5), (1, 4, 0.5), (1, 4, 2.5), (-1, 4, 2.5)]
    writer.node(name="lamp", mesh=writer.mesh("lamp", [writer.quads([square], lamp)]))
    eye = (0, 1.9, 5.2)
    writer.camera("camera", eye, math.radians(38), aspect=1.6, rotation=looking(eye, (0, 0.65, 0)))
    return writer.text()
