#!/usr/bin/python3
"""Compares the efficiency of raygraph with that of Cycles. README.md beside it has the settings."""
import argparse
import json
import os
import pathlib
import resource
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from error_of import error_of, read_rgb  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
SOURCES = HERE.parent.parent
THREADS = 2

# Of each: the file, what of it is shown by which light, and how. `assets/` is below $RAYGRAPH_ASSETS.
CASES = {
    "cornell": dict(scene="scenes/cornell.gltf", lambert=True, size=(128, 128)),
    "bottle": dict(scene="assets/scenes/known/WaterBottle.glb", environment="assets/scenes/env/royal_esplanade_1k.hdr",
                   camera=[0.25, 0.12, 0.33, 0, 0, 0, 0, 1, 0, 40], size=(128, 128)),
    "helmet": dict(scene="assets/scenes/known/FlightHelmet.glb", environment="assets/scenes/env/royal_esplanade_1k.hdr",
                   camera=[0.5, 0.45, 0.9, 0, 0.31, 0, 0, 1, 0, 40], size=(128, 128)),
}


def located(path):
    if path and path.startswith("assets/"):
        return str(pathlib.Path(os.environ["RAYGRAPH_ASSETS"]) / path[len("assets/"):])
    return path and str(SOURCES / path)


class Raygraph:
    name = "raygraph"

    def __init__(self, case, arguments):
        self.command = [arguments.raygraph, "render", located(case["scene"]), "--quiet", "--size",
                        "{}x{}".format(*case["size"])]
        if case.get("environment"):
            self.command += ["--env", located(case["environment"])]
        if case.get("camera"):
            self.command += ["--camera", " ".join(map(str, case["camera"]))]
        if case.get("lambert"):
            self.command += ["--brdf", "lambert"]
        self.command += arguments.option

    def render(self, pictures):
        """CPU seconds of each; `output` is written where it is not None."""
        seconds = []
        for picture in pictures:
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            command = self.command + ["--spp", str(picture["samples"]), "--seed", str(picture["seed"]),
                                      "-o", picture["output"]]
            subprocess.run(command, check=True, env=os.environ | {"LP_NUM_THREADS": str(THREADS)})
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            seconds.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
        return seconds


class Cycles:
    name = "cycles"

    def __init__(self, case, arguments):
        self.work = arguments.work
        self.job = dict(scene=located(case["scene"]), environment=located(case.get("environment")),
                        camera=case.get("camera"), size=case["size"], lambert=case.get("lambert", False),
                        pattern=arguments.pattern, threads=THREADS)

    def render(self, pictures):
        path = self.work / "job.json"
        path.write_text(json.dumps(self.job | {"pictures": pictures}))
        command = ["blender", "-b", "--factory-startup", "-P", str(HERE / "cycles_render.py"), "--", str(path)]
        run = subprocess.run(command, check=True, capture_output=True, text=True)
        seconds = [float(line.split()[1]) for line in run.stdout.splitlines() if line.startswith("cpu ")]
        if len(seconds) != len(pictures):
            sys.exit(run.stdout + run.stderr)
        return seconds


def measure(renderer, name, arguments, rounds):
    """Adds to rounds: CPU seconds of the samples, and the errors of the pictures of this round's seed."""
    work, spp, extra = arguments.work, arguments.spp, arguments.reference_spp
    reference = work / f"{name}.{renderer.name}.{extra}.exr"
    if not reference.exists():
        renderer.render([dict(samples=extra, seed=1000, output=str(reference))])
    output = work / f"{name}.{renderer.name}.exr"
    seed = len(rounds) + 1
    # The time of `spp` samples: that of a render of more less that of one of few, which is start-up
    few, more = renderer.render([dict(samples=1, seed=seed, output=str(work / "few.exr")),
                                 dict(samples=1 + spp, seed=seed, output=str(work / "more.exr"))])
    renderer.render([dict(samples=spp, seed=seed, output=str(output))])
    rounds.append(dict(seconds=more - few, error=error_of(reference, output)))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("case", nargs="*", help=", ".join(CASES))
    parser.add_argument("--raygraph", default=str(SOURCES / "build/release/raygraph"))
    parser.add_argument("--work", type=pathlib.Path, required=True, help="a folder for pictures; references stay there")
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--reference-spp", type=int, default=8192)
    parser.add_argument("--rounds", type=int, default=4, help="with a seed each")
    parser.add_argument("--pattern", default="PROGRESSIVE_MULTI_JITTER", help="of Cycles: this, or SOBOL")
    parser.add_argument("--only", choices=["raygraph", "cycles"], help="measure one of the two")
    parser.add_argument("--option", action="append", default=[], help="more of raygraph, one word each")
    arguments = parser.parse_args()
    arguments.work.mkdir(parents=True, exist_ok=True)
    for name in arguments.case or CASES:
        case = CASES[name]
        renderers = [kind(case, arguments) for kind in (Cycles, Raygraph) if arguments.only in (None, kind.name)]
        rounds = {renderer.name: [] for renderer in renderers}
        for _ in range(arguments.rounds):
            for renderer in renderers:  # in turn: other programs disturb both
                measure(renderer, name, arguments, rounds[renderer.name])
        efficiency = {}
        for kind, measured in rounds.items():
            seconds = sorted(r["seconds"] for r in measured)
            seconds = 0.5 * (seconds[(len(seconds) - 1) // 2] + seconds[len(seconds) // 2])
            errors = [sum(r["error"][i] for r in measured) / len(measured) for i in (0, 1)]
            efficiency[kind] = 1.0 / (seconds * errors[1])
            print(f"{name}: {kind}: {seconds:.2f} CPU-s, relMSE {errors[0]:.5f}, trimmed {errors[1]:.5f}, "
                  f"efficiency {efficiency[kind]:.1f}", flush=True)
        if len(efficiency) == 2:
            references = [read_rgb(arguments.work / f"{name}.{k}.{arguments.reference_spp}.exr") for k in efficiency]
            print(f"{name}: raygraph has {efficiency['raygraph'] / efficiency['cycles']:.2f} times the efficiency of "
                  f"Cycles; its picture is {references[1].mean() / references[0].mean():.4f} times as bright")


if __name__ == "__main__":
    main()
