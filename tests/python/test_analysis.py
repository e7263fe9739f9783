import signal
import time

import numpy as np
import pytest

import raygraph as rg
from conftest import SCENES, run_program

SMALL = {"size": (16, 16), "max_depth": 2}


def test_comparison_has_the_numbers_of_the_program(cornell, tmp_path):
    pictures = [rg.render(cornell, spp=4, seed=seed, **SMALL) for seed in (1, 2)]
    for index, picture in enumerate(pictures):
        picture.save(tmp_path / f"{index}.exr")
    ran = run_program("compare", tmp_path / "0.exr", tmp_path / "1.exr", "--json", tmp_path / "c.json")
    assert ran.returncode == 0, ran.stderr
    difference = rg.compare(*pictures)
    of_files = rg.compare(tmp_path / "0.exr", tmp_path / "1.exr")
    for name in ("rel_mse", "flip", "ssim"):
        assert difference[name] == pytest.approx(of_files[name], rel=1e-6)
    text = (tmp_path / "c.json").read_text()
    assert f"{of_files['flip']:.5g}"[:6] in text
    assert difference["flip_map"].shape == (16, 16)
    assert rg.compare(pictures[0]["color"], pictures[0])["flip"] == 0


def test_planted_mistake_is_judged(cornell):
    picture = rg.render(cornell, spp=64, **SMALL)
    assert rg.verify(cornell, picture, max_samples=64, max_depth=2)["is_right"]
    wrong = rg.verify(cornell, picture["color"] * 1.5, max_samples=64, max_depth=2)
    assert not wrong["is_right"] and wrong["causes"]
    assert any(not check["is_passed"] for check in wrong["checks"])


def test_reference_with_a_ground_hides_what_the_picture_hides(cornell):
    options = {**SMALL, "ground": True, "camera": "orbit 30 20"}
    picture = rg.render(cornell, spp=64, **options)
    assert (picture["color"][..., 3] < 0.5).any() and picture.settings["transparent"] == "on"
    assert rg.verify(cornell, picture, max_samples=64, **options)["is_right"]
    seen = rg.render(cornell, spp=64, **options, transparent=False)
    assert not rg.verify(cornell, seen, max_samples=64, **options)["is_right"]
    assert rg.verify(cornell, seen, max_samples=64, **options, transparent=False)["is_right"]
    x, y = np.argwhere(picture["color"][..., 3].T == 0)[0]
    assert rg.explain(cornell, (int(x), int(y)), **options)["mean"] == (0, 0, 0)


def test_explanation_is_that_of_the_program(cornell):
    ran = run_program("explain", SCENES / "cornell.gltf", "--pixel", "8,8", "--size", "16x16", "--max-depth", "2")
    explained = rg.explain(cornell, (8, 8), **SMALL)
    assert ran.returncode == 0 and explained["text"] == ran.stdout
    assert explained["values"].shape == (64, 3)
    np.testing.assert_allclose(explained["values"].mean(0), explained["mean"], rtol=1e-4, atol=1e-6)
    with pytest.raises(rg.Error) as raised:
        rg.explain(cornell, (99, 8), **SMALL)
    assert raised.value.kind == "usage"


def test_noise_of_an_adaptive_picture_is_that_of_its_file(cornell, tmp_path):
    picture = rg.render(cornell, spp=24, adaptive=True, **SMALL)
    reference = rg.render(cornell, spp=16, seed=5, **SMALL)
    assert picture["samples"].min() != picture["samples"].max()
    picture.save(tmp_path / "a.exr")
    of_file = rg.compare(reference, tmp_path / "a.exr")
    assert rg.compare(reference, picture)["z"] == pytest.approx(of_file["z"], rel=1e-4)


def test_signal_during_the_diagnosis_is_raised(cornell):
    wrong = rg.render(cornell, spp=64, **SMALL)["color"] * 1.5
    start = time.monotonic()
    assert rg.verify(cornell, wrong, max_samples=64, max_depth=2)["causes"]
    seconds = time.monotonic() - start

    def interrupt(*_):
        raise LookupError("enough")

    before = signal.signal(signal.SIGALRM, interrupt)
    try:
        for share in (0.4, 0.6, 0.8):
            with pytest.raises(LookupError):
                signal.setitimer(signal.ITIMER_REAL, share * seconds)
                rg.verify(cornell, wrong, max_samples=64, max_depth=2)
                time.sleep(10 * seconds)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
