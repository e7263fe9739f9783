import resource
import runpy

import numpy as np
import pytest

import raygraph as rg
from conftest import EXAMPLES, SCENES

SMALL = {"size": (16, 12), "spp": 2}
QUAD = [[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]]
TRIANGLES = [[0, 1, 2], [0, 2, 3]]


def placed(x, y, z):
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def test_point_light_over_a_lambertian_quad_gives_i_over_pi_d_squared():
    scene = rg.Scene()
    white = scene.add_material(base_color_factor=(1, 1, 1, 1), roughness_factor=1, metallic_factor=0, specular_factor=0)
    scene.add_mesh(np.float64(QUAD) * 0.01, TRIANGLES, material=white)
    light = scene.add_light("point", intensity=8, matrix=placed(0, 2, 0))
    options = {**SMALL, "spp": 4, "camera": rg.look_at((0, 1, 0), (0, 0, 0), up=(0, 0, -1), fov=0.5), "max_depth": 1}
    assert rg.render(scene, **options)["color"][..., :3].mean() == pytest.approx(8 / np.pi / 4, rel=0.02)
    light.intensity = 2
    assert rg.render(scene, **options)["color"][..., :3].mean() == pytest.approx(2 / np.pi / 4, rel=0.02)
    light.node.translation = (0, 1, 0)
    assert rg.render(scene, **options)["color"][..., :3].mean() == pytest.approx(2 / np.pi, rel=0.02)
    white.base_color_factor = (0.5, 1, 1, 1)
    color = rg.render(scene, **options)["color"][..., :3].mean((0, 1))
    assert color[0] / color[1] == pytest.approx(0.5, rel=1e-3)


def test_moved_node_changes_the_picture_and_moved_back_gives_its_bits():
    loaded = rg.load(SCENES / "cornell.gltf")
    node = loaded.nodes[0]
    before = rg.render(loaded, **SMALL)["color"].copy()
    moved = np.array(node.matrix)
    moved[0, 3] += 0.25
    node.matrix = moved
    np.testing.assert_array_equal(node.matrix, moved)
    after = rg.render(loaded, **SMALL)["color"]
    assert (after != before).any()
    node.matrix = moved - [[0, 0, 0, 0.25], [0] * 4, [0] * 4, [0] * 4]
    np.testing.assert_array_equal(rg.render(loaded, **SMALL)["color"], before)
    moved[1, 3] = 1000.0000001  # a float would lose the last digits
    node.matrix = moved
    assert node.matrix[1, 3] == pytest.approx(moved[1, 3], abs=1e-9, rel=0)


def test_texture_of_an_array_is_seen_with_its_upper_left_corner_at_uv_zero():
    scene = rg.Scene()
    texels = np.zeros((16, 16, 3), np.uint8)
    texels[:8, :8] = 255, 0, 0
    texels[8:, 8:] = 0, 0, 255
    paper = scene.add_material(base_color_texture=texels, unlit=True)
    scene.add_mesh(QUAD, TRIANGLES, uvs=[[0, 1], [1, 1], [1, 0], [0, 0]], material=paper)
    camera = rg.look_at((0, 1, 0), (0, 0, 0), up=(0, 0, -1), fov=89)
    color = rg.render(scene, spp=4, size=(16, 16), camera=camera)["color"]
    assert color[2, 2, 0] > 0.9 and color[2, 2, 2] < 0.1 and color[13, 13, 2] > 0.9 and color[13, 13, 0] < 0.1
    np.testing.assert_array_equal(paper.base_color_texture[..., :3], texels)


def test_spheres_have_their_depth():
    scene = rg.Scene()
    scene.add_spheres([[0, 0, 0]], 0.5)
    depth = rg.render(scene, spp=1, size=(9, 9), aovs=["depth"], camera=rg.look_at((0, 0, 3), (0, 0, 0), fov=5))["depth"]
    assert depth[4, 4] == pytest.approx(2.5, abs=1e-3)


def test_environment_of_an_array_lights_the_scene():
    scene = rg.Scene()
    scene.set_environment(np.full((2, 4, 3), 3.0))
    color = rg.render(scene, **SMALL, camera=rg.look_at((0, 0, 3), (0, 0, 0)))["color"]
    np.testing.assert_allclose(color[..., :3], 3.0, rtol=1e-3)


def test_camera_that_is_added_sees_along_minus_z_of_its_node():
    scene = rg.Scene()
    scene.add_spheres([[0, 0, 0]], 0.5)
    camera = scene.add_camera("front", y_fov=0.2, matrix=placed(0, 0, 3))
    side = scene.add_camera("side", orthographic=True, x_mag=0.25, y_mag=0.25, matrix=placed(0.3, 0, 2))
    assert [each.name for each in scene.cameras] == ["front", "side"] and not camera.orthographic and side.orthographic
    assert camera.node.name == "front" and side.node.index == 2
    options = {"spp": 1, "size": (9, 9), "aovs": ["depth"]}
    depth = rg.render(scene, **options)["depth"]
    assert depth[4, 4] == pytest.approx(2.5, abs=1e-3)
    of_program = rg.render(scene, **options, camera=rg.look_at((0, 0, 3), (0, 0, 0), fov=np.degrees(0.2)))["depth"]
    np.testing.assert_allclose(depth, of_program, rtol=1e-5)
    for chosen in (side, "side", 1):
        depth = rg.render(scene, **options, camera=chosen)["depth"]
        assert depth[4, 4] == pytest.approx(2 - 0.4, abs=1e-3)  # sqrt(0.5^2 - 0.3^2) in front of the middle
        assert np.isinf(depth[4, 8]) and depth[4, 0] < 1.6
    with pytest.raises(rg.Error, match=r"y_fov is 4, must be"):
        scene.add_camera(y_fov=4)
    with pytest.raises(TypeError, match="fov is no field of a camera"):
        scene.add_camera(fov=1)


@pytest.mark.parametrize("edit, text", [
    (lambda scene: scene.add_mesh([[0, 0]]), r"positions: the shape is \(1, 2\), not \(n, 3\)"),
    (lambda scene: scene.add_mesh(QUAD, [[0, 1, 4]]), "indices: 4 is not below the 4 positions"),
    (lambda scene: scene.add_mesh(QUAD, [0, 1]), "indices: 2 are no triangles"),
    (lambda scene: scene.add_mesh(QUAD, [[0.5, 1, 2]]), "indices: they are integers"),
    (lambda scene: scene.add_mesh(QUAD, TRIANGLES, normals=[[0, 1, 0]]), "normals: there are 1, and 4 positions"),
    (lambda scene: scene.add_mesh([[np.nan, 0, 0]] * 3), "positions: one is not finite"),
    (lambda scene: scene.add_material(roughness_factor=2), r"materials\[0\]: roughnessFactor is 2, must be 0 to 1"),
    (lambda scene: scene.add_light("lamp"), 'kind: "lamp" is none of directional, point, spot'),
    (lambda scene: scene.add_mesh(QUAD, TRIANGLES, material=rg.Scene().add_material()), "material: it is of another"),
    (lambda scene: scene.add_material(base_color_texture=np.zeros((2, 2))), "base_color_texture: it is uint8"),
    (lambda scene: scene.set_environment(np.full((2, 4, 3), -1.0)), "environment: -1 is no radiance"),
    (lambda scene: scene.add_mesh(QUAD, TRIANGLES, uvs=[[np.nan, 0]] * 4), "uvs: one is not finite"),
    (lambda scene: scene.add_mesh(QUAD, TRIANGLES, matrix=np.full((4, 4), np.inf)), "matrix: it is not finite"),
    (lambda scene: scene.add_spheres([[0, np.inf, 0]], 1), "centers: one is not finite"),
    (lambda scene: scene.add_spheres([[0, 0, 0]], 0), "radii: 0 is not 1e-09 to 1"),
    (lambda scene: scene.add_spheres([[0, 0, 0]], [[1], [1, 2]]), "radii: they are no numbers"),
])
def test_mistake_in_arrays_is_named(edit, text):
    with pytest.raises(rg.Error, match=text) as raised:
        edit(rg.Scene())
    assert raised.value.kind == "usage"


def test_refused_value_leaves_the_scene_as_it_was():
    loaded = rg.load(SCENES / "cornell.gltf")
    camera, node, count = loaded.cameras[0], loaded.nodes[0], len(loaded.nodes)
    for owner, name, wrong in ((camera, "y_fov", np.nan), (camera, "y_fov", 4), (node, "translation", (0, np.nan, 0))):
        before = getattr(owner, name)
        with pytest.raises(rg.Error, match=name):
            setattr(owner, name, wrong)
        assert getattr(owner, name) == before
    with pytest.raises(rg.Error):
        loaded.add_spheres([[0, 0, 0]], -1)
    assert len(loaded.nodes) == count
    with pytest.raises(TypeError):
        node.translation = "here"


def test_texture_takes_views_of_arrays_and_the_place_of_its_predecessor():
    scene = rg.Scene()
    texels = np.arange(4 * 4 * 3, dtype=np.uint8).reshape(4, 4, 3)
    first, second = scene.add_material(base_color_texture=texels[::-1]), scene.add_material(base_color_texture=texels)
    np.testing.assert_array_equal(first.base_color_texture[..., :3], texels[::-1])
    first.base_color_texture = texels[:2, ::2]
    np.testing.assert_array_equal(first.base_color_texture[..., :3], texels[:2, ::2])
    np.testing.assert_array_equal(second.base_color_texture[..., :3], texels)
    large = np.zeros((1024, 1024, 4), np.uint8)
    first.base_color_texture = large
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for _ in range(64):
        first.base_color_texture = large
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 64 * 1024  # KiB; kept they were 256 MiB


def test_environment_of_a_file_is_that_of_its_array(tmp_path):
    light = rg.Scene()
    light.set_environment(np.full((2, 4, 3), 3.0))
    camera = rg.look_at((0, 0, 3), (0, 0, 0))
    rg.render(light, **SMALL, camera=camera).save(tmp_path / "map.hdr")
    scene = rg.Scene()
    scene.set_environment(tmp_path / "map.hdr")
    np.testing.assert_allclose(rg.render(scene, **SMALL, camera=camera)["color"][..., :3], 3.0, rtol=2e-2)


def test_node_scaled_to_nothing_is_refused():
    scene = rg.Scene()
    scene.add_mesh(QUAD, TRIANGLES, matrix=np.zeros((4, 4)))
    with pytest.raises(rg.Error, match="scaled to nothing"):
        rg.render(scene, **SMALL)


def test_example_of_arrays_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    foggy = runpy.run_path(str(EXAMPLES / "arrays.py"))["foggy"]
    assert foggy.shape == (64, 96, 4) and np.isfinite(foggy).all()
    assert (tmp_path / "ring.png").exists() and capsys.readouterr().out.startswith("(64, 96, 4) ")
