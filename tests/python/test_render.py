import logging
import os
import runpy
import signal
import subprocess
import sys
import threading
import time

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


@pytest.mark.parametrize("options", [
    {"max_depth": 3, "aovs": ["albedo", "depth"]},
    {"ground": True, "camera": "orbit 30 20"},
    {"adaptive": True, "spp": 24},
])
def test_interrupted_and_resumed_render_has_the_bits_of_one(cornell, tmp_path, options):
    options = {"spp": 9, "size": (16, 12), "sample_offset": 5, "exposure": 1, **options}
    whole = rg.render(cornell, **options)
    part = rg.render(cornell, **options, progress=lambda state: state.samples < 3)
    assert part.was_stopped and 3 <= part.samples < options["spp"]
    part.save(tmp_path / "part.exr")
    last = {"spp": options["spp"], "exposure": 1}
    resumed = rg.render(cornell, **last, resume=tmp_path / "part.exr")
    same = rg.render(cornell, **options, resume=part)  # what is given again may be that of the render
    for picture in (resumed, same):
        assert not picture.was_stopped and picture.samples == whole.samples and picture.settings == whole.settings
        assert set(picture) == set(whole)
        for name in whole:
            np.testing.assert_array_equal(picture[name], whole[name], name)
        np.testing.assert_array_equal(picture.display, whole.display)
    complete = rg.render(cornell, spp=options["spp"], resume=whole)
    np.testing.assert_array_equal(complete["color"], whole["color"])


def test_render_that_is_resumed_may_not_become_another(cornell, tmp_path):
    rg.render(cornell, **SMALL, sample_offset=2).save(tmp_path / "a.exr")
    for options, kind, text in [
            ({"max_depth": 3}, "usage", r"^max_depth 3: .*a\.exr was rendered with none"),
            ({"size": (8, 8)}, "usage", r"^size 8x8: .*a\.exr was rendered with 16x12"),
            ({"aovs": ["depth"]}, "usage", r"^aovs depth: .*a\.exr was rendered with "),
            ({"sample_offset": 1}, "usage", r"^sample_offset 1: .*a\.exr was rendered with 2"),
            ({"spp": None}, "usage", r"^spp: it is the total to reach.*a\.exr, which has 2 samples"),
            ({"spp": 1}, "usage", "1 samples are asked for, and there are 2"),
            ({"resume": tmp_path / "none.exr"}, "bad_input", "none.exr")]:
        with pytest.raises(rg.Error, match=text) as raised:
            rg.render(cornell, **{"spp": 4, "resume": tmp_path / "a.exr", **options})
        assert raised.value.kind == kind
    with pytest.raises(rg.Error, match=r"a\.exr cannot be resumed: scene: ") as raised:
        rg.render(SCENES / "furnace_sphere.gltf", spp=4, resume=tmp_path / "a.exr")
    assert raised.value.kind == "bad_input"
    display = rg.render(cornell, **SMALL, view="normals")
    with pytest.raises(rg.Error, match="the picture cannot be resumed: it shows the view normals"):
        rg.render(cornell, spp=4, resume=display)


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


def test_progress_is_called_on_the_thread_of_the_call(cornell):
    threads = set()
    rg.render(cornell, **SMALL, progress=lambda state: threads.add(threading.get_ident()))
    assert threads == {threading.get_ident()}


def test_two_scenes_render_at_once_on_two_devices_while_python_goes_on(cornell):
    scenes = [cornell, rg.load(SCENES / "glass_sphere.gltf")]
    options = {"size": (96, 64), "spp": 8}
    alone = [rg.render(scene, **options) for scene in scenes]
    pictures, messages, spans = [None, None], [], [[], []]
    both_render = threading.Barrier(2, timeout=120)
    is_done = threading.Event()
    ticks = [0.0]

    def tick():
        while not is_done.is_set():
            now = time.monotonic()
            if now > ticks[-1] + 0.001:
                ticks.append(now)

    def render(index):
        def progress(state):
            begin = time.monotonic()
            if not spans[index]:  # the first call, which may come after several samples
                both_render.wait()
            spans[index].append((begin, time.monotonic()))

        device = rg.Device(validation=True)
        pictures[index] = rg.render(scenes[index], **options, device=device, progress=progress)
        messages.append(device.validation_messages)

    ticking = threading.Thread(target=tick)
    threads = [threading.Thread(target=render, args=(index,)) for index in range(2)]
    for thread in [ticking, *threads]:
        thread.start()
    for thread in threads:
        thread.join()
    is_done.set()
    ticking.join()
    assert messages == [0, 0]
    for index, picture in enumerate(pictures):
        for name in alone[index]:
            np.testing.assert_array_equal(picture[name], alone[index][name], name)
        # Python ran in the middle of most samples, and not only where progress lets it
        samples = [(end, begin) for (_, end), (begin, _) in zip(spans[index], spans[index][1:])]
        during = [sum(a + (b - a) / 4 < tick < b - (b - a) / 4 for tick in ticks) for a, b in samples]
        assert len(during) >= 6 and np.count_nonzero(during) > len(during) / 2, (samples, during)


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
