#!/usr/bin/env python3
"""Trains the network of the denoiser (passes/denoise_network.h); needs numpy, PyTorch and a GPU.

    train.py render raygraph FOLDER --count 300 --seconds 300
    train.py train FOLDER --seconds 240 --weights network
    RAYGRAPH_ASSETS=... train.py judge raygraph FOLDER --weights network --size 128x128

`render` makes pictures of training_scenes.py: each scene at three numbers of samples from 1 to 511, and a reference.
`train` fits the network and writes NAME.bin, which belongs to passes/denoise_network.cpp.bin, and NAME.pt. `judge`
renders the scenes of ../measure.py, which are no part of the training, and prints the relMSE of the mean, of
`--denoiser regression` and of the network before it is blended with the mean.
"""
import argparse
import concurrent.futures
import functools
import math
import os
import pathlib
import struct
import subprocess
import sys
import time

import numpy

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent), str(HERE.parent.parent / "compare_cycles")]
import training_scenes  # noqa: E402
from error_of import read_planes  # noqa: E402
from measure import SCENES  # noqa: E402

REFERENCE = 1024  # samples of a reference for training
SIZE = 256
FOR_DENOISING = ["--denoise", "--denoiser", "regression", "--aov", "denoising"]


# Planes of a picture as they are stored, three channels each.
TARGET, NOISE, ALBEDO, NORMAL, REGRESSION, SEEN = (slice(3 * i, 3 * i + 3) for i in range(6))
TRUTH = slice(18, 21)


def windows(planes, radius, function):
    """The function over windows around each pixel, which end at the borders."""
    height, width = planes.shape[-2:]
    padded = numpy.pad(planes, [(0, 0)] * (planes.ndim - 2) + [(radius, radius)] * 2)
    inside = numpy.pad(numpy.ones((height, width)), radius)
    return function([(padded[..., y:y + height, x:x + width], inside[y:y + height, x:x + width])
                     for y in range(2 * radius + 1) for x in range(2 * radius + 1)])


def box_sum(planes, radius):
    return windows(planes, radius, lambda parts: sum(part for part, _ in parts))


def noise_of(target, mean, variance, is_most, half, albedo, normal, count, first):
    """The variance of the mean, as passes::NoiseOfMean has it (shaders/denoise/noise.comp, half_error.comp)."""
    if count == 1:
        def gradient(planes):
            padded = numpy.pad(planes, [(0, 0), (1, 1), (1, 1)], mode="edge")
            below, above = padded[:, 2:, 1:-1] - planes, planes - padded[:, :-2, 1:-1]
            right, left = padded[:, 1:-1, 2:] - planes, planes - padded[:, 1:-1, :-2]
            smaller = [numpy.minimum(abs(a), abs(b)) for a, b in ((below, above), (right, left))]
            return 4 * sum((s**2).sum(0) for s in smaller)
        stacked = numpy.concatenate([target, albedo, normal, gradient(albedo)[None], gradient(normal)[None]])

        def spread(parts):
            total, sums, squares = 0, 0, 0
            for part, inside in parts:
                distance = (((part[3:6] - albedo) ** 2).sum(0) / (0.04**2 + numpy.minimum(part[9], stacked[9])) +
                            ((part[6:9] - normal) ** 2).sum(0) / (0.2**2 + numpy.minimum(part[10], stacked[10])))
                weight = numpy.exp(-distance) * inside
                value = part[:3] - target
                total, sums = total + weight, sums + weight * value
                squares = squares + weight * value**2
            return numpy.maximum(squares / total - (sums / total) ** 2, 0)
        return windows(stacked, 3, spread)
    if first == 0:
        return variance / count
    inside = box_sum(numpy.ones(mean.shape[1:]), 3)
    weight = 1 / ((box_sum(mean, 3) / inside) ** 2 + 0.01)
    by_half = is_most * first / ((count - first) * 1.17) * ((half - mean) ** 2 * weight).sum(0)
    sampled = is_most * (variance / count * weight).sum(0)
    sums = box_sum(numpy.stack([by_half, sampled]), 7)
    ratio = numpy.where(sums[1] > 0, numpy.minimum(sums[0] / numpy.maximum(sums[1], 1e-30), 1), 0)
    samples = min(first, count - first)
    if samples > 1:
        with numpy.errstate(divide="ignore"):
            ratio = ratio * numpy.exp2(numpy.minimum(numpy.log(ratio) / math.log(samples), 0))
    return variance / count * ratio


def variance_of_target(mean, variance, seen, squares, count):
    """Of a sample, as shaders/denoise/variance.comp computes it, and whether it is most of the variance."""
    rest = variance
    if count > 1:
        added, rounding = squares - seen**2 - 2 * seen * (mean - seen), 4e-6 * squares
        light = numpy.where(added > rounding, added + rounding, 0)
        rest = numpy.maximum(variance - count / (count - 1) * light, 0)
    weight = 1 / (mean**2 + 0.01)
    return rest, 2 * (rest * weight).sum(0) >= (variance * weight).sum(0)


def first_samples(file):
    """The number of samples whose mean a file has as the first half; 0 if it has none."""
    _, found, rest = file.read_bytes()[:65536].partition(b"raygraph.firstHalfSamples\0string\0")
    return int(rest[4:4 + struct.unpack("<i", rest[:4])[0]]) if found else 0


def planes_of(file):
    """Of a render with --denoise --aov denoising, and its count of samples."""
    planes = read_planes(file)
    count = int(planes["samples"].max())

    def three(prefix, channels="RGB"):
        if prefix + channels[0] not in planes:
            return numpy.zeros((3, *planes["R"].shape))
        return numpy.nan_to_num(numpy.stack([planes[prefix + c] for c in channels]), nan=0, posinf=0, neginf=0)

    mean, seen, by_all = three(""), three("denoising.seen."), three("denoising.seen_by_all.")
    albedo, normal = three("denoising.albedo."), three("denoising.N.", "XYZ")
    target = mean - seen
    variance, is_most = variance_of_target(mean, numpy.maximum(three("variance."), 0), seen,
                                           three("denoising.seen_squares."), count)
    noise = noise_of(target, mean, variance, is_most, three("denoising.first_half."), albedo, normal, count,
                     first_samples(file))
    return numpy.concatenate([target, noise, albedo, normal, three("denoised.") - by_all, by_all]), count


# --- render ---

def picture(program, scene, options, samples, seed, file, is_input):
    command = [program, "render", scene, *options, "--spp", samples, "--seed", seed, "--quiet", "-o", file]
    if is_input:
        command += FOR_DENOISING
    subprocess.run([str(x) for x in command], check=True, stdout=subprocess.DEVNULL)


def render_scene(arguments, end, number):
    folder, out = arguments.folder, arguments.folder / f"{number}.npz"
    if out.exists() or time.time() > end:
        return out.exists()
    training_scenes.write(folder, number)
    options = (folder / f"{number}.txt").read_text().splitlines() + ["--size", f"{SIZE}x{SIZE}"]
    random = numpy.random.default_rng(number)
    files = [folder / f"{number}.{name}.exr" for name in ("few", "some", "many", "reference")]
    counts = [int(2 ** random.uniform(0, 2.5)), int(2 ** random.uniform(2.5, 5.5)),
              int(2 ** random.uniform(5.5, 9)), REFERENCE]
    for seed, (file, count) in enumerate(zip(files, counts), 1):
        picture(arguments.program, folder / f"{number}.gltf", options, count, seed, file, file != files[-1])
    reference = read_planes(files[-1])
    truth = numpy.stack([reference[c] for c in "RGB"])
    inputs = [planes_of(file) for file in files[:-1]]
    data = numpy.stack([numpy.concatenate([planes, truth]) for planes, _ in inputs])
    if numpy.isfinite(data).all() and truth.mean() > 1e-4:
        numpy.savez(out, data=numpy.clip(data, -6e4, 6e4).astype(numpy.float16),
                    counts=numpy.array([count for _, count in inputs], numpy.float32))
    for file in files + [folder / f"{number}.gltf", folder / f"{number}.hdr"]:
        file.unlink(missing_ok=True)
    return out.exists()


def render(arguments):
    arguments.folder.mkdir(exist_ok=True)
    end = time.time() + arguments.seconds
    with concurrent.futures.ProcessPoolExecutor(arguments.jobs) as pool:
        done = sum(pool.map(functools.partial(render_scene, arguments, end), range(arguments.count)))
    print(f"{done} of {arguments.count} scenes")


# --- the network, as passes/denoise_network.cpp has it ---

FEATURES, TAPS, DARKEST = 16, 5, 0.02


def network(widths):
    import torch
    import torch.nn.functional as F
    from torch import nn

    def layer(inputs, outputs, taps=3, stride=1):
        return nn.Conv2d(inputs, outputs, taps, stride, taps // 2, padding_mode="replicate")

    class Network(nn.Module):
        def __init__(self):
            super().__init__()
            # In the order of their use, which is that of the weights in the file
            layers, before = [], 4 * FEATURES
            for level, width in enumerate(widths):
                layers += [layer(before, width, stride=2 if level else 1), layer(width, width)]
                before = width
            kernels = 4 * (TAPS**2 + 3)
            layers.append(layer(before, kernels, 1))
            for width in reversed(widths[:-1]):
                layers += [layer(before + width, width), layer(width, width), layer(width, kernels, 1)]
                before = width
            self.layers = nn.ModuleList(layers)

        def forward(self, planes, counts):
            """`planes`: N x 12 x H x W, those of planes_of; H and W are multiples of 16. Returns N x 3 x H x W."""
            target, noise, albedo, normal = (planes[:, p] for p in (TARGET, NOISE, ALBEDO, NORMAL))
            radiance = target.clamp(min=0)
            weights = torch.tensor([0.2126, 0.7152, 0.0722], device=planes.device)[:, None, None]
            luminance = (radiance * weights).sum(1, keepdim=True)
            scale = (luminance.sqrt().sum((1, 2, 3)) / luminance.sum((1, 2, 3)).clamp(min=1e-20))**2
            scale = scale[:, None, None, None]
            divisor = albedo.clamp(min=0) + DARKEST
            light = radiance / divisor
            deviation = noise.clamp(min=0).sqrt().mean(1, keepdim=True)
            relative = deviation / (radiance.mean(1, keepdim=True) + 0.01 / scale)
            known = torch.rsqrt(counts)[:, None, None, None].expand_as(relative)
            features = torch.cat([torch.log1p(scale * light), torch.log1p(scale * radiance),
                                  torch.log1p(scale * deviation), torch.log1p(relative), albedo, normal,
                                  (normal * normal).sum(1, keepdim=True), known], 1)
            n, c, h, w = features.shape
            x = features.view(n, c, h // 2, 2, w // 2, 2).permute(0, 3, 5, 1, 2, 4).reshape(n, 4 * c, h // 2, w // 2)
            lights, skips, kernels, layers = [light], [], [], iter(self.layers)
            for _ in widths[1:]:
                lights.append(F.avg_pool2d(lights[-1], 2))
            with torch.autocast("cuda", torch.bfloat16, enabled=planes.is_cuda):
                for _ in widths:
                    x = F.leaky_relu(next(layers)(x), 0.1)
                    x = F.leaky_relu(next(layers)(x), 0.1)
                    skips.append(x)
                kernels.append(next(layers)(x))
                for skip in reversed(skips[:-1]):
                    x = torch.cat([F.interpolate(x, scale_factor=2, mode="nearest"), skip], 1)
                    x = F.leaky_relu(next(layers)(x), 0.1)
                    x = F.leaky_relu(next(layers)(x), 0.1)
                    kernels.append(next(layers)(x))
            result = None
            for logits, source in zip(kernels, reversed(lights)):
                h, w = source.shape[2:]
                logits = logits.float().view(n, 2, 2, TAPS**2 + 3, h // 2, w // 2).permute(0, 3, 4, 1, 5, 2)
                logits = logits.reshape(n, TAPS**2 + 3, h, w)
                patches = F.unfold(F.pad(source, [TAPS // 2] * 4, mode="replicate"), TAPS).view(n, 3, TAPS**2, h, w)
                filtered = (patches * torch.softmax(logits[:, :TAPS**2], 1)[:, None]).sum(2)
                if result is not None:
                    blurred = F.interpolate(F.avg_pool2d(filtered, 2), scale_factor=2, mode="nearest")
                    coarser = F.interpolate(result, scale_factor=2, mode="bilinear", align_corners=False)
                    filtered = filtered + torch.sigmoid(logits[:, TAPS**2:TAPS**2 + 1]) * (coarser - blurred)
                result = filtered
            return result.clamp(min=0) * divisor

    return Network()


def write_weights(model, file):
    """In the order of NetworkWeights (passes/denoise_network.h)."""
    with open(file, "wb") as out:
        for layer in model.layers:
            weights = layer.weight.detach().cpu().numpy()  # results x inputs x rows x columns
            biases = layer.bias.detach().cpu().numpy()
            for first in range(0, len(biases), 8):
                group = weights[first:first + 8]
                blocks = group.reshape(8, -1, 4, *group.shape[2:]).transpose(1, 3, 4, 2, 0)
                out.write(numpy.concatenate([biases[first:first + 8], blocks.ravel()]).astype("<f2").tobytes())


def rel_mse(picture, truth, floor):
    return ((picture - truth) ** 2 / (truth**2 + floor)).mean((1, 2, 3))


def augmented(batch, torch):
    """Flips, transposes, colors in other orders, and turned normals."""
    for axis in (2, 3):
        if torch.rand(()) < 0.5:
            batch = batch.flip(axis)
    if torch.rand(()) < 0.5:
        batch = batch.transpose(2, 3)
    order = torch.randperm(3)
    groups = list(batch.split(3, 1))
    turn = torch.linalg.qr(torch.randn(3, 3))[0].to(batch.device)
    for i in range(len(groups)):
        groups[i] = torch.einsum("ij,njhw->nihw", turn, groups[i]) if i == 3 else groups[i][:, order]
    return torch.cat(groups, 1)


def train(arguments):
    import torch
    device = "cuda" if torch.cuda.is_available() else "cpu"
    torch.manual_seed(1)
    torch.backends.cudnn.benchmark = True
    files = [numpy.load(f) for f in sorted(arguments.folder.glob("*.npz"), key=lambda f: int(f.stem))]
    data = torch.from_numpy(numpy.concatenate([f["data"] for f in files])).to(device)
    counts = torch.from_numpy(numpy.concatenate([f["counts"] for f in files])).to(device)
    held = 3 * max(1, len(files) // 16)  # the last scenes test
    tests, data = data[-held:].float(), data[:-held]
    test_counts, counts = counts[-held:], counts[:-held]
    model = network(arguments.widths).to(device)
    print(f"{len(data)} pictures, {sum(p.numel() for p in model.parameters())} parameters")
    optimizer = torch.optim.Adam(model.parameters(), 1e-3)
    begin, step, crop, losses = time.time(), 0, 128, []
    while (share := (time.time() - begin) / arguments.seconds) < 1:
        optimizer.param_groups[0]["lr"] = 1e-3 * min(step / 200 + 0.01, 1) * max(1 - share, 0.01) ** 1.5
        chosen = torch.randint(len(data), (arguments.batch,))
        places = torch.randint(SIZE - crop + 1, (arguments.batch, 2))
        batch = torch.stack([data[i, :, y:y + crop, x:x + crop] for i, (y, x) in
                             zip(chosen.tolist(), places.tolist())]).float()
        batch = augmented(batch, torch)
        truth = batch[:, TRUTH]
        floor = 0.01 * (truth.mean((1, 2, 3), keepdim=True) / 0.2) ** 2 + 1e-7  # as if exposed alike
        result = model(batch[:, :12], counts[chosen.to(device)]) + batch[:, SEEN]
        loss = torch.log(rel_mse(result, truth, floor) + 1e-5).mean()
        optimizer.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(model.parameters(), 1.0)
        optimizer.step()
        step += 1
        losses.append(loss.detach())
        if step % 2000 == 0:
            print(f"step {step}, loss {torch.stack(losses).mean().item():.3f}, {time.time() - begin:.0f} s", flush=True)
            losses = []
    with torch.no_grad():
        errors = []
        for test, count in zip(tests, test_counts):
            pictures = [(test[TARGET] + test[SEEN]), test[REGRESSION] + test[SEEN],
                        model(test[None, :12], count[None])[0] + test[SEEN]]
            errors.append([rel_mse(p[None], test[None, TRUTH], 0.01).item() for p in pictures])
    errors = numpy.log(numpy.array(errors) + 1e-7)
    for name, of in (("regression", 1), ("network", 2)):
        gains = [numpy.exp((errors[i::3, 0] - errors[i::3, of]).mean()) for i in range(3)]
        print(f"scenes of the same kind: mean over {name}, geometric means of few, some and many samples:",
              *(f"{gain:.2f}" for gain in gains))
    torch.save({"widths": arguments.widths, "weights": model.state_dict()}, arguments.weights + ".pt")
    write_weights(model, arguments.weights + ".bin")
    print(f"{step} steps")


# --- judge ---

def judge(arguments):
    import torch
    device = "cuda" if torch.cuda.is_available() else "cpu"
    saved = torch.load(arguments.weights + ".pt", map_location=device)
    model = network(saved["widths"]).to(device)
    model.load_state_dict(saved["weights"])
    arguments.folder.mkdir(exist_ok=True)
    width, height = map(int, arguments.size.split("x"))
    jobs = [(scene, kind, count, seed) for scene in SCENES for kind, count, seed in
            (("reference", arguments.reference, 7), ("reference", arguments.reference, 8),
             *(("input", n, 0) for n in arguments.spp))]

    def file_of(scene, kind, count, seed):
        return arguments.folder / f"{scene.split()[0]}.{width}.{kind}.{count}.{seed}.exr"

    def make(job):
        scene, kind, count, seed = job
        if not file_of(*job).exists():
            picture(arguments.program, SCENES[scene][0], [*SCENES[scene][1:], "--size", arguments.size], count, seed,
                    file_of(*job), kind == "input")

    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        list(pool.map(make, jobs))
    print("| scene | samples | relMSE | regression | network | gain, regression | gain, network |\n" + "|---" * 7 + "|")
    for scene in SCENES:
        first, second = (read_planes(file_of(scene, "reference", arguments.reference, s)) for s in (7, 8))
        first, second = (numpy.stack([p[c] for c in "RGB"]) for p in (first, second))
        weight = 1 / ((0.5 * (first + second)) ** 2 + 0.01)
        for samples in arguments.spp:
            planes, count = planes_of(file_of(scene, "input", samples, 0))
            mean = read_planes(file_of(scene, "input", samples, 0))
            mean = numpy.stack([mean[c] for c in "RGB"])
            padded = numpy.pad(planes, [(0, 0), (0, -height % 16), (0, -width % 16)], mode="edge").astype(numpy.float32)
            with torch.no_grad():
                result = model(torch.from_numpy(padded[None, :12]).to(device), torch.tensor([float(count)], device=device))
            result = result[0, :, :height, :width].cpu().numpy()
            errors = [float(((x - first) * (x - second) * weight).mean()) for x in
                      (mean, planes[REGRESSION] + planes[SEEN], result + planes[SEEN])]
            print(f"| {scene} | {samples} | " + " | ".join(f"{e:.5f}" for e in errors) +
                  f" | {errors[0] / errors[1]:.2f} | {errors[0] / errors[2]:.2f} |", flush=True)


def main():
    parser = argparse.ArgumentParser()
    commands = parser.add_subparsers(required=True)
    for name, function in (("render", render), ("train", train), ("judge", judge)):
        command = commands.add_parser(name)
        command.set_defaults(function=function)
        if name != "train":
            command.add_argument("program")
            command.add_argument("--jobs", type=int, default=max(1, (os.cpu_count() or 2) // 2))
        command.add_argument("folder", type=pathlib.Path)
        if name != "judge":
            command.add_argument("--seconds", type=float, default=240)
        if name != "render":
            command.add_argument("--weights", default="network", help="files NAME.pt and NAME.bin")
    commands.choices["render"].add_argument("--count", type=int, default=300)
    commands.choices["train"].add_argument("--widths", type=int, nargs="+", default=[64, 80, 88, 80])
    commands.choices["train"].add_argument("--batch", type=int, default=32)
    commands.choices["judge"].add_argument("--size", default="128x128")
    commands.choices["judge"].add_argument("--spp", type=int, nargs="+", default=[1, 16, 64, 256])
    commands.choices["judge"].add_argument("--reference", type=int, default=8192)
    arguments = parser.parse_args()
    arguments.function(arguments)


if __name__ == "__main__":
    main()
