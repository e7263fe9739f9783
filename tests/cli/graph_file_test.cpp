// Tests the reading of graphs that are described in JSON.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/text.h"
#include "editor/graph_run/graph_file.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/text_files.h"

namespace raygraph::graph_run {
namespace {

constexpr const char* kWhole = R"({
    "textures": {
        "photo": {"file": "pictures/photo.png", "format": "rgba8"},
        "half": {"size": "photo", "format": "rgba16f"},
        "state": {"size": [64, 32], "layers": 3, "format": "r32ui", "persistent": true, "file": "state.bin"}
    },
    "buffers": {
        "sums": {"bytes": 1024, "persistent": true},
        "table": {"file": "table.bin"}
    },
    "passes": [
        {"shader": "blur.comp", "bind": {"source": "photo", "target": "half"},
         "push": {"direction": [1, 0.5], "frame": "frame", "isLast": true}, "specialize": {"RADIUS": 3},
         "dispatch": "photo", "queue": "compute"},
        {"shader": "./blur.comp", "dispatch": [1, 2, 3]},
        {"name": "Show", "shader": "show.frag", "targets": ["photo", "half"], "queue": "main"}
    ],
    "outputs": {"b.png": "half", "a.bin": "sums", "c.EXR": {"texture": "state", "layer": 2}},
    "frames": 4
})";

TEST(GraphFile, EveryKeyIsRead) {
    const GraphFile graph = ParseGraphFile(kWhole, "g.json");
    EXPECT_EQ(graph.name, "g.json");
    EXPECT_EQ(graph.frames, 4u);
    ASSERT_EQ(graph.textures.size(), 3u);
    const FileTexture &photo = graph.textures.at("photo"), &half = graph.textures.at("half"),
                      &state = graph.textures.at("state");
    EXPECT_EQ(photo.file, "pictures/photo.png");
    EXPECT_EQ(photo.format, rhi::Format::Rgba8Unorm);
    EXPECT_EQ(half.sizeOf, "photo");
    EXPECT_FALSE(half.isPersistent);
    EXPECT_EQ(state.size, (rhi::Extent2D{64, 32}));
    EXPECT_EQ(state.layers, 3u);
    EXPECT_EQ(state.format, rhi::Format::R32Uint);
    EXPECT_TRUE(state.isPersistent);
    EXPECT_EQ(state.file, "state.bin");
    EXPECT_EQ(graph.buffers.at("sums").bytes, 1024u);
    EXPECT_TRUE(graph.buffers.at("sums").isPersistent);
    EXPECT_EQ(graph.buffers.at("table").file, "table.bin");
    ASSERT_EQ(graph.passes.size(), 3u);
    const FilePass &blur = graph.passes[0], &again = graph.passes[1], &show = graph.passes[2];
    EXPECT_EQ(blur.name, "blur");
    EXPECT_EQ(blur.shader, "blur.comp");
    EXPECT_EQ(blur.bind, (std::map<std::string, std::string>{{"source", "photo"}, {"target", "half"}}));
    EXPECT_EQ(std::get<std::vector<double>>(blur.push.at("direction")), (std::vector<double>{1.0, 0.5}));
    EXPECT_EQ(std::get<std::vector<double>>(blur.push.at("isLast")), std::vector<double>{1.0});
    EXPECT_TRUE(std::holds_alternative<FrameNumber>(blur.push.at("frame")));
    EXPECT_EQ(blur.specialize.at("RADIUS"), 3.0);
    EXPECT_EQ(blur.over, "photo");
    EXPECT_TRUE(blur.isAsync);
    EXPECT_EQ(again.name, "blur 2") << "names of passes differ";
    EXPECT_EQ(again.shader, "blur.comp");
    EXPECT_EQ(again.groups, (std::array<uint32_t, 3>{1, 2, 3}));
    EXPECT_EQ(show.name, "Show");
    EXPECT_EQ(show.targets, (std::vector<std::string>{"photo", "half"}));
    EXPECT_FALSE(show.isAsync);
    ASSERT_EQ(graph.outputs.size(), 3u);
    EXPECT_EQ(graph.outputs[0].file, "b.png") << "in the order of the file";
    EXPECT_EQ(graph.outputs[1].resource, "sums");
    EXPECT_EQ(graph.outputs[2].layer, 2u);
}

// Returns the message about a description whose text `from` is replaced by `to`, without the file's name.
std::string Refusal(std::string_view from, std::string_view to) {
    std::string text = kWhole;
    const size_t at = text.find(from);
    EXPECT_NE(at, text.npos) << from;
    text.replace(at, from.size(), to);
    const std::string message =
        testing::ErrorTextOf([&] { ParseGraphFile(text, "g.json"); }, ErrorKind::BadInput);
    EXPECT_TRUE(message.starts_with("g.json: ")) << message;
    return message.substr(std::min<size_t>(message.size(), 8));
}

TEST(GraphFile, WhatIsWrongIsNamedWithItsPath) {
    struct Row {
        const char *from, *to, *message;
    };
    const Row rows[] = {
        {R"("frames": 4)", R"("frames": 0)", "frames: a whole number from 1 to 1000000 is expected"},
        {R"("frames": 4)", R"("frames": 2.5)", "frames: a whole number from 1 to 1000000 is expected"},
        {R"("frames": 4)", R"("frames": "4")", "frames: a whole number from 1 to 1000000 is expected"},
        {R"("frames": 4)", R"("frames": -4)", "frames: a whole number from 1 to 1000000 is expected"},
        {R"("frames": 4)", R"("frame": 4)",
         "frame: there is no such key; there are textures, buffers, passes, outputs, frames"},
        {R"("frames": 4)", R"("frames": 4, "frames": 5)", "frames: the key is there twice"},
        {R"("format": "rgba8")", R"("format": "rgba8", "format": "rgba8")",
         "textures.photo.format: the key is there twice"},
        {R"("dispatch": [1, 2, 3])", R"("dispatch": [1, 2, 3], "shader": "a.comp")",
         "passes[1].shader: the key is there twice"},
        {R"("size": [64, 32])", R"("size": [64, 0])",
         "textures.state.size[1]: a whole number from 1 to 16384 is expected"},
        {R"("size": [64, 32])", R"("size": [64])",
         "textures.state.size: two numbers or the name of a texture are expected"},
        {R"("size": [64, 32])", R"("size": 64)", "textures.state.size: a list is expected"},
        {R"("size": [64, 32], "layers": 3)", R"("size": [16384, 16384], "layers": 5)",
         "textures.state.size: the texture has more than 4 GiB"},
        {R"("size": [64, 32], )", "", "textures.state: it has no size"},
        {R"("size": "photo")", R"("size": "foto")", "textures.half.size: there is no texture \"foto\""},
        {R"("size": "photo")", R"("size": "half")", "textures.half.size: it depends on itself"},
        {R"("size": "photo")", R"("size": "sums")", "textures.half.size: there is no texture \"sums\""},
        {R"("file": "pictures/photo.png")", R"("file": "photo.png", "size": [1, 1])",
         "textures.photo.size: leave it out, since the picture in file has the size"},
        {R"("file": "pictures/photo.png")", R"("file": "photo.png", "layers": 2)",
         "textures.photo: the picture has one layer"},
        {R"("layers": 3)", R"("layers": 4000)",
         "textures.state.layers: a whole number from 1 to 2048 is expected"},
        {R"("format": "rgba8")", R"("format": 8)", "textures.photo.format: a text is expected"},
        {R"("persistent": true, "file")", R"("persistent": 1, "file")",
         "textures.state.persistent: true or false is expected"},
        {R"("layers")", R"("levels")",
         "textures.state.levels: there is no such key; there are size, format, layers, persistent, file"},
        {R"("state": {)", R"("": {)", "textures: a name is empty"},
        {R"({"file": "table.bin"})", R"(7)", "buffers.table: an object is expected"},
        {R"({"file": "table.bin"})", R"({})", "buffers.table: it has neither bytes nor a file"},
        {R"({"file": "table.bin"})", R"({"file": ""})", "buffers.table.file: it is empty"},
        {R"({"file": "table.bin"})", R"({"file": "table.bin", "bytes": 4})",
         "buffers.table.bytes: the file has the size"},
        {R"("bytes": 1024)", R"("bytes": 1023)", "buffers.sums.bytes: a multiple of 4 is expected"},
        {R"("bytes": 1024)", R"("bytes": 4294967300)",
         "buffers.sums.bytes: a whole number from 4 to 4294967296 is expected"},
        {R"("bytes": 1024)", R"("size": 1024)",
         "buffers.sums.size: there is no such key; there are bytes, persistent, file"},
        {R"("sums": {)", R"("half": {)", "buffers.half: there is a texture of that name"},
        {R"("shader": "blur.comp", )", "", "passes[0]: it has no shader"},
        {R"("shader": "blur.comp")", R"("shader": "blur.glsl")",
         "passes[0].shader: a .comp or a .frag file is expected"},
        {R"("target": "half")", R"("target": "haft")",
         "passes[0].bind.target: there is neither a texture nor a buffer \"haft\""},
        {R"("target": "half")", R"("target": ["half"])", "passes[0].bind.target: a text is expected"},
        {R"({"source": "photo", "target": "half"})", R"("photo")", "passes[0].bind: an object is expected"},
        {R"([1, 0.5])", R"([1, "frame"])", "passes[0].push.direction[1]: a number is expected"},
        {R"([1, 0.5])", R"("fame")",
         "passes[0].push.direction: a number, a list of numbers or \"frame\" is expected"},
        {R"([1, 0.5])", R"(null)", "passes[0].push.direction: a number is expected"},
        {R"({"RADIUS": 3})", R"({"RADIUS": "3"})", "passes[0].specialize.RADIUS: a number is expected"},
        {R"("dispatch": "photo")", R"("dispatch": "sums")",
         "passes[0].dispatch: there is no texture \"sums\""},
        {R"([1, 2, 3])", R"([1, 2])",
         "passes[1].dispatch: the name of a texture or three numbers are expected"},
        {R"([1, 2, 3])", R"([1, 2, 65536])",
         "passes[1].dispatch[2]: a whole number from 1 to 65535 is expected"},
        {R"("queue": "compute")", R"("queue": "transfer")",
         "passes[0].queue: \"main\" or \"compute\" is expected"},
        {R"("queue": "main")", R"("queue": "compute")",
         "passes[2].queue: a .frag is drawn on the main queue"},
        {R"("queue": "compute")", R"("targets": ["half"])", "passes[0].targets: only a .frag has targets"},
        {R"("targets": ["photo", "half"])", R"("targets": [])", "passes[2]: a .frag needs targets"},
        {R"("targets": ["photo", "half"])", R"("targets": ["sums"])",
         "passes[2].targets[0]: there is no texture \"sums\""},
        {R"("queue": "main")", R"("dispatch": [1, 1, 1])",
         "passes[2].dispatch: a .frag is drawn over its targets"},
        {R"("name": "Show")", R"("name": "blur 2")", "passes[2].name: there is a pass of that name"},
        {R"("name": "Show")", R"("kind": "raster")",
         "passes[2].kind: there is no such key; there are name, shader, bind, targets, push, specialize, "
         "dispatch, queue"},
        {R"("b.png": "half")", R"("b.jpg": "half")", "outputs.b.jpg: a .png, .exr or .bin file is expected"},
        {R"("b.png": "half")", R"("b.png": "haft")",
         "outputs.b.png: there is neither a texture nor a buffer \"haft\""},
        {R"("b.png": "half")", R"("b.png": "sums")", "outputs.b.png: a buffer is written to a .bin"},
        {R"("b.png": "half")", R"("b.png": {"texture": "sums"})",
         "outputs.b.png.texture: a buffer is written to a .bin"},
        {R"("b.png": "half")", R"("b.png": {"layer": 0})", "outputs.b.png: it has no texture"},
        {R"("b.png": "half")", R"("b.png": {"texture": "half", "level": 0})",
         "outputs.b.png.level: there is no such key; there are texture, layer"},
        {R"("layer": 2)", R"("layer": 3)", "outputs.c.EXR.layer: a whole number from 0 to 2 is expected"},
        {R"("a.bin": "sums")", R"("a.bin": {"texture": "state"})",
         "outputs.a.bin: a .bin has all layers of a texture, which is given by its name"},
        {R"({"b.png": "half", "a.bin": "sums", "c.EXR": {"texture": "state", "layer": 2}})", "{}",
         "outputs: there are none"},
    };
    for (const auto& [from, to, message] : rows) EXPECT_EQ(Refusal(from, to), message) << to;
    EXPECT_THAT(Refusal(R"("format": "rgba8")", R"("format": "rgba9")"),
                ::testing::StartsWith("textures.photo.format: \"rgba9\" is no format; there are r8, "));
}

TEST(GraphFile, ReadsAndWritesBelowItsFoldersOnly) {
    const char* refusal = "buffers.table.file: a file below the folder of the description is expected";
    for (const char* file : {"/etc/passwd", "../table.bin", "a/../../table.bin", "..", "a/", "a\\u0000.bin"})
        EXPECT_EQ(Refusal("table.bin", file), refusal) << file;
    for (const char* file : {"/tmp/b.png", "../b.png", "a/b.png"})
        EXPECT_EQ(Refusal("b.png", file), Text("outputs.{}: a file without a folder is expected", file));
    EXPECT_EQ(Refusal("shader\": \"blur.comp", "shader\": \"../blur.comp"),
              "passes[0].shader: a file below the folder of the description is expected");
}

TEST(GraphFile, WhatIsNoDescriptionIsRefused) {
    const auto refusal = [](std::string_view text) {
        return testing::ErrorTextOf([&] { ParseGraphFile(text, "a\nb.json"); }, ErrorKind::BadInput);
    };
    EXPECT_EQ(refusal(""), "a?b.json: line 1: it is no JSON");
    EXPECT_EQ(refusal("{\n\"frames\": 1,\n}"), "a?b.json: line 3: it is no JSON");
    EXPECT_EQ(refusal("[]"), "a?b.json: an object is expected");
    EXPECT_EQ(refusal("{}"), "a?b.json: it has no passes");
    EXPECT_EQ(refusal(R"({"passes": []})"), "a?b.json: it has no outputs");
    EXPECT_EQ(refusal(R"({"passes": {}, "outputs": {}})"), "a?b.json: passes: a list is expected");
    EXPECT_EQ(refusal(R"({"frames": 1e999})"), "a?b.json: it has a number beyond the range of numbers");
    EXPECT_EQ(refusal(R"({"a\u001b": 1})"),
              "a?b.json: a?: there is no such key; there are textures, buffers, passes, outputs, frames");
    EXPECT_EQ(refusal("{\"frames\": " + std::string(100000, '[')),
              "a?b.json: frames[0][0][0][0][0][0][0]: it is nested more than 8 deep");
    std::string many = "{";
    for (int i = 0; i < 5000; ++i) many += Text("\"{}\": 0,", i);
    EXPECT_EQ(refusal(many), "a?b.json: 4096: there are more than 4096 items");
    many = "{\"passes\": [0";
    for (int i = 0; i < 5000; ++i) many += ",0";
    EXPECT_EQ(refusal(many), "a?b.json: passes[4097]: there are more than 4096 items");
}

TEST(GraphFile, IsReadFromDisk) {
    const test::TemporaryFolder folder;
    test::Put(folder / "g.json", kWhole);
    const GraphFile graph = ReadGraphFile(folder / "g.json");
    EXPECT_EQ(graph.folder, folder.Path());
    EXPECT_EQ(graph.name, (folder / "g.json").string());
    const auto refusal = [&](const char* file) {
        return testing::ErrorTextOf([&] { ReadGraphFile(folder / file); }, ErrorKind::BadInput);
    };
    EXPECT_EQ(refusal("none.json"),
              (folder / "none.json").string() + ": cannot open: No such file or directory");
    test::Put(folder / "large.json", std::string((1 << 20) + 1, ' '));
    EXPECT_THAT(refusal("large.json"), ::testing::HasSubstr("1048576"));
}

}  // namespace
}  // namespace raygraph::graph_run
