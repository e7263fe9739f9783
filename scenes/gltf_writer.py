"""Builds small glTF files: geometry in one embedded buffer, JSON of a fixed layout, always the same bytes."""

import base64
import json
import struct
import zlib

FLOAT = 5126
UNSIGNED_SHORT = 5123
UNSIGNED_INT = 5125
ARRAY_BUFFER = 34962
ELEMENT_ARRAY_BUFFER = 34963


def to_float32(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]


def rounded(values, digits=6):
    """Numbers as they appear in the JSON: few digits, so that no platform's last bit shows."""
    result = []
    for value in values:
        number = float(f"{value:.{digits}g}")
        result.append(int(number) if number == int(number) else number)
    return result


def data_uri(kind, data):
    return f"data:{kind};base64," + base64.b64encode(data).decode("ascii")


class GltfWriter:
    """Collects meshes, materials, nodes; `text` gives the file."""

    def __init__(self):
        self.buffer = bytearray()
        self.more_buffers = []
        self.extensions = set()
        self.root = {
            "asset": {"version": "2.0", "generator": "raygraph scenes/generate.py"},
            "scene": 0,
            "scenes": [{"nodes": []}],
        }

    def add(self, kind, item):
        items = self.root.setdefault(kind, [])
        items.append(item)
        return len(items) - 1

    def accessor(self, values, width, component=FLOAT, target=ARRAY_BUFFER, has_bounds=False):
        """`values`: rows of `width` numbers, or plain numbers when width is 1."""
        code = {FLOAT: "f", UNSIGNED_SHORT: "H", UNSIGNED_INT: "I"}[component]
        rows = [(value,) for value in values] if width == 1 else values
        while len(self.buffer) % 4:
            self.buffer.append(0)
        data = b"".join(struct.pack(f"<{width}{code}", *row) for row in rows)
        view = self.add("bufferViews", {"buffer": 0, "byteOffset": len(self.buffer),
                                        "byteLength": len(data), "target": target})
        self.buffer += data
        accessor = {"bufferView": view, "componentType": component, "count": len(rows),
                    "type": {1: "SCALAR", 2: "VEC2", 3: "VEC3"}[width]}
        if has_bounds:
            columns = [[to_float32(row[i]) for row in rows] for i in range(width)]
            accessor["min"] = [min(column) for column in columns]
            accessor["max"] = [max(column) for column in columns]
        return self.add("accessors", accessor)

    def primitive(self, positions, triangles, material, normals=None, texcoords=()):
        """Indexed triangles. `normals` may be the list of positions itself, which is then stored once."""
        position = self.accessor(positions, 3, has_bounds=True)
        attributes = {"POSITION": position}
        if normals is not None:
            attributes["NORMAL"] = position if normals is positions else self.accessor(normals, 3)
        for i, uvs in enumerate(texcoords):
            attributes[f"TEXCOORD_{i}"] = self.accessor(uvs, 2)
        flat = [index for triangle in triangles for index in triangle]
        component = UNSIGNED_SHORT if len(positions) < 65535 else UNSIGNED_INT
        indices = self.accessor(flat, 1, component, ELEMENT_ARRAY_BUFFER)
        return {"attributes": attributes, "indices": indices, "material": material}

    def lines(self, mode, positions, material, colors=None, indices=None):
        """Points or lines, of the mode's number; `colors` are linear RGB."""
        attributes = {"POSITION": self.accessor(positions, 3, has_bounds=True)}
        if colors is not None:
            attributes["COLOR_0"] = self.accessor(colors, 3)
        primitive = {"attributes": attributes, "material": material, "mode": mode}
        if indices is not None:
            primitive["indices"] = self.accessor(indices, 1, UNSIGNED_SHORT, ELEMENT_ARRAY_BUFFER)
        return primitive

    def quads(self, quads, material):
        """Planar or nearly planar quads, each as two triangles with their own flat normals. Corners run
        counter-clockwise seen from the front."""
        positions, normals, triangles = [], [], []
        for a, b, c, d in quads:
            for triangle in ((a, b, c), (a, c, d)):
                first = len(positions)
                positions += triangle
                normals += [normal_of(*triangle)] * 3
                triangles.append((first, first + 1, first + 2))
        return self.primitive(positions, triangles, material, normals)

    def material(self, name, color, emission=None, extensions=None, **fields):
        """As near to Lambert as glTF comes, unless fields say otherwise: no metal, roughness 1. `emission` is
        a radiance, linear RGB."""
        material = {"name": name, "pbrMetallicRoughness": {
            "baseColorFactor": rounded(color) + [1], "metallicFactor": 0, "roughnessFactor": 1}}
        if emission is not None:
            strength = max(emission)
            material["emissiveFactor"] = rounded([value / strength for value in emission])
            if strength != 1:
                material["extensions"] = {"KHR_materials_emissive_strength":
                                          {"emissiveStrength": rounded([strength])[0]}}
                self.extensions.add("KHR_materials_emissive_strength")
        for key, value in fields.items():
            is_core = key in ("baseColorTexture", "metallicFactor", "roughnessFactor")
            target = material["pbrMetallicRoughness"] if is_core else material
            target[key] = value
        for key, value in (extensions or {}).items():
            material.setdefault("extensions", {})[key] = value
            self.extensions.add(key)
        return self.add("materials", material)

    def glass(self, name, ior, priority=None, attenuation=None, **fields):
        """The surface of a clear medium, for closed meshes; `attenuation` is (color, distance) or nothing."""
        volume = {"thicknessFactor": 1}
        if attenuation is not None:
            color, distance = attenuation
            volume.update(attenuationColor=rounded(color), attenuationDistance=distance)
        if priority is not None:
            fields["extras"] = {"priority": priority}
        fields = {"roughnessFactor": 0, **fields}
        return self.material(name, [1, 1, 1], None, {
            "KHR_materials_ior": {"ior": ior}, "KHR_materials_transmission": {"transmissionFactor": 1},
            "KHR_materials_volume": volume}, **fields)

    def point_light(self, color, intensity, translation):
        """`color` has a largest channel of 1, `intensity` is in candela."""
        return self.punctual_light({"type": "point"}, color, intensity, translation=rounded(translation, 4))

    def punctual_light(self, kind, color, intensity, **placement):
        """`kind` holds the type and, of a spot, its cone; `intensity` is in candela, or in lux if directional."""
        extensions = self.root.setdefault("extensions", {})
        lights = extensions.setdefault("KHR_lights_punctual", {"lights": []})["lights"]
        lights.append({**kind, "color": rounded(color, 3), "intensity": rounded([intensity], 3)[0]})
        self.extensions.add("KHR_lights_punctual")
        return self.node(**placement, extensions={"KHR_lights_punctual": {"light": len(lights) - 1}})

    def mesh(self, name, primitives):
        return self.add("meshes", {"name": name, "primitives": primitives})

    def node(self, is_root=True, **fields):
        node = self.add("nodes", fields)
        if is_root:
            self.root["scenes"][0]["nodes"].append(node)
        return node

    def camera(self, name, translation, yfov, aspect=None, rotation=None):
        """Without rotation the camera looks along -z, y up. yfov in radians."""
        perspective = {"yfov": rounded([yfov], 8)[0], "znear": 0.001}
        if aspect is not None:
            perspective["aspectRatio"] = aspect
        camera = self.add("cameras", {"name": name, "type": "perspective", "perspective": perspective})
        fields = {"name": name, "camera": camera, "translation": rounded(translation)}
        if rotation is not None:
            fields["rotation"] = rounded(rotation, 8)
        return self.node(**fields)

    def image(self, name, data, kind="png"):
        return self.add("images", {"name": name, "uri": data_uri("image/" + kind, data)})

    def text(self):
        if self.extensions:
            self.root["extensionsUsed"] = sorted(self.extensions)
        uri = data_uri("application/octet-stream", bytes(self.buffer))
        self.root["buffers"] = [{"byteLength": len(self.buffer), "uri": uri}] + self.more_buffers
        lines = []
        for key, value in self.root.items():
            if isinstance(value, list) and value and isinstance(value[0], dict):
                items = ",\n  ".join(json.dumps(item, separators=(",", ":")) for item in value)
                lines.append(f'"{key}":[\n  {items}]')
            else:
                lines.append(f'"{key}":{json.dumps(value, separators=(",", ":"))}')
        return "{\n" + ",\n".join(lines) + "\n}\n"


def normal_of(a, b, c):
    u = [b[i] - a[i] for i in range(3)]
    v = [c[i] - a[i] for i in range(3)]
    n = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
    length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) ** 0.5
    return tuple(x / length for x in n)


def stored(data):
    """A zlib stream whose data is stored, not compressed: the same bytes with every zlib."""
    deflated = b"\x78\x01"
    for start in range(0, len(data), 65535):
        block = data[start:start + 65535]
        is_last = start + 65535 >= len(data)
        deflated += struct.pack("<BHH", is_last, len(block), len(block) ^ 0xFFFF) + block
    return deflated + struct.pack(">I", zlib.adler32(data))


def png_file(header, data):
    """`data` is the zlib stream of the rows."""
    def chunk(kind, content):
        check = zlib.crc32(kind + content)
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", check)

    # sRGB chunk: the colors are meant as sRGB, perceptual intent.
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"sRGB", b"\0") + chunk(b"IDAT", data)
            + chunk(b"IEND", b""))


def png(rows):
    """8-bit rows of RGB or RGBA texels."""
    raw = b"".join(b"\0" + bytes(channel for texel in row for channel in texel) for row in rows)
    color_type = {3: 2, 4: 6}[len(rows[0][0])]
    return png_file(struct.pack(">IIBBBBB", len(rows[0]), len(rows), 8, color_type, 0, 0, 0), stored(raw))
