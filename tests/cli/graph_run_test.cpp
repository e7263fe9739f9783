// Runs graphs that are described in JSON, and looks at every value.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "base/files.h"
#include "base/text.h"
#include "editor/graph_run/graph_run.h"
#include "renderer/image/exr.h"
#include "renderer/image/image.h"
#include "tests/cli/program_runner.h"
#include "tests/support/error_of.h"
#include "tests/support/source_file.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/text_files.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::graph_run {
namespace {

using testing::As;
using testing::BytesOf;

constexpr const char* kHead = R"(#version 460
#extension GL_EXT_scalar_block_layout : require
layout(local_size_x = 4, local_size_y = 4) in;
)";

constexpr const char* kAdd = R"(
layout(binding = 0, r32f) uniform image2D sum;
layout(push_constant, scalar) uniform Push { uint frame; float amount; ivec3 offset; bool isOn; };
void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(sum)))) return;
    float more = isOn ? float(frame) * amount + float(offset.x * texel.x + offset.y * texel.y + offset.z) : 0.0;
    imageStore(sum, texel, imageLoad(sum, texel) + more);
})";
constexpr const char* kScale = R"(
layout(constant_id = 0) const float FACTOR = 2.0;
layout(binding = 0, r32f) uniform readonly image2D source;
layout(binding = 1, r32f) uniform writeonly image2D target;
void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(target)))) return;
    imageStore(target, texel, FACTOR * imageLoad(source, texel));
})";
constexpr const char* kLife = R"(
layout(binding = 0, r32ui) uniform readonly uimage2D now;
layout(binding = 1, r32ui) uniform writeonly uimage2D next;
void main() {
    ivec2 cell = ivec2(gl_GlobalInvocationID.xy), size = imageSize(now);
    if (any(greaterThanEqual(cell, size))) return;
    uint neighbors = 0;
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x)
            if (x != 0 || y != 0) neighbors += imageLoad(now, (cell + ivec2(x, y) + size) % size).x;
    bool lives = neighbors == 3 || (neighbors == 2 && imageLoad(now, cell).x == 1);
    imageStore(next, cell, uvec4(lives ? 1 : 0));
})";
constexpr const char* kSquares = R"(
layout(constant_id = 3) const uint FIRST = 0;
layout(binding = 0) buffer Numbers { uint numbers[]; };
layout(binding = 1) readonly buffer Table { uint entries[]; } table;
void main() {
    uint i = gl_WorkGroupID.x * 16 + gl_LocalInvocationIndex;
    numbers[i] += (FIRST + i) * (FIRST + i) + table.entries[i % 2];
})";
constexpr const char* kLayers = R"(
layout(binding = 0, r32f) uniform readonly image2DArray source;
layout(binding = 1, r32f) uniform writeonly image2DArray target;
void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(target).xy))) return;
    for (int layer = 0; layer < imageSize(target).z; ++layer)
        imageStore(target, ivec3(texel, layer), float(layer) + 2.0 * imageLoad(source, ivec3(texel, layer)));
})";
constexpr const char* kPlace = R"(#version 460
layout(location = 0) in vec2 uv;
layout(location = 0) out vec2 place;
layout(location = 1) out float sampled;
layout(binding = 0) uniform sampler2D picture;
void main() {
    place = uv;
    sampled = texture(picture, uv).x;
})";

class GraphRunTest : public testing::VulkanTest {
  public:
    GraphRunTest() {
        for (const auto& [name, text] :
             {std::pair("add.comp", kAdd), std::pair("scale.comp", kScale), std::pair("life.comp", kLife),
              std::pair("squares.comp", kSquares), std::pair("layers.comp", kLayers)})
            test::Put(folder / name, std::string(kHead) + text);
        test::Put(folder / "place.frag", kPlace);
    }

    GraphRun Run(std::string_view json) {
        GraphFile graph = ParseGraphFile(json, "g.json");
        graph.folder = folder.Path();
        return RunGraph(Device(), graph);
    }
    template <typename T>
    std::vector<T> ValuesOf(std::string_view json, size_t output = 0) {
        return As<T>(Run(json).outputs.at(output).bytes);
    }
    // Returns the one line about a graph that cannot run, without the description's name.
    std::string Refusal(std::string_view json) {
        const std::string message = testing::ErrorTextOf([&] { Run(json); }, ErrorKind::BadInput);
        EXPECT_TRUE(message.starts_with("g.json: ")) << message;
        return message.substr(std::min<size_t>(message.size(), 8));
    }
    template <typename T>
    void PutValues(const char* file, const std::vector<T>& values) {
        AtomicFile target(folder / file);
        target.Write(BytesOf(values));
        target.Commit();
    }

    test::TemporaryFolder folder;
};

// A blur of one bright texel has the products of the weights of both directions.
TEST_F(GraphRunTest, BlurOfTheExampleIsSeparable) {
    std::filesystem::copy_file(test::SourceFile("examples/10_graph_run/blur.comp"), folder / "blur.comp");
    constexpr int kSide = 9, kRadius = 3;
    std::vector<float> bright(kSide * kSide * 4);
    for (int c = 0; c < 4; ++c) bright[4 * (4 * kSide + 4) + c] = static_cast<float>(c + 1);
    PutValues("bright.bin", bright);
    const auto blurred = ValuesOf<float>(R"({
        "textures": {"bright": {"size": [9, 9], "file": "bright.bin"}, "a": {"size": "bright"}, "b": {"size": "a"}},
        "passes": [
            {"shader": "blur.comp", "bind": {"source": "bright", "target": "a"},
             "push": {"direction": [1, 0], "sigma": 1.5}, "specialize": {"RADIUS": 3}},
            {"shader": "blur.comp", "bind": {"source": "a", "target": "b"},
             "push": {"direction": [0, 1], "sigma": 1.5}, "specialize": {"RADIUS": 3}}],
        "outputs": {"blurred.exr": "b"}})");
    const auto weight = [](int i) { return std::abs(i) > kRadius ? 0.0 : std::exp(-0.5 * i * i / 2.25); };
    double sum = 0.0;
    for (int i = -kRadius; i <= kRadius; ++i) sum += weight(i);
    ASSERT_EQ(blurred.size(), bright.size());
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x)
            for (int c = 0; c < 4; ++c)
                EXPECT_NEAR(blurred[4 * (y * kSide + x) + c],
                            (c + 1) * weight(x - 4) * weight(y - 4) / sum / sum, 1e-6)
                    << x << " " << y << " " << c;
}

TEST_F(GraphRunTest, PersistentTexturesBeginWithZerosAndKeepTheirValues) {
    const auto json = [](const char* isPersistent, int frames) {
        return Text(R"({{"textures": {{"sum": {{"size": [3, 2], "format": "r32f", "persistent": {}}}}},
            "passes": [{{"shader": "add.comp", "bind": {{"sum": "sum"}},
                        "push": {{"frame": "frame", "amount": 0.5, "offset": [1000, -100, 7], "isOn": true}}}}],
            "outputs": {{"sum.bin": "sum"}}, "frames": {}}})",
                    isPersistent, frames);
    };
    const std::vector<float> one{7, 1007, 2007, -93, 907, 1907};
    EXPECT_EQ(ValuesOf<float>(json("true", 1)), one);
    std::vector<float> five;
    for (const float value : one) five.push_back(5 * value + 0.5f * (0 + 1 + 2 + 3 + 4));
    EXPECT_EQ(ValuesOf<float>(json("true", 5)), five);
}

TEST_F(GraphRunTest, GliderOfLifeMovesByOneCellInFourGenerations) {
    constexpr uint32_t kSide = 8;
    const auto glider = [](uint32_t x, uint32_t y) {
        std::vector<uint32_t> cells(kSide * kSide);
        for (const auto& [dx, dy] : {std::pair(1u, 0u), {2u, 1u}, {0u, 2u}, {1u, 2u}, {2u, 2u}})
            cells[(y + dy) % kSide * kSide + (x + dx) % kSide] = 1;
        return cells;
    };
    PutValues("glider.bin", glider(0, 0));
    const auto after = [&](int frames, const char* queue) {
        return ValuesOf<uint32_t>(
            Text(R"({{"textures": {{"now": {{"size": [8, 8], "format": "r32ui", "file": "glider.bin"}},
                                   "next": {{"size": "now", "format": "r32ui"}}}},
                "passes": [{{"shader": "life.comp", "bind": {{"now": "now", "next": "next"}}, "queue": "{0}"}},
                           {{"shader": "life.comp", "bind": {{"now": "next", "next": "now"}}, "queue": "{0}"}}],
                "outputs": {{"life.bin": "now"}}, "frames": {1}}})",
                 queue, frames));
    };
    EXPECT_EQ(after(2, "main"), glider(1, 1));
    EXPECT_EQ(after(20, "main"), glider(10, 10));
    EXPECT_EQ(after(20, "compute"), glider(10, 10)) << "on a queue beside";
}

TEST_F(GraphRunTest, BuffersHaveTheBytesOfFilesAndSpecializationItsValue) {
    PutValues<uint32_t>("table.bin", {1000, 2000});
    const GraphRun run = Run(R"({
        "buffers": {"numbers": {"bytes": 128, "persistent": true}, "table": {"file": "table.bin"}},
        "passes": [{"shader": "squares.comp", "bind": {"Numbers": "numbers", "table": "table"},
                    "specialize": {"FIRST": 2}, "dispatch": [2, 1, 1]}],
        "outputs": {"numbers.bin": "numbers", "table.bin": "table"}, "frames": 3})");
    std::vector<uint32_t> squares;
    for (uint32_t i = 0; i < 32; ++i) squares.push_back(3 * ((2 + i) * (2 + i) + (i % 2 == 0 ? 1000 : 2000)));
    EXPECT_EQ(As<uint32_t>(run.outputs.at(0).bytes), squares);
    EXPECT_EQ(As<uint32_t>(run.outputs.at(1).bytes), (std::vector<uint32_t>{1000, 2000})) << "as it was";
}

TEST_F(GraphRunTest, FragmentShaderCoversItsTargets) {
    PutValues<float>("picture.bin", {0.25f, 4.0f, 1.0f, 2.0f, 8.0f, 16.0f});
    const GraphRun run = Run(R"({
        "textures": {"picture": {"size": [3, 2], "format": "r32f", "file": "picture.bin"},
                     "place": {"size": "picture", "format": "rg32f"},
                     "sampled": {"size": "picture", "format": "r32f"}},
        "passes": [{"shader": "place.frag", "bind": {"picture": "picture"}, "targets": ["place", "sampled"]}],
        "outputs": {"place.bin": "place", "sampled.bin": "sampled"}})");
    const auto place = As<float>(run.outputs.at(0).bytes);
    ASSERT_EQ(place.size(), 12u);
    for (size_t i = 0; i < 6; ++i) {
        EXPECT_NEAR(place[2 * i], (static_cast<double>(i % 3) + 0.5) / 3.0, 1e-6) << i;
        EXPECT_NEAR(place[2 * i + 1], (static_cast<double>(i / 3) + 0.5) / 2.0, 1e-6) << i;
    }
    const auto sampled = As<float>(run.outputs.at(1).bytes),
               picture = As<float>(ReadFile(folder / "picture.bin"));
    ASSERT_EQ(sampled.size(), 6u);
    for (size_t i = 0; i < 6; ++i)
        EXPECT_NEAR(sampled[i], picture[i], 1e-3f * picture[i]) << "upright: " << i;
}

TEST_F(GraphRunTest, LayersAreReadAndWrittenOneAfterTheOther) {
    std::vector<float> values(3 * 4);
    std::iota(values.begin(), values.end(), 1.0f);
    PutValues("stack.bin", values);
    const GraphRun run = Run(R"({
        "textures": {"stack": {"size": [2, 2], "layers": 3, "format": "r32f", "file": "stack.bin"},
                     "out": {"size": "stack", "layers": 3, "format": "r32f"}},
        "passes": [{"shader": "layers.comp", "bind": {"source": "stack", "target": "out"}}],
        "outputs": {"all.bin": "out", "one.exr": {"texture": "out", "layer": 2}, "first.exr": "out"}})");
    std::vector<float> expected;
    for (size_t i = 0; i < values.size(); ++i) expected.push_back(static_cast<float>(i / 4) + 2 * values[i]);
    EXPECT_EQ(As<float>(run.outputs.at(0).bytes), expected);
    EXPECT_EQ(As<float>(run.outputs.at(1).bytes), std::vector<float>(expected.begin() + 8, expected.end()));
    EXPECT_EQ(As<float>(run.outputs.at(2).bytes), std::vector<float>(expected.begin(), expected.begin() + 4));
}

TEST_F(GraphRunTest, ElementsOfAnArrayAreBoundByTheirNames) {
    test::Put(folder / "differ.comp", std::string(kHead) + R"(
layout(binding = 0) uniform sampler2D maps[2];
layout(binding = 2, r32f) uniform writeonly image2D target;
void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(target)))) return;
    imageStore(target, texel, texelFetch(maps[0], texel, 0) - texelFetch(maps[1], texel, 0));
})");
    PutValues<float>("a.bin", {5, 7});
    PutValues<float>("b.bin", {1, 4});
    const auto json = [](const char* second) {
        return Text(R"({{"textures": {{"a": {{"size": [2, 1], "format": "r32f", "file": "a.bin"}},
            "b": {{"size": "a", "format": "r32f", "file": "b.bin"}}, "c": {{"size": "a", "format": "r32f"}}}},
            "passes": [{{"shader": "differ.comp", "bind": {{"maps[0]": "a", "{}": "b", "target": "c"}}}}],
            "outputs": {{"c.bin": "c"}}}})",
                    second);
    };
    EXPECT_EQ(ValuesOf<float>(json("maps[1]")), (std::vector<float>{4, 3}));
    EXPECT_EQ(Refusal(json("maps[2]")),
              "passes[0].bind.maps[2]: differ.comp has no such binding; there are maps[0], maps[1], target");
}

TEST_F(GraphRunTest, PicturesGoInAndOutAsTheyAre) {
    const std::vector<uint8_t> rgba{0, 1, 2, 3, 100, 150, 200, 255, 255, 128, 64, 32, 7, 6, 5, 4};
    image::WritePng(folder / "in.png", {.width = 2, .height = 2, .rgba = rgba});
    const std::vector<float> reds{-1.5f, 0.25f, 3.0f, std::nanf("")};
    const image::ExrPlane planes[] = {{.name = "R", .samples = std::span(reds)},
                                      {.name = "G", .samples = std::span(reds)},
                                      {.name = "B", .samples = std::span(reds)}};
    image::WriteExr(folder / "in.exr", 2, 2, planes);
    image::WriteHdr(folder / "in.hdr", {.width = 1, .height = 1, .rgba = {0.5f, 2.0f, 8.0f, 1.0f}});
    // No pass is needed between an input and an output
    const GraphRun run = Run(R"({
        "textures": {"png": {"file": "in.png", "format": "rgba8"}, "exr": {"file": "in.exr", "format": "r32f"},
                     "hdr": {"file": "in.hdr"}, "unorm": {"file": "in.exr", "format": "rgba8"}},
        "passes": [],
        "outputs": {"a.png": "png", "b.exr": "exr", "c.exr": "hdr", "d.png": "exr", "e.bin": "unorm"}})");
    const char* names[] = {"a.png", "b.exr", "c.exr", "d.png", "e.bin"};
    for (size_t i = 0; i < std::size(names); ++i) WriteOutput(run.outputs.at(i), folder / names[i]);
    EXPECT_EQ(image::DecodeImage8(ReadFile(folder / "a.png"), "a.png").rgba, rgba);
    const image::ExrImage exr = image::ReadExr(folder / "b.exr"), hdr = image::ReadExr(folder / "c.exr");
    ASSERT_TRUE(exr.FloatChannel("Y") && exr.channels.size() == 1);
    EXPECT_EQ(std::vector<float>(exr.FloatChannel("Y")->begin(), exr.FloatChannel("Y")->begin() + 3),
              (std::vector<float>{-1.5f, 0.25f, 3.0f}));
    EXPECT_TRUE(std::isnan(exr.FloatChannel("Y")->back()));
    EXPECT_EQ(*hdr.FloatChannel("B"), std::vector<float>{8.0f});
    EXPECT_EQ(*hdr.FloatChannel("A"), std::vector<float>{1.0f});
    EXPECT_EQ(image::DecodeImage8(ReadFile(folder / "d.png"), "d.png").rgba,
              (std::vector<uint8_t>{0, 0, 0, 255, 64, 64, 64, 255, 255, 255, 255, 255, 0, 0, 0, 255}))
        << "clamped, gray, opaque";
    const std::vector<std::byte> unorm = ReadFile(folder / "e.bin");
    EXPECT_EQ(std::to_integer<int>(unorm.at(4)), 64);
    EXPECT_EQ(std::to_integer<int>(unorm.at(12)), 0) << "not a number";
}

TEST_F(GraphRunTest, ExrKeepsIntegersThatFloatsHaveNot) {
    PutValues<uint32_t>("in.bin", {16777217, 4294967295, 0, 5});
    const GraphRun run = Run(R"({"textures": {"in": {"size": [2, 1], "format": "rg32ui", "file": "in.bin"}},
        "passes": [], "outputs": {"a.exr": "in"}})");
    WriteOutput(run.outputs.at(0), folder / "a.exr");
    const image::ExrImage exr = image::ReadExr(folder / "a.exr");
    ASSERT_TRUE(exr.UintChannel("R") && exr.UintChannel("G"));
    EXPECT_EQ(*exr.UintChannel("R"), (std::vector<uint32_t>{16777217, 0}));
    EXPECT_EQ(*exr.UintChannel("G"), (std::vector<uint32_t>{4294967295, 5}));
}

TEST_F(GraphRunTest, PassesThatLeadNowhereAreCulledAndTheOthersTimed) {
    PutValues<float>("in.bin", {1.0f});
    const GraphRun run = Run(R"({
        "textures": {"in": {"size": [1, 1], "format": "r32f", "file": "in.bin"}, "a": {"size": "in", "format": "r32f"},
                     "b": {"size": "in", "format": "r32f"}},
        "passes": [{"name": "Used", "shader": "scale.comp", "bind": {"source": "in", "target": "a"}},
                   {"name": "Unused", "shader": "scale.comp", "bind": {"source": "in", "target": "b"}}],
        "outputs": {"a.bin": "a"}, "frames": 6})");
    ASSERT_EQ(run.passes.size(), 1u);
    EXPECT_EQ(run.passes[0].name, "Used");
    EXPECT_GT(run.passes[0].gpuMs, 0.0);
    EXPECT_EQ(As<float>(run.outputs.at(0).bytes), std::vector<float>{2.0f}) << "the constant's default";
    EXPECT_THAT(run.plan, ::testing::HasSubstr("Unused"));
    EXPECT_THAT(run.dot, ::testing::StartsWith("digraph"));
}

TEST_F(GraphRunTest, WhatShadersAndFilesHaveNotIsNamed) {
    PutValues<float>("three.bin", {1, 2, 3});
    test::Put(folder / "odd.bin", "12345");
    test::Put(folder / "no.png", "no picture");
    test::Put(folder / "matrix.comp", std::string(kHead) +
                                          "layout(push_constant) uniform P { mat2 m; };\n"
                                          "layout(binding = 0) buffer B { float v[]; };\n"
                                          "void main() { v[0] = m[0][0]; }");
    test::Put(folder / "broken.comp", std::string(kHead) + "void main() { wrong(); }");
    // The passes, beside resources for them
    const auto passes = [&](const std::string& pass) {
        return Refusal(Text(
            R"({{"textures": {{"a": {{"size": [4, 4], "format": "r32f"}}, "w": {{"size": "a", "persistent": true}},
            "p": {{"size": "a", "format": "r32f", "persistent": true}}}}, "buffers": {{"b": {{"bytes": 64}}}},
            "passes": [{}], "outputs": {{"a.bin": "a"}}}})",
            pass));
    };
    const auto resource = [&](const std::string& kind, const std::string& text) {
        return Refusal(
            Text(R"({{"{}": {{"a": {}}}, "passes": [], "outputs": {{"a.bin": "a"}}}})", kind, text));
    };
    EXPECT_EQ(passes(""), "outputs.a.bin: no pass writes \"a\"");
    EXPECT_EQ(passes(R"({"shader": "none.comp"})"),
              Text("passes[0].shader: {}: cannot be read", (folder / "none.comp").string()));
    EXPECT_EQ(passes(R"({"shader": "scale.comp", "bind": {"sauce": "p", "target": "a"}})"),
              "passes[0].bind.sauce: scale.comp has no such binding; there are source, target");
    EXPECT_EQ(passes(R"({"shader": "scale.comp", "bind": {"target": "a"}})"),
              "passes[0]: bind lacks source, which scale.comp uses");
    EXPECT_EQ(passes(R"({"shader": "scale.comp", "bind": {"source": "b", "target": "a"}})"),
              "passes[0].bind.source: scale.comp has a storage image there, and \"b\" is a buffer");
    EXPECT_EQ(
        passes(R"({"shader": "scale.comp", "bind": {"source": "p", "target": "a"}, "specialize": {"F": 1}})"),
        "passes[0].specialize.F: scale.comp has no such constant; there are FACTOR");
    EXPECT_EQ(passes(R"({"shader": "scale.comp", "bind": {"source": "p", "target": "a"}, "push": {"F": 1}})"),
              "passes[0].push.F: scale.comp has no such push constant; there are none");
    EXPECT_EQ(
        passes(
            R"({"shader": "scale.comp", "bind": {"source": "p", "target": "a"}, "specialize": {"FACTOR": 1e39}})"),
        "passes[0].specialize.FACTOR: 1e+39 is no value of type float");
    const auto push = [&](const char* constants) {
        return passes(Text(R"({{"shader": "add.comp", "bind": {{"sum": "a"}}, "push": {{{}}}}})", constants));
    };
    EXPECT_EQ(push(R"("frame": 1, "amount": 1, "isOn": 1)"),
              "passes[0]: push lacks offset, which add.comp has");
    EXPECT_EQ(push(R"("frame": 1, "amount": [1, 2])"),
              "passes[0].push.amount: it has 2 numbers, the shader 1");
    EXPECT_EQ(push(R"("offset": "frame")"), "passes[0].push.offset: it has 1 number, the shader 3");
    EXPECT_EQ(push(R"("frame": -1)"), "passes[0].push.frame: -1 is no value of type uint");
    EXPECT_EQ(push(R"("frame": 4294967296)"), "passes[0].push.frame: 4294967296 is no value of type uint");
    EXPECT_EQ(push(R"("offset": [0, 0.5, 0])"), "passes[0].push.offset: 0.5 is no value of type int");
    EXPECT_EQ(passes(R"({"shader": "matrix.comp", "bind": {"B": "b"}, "push": {"m": [1, 2, 3, 4]}})"),
              "passes[0].push.m: it is neither a number nor a vector of 32-bit numbers");
    EXPECT_EQ(passes(R"({"shader": "squares.comp", "bind": {"Numbers": "b", "table": "b"}})"),
              "passes[0]: it needs a dispatch, since it writes no texture");
    EXPECT_THAT(passes(R"({"shader": "scale.comp", "bind": {"source": "w", "target": "a"}})"),
                ::testing::AllOf(::testing::StartsWith("passes[0]: "), ::testing::HasSubstr("declares r32f")))
        << "another format";
    EXPECT_THAT(passes(R"({"shader": "place.frag", "bind": {"picture": "p"}, "targets": ["p", "a"]})"),
                ::testing::StartsWith("passes[0]: "))
        << "read and drawn to";
    EXPECT_EQ(resource("textures", R"({"size": [2, 2], "format": "r32f", "file": "three.bin"})"),
              "textures.a.file: three.bin has 12 bytes, the texture has 16");
    EXPECT_EQ(resource("textures", R"({"file": "no.png"})").substr(0, 25), "textures.a.file: no.png: ");
    EXPECT_EQ(
        resource("textures", R"({"file": "none.png"})"),
        Text("textures.a.file: {}: cannot open: No such file or directory", (folder / "none.png").string()));
    EXPECT_EQ(resource("textures", R"({"file": "no.png", "format": "r32ui"})"),
              "textures.a.file: a picture has no integers; a .bin may have them");
    EXPECT_EQ(resource("buffers", R"({"file": "odd.bin"})"),
              "buffers.a.file: odd.bin has 5 bytes, a multiple of 4 is expected");
    const Error broken = testing::ErrorOf([&] {
        Run(R"({"passes": [{"shader": "broken.comp"}], "buffers": {"a": {"bytes": 4}}, "outputs": {"a.bin": "a"}})");
    });
    EXPECT_EQ(broken.Kind(), ErrorKind::BadInput);
    EXPECT_THAT(broken.what(), ::testing::StartsWith("broken.comp:4: "));
}

// --- The command ---

class GraphRunProgram : public ::testing::Test {
  public:
    GraphRunProgram() {
        std::filesystem::create_directories(folder / "g");
        for (const auto& file :
             std::filesystem::directory_iterator(test::SourceFile("examples/10_graph_run")))
            std::filesystem::copy_file(file.path(), folder / "g" / file.path().filename().string());
    }
    image::Image8 Picture(const char* file) const {
        return image::DecodeImage8(ReadFile(folder / file), file);
    }

    test::TemporaryFolder folder;
};

TEST_F(GraphRunProgram, BlursAndSaysWhatItDid) {
    const test::ProgramResult result =
        test::RunProgram(folder, "graph run g/blur.json --validate --plan --time");
    EXPECT_EQ(result.exitCode, 0) << result.messages;
    EXPECT_EQ(result.messages, "");
    EXPECT_THAT(result.output, ::testing::StartsWith("pattern.png\nblurred.png\n"));
    EXPECT_THAT(result.output, ::testing::HasSubstr("Blur down"));
    EXPECT_THAT(result.output, ::testing::ContainsRegex("Blur across +[0-9.]+ ms\nBlur down +[0-9.]+ ms\n"));
    const image::Image8 pattern = Picture("pattern.png"), blurred = Picture("blurred.png");
    ASSERT_EQ(blurred.width, 512u);
    const uint8_t* middle = &pattern.rgba[4 * (512 * 256 + 256)];
    EXPECT_EQ(std::vector<int>(middle, middle + 3), (std::vector<int>{242, 115, 26}));
    double sums[2] = {};
    int most = 0;
    for (size_t i = 0; i < pattern.rgba.size(); i += 4) {
        EXPECT_TRUE(pattern.rgba[i] == 0 || pattern.rgba[i] >= 242) << i;
        sums[0] += pattern.rgba[i];
        sums[1] += blurred.rgba[i];
        if (i % 2048 >= 400 && i % 2048 < 1600)
            most = std::max(most, std::abs(blurred.rgba[i] - blurred.rgba[i + 4]));
    }
    EXPECT_NEAR(sums[1] / sums[0], 1.0, 0.01) << "a blur keeps the mean";
    EXPECT_LE(most, 20) << "a blur has no edges";
}

TEST_F(GraphRunProgram, RunsFramesIntoAFolder) {
    std::filesystem::create_directory(folder / "out");
    const test::ProgramResult result =
        test::RunProgram(folder, "graph run g/reaction.json --frames 3 -o out --validate --dot");
    EXPECT_EQ(result.exitCode, 0) << result.messages;
    EXPECT_THAT(result.output, ::testing::StartsWith("digraph"));
    EXPECT_EQ(test::FileCount(folder / "out"), 2u);
    const image::ExrImage state = image::ReadExr(folder / "out/reaction.exr");
    ASSERT_TRUE(state.FloatChannel("R") && state.FloatChannel("G"));
    // Both substances are within their bounds; where no drop is near, x is 1 and y is 0
    const auto [least, most] = std::ranges::minmax(*state.FloatChannel("G"));
    EXPECT_GE(least, 0.0f);
    EXPECT_LT(most, 1.0f);
    EXPECT_GT(most, 0.3f);
    EXPECT_NEAR(std::ranges::max(*state.FloatChannel("R")), 1.0, 1e-5);
}

TEST_F(GraphRunProgram, EndsWithOneLineForWhatIsWrong) {
    test::Put(folder / "bad.json",
              R"({"passes": [{"shader": "a.comp", "bind": {"x": "y"}}], "outputs": {}})");
    const test::ProgramResult bad = test::RunProgram(folder, "graph run bad.json");
    EXPECT_EQ(bad.exitCode, 4);
    EXPECT_EQ(bad.messages,
              "raygraph: bad.json: passes[0].bind.x: there is neither a texture nor a buffer \"y\"\n");
    EXPECT_EQ(test::RunProgram(folder, "graph run none.json").messages,
              "raygraph: none.json: cannot open: No such file or directory\n");
    const test::ProgramResult nowhere = test::RunProgram(folder, "graph run g/blur.json -o nowhere");
    EXPECT_EQ(nowhere.exitCode, 1);
    EXPECT_THAT(nowhere.messages, ::testing::StartsWith("raygraph: nowhere/pattern.png: "));
    EXPECT_FALSE(std::filesystem::exists(folder / "pattern.png"));
}

TEST_F(GraphRunProgram, WritesNoInput) {
    test::Put(folder / "g.json",
              R"({"textures": {"a": {"file": "a.png"}}, "passes": [], "outputs": {"a.png": "a"}})");
    image::WritePng(folder / "a.png", {.width = 1, .height = 1, .rgba = {1, 2, 3, 255}});
    const std::string before = test::TextOf(folder / "a.png");
    const test::ProgramResult result = test::RunProgram(folder, "graph run g.json");
    EXPECT_EQ(result.exitCode, 2);
    EXPECT_EQ(test::TextOf(folder / "a.png"), before);
}

}  // namespace
}  // namespace raygraph::graph_run
