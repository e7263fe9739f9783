import numpy as np
import pytest

import raygraph as rg

SCALE = """#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0, rgba32f) readonly uniform image2D picture;
layout(set = 0, binding = 1, rgba32f) writeonly uniform image2D scaled;
layout(push_constant) uniform Constants { float factor; } constants;
void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(scaled)))) return;
    imageStore(scaled, pixel, imageLoad(picture, pixel) * constants.factor);
}
"""
SQUARES = """#version 460
layout(local_size_x = 4) in;
layout(set = 0, binding = 0) readonly buffer Numbers { int at[]; } numbers;
layout(set = 0, binding = 1) writeonly buffer Squares { int at[]; } squares;
void main() { squares.at[gl_GlobalInvocationID.x] = numbers.at[gl_GlobalInvocationID.x] * numbers.at[gl_GlobalInvocationID.x]; }
"""


def test_pass_takes_and_returns_images():
    picture = np.arange(5 * 9 * 4, dtype=np.float32).reshape(5, 9, 4)
    scaled = rg.run_pass(SCALE, {"picture": picture}, {"scaled": (5, 9)}, constants=np.float32(0.5))["scaled"]
    assert scaled.dtype == np.float32
    np.testing.assert_array_equal(scaled, picture * 0.5)


def test_pass_takes_and_returns_buffers():
    numbers = np.arange(8, dtype=np.int32)
    squares = rg.run_pass(SQUARES, {"numbers": numbers}, {"squares": np.empty((2, 4), np.int32)}, groups=(2, 1, 1))
    np.testing.assert_array_equal(squares["squares"], (numbers**2).reshape(2, 4))


def test_buffer_that_is_updated_returns_with_the_size_of_its_input():
    double = """#version 460
layout(local_size_x = 4) in;
layout(set = 0, binding = 0) buffer Numbers { int at[]; } numbers;
void main() { numbers.at[gl_GlobalInvocationID.x] *= 2; }
"""
    numbers = np.arange(8, dtype=np.int32)
    result = rg.run_pass(double, {"numbers": numbers}, {"numbers": numbers.reshape(2, 4)}, groups=(2, 1, 1))
    np.testing.assert_array_equal(result["numbers"], numbers.reshape(2, 4) * 2)
    with pytest.raises(rg.Error, match="numbers: the output has 4 bytes, the input of this name 32"):
        rg.run_pass(double, {"numbers": numbers}, {"numbers": np.empty(1, np.int32)}, groups=(2, 1, 1))


@pytest.mark.parametrize("wrong", [[[1, 2], [3]], [object()] * 8, np.array([(1, "a")], [("x", "i4"), ("y", "O")])])
def test_buffer_is_no_ragged_list_and_holds_no_objects(wrong):
    right = np.zeros(8, np.int32)
    for numbers, squares in ((wrong, right), (right, wrong)):
        with pytest.raises(rg.Error, match="it is no array of numbers") as raised:
            rg.run_pass(SQUARES, {"numbers": numbers}, {"squares": squares}, groups=(2, 1, 1))
        assert raised.value.kind == "usage"


@pytest.mark.parametrize("shape", [(8,), [8], 8, range(8)])
def test_buffer_is_not_given_by_its_shape_alone(shape):
    with pytest.raises(rg.Error, match="squares: it is no array of numbers with the type and shape of the result"):
        rg.run_pass(SQUARES, {"numbers": np.zeros(8, np.int32)}, {"squares": shape}, groups=(2, 1, 1))


COPY = """#version 460
layout(local_size_x = 1) in;
layout({layout}) uniform Words {{ uvec4 at[{count} / 4]; }} words;
layout(set = 0, binding = 1) writeonly buffer Copied {{ uvec4 at[{count} / 4]; }} copied;
void main() {{ copied.at[gl_WorkGroupID.x] = words.at[gl_WorkGroupID.x]; }}
"""


def test_constants_have_as_many_bytes_as_the_device_takes():
    def copy(count):
        words = np.random.default_rng(count).integers(0, 2**32, count, np.uint32)
        result = rg.run_pass(COPY.format(layout="push_constant", count=count), {}, {"copied": words}, constants=words,
                             groups=(count // 4, 1, 1))
        np.testing.assert_array_equal(result["copied"], words)

    with pytest.raises(rg.Error, match=r"^constants: 4096 bytes are more than the \d+ of .*; a uniform block") as raised:
        copy(1024)
    assert raised.value.kind == "usage"
    limit = int(str(raised.value).split("more than the ")[1].split()[0])
    assert limit >= 128
    for count in (4, 32, limit // 4):
        copy(count)
    with pytest.raises(rg.Error, match=f"^constants: {limit + 16} bytes are more"):
        copy(limit // 4 + 4)


def test_uniform_block_is_an_input():
    words = np.arange(1024, dtype=np.uint32)
    glsl = COPY.format(layout="set = 0, binding = 0", count=1024)
    result = rg.run_pass(glsl, {"words": words}, {"copied": words}, groups=(256, 1, 1))
    np.testing.assert_array_equal(result["copied"], words)
    with pytest.raises(rg.Error, match='4092 bytes for "words", which has 4096'):
        rg.run_pass(glsl, {"words": words[1:]}, {"copied": words}, groups=(256, 1, 1))


def test_picture_goes_through_a_pass(cornell):
    color = rg.render(cornell, spp=1, size=(16, 12))["color"]
    scaled = rg.run_pass(SCALE, {"picture": color}, {"scaled": color.shape[:2]}, constants=np.float32(2))["scaled"]
    np.testing.assert_array_equal(scaled, color * 2)


@pytest.mark.parametrize("changes, kind, text", [
    ({"glsl": SCALE.replace("factor;", "factor")}, "bad_input", r"pass\.comp:\d+: "),
    ({"inputs": {"pictures": np.zeros((2, 2))}}, "usage", "pictures: the shader has no such binding; it has picture, sc"),
    ({"inputs": {}}, "usage", "picture: the shader has it, and it is neither"),
    ({"constants": None}, "usage", "constants: they have 0 bytes, the block of the shader has 4"),
    ({"outputs": {"picture": (2, 2)}}, "usage", "picture: the shader does not write it"),
])
def test_mistake_in_a_pass_is_named(changes, kind, text):
    arguments = {"glsl": SCALE, "inputs": {"picture": np.zeros((2, 2))}, "outputs": {"scaled": (2, 2)},
                 "constants": np.float32(1), **changes}
    with pytest.raises(rg.Error, match=text) as raised:
        rg.run_pass(**arguments)
    assert raised.value.kind == kind
