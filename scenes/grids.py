"""Test grids: pictures of labelled cells, each of which shows one feature of glTF."""

import math
import struct

from encoders import (
    DRACO_NORMAL, DRACO_POSITION, DRACO_TEXCOORD, MODIFIERS, UASTC, bc1_block, bc2_block,
    bc3_block, bc4_block, bc7_block, dds, draco, etc1s, ktx2, meshopt_attributes,
    meshopt_triangles, png_palette, png_wide, uastc_block, webp, wide)
from gltf_writer import (
    ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER, FLOAT, GltfWriter, UNSIGNED_INT, UNSIGNED_SHORT, png,
    png_file, stored)
from lit_scenes import D65, interpolate, linear_srgb
from shapes import box_quads


# Test pictures: cells in columns and rows with labels, each cell a pair of squares of side 1. The left one
# shows what is tested, the right one, in front of the plane of the others, what should be seen. Nothing that is
# expected is lit or seen from behind, so it changes no light.

WIDE, HIGH = 2.5, 1.5  # of a cell, with the gaps
TOP = 0.75             # for the labels of columns
DOT = 1 / 16           # of a letter; the pixel of a picture in which a square has 16
FRONT = 3.0            # z of what is expected

# Rows of three dots, the left one the highest bit.
FONT = {
    "0": "75557", "1": "26227", "2": "71747", "3": "71317", "4": "55711", "5": "74717", "6": "74757",
    "7": "71122", "8": "75757", "9": "75717", "A": "25755", "B": "65656", "C": "34443", "D": "65556",
    "E": "74647", "F": "74644", "G": "34553", "H": "55755", "I": "72227", "J": "11152", "K": "55655",
    "L": "44447", "M": "57755", "N": "65555", "O": "25552", "P": "65644", "Q": "25573", "R": "65655",
    "S": "34216", "T": "72222", "U": "55557", "V": "55552", "W": "55775", "X": "55255", "Y": "55222",
    "Z": "71247", ".": "00002", "-": "00700", "+": "02720", "/": "11244", " ": "00000"}

SQUARE = ((-0.5, -0.5, 0), (0.5, -0.5, 0), (0.5, 0.5, 0), (-0.5, 0.5, 0))
UPRIGHT = ((0, 1), (1, 1), (1, 0), (0, 0))


def label_picture(labels):
    """Black on white, a line of 7 dots for each: a PNG, its width and height."""
    width = 4 * max(len(label) for label in labels) + 1
    rows = []
    for label in labels:
        for line in (None, 0, 1, 2, 3, 4, None):
            dots = [1] * width
            for i, letter in enumerate(label):
                bits = 0 if line is None else int(FONT[letter][line])
                for x in range(3):
                    if bits >> (2 - x) & 1:
                        dots[4 * i + 1 + x] = 0
            rows.append(dots)
    packed = b""
    for dots in rows:
        dots = dots + [1] * (-len(dots) % 8)
        packed += b"\0" + bytes(sum(dot << (7 - k) for k, dot in enumerate(dots[i:i + 8]))
                                for i in range(0, len(dots), 8))
    header = struct.pack(">IIBBBBB", width, len(rows), 1, 0, 0, 0, 0)
    return png_file(header, stored(packed)), width, len(rows)


class TestGrid:
    """Labels of columns and rows, or, with `cells`, of each cell, so many of them `across`."""

    def __init__(self, columns=(), rows=(), cells=(), across=0, front=FRONT):
        self.writer = GltfWriter()
        self.columns, self.rows, self.cells, self.front = columns, rows, cells, front
        self.across = across or len(columns)
        self.down = len(rows) or -(-len(cells) // across)
        assert all(4 * len(label) + 1 < WIDE / DOT for label in (*columns, *cells)), "labels overlap"
        self.left = 4 * DOT * max([len(row) for row in rows], default=-1) + 0.5
        self.square = None
        self.nearest = None

    def sampler(self):
        if self.nearest is None:
            self.nearest = self.writer.add("samplers", {"magFilter": 9728, "minFilter": 9728,
                                                        "wrapS": 33071, "wrapT": 33071})
        return self.nearest

    def texture(self, image):
        return self.writer.add("textures", {"sampler": self.sampler(), "source": image})

    def center(self, column, row):
        """Of the left square of a pair."""
        return (self.left + WIDE * column + 0.5, -(TOP + HIGH * row + 0.5))

    def square_of(self, material):
        """The square as a primitive of its own, its texture coordinates upright."""
        if self.square is None:
            self.square = self.writer.primitive(SQUARE, ((0, 1, 2), (0, 2, 3)), 0, [(0, 0, 1)] * 4, [UPRIGHT])
        return {**self.square, "material": material}

    def unlit(self, name, color, **fields):
        return self.writer.material(name, color, None, {"KHR_materials_unlit": {}}, **fields)

    def name(self, column, row):
        if self.cells:
            return self.cells[row * self.across + column]
        return self.rows[row] + " " + self.columns[column]

    def place(self, column, row, primitive, z=0.0, **fields):
        """What is tested."""
        name = self.name(column, row)
        x, y = self.center(column, row)
        return self.writer.node(name=name, mesh=self.writer.mesh(name, [primitive]), translation=[x, y, z],
                                **fields)

    def expect(self, column, row, primitive):
        """What should be seen; its bounds tell the tests where."""
        name = "expected " + self.name(column, row)
        x, y = self.center(column, row)
        self.writer.node(name=name, mesh=self.writer.mesh(name, [primitive]),
                         translation=[x + 1, y, self.front])

    def expect_nodes(self, column, row, primitive, placements):
        """As nodes of their own: placements are translations, rotations and scales within the square. An
        invisible square tells the tests where."""
        x, y = self.center(column, row)
        mesh = self.writer.mesh(self.name(column, row), [primitive])
        for translation, rotation, scale in placements:
            at = [x + 1 + translation[0], y + translation[1], self.front + translation[2]]
            self.writer.node(name=self.name(column, row) + " by itself", mesh=mesh, translation=at,
                             rotation=list(rotation), scale=list(scale))
        hole = self.unlit("nothing", [0, 0, 0], alphaMode="MASK")
        self.writer.root["materials"][hole]["pbrMetallicRoughness"]["baseColorFactor"][3] = 0
        self.expect(column, row, self.square_of(hole))

    def expect_color(self, column, row, color):
        self.expect(column, row, self.square_of(self.unlit("expected " + self.name(column, row), color)))

    def text(self):
        self.add_labels()
        width = self.left + WIDE * self.across
        height = TOP + HIGH * self.down
        camera = self.writer.add("cameras", {"name": "camera", "type": "orthographic", "orthographic": {
            "xmag": width / 2, "ymag": height / 2, "znear": 0.1, "zfar": 1e5}})
        self.writer.node(name="camera", camera=camera, translation=[width / 2, -height / 2, 20])
        return self.writer.text()

    def add_labels(self):
        """Of rows at the left of their squares, of columns and cells above them."""
        above = lambda column, row: (self.center(column, row)[0] - 0.5, self.center(column, row)[1] + 1)
        places = [(0.25, self.center(0, row)[1] + 4 * DOT, label) for row, label in enumerate(self.rows)]
        places += [(*above(column, 0), label) for column, label in enumerate(self.columns)]
        places += [(*above(i % self.across, i // self.across), label) for i, label in enumerate(self.cells)]
        png, width, height = label_picture([label for _, _, label in places])
        positions, uvs, triangles, z = [], [], [], self.front
        for i, (x, y, label) in enumerate(places):
            dots = 4 * len(label) + 1
            first = len(positions)
            right, low = x + dots * DOT, y - 7 * DOT
            positions += [(x, low, z), (right, low, z), (right, y, z), (x, y, z)]
            u, v0, v1 = dots / width, 7 * i / height, 7 * (i + 1) / height
            uvs += [(0, v1), (u, v1), (u, v0), (0, v0)]
            triangles += [(first, first + 1, first + 2), (first, first + 2, first + 3)]
        texture = self.texture(self.writer.image("labels", png))
        material = self.unlit("labels", [1, 1, 1], baseColorTexture={"index": texture})
        primitive = self.writer.primitive(positions, triangles, material, [(0, 0, 1)] * len(positions), [uvs])
        self.writer.node(name="labels", mesh=self.writer.mesh("labels", [primitive]))


# What a slab of a medium that scatters returns in light from all sides, computed without random numbers by
# doubling (van de Hulst 1963; Hansen and Travis 1974, "Light Scattering in Planetary Atmospheres"): from a
# layer so thin that light scatters once in it, to ever thicker ones.

NODES = 8


def legendre(order, x):
    """P_order and its derivative."""
    before, value = 1.0, x
    for n in range(2, order + 1):
        before, value = value, ((2 * n - 1) * x * value - (n - 1) * before) / n
    return value, order * (x * value - before) / (x * x - 1)


def gauss_nodes(count):
    """Nodes and weights of Gauss and Legendre's quadrature on 0 ... 1."""
    nodes, weights = [], []
    for i in range(count):
        x = math.cos(math.pi * (i + 0.75) / (count + 0.5))
        for _ in range(50):
            value, slope = legendre(count, x)
            x -= value / slope
        slope = legendre(count, x)[1]
        nodes.append((1 + x) / 2)
        weights.append(1 / ((1 - x * x) * slope * slope))
    return nodes, weights


def returned_light(albedo, g, depth):
    """The radiance towards the normal of a slab, in light of radiance 1 from all directions: `depth` mean
    free paths thick, single-scattering albedo, mean cosine g of Henyey and Greenstein's phase function."""
    nodes, weights = gauss_nodes(NODES)
    nodes, weights = nodes + [1.0], weights + [0.0]  # the direction that is asked for
    size = len(nodes)
    legendres = [[1.0, mu] for mu in nodes]
    for values, mu in zip(legendres, nodes):
        for n in range(2, 2 * NODES):
            values.append(((2 * n - 1) * mu * values[-1] - (n - 1) * values[-2]) / n)

    def phase(i, k, sign):
        """Its mean over the azimuth."""
        return sum((2 * n + 1) * (g * sign) ** n * legendres[i][n] * legendres[k][n]
                   for n in range(2 * NODES))

    def times(a, b):
        columns = list(zip(*b))
        scaled = [[2 * value * mu * w for value, mu, w in zip(row, nodes, weights)] for row in a]
        return [[sum(map(float.__mul__, row, column)) for column in columns] for row in scaled]

    def plus(*matrices):
        return [[sum(values) for values in zip(*rows)] for rows in zip(*matrices)]

    doublings = max(1, math.ceil(math.log2(depth * 2.0 ** 22)))
    thin = depth / 2.0 ** doublings
    pairs = [[albedo * thin / (4 * a * b) for b in nodes] for a in nodes]
    back = [[pairs[i][k] * phase(i, k, -1) for k in range(size)] for i in range(size)]
    through = [[pairs[i][k] * phase(i, k, 1) for k in range(size)] for i in range(size)]
    for step in range(doublings):
        direct = [math.exp(-thin * 2.0 ** step / mu) for mu in nodes]
        after = lambda m: [[value * e for value, e in zip(row, direct)] for row in m]
        before = lambda m: [[value * e for value in row] for row, e in zip(m, direct)]
        # Light between the two halves: all numbers of reflections.
        once = times(back, back)
        power, between = once, once
        while max(map(max, power)) > 1e-9:
            between = plus(between, times(power, between))
            power = times(power, power)
        down = plus(through, after(between), times(between, through))
        up = plus(after(back), times(back, down))
        back = plus(back, before(up), times(through, up))
        through = plus(before(down), after(through), times(through, down))
    seen = sum(2 * mu * w * (r + t) for mu, w, r, t in zip(nodes, weights, back[-1], through[-1]))
    return seen + math.exp(-depth)


# Test pictures of layers on surfaces: squares that are turned away from the viewer in an environment of
# radiance 1, beside closed forms of what they reflect and let pass.

APART = 100.0  # meters along the view: so far from each other squares do not light one another


def schlick(f0, cosine, f90=1.0):
    return f0 + (f90 - f0) * (1 - cosine) ** 5


def sheen_albedo(roughness, cosine):
    """What white sheen returns of light from all sides: Conty and Kulla 2017, "Production Friendly Microfacet
    Sheen BRDF", integrated over the hemisphere."""
    alpha = roughness * roughness
    t = (1 - alpha) ** 2
    mix = lambda rough, smooth: rough + (smooth - rough) * t
    a, b, c, d, e = (mix(21.5473, 25.3245), mix(3.82987, 3.32435), mix(0.19823, 0.16801),
                     mix(-1.97760, -1.27393), mix(-4.32054, -4.85967))
    fit = lambda x: a / (1 + b * x ** c) + d * x + e
    shadowed = lambda x: math.exp(fit(x) if x < 0.5 else 2 * fit(0.5) - fit(1 - x))
    sine, steps, turns = math.sqrt(1 - cosine * cosine), 100, 60
    total = 0.0
    for i in range(steps):
        mu = (i + 0.5) / steps
        masking = 1 + shadowed(cosine) + shadowed(mu)
        for k in range(turns):
            turn = math.pi * (k + 0.5) / turns
            x = math.sqrt(1 - mu * mu) * math.cos(turn) + sine
            y = math.sqrt(1 - mu * mu) * math.sin(turn)
            half2 = (mu + cosine) ** 2 / (x * x + y * y + (mu + cosine) ** 2)
            density = (2 + 1 / alpha) * max(1 - half2, 0) ** (0.5 / alpha) / (2 * math.pi)
            total += density / (4 * cosine * masking)
    return total * 2 * math.pi / (steps * turns)


def place_turned(grid, column, row, material, angle, back=0.0):
    """The square turned about the vertical axis and so wide that it fills its cell; `back` meters behind
    where others are."""
    half = math.radians(angle) / 2
    grid.place(column, row, grid.square_of(material), -APART * (column + row * grid.across) - back,
               rotation=[0, round(math.sin(half), 8), 0, round(math.cos(half), 8)],
               scale=[round(1 / math.cos(2 * half), 6), 1, 1])


def layers_grid():
    angles = (0, 30, 50, 65, 75)
    gold, glow, tint, violet = (1, 0.7, 0.3), (0.1, 0.5, 0.2), (0.9, 0.7, 0.5), (0.6, 0.2, 0.8)
    behind = (0.2, 0.5, 0.8)  # the wall, straight on
    dull = {"KHR_materials_specular": {"specularFactor": 0}}
    coat = lambda factor: {**dull, "KHR_materials_clearcoat": {"clearcoatFactor": factor}}
    sheen = {**dull, "KHR_materials_sheen": {"sheenColorFactor": violet, "sheenRoughnessFactor": 0.9}}
    sheen_at = {angle: sheen_albedo(0.9, math.cos(math.radians(angle))) for angle in angles}
    smooth = {"roughnessFactor": 0}
    # Label, base color, emission, extensions, fields, what is seen at a cosine of the angle
    kinds = [
        ("METAL", gold, None, {}, {**smooth, "metallicFactor": 1},
         lambda c, _: [schlick(f0, c) for f0 in gold]),
        ("SPECULAR", (0, 0, 0), None,
         {"KHR_materials_specular": {"specularFactor": 0.8, "specularColorFactor": [4, 2, 1]}}, smooth,
         lambda c, _: [0.8 * schlick(0.04 * f, c) for f in (4, 2, 1)]),
        ("IOR 2", (0, 0, 0), None, {"KHR_materials_ior": {"ior": 2}}, smooth,
         lambda c, _: [schlick(1 / 9, c)] * 3),
        ("COAT", (0, 0, 0), None, coat(1), {}, lambda c, _: [schlick(0.04, c)] * 3),
        ("COAT ON GLOW", (0, 0, 0), glow, coat(0.5), {},
         lambda c, _: [0.5 * schlick(0.04, c) + (1 - 0.5 * schlick(0.04, c)) * light for light in glow]),
        ("SHEEN", (0, 0, 0), None, sheen, {}, lambda _, angle: [v * sheen_at[angle] for v in violet]),
        ("SHEEN ON WHITE", (1, 1, 1), None, sheen, {},
         lambda _, angle: [1 - (max(violet) - v) * sheen_at[angle] for v in violet]),
        ("THIN WALL", tint, None, {"KHR_materials_transmission": {"transmissionFactor": 1}}, smooth,
         lambda c, _: [schlick(0.04, c) + (1 - schlick(0.04, c)) * t * b for t, b in zip(tint, behind)])]
    grid = TestGrid([f"ANGLE {angle}" for angle in angles], [kind[0] for kind in kinds])
    wall, plate = grid.rows.index("THIN WALL"), grid.unlit("behind", behind)
    for row, (_, base, emission, extensions, fields, seen) in enumerate(kinds):
        material = grid.writer.material(grid.rows[row], base, emission, extensions, **fields)
        for column, angle in enumerate(angles):
            place_turned(grid, column, row, material, angle)
            if row == wall:
                place_turned(grid, column, row, plate, 0, 10)
            grid.expect_color(column, row, seen(math.cos(math.radians(angle)), angle))
    return grid.text()


def film_color(ior, thickness, cosine):
    """What a film in air reflects of daylight, relative to a white: Airy's formula, both polarizations."""
    inside = math.sqrt(1 - (1 - cosine * cosine) / (ior * ior))
    faces = ((cosine - ior * inside) / (cosine + ior * inside),
             (ior * cosine - inside) / (ior * cosine + inside))

    def reflected(wavelength):
        wave = 4 * math.pi * ior * thickness * inside / wavelength
        total = 0.0
        for r in faces:
            depth = 4 * r * r / (1 - r * r) ** 2 * math.sin(wave / 2) ** 2
            total += depth / (1 + depth) / 2
        return total

    daylight = lambda wavelength: interpolate(D65, 10, wavelength)
    white = linear_srgb(daylight)
    color = linear_srgb(lambda wavelength: reflected(wavelength) * daylight(wavelength))
    return [max(0.0, c / w) for c, w in zip(color, white)]


def films_grid():
    """Films over a metal that reflects nothing but at grazing angles: soap bubbles."""
    thicknesses = (100, 200, 300, 400, 500, 600)
    kinds = [(1.3, 0), (1.6, 0), (2, 0), (1.6, 60)]
    grid = TestGrid([f"{thickness} NM" for thickness in thicknesses],
                    [f"IOR {ior:g} ANGLE {angle}" for ior, angle in kinds])
    for row, (ior, angle) in enumerate(kinds):
        cosine = math.cos(math.radians(angle))
        for column, thickness in enumerate(thicknesses):
            material = grid.writer.material(grid.name(column, row), [0, 0, 0], None, {
                "KHR_materials_iridescence": {"iridescenceFactor": 1, "iridescenceIor": ior,
                                              "iridescenceThicknessMaximum": thickness}},
                roughnessFactor=0, metallicFactor=1)
            place_turned(grid, column, row, material, angle)
            film = film_color(ior, thickness, cosine)
            grid.expect_color(column, row, [schlick(0, cosine) + c for c in film])
    return grid.text()


# Test pictures of materials that scatter light: squares beside the radiance that they should have.

def multiscatter_color(albedo, g):
    """The color whose single-scattering albedo is `albedo`, by KHR_materials_volume_scatter's formula."""
    def albedo_of(color):
        s = 4.09712 + 4.20863 * color - math.sqrt(9.59217 + 41.6808 * color + 17.7126 * color * color)
        return (1 - s * s) / (1 - g * s * s)

    low, high = 0.0, 1.0
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (middle, high) if albedo_of(middle) < albedo else (low, middle)
    return 1.0 if albedo == 1 else high


def scattering_grid():
    """Slabs of media that scatter, for an environment of radiance 1 on all sides. Their index is 1, so that
    the surface neither reflects nor refracts; they reach farther than the squares that are seen of them, so
    that what is seen is a slab without end. The last column has another albedo for each color."""
    albedos = [(value,) * 3 for value in (0.5, 0.8, 0.9, 0.98, 1)] + [(0.98, 0.8, 0.3)]
    path = 0.005  # mean free path, in meters
    kinds = [(0, 1), (0, 3), (0, 10), (0.5, 10), (-0.5, 10)]  # mean cosine, depth in mean free paths
    grid = TestGrid([f"A {albedo[0]:g}" for albedo in albedos[:-1]] + ["A RGB"],
                    [f"D {depth:g} G {g:g}" for g, depth in kinds])
    shapes = {}
    seen = {}
    for row, (g, depth) in enumerate(kinds):
        for column, albedo in enumerate(albedos):
            thickness = depth * path
            if thickness not in shapes:
                quads = box_quads((-0.7, -0.7, -thickness), (1.7, 0.7, 0))
                shapes[thickness] = grid.writer.quads(quads, 0)
            material = grid.writer.material(grid.name(column, row), [1, 1, 1], None, {
                "KHR_materials_ior": {"ior": 1},
                "KHR_materials_transmission": {"transmissionFactor": 1},
                "KHR_materials_volume": {"thicknessFactor": thickness, "attenuationDistance": path,
                                         "attenuationColor": [0.367879441] * 3},  # 1 / e
                "KHR_materials_volume_scatter": {
                    "multiscatterColorFactor": [round(multiscatter_color(a, g), 6) for a in albedo],
                    "scatterAnisotropy": g}}, roughnessFactor=0)
            grid.place(column, row, {**shapes[thickness], "material": material})
            for a in albedo:
                if (a, g, depth) not in seen:
                    seen[a, g, depth] = 1.0 if a == 1 else round(returned_light(a, g, depth), 4)
            grid.expect_color(column, row, [seen[a, g, depth] for a in albedo])
    return grid.text()


FRONT_LIGHT, BACK_LIGHT = (1, 0.6, 0.2), (0.2, 0.6, 1)


def lit_from_both_sides(grid):
    """Directional lights of pi lux times a color, in front of the squares and behind them: white that
    reflects all is as bright as that color."""
    for color, turn in ((FRONT_LIGHT, [0, 0, 0, 1]), (BACK_LIGHT, [0, 1, 0, 0])):
        grid.writer.punctual_light({"type": "directional"}, color, math.pi, rotation=turn)


def diffuse_transmission_grid():
    """Sheets between an orange light in front and a blue one behind: reflected (1 - t) of the one in the base
    color, t of the other in the color of the transmission. They have no Fresnel layer."""
    factors = (0, 0.25, 0.5, 0.75, 1)
    white, red, green = [1, 1, 1], [0.9, 0.2, 0.1], [0.1, 0.8, 0.3]
    kinds = [("WHITE", white, white, False), ("TINTED", red, green, False), ("TEXTURES", red, white, True)]
    grid = TestGrid([f"T {factor:g}" for factor in factors], [name for name, *_ in kinds])
    # One texel: of the factor's picture alpha counts alone, of the color's red, green and blue, as sRGB.
    factor_texture = grid.texture(grid.writer.image("factor", png([[(255, 0, 40, 128)]])))
    color_texel = (230, 160, 60)
    color_texture = grid.texture(grid.writer.image("color", png([[color_texel]])))
    for row, (_, base, color, has_textures) in enumerate(kinds):
        for column, factor in enumerate(factors):
            transmission = {"diffuseTransmissionFactor": factor, "diffuseTransmissionColorFactor": color}
            share, tint = factor, color
            if has_textures:
                transmission["diffuseTransmissionTexture"] = {"index": factor_texture}
                transmission["diffuseTransmissionColorTexture"] = {"index": color_texture}
                share = factor * 128 / 255
                tint = [((c / 255 + 0.055) / 1.055) ** 2.4 for c in color_texel]
            material = grid.writer.material(grid.name(column, row), base, None, {
                "KHR_materials_specular": {"specularFactor": 0},
                "KHR_materials_diffuse_transmission": transmission})
            grid.place(column, row, grid.square_of(material))
            grid.expect_color(column, row, [(1 - share) * b * front + share * t * back for b, t, front, back
                                            in zip(base, tint, FRONT_LIGHT, BACK_LIGHT)])
    lit_from_both_sides(grid)
    return grid.text()


# Test pictures of textures: what a file of some format shows beside the same texels as PNG.

SIZE = 16
# A letter that is no mirror image of itself, on paper; the corner at the upper left is another color.
LETTER = ("................", "................", "..############..", "..############..",
          "..############..", "..####..........", "..####..........", "..#########.....",
          "..#########.....", "..####..........", "..####..........", "..####..........",
          "..####..........", "..####..........", "................", "................")
HOLES = ("................",) * 11 + (".............#..", "...........###..", "..........###...",
                                       "..........##....", "................")


def agreed(value, bits):
    """As 8 bits; of numbers that decoders round differently (some repeat the bits), the next smaller one."""
    repeated = lambda v: v << (8 - bits) | v >> (2 * bits - 8)
    while wide(value, bits) != repeated(value):
        value -= 1
    return wide(value, bits)


def blocks():
    """From the upper left, row by row: the color of the paper and of the letter, of 5, 6 and 5 bits, and
    which texel has which. All are different, so that no block can stand for another."""
    result = []
    for y in range(4):
        for x in range(4):
            paper = (agreed(31 - 5 * x, 5), agreed(24 + 12 * y, 6), agreed(10 + 6 * x - 3 * y, 5))
            ink = (agreed(3 + 4 * y, 5), agreed(2 + 3 * x, 6), agreed(2 + 3 * x + y, 5))
            if x == y == 0:
                paper = (agreed(31, 5), 0, 0)
            bits = [int(LETTER[4 * y + i // 4][4 * x + i % 4] == "#") for i in range(16)]
            alphas = [0 if HOLES[4 * y + i // 4][4 * x + i % 4] == "#" else 255 for i in range(16)]
            result.append((paper, ink, bits, alphas))
    return result


def rows_of(blocks):
    """Blocks of 16 texels as rows of the picture."""
    return [[blocks[y // 4 * 4 + x // 4][y % 4 * 4 + x % 4] for x in range(SIZE)] for y in range(SIZE)]


def texels_of(blocks, has_alpha=False, change=lambda color: color):
    return rows_of([[tuple(change((paper, ink)[bit])) + ((alpha if has_alpha else 255),)
                     for bit, alpha in zip(bits, alphas)] for paper, ink, bits, alphas in blocks])


def texture_formats_grid():
    """Each texture has a `source` of magenta as well, for programs that do not know its extension."""
    parts = blocks()
    plain, holes = texels_of(parts), texels_of(parts, True)
    odd = lambda color: [channel | 1 for channel in color]
    raw = lambda rows: b"".join(bytes(texel) for row in rows for texel in row)
    swapped = lambda rows: [[(b, g, r, a) for r, g, b, a in row] for row in rows]
    bc1 = b"".join(bc1_block(*part[:3]) for part in parts)
    bc1_holes = b"".join(bc1_block(*part) for part in parts)
    bc2 = b"".join(bc2_block(*part) for part in parts)
    bc3 = b"".join(bc3_block(*part) for part in parts)
    bc7 = b"".join(bc7_block(odd(paper), odd(ink), bits) for paper, ink, bits, _ in parts)
    uastc = b"".join(uastc_block(*part[:3]) for part in parts)
    red = b"".join(bc4_block([(paper, ink)[bit][0] for bit in bits]) for paper, ink, bits, _ in parts)
    red_green = b"".join(bc4_block([(paper, ink)[bit][c] for bit in bits])
                         for paper, ink, bits, _ in parts for c in (0, 1))
    # Of ETC1S: colors in the middle of paper and letter, made brighter and darker.
    tones = [([channel + 3 >> 3 for channel in map(lambda a, b: (a + b) // 2, paper, ink)], (i % 4) + 3,
              [1 - bit for bit in bits]) for i, (paper, ink, bits, _) in enumerate(parts)]
    toned = rows_of([[tuple(max(0, min(255, (channel << 3 | channel >> 2) + MODIFIERS[table] * (2 * bit - 1)))
                            for channel in color) + (255,) for bit in bits] for color, table, bits in tones])
    only = lambda count: texels_of(parts, change=lambda color: list(color[:count]) + [0] * (3 - count))
    four = ((0, 0, 64),)
    eight = ((0, 0, 128),)
    alpha_color = ((15, 0, 64), (0, 64, 64))
    webp_key, ktx_key, dds_key = "EXT_texture_webp", "KHR_texture_basisu", "MSFT_texture_dds"
    cells = [
        ("PNG 256", None, png_palette(plain), plain),
        ("PNG 16", None, png_wide(holes), holes),
        ("WEBP", webp_key, webp(holes), holes),
        ("KTX RGBA8", ktx_key, ktx2(SIZE, raw(holes), 43), holes),
        ("KTX ZSTD", ktx_key, ktx2(SIZE, raw(holes), 43, supercompression=2), holes),
        ("KTX BC1", ktx_key, ktx2(SIZE, bc1, 132, 128, four, (4, 4, 8)), plain),
        ("KTX BC1 A", ktx_key, ktx2(SIZE, bc1_holes, 134, 128, ((1, 0, 64),), (4, 4, 8)), holes),
        ("KTX BC3", ktx_key, ktx2(SIZE, bc3, 138, 130, alpha_color, (4, 4, 16)), holes),
        ("KTX BC4", ktx_key, ktx2(SIZE, red, 139, 131, four, (4, 4, 8)), only(1)),
        ("KTX BC5", ktx_key, ktx2(SIZE, red_green, 141, 132, ((0, 0, 64), (1, 64, 64)), (4, 4, 16)), only(2)),
        ("KTX BC7", ktx_key, ktx2(SIZE, bc7, 146, 134, eight, (4, 4, 16)), texels_of(parts, change=odd)),
        ("BC7 ZSTD", ktx_key, ktx2(SIZE, bc7, 146, 134, eight, (4, 4, 16), 2), texels_of(parts, change=odd)),
        ("UASTC", ktx_key, ktx2(SIZE, uastc, 0, UASTC, eight, (4, 4, 16)), plain),
        ("UASTC ZST", ktx_key, ktx2(SIZE, uastc, 0, UASTC, eight, (4, 4, 16), 2), plain),
        ("ETC1S", ktx_key, etc1s(SIZE, tones), toned),
        ("DDS RGBA8", dds_key, dds(SIZE, raw(holes)), holes),
        ("DDS BGRA8", dds_key, dds(SIZE, raw(swapped(holes)), dxgi=87), holes),
        ("DDS BC1", dds_key, dds(SIZE, bc1_holes, b"DXT1"), holes),
        ("DDS BC2", dds_key, dds(SIZE, bc2, b"DXT3"), holes),
        ("DDS BC3", dds_key, dds(SIZE, bc3, b"DXT5"), holes),
        ("DDS BC4", dds_key, dds(SIZE, red, b"ATI1"), only(1)),
        ("DDS BC5", dds_key, dds(SIZE, red_green, b"ATI2"), only(2)),
        ("DDS BC7", dds_key, dds(SIZE, bc7, dxgi=98), texels_of(parts, change=odd)),
        ("DX10 BC1", dds_key, dds(SIZE, bc1, dxgi=72), plain),
    ]
    grid = TestGrid(cells=[cell[0] for cell in cells], across=6)
    writer = grid.writer
    wrong = writer.image("wrong", png([[(255, 0, 255)]]))
    expected = {}
    for i, (label, key, data, rows) in enumerate(cells):
        column, row = i % 6, i // 6
        kind = {None: "png", webp_key: "webp", ktx_key: "ktx2", dds_key: "vnd-ms.dds"}[key]
        image = writer.image(label, data, kind)
        texture = grid.texture(image)
        if key:
            writer.root["textures"][texture].update(source=wrong, extensions={key: {"source": image}})
            writer.extensions.add(key)
        reference = png(rows if rows is holes else [[texel[:3] for texel in row] for row in rows])
        if reference not in expected:
            expected[reference] = grid.texture(writer.image("expected " + label, reference))
        for place, used in ((grid.place, texture), (grid.expect, expected[reference])):
            name = ("" if place == grid.place else "expected ") + label
            masked = {"alphaMode": "MASK"} if rows is holes else {}
            material = grid.unlit(name, [1, 1, 1], baseColorTexture={"index": used}, **masked)
            place(column, row, grid.square_of(material))
    return grid.text()


def transformed(uvs, offset=(0, 0), rotation=0.0, scale=(1, 1)):
    """As KHR_texture_transform says: scaled, turned, moved."""
    cosine, sine = math.cos(rotation), math.sin(rotation)
    result = []
    for u, v in uvs:
        u, v = u * scale[0], v * scale[1]
        result.append((round(cosine * u + sine * v + offset[0], 6),
                       round(cosine * v - sine * u + offset[1], 6)))
    return result


def texture_coordinates_grid():
    """Coordinates that the extension, a sampler or a second set of them changes, beside squares whose
    coordinates are so already."""
    cases = [("OFFSET", {"offset": [0.25, 0.375]}, {}), ("ROTATION", {"rotation": 0.6}, {}),
             ("SCALE", {"scale": [1.5, -0.75]}, {}),
             ("ALL", {"offset": [0.3, 0.1], "rotation": -1.1, "scale": [0.8, 2.2]}, {}),
             ("SET", {"texCoord": 1}, {}), ("SET AND", {"texCoord": 1, "rotation": 2.5, "scale": [2, 1]}, {}),
             ("SET 1", None, {"texCoord": 1}), ("EMISSION", {"offset": [0.5, 0.125], "scale": [0.25, 0.25]}, {})]
    grid = TestGrid(cells=[case[0] for case in cases], across=4)
    writer = grid.writer
    picture = writer.image("picture", png([[texel[:3] for texel in row] for row in texels_of(blocks())]))
    sampler = writer.add("samplers", {"magFilter": 9728, "minFilter": 9728, "wrapS": 10497, "wrapT": 10497})
    texture = writer.add("textures", {"sampler": sampler, "source": picture})
    # No center of a pixel is between two texels, where devices may round to either.
    second = ((0.91, 0.13), (0.91, 1.32), (-0.22, 1.32), (-0.22, 0.13))
    extra = writer.accessor(second, 2)
    for i, (label, change, fields) in enumerate(cases):
        info = {"index": texture, **fields}
        if change is not None:
            info["extensions"] = {"KHR_texture_transform": change}
            writer.extensions.add("KHR_texture_transform")
        if label == "EMISSION":
            material = writer.material(label, [0, 0, 0], [1, 1, 1], emissiveTexture=info)
            plain = writer.material("expected " + label, [0, 0, 0], [1, 1, 1],
                                    emissiveTexture={"index": texture})
        else:
            material = grid.unlit(label, [1, 1, 1], baseColorTexture=info)
            plain = grid.unlit("expected " + label, [1, 1, 1], baseColorTexture={"index": texture})
        square = grid.square_of(material)
        square["attributes"] = {**square["attributes"], "TEXCOORD_1": extra}
        grid.place(i % 4, i // 4, square)
        change = dict(change or {})
        is_second = change.pop("texCoord", fields.get("texCoord", 0)) == 1
        baked = transformed(second if is_second else UPRIGHT, **change)
        square = grid.square_of(plain)
        square["attributes"] = {**square["attributes"], "TEXCOORD_0": writer.accessor(baked, 2)}
        grid.expect(i % 4, i // 4, square)
    return grid.text()


def variants_grid():
    """Rows show what the left squares of all rows look like under that variant: those of a column are one
    mesh. The row of the variant that is shown looks as expected, and others do not."""
    names = ["DAY", "NIGHT", "RUST"]
    grid = TestGrid(["EACH", "ONE", "SHARED", "PICTURE"], ["NO VARIANT"] + names)
    writer = grid.writer
    picture = writer.image("picture", png([[texel[:3] for texel in row] for row in texels_of(blocks())]))
    texture = {"index": grid.texture(picture)}
    gray, day = grid.unlit("gray", [0.5, 0.5, 0.5]), grid.unlit("day", [0.9, 0.8, 0.3])
    night, rust = grid.unlit("night", [0.05, 0.1, 0.4]), grid.unlit("rust", [0.6, 0.2, 0.05])
    green = grid.unlit("green", [0.1, 0.5, 0.1])
    letter = grid.unlit("picture", [1, 1, 1], baseColorTexture=texture)
    # Of each column: the material without a variant, and by the variant's number.
    columns = [(gray, {0: day, 1: night, 2: rust}), (gray, {1: night}), (gray, {0: green, 2: green}),
               (day, {0: rust, 1: letter, 2: letter})]
    writer.root["extensions"] = {"KHR_materials_variants": {"variants": [{"name": name} for name in names]}}
    writer.extensions.add("KHR_materials_variants")
    for column, (own, by_variant) in enumerate(columns):
        mappings = [{"material": material,
                     "variants": [i for i, other in by_variant.items() if other == material]}
                    for material in dict.fromkeys(by_variant.values())]
        primitive = {**grid.square_of(own), "extensions": {"KHR_materials_variants": {"mappings": mappings}}}
        mesh = writer.mesh(grid.columns[column], [primitive])
        for row in range(len(names) + 1):
            x, y = grid.center(column, row)
            writer.node(name=grid.name(column, row), mesh=mesh, translation=[x, y, 0])
            grid.expect(column, row, grid.square_of(by_variant.get(row - 1, own)))
    return grid.text()


# Test pictures of the ways in which a file may store its meshes: the same relief, or the same set of small
# reliefs, from each of them beside the plain one.

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
