import logging
import os
import runpy
import signal
import subprocess
import sys
import threading

import numpy as np
import pytest

import raygraph as rg
from conftest import EXAMPLES, SCENES, run_program

SMALL = {"size": (16, 12), "spp": 2}


def test_first_script_gives_linear_float32_of_height_and_width():
    scene = rg.load(SCENES / "cornell.gltf")
    image = rg.render(scene, **SMALL)["color"]
    assert image.dtype == np.float32 and image.shape == (12, 16, 4)
    assert image[..., :3].mean() > 0.01 and np.isfinite(image).all()
    assert not image.flags.owndata


def test_picture_has_the_bits_of_the_program(cornell, tmp_path):
    options = ["--size", "16x12", "--spp", "3", "--seed", "7", "--max-depth", "3", "--aov", "albedo,depth,instance",
               "--exposure", "1"]
    ran = run_program("render", SCENES / "cornell.gltf", "-o", tmp_path / "a.exr", "-o", tmp_path / "a.png", *options)
    assert ran.returncode == 0, ran.stderr
    of_program = rg.read(tmp_path / "a.exr")
    picture = rg.render(cornell, spp=3, size=(16, 12), seed=7, max_depth=3, aovs=["albedo", "depth", "instance"],
                        exposure=1)
    assert picture.settings == of_program.settings
    assert set(picture) == set(of_program) == {"color", "variance", "albedo", "depth", "instance"}
    for name, values in picture.items():
        np.testing.assert_array_equal(values[..., :3] if values.ndim == 3 else values,
                                      of_program[name][..., :3] if values.ndim == 3 else of_program[name], name)
    picture.save(tmp_path / "b.png")
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_picture_with_a_ground_has_the_bits_of_the_program(cornell, tmp_path):
    ran = run_program("render", SCENES / "cornell.gltf", "-o", tmp_path / "a.png", "--size", "16x12", "--spp", "2",
                      "--ground", "on", "--camera", "orbit 30 20")
    assert ran.returncode == 0, ran.stderr
    picture = rg.render(cornell, **SMALL, ground=True, camera="orbit 30 20")
    assert picture._repr_png_() == (tmp_path / "a.png").read_bytes()
    assert picture.settings["transparent"] == "on" and (picture.display[..., 3] == 255).all()
    cut_out = rg.render(cornell, **SMALL, ground=True, transparent=True, camera="orbit 30 20")
    assert (cut_out.display[..., 3] < 255).any()


def test_error_is_the_line_of_the_program(tmp_path):
    (tmp_path / "bad.gltf").write_text("{")
    ran = run_program("render", tmp_path / "bad.gltf", "-o", tmp_path / "a.png")
    with pytest.raises(rg.Error) as raised:
        rg.load(tmp_path / "bad.gltf")
    assert raised.value.kind == "bad_input"
    assert str(raised.value) in ran.stderr and "\n" not in str(raised.value)


@pytest.mark.parametrize("options, text", [
    ({"max_depth": "x"}, 'max_depth: "x"'),
    ({"camera": "None such"}, "camera: "),
    ({"aovs": ["albino"]}, 'aovs: "albino" is not one of albedo'),
    ({"aovs": ["motion"]}, "aovs: a picture with these settings has no motion"),
    ({"seconds": -1.0}, "seconds: -1 is not above 0"),
    ({"spp": 0}, "spp: 0 is not above 0"),
    ({"denoise": "magic"}, 'denoise: "magic"'),
    ({"device": [None]}, "device: one of the list is None"),
])
def test_mistake_is_named_by_its_keyword(cornell, options, text):
    with pytest.raises(rg.Error, match=text) as raised:
        rg.render(cornell, **{**SMALL, **options})
    assert raised.value.kind == "usage"


def test_unknown_setting_is_a_type_error(cornell):
    with pytest.raises(TypeError, match="depth_max is no setting.*max_depth"):
        rg.render(cornell, depth_max=1)


def test_progress_is_called_and_may_stop(cornell):
    seen = []

    def progress(state):
        seen.append(state.samples)
        return state.samples < 3

    picture = rg.render(cornell, spp=1000, size=(16, 12), progress=progress)
    assert picture.was_stopped and 3 <= picture.samples < 1000
    assert seen == sorted(seen) and seen[-1] <= picture.samples


def test_exception_of_progress_ends_the_render(cornell):
    def progress(state):
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        rg.render(cornell, spp=1000, size=(16, 12), progress=progress)


def test_ctrl_c_ends_between_samples(cornell):
    def interrupt(state):
        os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        rg.render(cornell, spp=100000, size=(16, 12), progress=interrupt)


def test_other_threads_run_while_the_library_works(cornell):
    count = 0
    done = threading.Event()

    def render():
        rg.render(cornell, spp=64, size=(32, 32))
        done.set()

    thread = threading.Thread(target=render)
    thread.start()
    while not done.is_set():
        count += 1
    thread.join()
    assert count > 100


def test_import_opens_no_device():
    script = "import raygraph, sys; print('numpy' in sys.modules, len(raygraph.__all__) > 5)"
    environment = {**os.environ, "VK_DRIVER_FILES": "/nowhere.json", "DISPLAY": ""}
    ran = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, env=environment, check=True)
    assert ran.stdout.split()[1] == "True" and ran.stderr == ""


def test_no_device_is_an_error_of_that_kind():
    script = ("import raygraph as rg\n"
              "try: rg.Device()\n"
              "except rg.Error as error: print(error.kind)")
    environment = {**os.environ, "VK_DRIVER_FILES": "/nowhere.json"}
    ran = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, env=environment, check=True)
    assert ran.stdout.strip() == "no_device"


def test_first_example_writes_its_picture(tmp_path, monkeypatch):
    (tmp_path / "scenes").symlink_to(SCENES)
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(EXAMPLES / "first.py"))
    assert (tmp_path / "cornell.png").read_bytes().startswith(b"\x89PNG")


def test_arrays_go_to_others_by_dlpack_without_a_copy(cornell):
    picture = rg.render(cornell, **SMALL)
    taken = np.from_dlpack(picture["color"])
    assert np.shares_memory(taken, picture["color"])
    del picture
    assert np.isfinite(taken).all()


def test_array_outlives_its_picture(cornell):
    color = rg.render(cornell, **SMALL)["color"]
    again = rg.render(cornell, **SMALL)
    np.testing.assert_array_equal(color, again["color"])


def test_merged_pictures_have_the_bits_of_one(cornell, tmp_path):
    first = rg.render(cornell, **SMALL)
    second = rg.render(cornell, **{**SMALL, "spp": 1}, sample_offset=2)
    second.save(tmp_path / "second.exr")
    merged = rg.merge([first, tmp_path / "second.exr"])
    whole = rg.render(cornell, **{**SMALL, "spp": 3})
    assert merged.samples == 3
    np.testing.assert_array_equal(merged["color"], whole["color"])
    with pytest.raises(rg.Error, match=r"pictures\[0\]"):
        rg.merge([first, first])


def test_picture_shows_itself(cornell):
    picture = rg.render(cornell, **SMALL)
    assert picture._repr_png_().startswith(b"\x89PNG")
    assert picture.display.dtype == np.uint8 and picture.display.shape == (12, 16, 4)


def test_denoised_picture_is_beside_the_mean(cornell):
    picture = rg.render(cornell, **SMALL, denoise="regression")
    plain = rg.render(cornell, **SMALL)
    np.testing.assert_array_equal(picture["color"], plain["color"])
    assert picture["denoised"].shape == (12, 16, 4) and (picture["denoised"] != picture["color"]).any()


def test_two_devices_render_in_two_threads(cornell):
    pictures = {}

    def render(index):
        pictures[index] = rg.render(cornell, **SMALL, device=rg.Device())

    threads = [threading.Thread(target=render, args=(index,)) for index in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    np.testing.assert_array_equal(pictures[0]["color"], pictures[1]["color"])


def test_display_of_a_picture_that_was_read_is_made_once(cornell, tmp_path):
    rg.render(cornell, **SMALL).save(tmp_path / "a.exr")
    picture = rg.read(tmp_path / "a.exr")
    start = threading.Barrier(4)
    shown = []

    def show():
        start.wait()
        shown.append(picture.display)

    threads = [threading.Thread(target=show) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len({each.__array_interface__["data"][0] for each in shown}) == 1 and len(shown) == 4


def test_view_that_is_no_light_is_shown_alike_when_it_is_read(cornell, tmp_path):
    picture = rg.render(cornell, size=(16, 12), view="normals")
    picture.save(tmp_path / "a.exr")
    np.testing.assert_array_equal(rg.read(tmp_path / "a.exr").display, picture.display)


def test_messages_come_during_the_call(cornell, caplog):
    caplog.set_level(logging.DEBUG, "raygraph")
    seen = []
    device = rg.Device()
    caplog.clear()
    rg.render(cornell, **SMALL, device=device, progress=lambda state: seen.append(len(caplog.records)))
    assert caplog.records and seen[0] > 0
