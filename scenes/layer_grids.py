"""Test pictures of layers on surfaces: squares that are turned away from the viewer in an environment of
radiance 1, beside closed forms of what they reflect and let pass."""

import math

from cornell_box import D65, interpolate, linear_srgb
from test_grid import TestGrid

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
