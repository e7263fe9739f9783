"""Test pictures: cells in columns and rows with labels, each cell a pair of squares of side 1. The left one
shows what is tested, the right one, in front of the plane of the others, what should be seen. Nothing that is
expected is lit or seen from behind, so it changes no light."""

import struct

from gltf_writer import GltfWriter, png_file, stored

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
