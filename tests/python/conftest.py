import os
import pathlib
import signal
import subprocess

import pytest

import raygraph as rg

SCENES = pathlib.Path(os.environ["RAYGRAPH_SCENES"]).resolve()
EXAMPLES = pathlib.Path(rg.__file__).resolve().parent.parent / "examples"
PROGRAM = os.environ["RAYGRAPH_PROGRAM"]


# A shell that starts commands in the background lets them ignore Ctrl-C, which Python then does too.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session", autouse=True)
def device():
    """The default device, with core and synchronization validation."""
    device = rg.Device(validation=True)
    rg.set_default_device(device)
    yield device
    assert device.validation_messages == 0


@pytest.fixture(scope="session")
def cornell():
    return rg.load(SCENES / "cornell.gltf")


def run_program(*words):
    """Runs `raygraph` and returns what it has printed; CompletedProcess.stderr has the messages."""
    return subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True, check=False)
