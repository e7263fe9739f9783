"""Test pictures of materials that scatter light: squares beside the radiance that they should have."""

import math

from gltf_writer import png
from shapes import box_quads
from slab_light import returned_light
from test_grid import TestGrid


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
