"""The pictures of docs/python.md: `python3 gallery.py [FOLDER]` writes them to a folder."""
import sys
from pathlib import Path

import numpy as np

import raygraph as rg

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
folder.mkdir(parents=True, exist_ok=True)
tree = Path(__file__).resolve().parents[2]
size = (320, 192)


def sunflower():
    """Balls at the golden angle, in materials that change along the spiral."""
    scene = rg.Scene()
    paper = scene.add_material("paper", base_color_factor=(0.75, 0.75, 0.78, 1), metallic_factor=0, roughness_factor=0.6)
    scene.add_mesh([[-9, 0, 9], [9, 0, 9], [9, 0, -9], [-9, 0, -9]], [[0, 1, 2], [0, 2, 3]], material=paper)
    count = 12
    for ring in range(count):
        i = np.arange(ring, 240, count)
        angle, distance = i * np.pi * (3 - np.sqrt(5)), 0.2 * np.sqrt(i)
        radius = 0.09 + 0.0006 * i
        centers = np.stack([distance * np.cos(angle), radius, distance * np.sin(angle)], axis=1)
        hue = np.array([0, 1 / 3, 2 / 3]) + ring / count
        color = 0.45 + 0.4 * np.cos(2 * np.pi * hue)
        material = scene.add_material(base_color_factor=(*color, 1), metallic_factor=ring % 2, roughness_factor=0.15)
        scene.add_spheres(centers, radius, material=material)
    return scene, {"camera": rg.look_at((0, 4.2, 5.2), (0, 0, 0.15), fov=42), "exposure": -1}


def waves():
    """A surface y = f(x, z), with a color of its height at each vertex."""
    n = 161
    y, x = np.mgrid[-1:1:n * 1j, -1:1:n * 1j]
    r = 9 * np.hypot(x, y) + 1e-6
    height = 0.5 * np.sin(r) / r
    points = np.stack([2 * x, height, -2 * y], axis=-1).reshape(-1, 3)
    corner = np.arange(n * n).reshape(n, n)[:-1, :-1].ravel()
    triangles = np.concatenate([np.stack([corner, corner + 1, corner + n + 1], axis=1),
                                np.stack([corner, corner + n + 1, corner + n], axis=1)])
    slope_y, slope_x = np.gradient(height, 2 / (n - 1))
    normals = np.stack([-slope_x / 2, np.ones_like(x), slope_y / 2], axis=-1).reshape(-1, 3)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    low, high = np.array([0.1, 0.25, 0.7]), np.array([1.0, 0.55, 0.1])
    share = ((height - height.min()) / np.ptp(height))[..., None]
    colors = (low + share * (high - low)).reshape(-1, 3)
    scene = rg.Scene()
    material = scene.add_material("values", metallic_factor=0, roughness_factor=0.3, double_sided=True)
    scene.add_mesh(points, triangles, normals=normals, colors=colors, material=material)
    return scene, {"camera": rg.look_at((2.2, 2.4, 3.4), (0, -0.1, 0), fov=38)}


def edited_box():
    """The Cornell box of scenes/, with other materials: edits of a scene from a file."""
    scene = rg.load(tree / "scenes/cornell.gltf")
    for node in scene.nodes:
        if node.name == "tall block":
            node.rotation = (0, np.sin(0.6), 0, np.cos(0.6))
    for material in scene.materials:
        if "red" in material.name:
            material.base_color_factor = (0.1, 0.3, 0.75, 1)
    return scene, {"exposure": 2.5}


for picture in (sunflower, waves, edited_box):
    scene, options = picture()
    result = rg.render(scene, spp=24, size=size, denoise=True, **options)
    result.save(folder / f"python_{picture.__name__}.png")
    print(f"{picture.__name__}: {result.samples} samples in {result.seconds:.0f} s on {result.device}")
