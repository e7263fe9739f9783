"""Test pictures of textures: what a file of some format shows beside the same texels as PNG."""

import math

from gltf_writer import png
from test_grid import UPRIGHT, TestGrid
from texture_files import (MODIFIERS, UASTC, bc1_block, bc2_block, bc3_block, bc4_block, bc7_block, dds,
                           etc1s, ktx2, png_palette, png_wide, uastc_block, webp, wide)

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
