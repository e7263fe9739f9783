#!/usr/bin/python3
"""The error of pictures that each denoiser makes, by samples a pixel, for docs/denoise.md; needs python3-numpy.

    RAYGRAPH_ASSETS=... tests/denoise/measure.py build/release/raygraph --work /tmp/denoised [--most 1024]

Renders what the folder lacks: pictures, and of each scene two references of --reference samples with other
seeds. The product of the differences to both is an unbiased estimate of the squared error, since the noise of
the references cancels. relMSE is that of all pixels; FLIP and SSIM are of pictures clipped to 1.
"""
import argparse
import os
import pathlib
import struct
import subprocess
import sys
import zlib

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/compare_cycles"))
from error_of import read_planes  # noqa: E402

ASSETS = pathlib.Path(os.environ.get("RAYGRAPH_ASSETS", ROOT / "assets")) / "scenes"
MAP = ["--env", ASSETS / "env/royal_esplanade_1k.hdr"]
SCENES = {
    "Cornell box": [ROOT / "scenes/cornell.gltf"],
    "nested_dielectrics": [ROOT / "scenes/nested_dielectrics.gltf"],
    "material_row": [ROOT / "scenes/material_row.gltf"],
    "FlightHelmet": [ASSETS / "known/FlightHelmet.glb", *MAP],
    "many_lights": [ROOT / "scenes/many_lights.gltf"],
    "terrace": [ROOT / "scenes/terrace.gltf"],
    "WaterBottle": [ASSETS / "known/WaterBottle.glb", *MAP],
    "Fox": [ASSETS / "known/Fox.glb", "--clips", "Walk", "--at", "0.3"],
}


def run(file, *command):
    if file.exists():
        return
    whole = file.with_suffix(".new.exr")
    subprocess.run([str(a) for a in [*command, "--quiet", "-o", whole]], check=True)
    whole.rename(file)


def render(arguments, scene, file, samples, seed, *more):
    run(file, arguments.program, "render", *SCENES[scene], "--size", arguments.size, "--spp", samples, "--seed", seed,
        *more)


def colors(planes, prefix=""):
    return numpy.stack([planes[prefix + c] for c in "RGB"], -1)


def convolved(planes, kernel, axis):
    radius = len(kernel) // 2
    padding = [(radius, radius) if i == axis else (0, 0) for i in range(planes.ndim)]
    padded = numpy.pad(planes, padding, mode="edge")
    size = planes.shape[axis]
    return sum(w * numpy.take(padded, range(i, i + size), axis) for i, w in enumerate(kernel))


def ssim(reference, picture):
    """Wang et al. 2004 on luminance in sRGB, windows of sigma 1.5."""
    gaussian = numpy.exp(-(numpy.arange(-5, 6) ** 2) / 4.5)
    gaussian /= gaussian.sum()

    def luma(rgb):
        y = numpy.clip(rgb, 0, 1) @ [0.2126, 0.7152, 0.0722]
        return numpy.where(y <= 0.0031308, 12.92 * y, 1.055 * y ** (1 / 2.4) - 0.055)

    def smooth(plane):
        return convolved(convolved(plane, gaussian, 0), gaussian, 1)

    x, y = luma(reference), luma(picture)
    mx, my = smooth(x), smooth(y)
    vx, vy, cov = smooth(x * x) - mx**2, smooth(y * y) - my**2, smooth(x * y) - mx * my
    c1, c2 = 0.01**2, 0.03**2
    return ((2 * mx * my + c1) * (2 * cov + c2) / ((mx**2 + my**2 + c1) * (vx + vy + c2))).mean()


TO_XYZ = numpy.array([[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750],
                      [0.0193339, 0.1191920, 0.9503041]])
WHITE = TO_XYZ.sum(1)
PER_DEGREE = 67.02


def flip(reference, picture):
    """Andersson et al. 2020, the mean over the picture."""

    def opponents(rgb):
        x, y, z = numpy.moveaxis(numpy.clip(rgb, 0, 1) @ TO_XYZ.T / WHITE, -1, 0)
        return numpy.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], -1)

    def adjusted(rgb):  # CIELab by Hunt
        t = numpy.clip(rgb, 0, 1) @ TO_XYZ.T / WHITE
        f = numpy.where(t > (6 / 29) ** 3, numpy.cbrt(t), t / (3 * (6 / 29) ** 2) + 4 / 29)
        x, y, z = numpy.moveaxis(f, -1, 0)
        lightness = 116 * y - 16
        return numpy.stack([lightness, 5 * lightness * (x - y), 2 * lightness * (y - z)], -1)

    def filtered(yxz):
        radius = int(numpy.ceil(3 * numpy.sqrt(0.04 / (2 * numpy.pi**2)) * PER_DEGREE))
        x2 = (numpy.arange(-radius, radius + 1) / PER_DEGREE) ** 2
        planes = []
        for plane, terms in zip(numpy.moveaxis(yxz, -1, 0),
                                ([(1, 0.0047)], [(1, 0.0053)], [(34.1, 0.04), (13.5, 0.025)])):
            # A sum of Gaussians in two dimensions, each of which is separable
            kernels = [(a * numpy.pi / b, numpy.exp(-(numpy.pi**2) * x2 / b)) for a, b in terms]
            total = sum(a * k.sum() ** 2 for a, k in kernels)
            planes.append(sum(a * convolved(convolved(plane, k, 0), k, 1) for a, k in kernels) / total)
        y, x, z = planes
        y = (y + 16) / 116
        xyz = numpy.stack([y + x / 500, y, y - z / 200], -1) * WHITE
        return adjusted(xyz @ numpy.linalg.inv(TO_XYZ).T)

    def hyab(a, b):
        return abs(a[..., 0] - b[..., 0]) + numpy.hypot(a[..., 1] - b[..., 1], a[..., 2] - b[..., 2])

    most = hyab(adjusted(numpy.array([0.0, 1, 0])), adjusted(numpy.array([0.0, 0, 1]))) ** 0.7
    first, second = opponents(reference), opponents(picture)
    color = hyab(filtered(first), filtered(second)) ** 0.7
    knee = 0.4 * most
    color = numpy.where(color < knee, 0.95 / knee * color, 0.95 + (color - knee) / (most - knee) * 0.05)

    deviation = 0.5 * 0.082 * PER_DEGREE
    radius = int(numpy.ceil(3 * deviation))
    x = numpy.arange(-radius, radius + 1)
    gaussian = numpy.exp(-(x**2) / (2 * deviation**2))
    edge, point = -x * gaussian, (x**2 / deviation**2 - 1) * gaussian

    def normalized(kernel):
        return numpy.where(kernel > 0, kernel / kernel[kernel > 0].sum(), -kernel / kernel[kernel < 0].sum())

    def strength(yxz, kernel):
        y = (yxz[..., 0] + 16) / 116
        along = [convolved(convolved(y, normalized(kernel), axis), gaussian / gaussian.sum(), 1 - axis)
                 for axis in (0, 1)]
        return numpy.hypot(*along)

    feature = numpy.maximum(*(abs(strength(first, k) - strength(second, k)) for k in (edge, point)))
    return (color ** (1 - numpy.sqrt(numpy.clip(feature / numpy.sqrt(2), 0, 1)))).mean()


DENOISERS = ("network", "regression")
SHOWN = ("nested_dielectrics", "material_row")


def write_png(file, rgb):
    y = numpy.clip(rgb, 0, 1)
    y = numpy.where(y <= 0.0031308, 12.92 * y, 1.055 * y ** (1 / 2.4) - 0.055)
    lines = (255 * y + 0.5).astype(numpy.uint8).repeat(2, 0).repeat(2, 1)
    height, width, _ = lines.shape
    packed = zlib.compress(b"".join(b"\0" + line.tobytes() for line in lines), 9)
    with open(file, "wb") as out:
        out.write(b"\x89PNG\r\n\x1a\n")
        for kind, data in ((b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)), (b"IDAT", packed),
                           (b"IEND", b"")):
            out.write(struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--work", type=pathlib.Path, required=True)
    parser.add_argument("--size", default="128x128")
    parser.add_argument("--least", type=int, default=1, help="samples")
    parser.add_argument("--most", type=int, default=1024, help="samples")
    parser.add_argument("--scenes", nargs="+", choices=SCENES, default=list(SCENES), metavar="SCENE")
    parser.add_argument("--reference", type=int, default=256, help="samples of each reference")
    parser.add_argument("--picture", type=pathlib.Path, help="PNG")
    arguments = parser.parse_args()
    arguments.work.mkdir(exist_ok=True)
    counts = [n for n in (4**i for i in range(8)) if arguments.least <= n <= arguments.most]
    rows, details, shown = {name: [] for name in DENOISERS}, [], []
    for scene in arguments.scenes:
        name = scene.split()[0]
        references = [arguments.work / f"{name}.reference{seed}.exr" for seed in (7, 8)]
        for seed, file in zip((7, 8), references):
            render(arguments, scene, file, arguments.reference, seed)
        first, second = (colors(read_planes(file)) for file in references)
        truth = 0.5 * (first + second)
        weight = 1 / (truth**2 + 0.01)
        gains = {denoiser: [scene] for denoiser in DENOISERS}
        for count in counts:
            file = arguments.work / f"{name}.{count}.exr"
            render(arguments, scene, file, count, 0, "--aov", "denoising")
            pictures = [colors(read_planes(file))]
            for denoiser in DENOISERS:
                result = file.with_suffix(f".{denoiser}.exr")
                run(result, arguments.program, "denoise", file, "--denoiser", denoiser)
                pictures.append(colors(read_planes(result), "denoised."))
            errors = [((x - first) * (x - second) * weight).mean() for x in pictures]
            for denoiser, error in zip(DENOISERS, errors[1:]):
                gains[denoiser].append(f"{errors[0] / error:.2f}")
            if count == 64 and scene in SHOWN:
                shown.append(numpy.concatenate([*pictures[:2], truth], 1))
            if count == 64:
                details.append([scene, *(f"{e:.5f}" for e in errors)] +
                               [f"{of(truth, x):.3f}" for of in (flip, ssim) for x in pictures] +
                               [f"{x.mean() / pictures[0].mean():.3f}" for x in pictures[1:]])
        for denoiser in DENOISERS:
            rows[denoiser].append(gains[denoiser])
            print(denoiser, *gains[denoiser], flush=True)
    if arguments.picture and shown:
        write_png(arguments.picture, numpy.concatenate(shown))
    three = ["mean", *DENOISERS]
    for head, table in (*((["scene, " + denoiser, *counts], rows[denoiser]) for denoiser in DENOISERS),
                        (["scene, 64 samples", *(f"{of}, {x}" for of in ("relMSE", "FLIP", "SSIM") for x in three),
                          *(f"energy, {x}" for x in DENOISERS)], details)):
        print("\n|", " | ".join(map(str, head)), "|\n" + "|---" * len(head) + "|")
        for row in table:
            print("|", " | ".join(row), "|")


if __name__ == "__main__":
    main()
