"""Shapes as lists of positions, normals and triangles. Fronts face outwards unless asked."""

import math


def icosphere(subdivisions):
    """The unit sphere as a subdivided icosahedron: positions, which are the normals too, and 20 * 4^n
    triangles. Square roots alone: the same on every platform."""
    t = (1.0 + math.sqrt(5.0)) / 2.0

    def unit(v):
        length = math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
        return (v[0] / length, v[1] / length, v[2] / length)

    positions = [unit(v) for v in (
        (-1, t, 0), (1, t, 0), (-1, -t, 0), (1, -t, 0), (0, -1, t), (0, 1, t), (0, -1, -t), (0, 1, -t),
        (t, 0, -1), (t, 0, 1), (-t, 0, -1), (-t, 0, 1))]
    triangles = [
        (0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2),
        (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5),
        (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    for _ in range(subdivisions):
        middles, finer = {}, []

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middles:
                middles[key] = len(positions)
                positions.append(unit([(positions[a][i] + positions[b][i]) / 2.0 for i in range(3)]))
            return middles[key]

        for a, b, c in triangles:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        triangles = finer
    return positions, triangles


def box_quads(lower, upper, is_inward=False):
    """The six sides of an axis-aligned box, fronts outwards unless asked."""
    x0, y0, z0 = lower
    x1, y1, z1 = upper
    quads = [((x1, y0, z1), (x1, y0, z0), (x1, y1, z0), (x1, y1, z1)),
             ((x0, y0, z0), (x0, y0, z1), (x0, y1, z1), (x0, y1, z0)),
             ((x0, y1, z1), (x1, y1, z1), (x1, y1, z0), (x0, y1, z0)),
             ((x0, y0, z0), (x1, y0, z0), (x1, y0, z1), (x0, y0, z1)),
             ((x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)),
             ((x1, y0, z0), (x0, y0, z0), (x0, y1, z0), (x1, y1, z0))]
    return [tuple(reversed(quad)) for quad in quads] if is_inward else quads


def floor_quad(half_width, half_depth, y=0.0):
    """A rectangle about the y axis that faces up."""
    w, d = half_width, half_depth
    return ((-w, y, d), (w, y, d), (w, y, -d), (-w, y, -d))


def lathe(profile, segments):
    """A closed profile of (radius, height) turned about the y axis: from the axis, outwards along the bottom,
    up, and back to the axis. Smooth around, with an edge at every point of the profile; neighbors meet in
    exactly equal positions."""
    positions, normals, triangles = [], [], []
    angles = [2.0 * math.pi * i / segments for i in range(segments)]
    circle = [(round(math.cos(angle), 7), round(math.sin(angle), 7)) for angle in angles]
    for (r0, y0), (r1, y1) in zip(profile, profile[1:]):
        length = math.sqrt((r1 - r0) ** 2 + (y1 - y0) ** 2)
        across, up = (y1 - y0) / length, (r0 - r1) / length
        first = len(positions)
        for x, z in circle:
            positions += [(r0 * x, y0, -r0 * z), (r1 * x, y1, -r1 * z)]
            normals += [(across * x, up, -across * z)] * 2
        for i in range(segments):
            a, b = first + 2 * i, first + 2 * i + 1
            c, d = first + 2 * ((i + 1) % segments), first + 2 * ((i + 1) % segments) + 1
            if r0 > 0:
                triangles.append((a, c, b) if r1 == 0 else (a, c, d))
            if r1 > 0:
                triangles.append((a, d, b))
    return positions, normals, triangles


class Picker:
    """Numbers as if at random, the same everywhere: Numerical Recipes' linear congruential generator."""

    def __init__(self, state=1):
        self.state = state

    def __call__(self, low, high):
        self.state = (self.state * 1664525 + 1013904223) % 2 ** 32
        return low + (high - low) * (self.state >> 8) / 2 ** 24
