"""Ctrl-C where the library works in one piece: a driver that compiles, a file that is read. A script of its own gets a
real signal, as its terminal would send it."""
import os
import signal
import subprocess
import sys
import time

import pytest

from conftest import SCENES

SCRIPT = """
import sys, time
import raygraph as rg
device = rg.Device()
print("begins", flush=True)
try:
    {call}
    print("is done", flush=True)
except {handled} as error:
    print(type(error).__name__, flush=True)
print(rg.Scene().file, flush=True)
"""
RENDER = "rg.render(sys.argv[1], spp=1, size=(16, 12), device=device)"
LOAD = "rg.load(sys.argv[1])"


class Run:
    """A script that makes a call with caches of its own, which are empty, and how long the call took."""

    def __init__(self, call, argument, folder, handled="()", interrupt_after=None):
        # Without the flags of other tests, which let the driver compile less
        environment = {**os.environ, "XDG_CACHE_HOME": str(folder), "MESA_SHADER_CACHE_DIR": str(folder)}
        environment.pop("GALLIVM_PERF", None)
        script = SCRIPT.format(call=call, handled=handled)
        process = subprocess.Popen([sys.executable, "-c", script, str(argument)], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True, env=environment)
        try:
            assert process.stdout.readline() == "begins\n"
            start = time.monotonic()
            if interrupt_after is not None:
                time.sleep(interrupt_after)
                process.send_signal(signal.SIGINT)
                start = time.monotonic()
            self.word = process.stdout.readline()  # "" if the script ends before it has one
            self.seconds = time.monotonic() - start  # from the signal on, if there was one
            self.printed = self.word + process.stdout.read()
            self.messages, self.status = process.stderr.read(), process.wait()
        finally:
            process.kill()


@pytest.fixture(scope="module")
def compiling(tmp_path_factory):
    """The seconds of a first render, most of which the driver compiles."""
    run = Run(RENDER, SCENES / "cornell.gltf", tmp_path_factory.mktemp("cache"))
    assert run.status == 0 and run.word == "is done\n" and run.seconds > 1
    return run.seconds


def test_ctrl_c_ends_a_script_whose_shaders_are_compiled(tmp_path, compiling):
    run = Run(RENDER, SCENES / "cornell.gltf", tmp_path, interrupt_after=0.2 * compiling)
    assert run.status == -signal.SIGINT and "KeyboardInterrupt" in run.messages and run.printed == ""
    assert run.seconds < 0.5 * compiling


def test_script_that_handles_ctrl_c_goes_on_and_ends_well(tmp_path, compiling):
    run = Run(RENDER, SCENES / "cornell.gltf", tmp_path, "KeyboardInterrupt", 0.2 * compiling)
    assert run.printed == "KeyboardInterrupt\npython\n" and run.seconds < 0.5 * compiling
    assert run.status == 0 and run.messages == ""


def test_ctrl_c_ends_a_script_that_reads_a_scene(tmp_path):
    count = 2_000_000
    nodes, roots = ",".join(["{}"] * count), ",".join(map(str, range(count)))
    large = tmp_path / "large.gltf"
    large.write_text(f'{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[{roots}]}}],"nodes":[{nodes}]}}')
    whole = Run(LOAD, large, tmp_path)
    assert whole.status == 0 and whole.word == "is done\n" and whole.seconds > 1
    run = Run(LOAD, large, tmp_path, interrupt_after=0.2 * whole.seconds)
    assert run.status == -signal.SIGINT and "KeyboardInterrupt" in run.messages and run.printed == ""
    assert run.seconds < 0.5 * whole.seconds
