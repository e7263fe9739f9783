"""Scenes under light: the Cornell box, many lights, points and lines, rows of materials."""

import colorsys
import math

from gltf_writer import GltfWriter, rounded
from shapes import Picker, box_quads, floor_quad, icosphere, lathe


# The Cornell box as it was measured: Cornell University Program of Computer Graphics, "Cornell Box Data".
#
# Lengths are in millimeters, x to the left of the camera, y up, z away from it. Reflectances run from 400 to
# 700 nm in steps of 4 nm.

WHITE = (
    .343, .445, .551, .624, .665, .687, .708, .723, .715, .710, .745, .758, .739, .767, .777, .765,
    .751, .745, .748, .729, .745, .757, .753, .750, .746, .747, .735, .732, .739, .734, .725, .721,
    .733, .725, .732, .743, .744, .748, .728, .716, .733, .726, .713, .740, .754, .764, .752, .736,
    .734, .741, .740, .732, .745, .755, .751, .744, .731, .733, .744, .731, .712, .708, .729, .730,
    .727, .707, .703, .729, .750, .760, .751, .739, .724, .730, .740, .737)
GREEN = (
    .092, .096, .098, .097, .098, .095, .095, .097, .095, .094, .097, .098, .096, .101, .103, .104,
    .107, .109, .112, .115, .125, .140, .160, .187, .229, .285, .343, .390, .435, .464, .472, .476,
    .481, .462, .447, .441, .426, .406, .373, .347, .337, .314, .285, .277, .266, .250, .230, .207,
    .186, .171, .160, .148, .141, .136, .130, .126, .123, .121, .122, .119, .114, .115, .117, .117,
    .118, .120, .122, .128, .132, .139, .144, .146, .150, .152, .157, .159)
RED = (
    .040, .046, .048, .053, .049, .050, .053, .055, .057, .056, .059, .057, .061, .061, .060, .062,
    .062, .062, .061, .062, .060, .059, .057, .058, .058, .058, .056, .055, .056, .059, .057, .055,
    .059, .059, .058, .059, .061, .061, .063, .063, .067, .068, .072, .080, .090, .099, .124, .154,
    .192, .255, .287, .349, .402, .443, .487, .513, .558, .584, .620, .606, .609, .651, .612, .610,
    .650, .638, .627, .620, .630, .628, .642, .639, .657, .639, .635, .642)

# Emission of the lamp at 400, 500, 600 and 700 nm, linear in between; its reflectance is 0.78 throughout.
LAMP = (0.0, 8.0, 15.6, 18.4)
LAMP_REFLECTANCE = 0.78

# CIE standard illuminant D65, 400 to 700 nm in steps of 10 nm.
D65 = (
    82.7549, 91.4860, 93.4318, 86.6823, 104.865, 117.008, 117.812, 114.861, 115.923, 108.811, 109.354,
    107.802, 104.790, 107.689, 104.405, 104.046, 100.000, 96.3342, 95.7880, 88.6856, 90.0062, 89.5991,
    87.6987, 83.2886, 83.6992, 80.0268, 80.2146, 82.2778, 78.2842, 69.7213, 71.6091)

FLOOR = ((552.8, 0, 0), (0, 0, 0), (0, 0, 559.2), (549.6, 0, 559.2))
BACK_WALL = ((549.6, 0, 559.2), (0, 0, 559.2), (0, 548.8, 559.2), (556.0, 548.8, 559.2))
RIGHT_WALL = ((0, 0, 559.2), (0, 0, 0), (0, 548.8, 0), (0, 548.8, 559.2))
LEFT_WALL = ((552.8, 0, 0), (549.6, 0, 559.2), (556.0, 548.8, 559.2), (556.0, 548.8, 0))
CEILING_X = (0, 213.0, 343.0, 556.0)  # The lamp fills the middle cell of the ceiling.
CEILING_Z = (0, 227.0, 332.0, 559.2)
CEILING_Y = 548.8
SHORT_BLOCK = (((130, 65), (82, 225), (240, 272), (290, 114)), 165.0)
TALL_BLOCK = (((423, 247), (265, 296), (314, 456), (472, 406)), 330.0)

CAMERA_POSITION = (278.0, 273.0, -800.0)
FOCAL_LENGTH = 0.035
FILM_HEIGHT = 0.025


def interpolate(samples, step, wavelength):
    position = (wavelength - 400.0) / step
    i = min(int(position), len(samples) - 2)
    return samples[i] + (samples[i + 1] - samples[i]) * (position - i)


def observer(wavelength):
    """The CIE 1931 color matching functions, multi-lobe fit of Wyman, Sloan and Shirley 2013 (JCGT 2(2))."""
    def lobe(mean, below, above):
        return math.exp(-0.5 * ((wavelength - mean) / (below if wavelength < mean else above)) ** 2)
    return (1.056 * lobe(599.8, 37.9, 31.0) + 0.362 * lobe(442.0, 16.0, 26.7)
            - 0.065 * lobe(501.1, 20.4, 26.2),
            0.821 * lobe(568.8, 46.9, 40.5) + 0.286 * lobe(530.9, 16.3, 31.1),
            1.217 * lobe(437.0, 11.8, 36.0) + 0.681 * lobe(459.0, 26.0, 13.8))


def linear_srgb(spectrum):
    """The linear sRGB color of a spectrum, in steps of 1 nm; a constant spectrum of 1 has Y = 1."""
    xyz, norm = [0.0, 0.0, 0.0], 0.0
    for wavelength in range(400, 701):
        weights = observer(wavelength)
        norm += weights[1]
        for i in range(3):
            xyz[i] += spectrum(wavelength) * weights[i]
    x, y, z = (value / norm for value in xyz)
    return (3.2404542 * x - 1.5371385 * y - 0.4985314 * z, -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
            0.0556434 * x - 0.2040259 * y + 1.0572252 * z)


def reflectance(samples):
    """The color under D65 as a share, channel by channel, of that of a perfect reflector."""
    lit = linear_srgb(lambda w: interpolate(samples, 4.0, w) * interpolate(D65, 10.0, w))
    white = linear_srgb(lambda w: interpolate(D65, 10.0, w))
    return [a / b for a, b in zip(lit, white)]


def placed(point):
    """Meters, the middle of the box at x = z = 0, the camera looking along -z: half a turn about y."""
    return ((278.0 - point[0]) / 1000.0, point[1] / 1000.0, (279.6 - point[2]) / 1000.0)


def facing(quad, target):
    """The quad with its front towards a point (millimeters)."""
    a, b, c, _ = quad
    u = [b[i] - a[i] for i in range(3)]
    v = [c[i] - a[i] for i in range(3)]
    n = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
    is_facing = sum(n[i] * (target[i] - a[i]) for i in range(3)) > 0
    return quad if is_facing else tuple(reversed(quad))


def block_quads(block):
    corners, height = block
    middle = (sum(c[0] for c in corners) / 4.0, height / 2.0, sum(c[1] for c in corners) / 4.0)
    quads = [tuple((x, height, z) for x, z in corners)]
    for (x0, z0), (x1, z1) in zip(corners, corners[1:] + corners[:1]):
        quads.append(((x0, 0, z0), (x1, 0, z1), (x1, height, z1), (x0, height, z0)))
    return [tuple(reversed(facing(quad, middle))) for quad in quads]


def ceiling_cell(i, k):
    x0, x1, z0, z1 = CEILING_X[i], CEILING_X[i + 1], CEILING_Z[k], CEILING_Z[k + 1]
    return ((x0, CEILING_Y, z0), (x1, CEILING_Y, z0), (x1, CEILING_Y, z1), (x0, CEILING_Y, z1))


def cornell():
    writer = GltfWriter()
    white = writer.material("white", reflectance(WHITE))
    red = writer.material("red", reflectance(RED))
    green = writer.material("green", reflectance(GREEN))
    lamp = writer.material("lamp", [LAMP_REFLECTANCE] * 3, linear_srgb(lambda w: interpolate(LAMP, 100.0, w)))

    inside = (278.0, 273.0, 279.6)
    ceiling = [ceiling_cell(i, k) for i in range(3) for k in range(3) if (i, k) != (1, 1)]
    parts = ((white, [FLOOR, BACK_WALL] + ceiling), (green, [RIGHT_WALL]), (red, [LEFT_WALL]),
             (lamp, [ceiling_cell(1, 1)]))
    room = [writer.quads([[placed(p) for p in facing(quad, inside)] for quad in quads], material)
            for material, quads in parts]
    writer.node(name="room", mesh=writer.mesh("room", room))
    for name, block in (("short block", SHORT_BLOCK), ("tall block", TALL_BLOCK)):
        quads = [[placed(p) for p in quad] for quad in block_quads(block)]
        writer.node(name=name, mesh=writer.mesh(name, [writer.quads(quads, white)]))
    yfov = 2.0 * math.atan(0.5 * FILM_HEIGHT / FOCAL_LENGTH)
    writer.camera("camera", placed(CAMERA_POSITION), yfov, aspect=1)
    return writer.text()


# Scenes that are easy or hard by their lights.

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


# A scene of points and lines, as scanners and CAD programs write them.

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


# Scenes that show materials.

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
