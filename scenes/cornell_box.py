"""The Cornell box as it was measured: Cornell University Program of Computer Graphics, "Cornell Box Data".

Lengths are in millimeters, x to the left of the camera, y up, z away from it. Reflectances run from 400 to
700 nm in steps of 4 nm.
"""

import math

from gltf_writer import GltfWriter

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
