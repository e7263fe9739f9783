// Tests the program with a scene's own environment.
#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "renderer/image/image.h"
#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::program_environment_test {
namespace {

using test::ProgramResult;
using test::RunProgram;

constexpr const char* kTriangle = R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
 "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                "min": [-1, -1, 0], "max": [1, 1, 0]}],
 "bufferViews": [{"buffer": 0, "byteLength": 36}],
 "buffers": [{"byteLength": 36, "uri":
  "data:application/octet-stream;base64,AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgD8AAAAA"}]})";

// Each face is a PNG of one opaque white pixel.
TEST(ProgramRender, EnvironmentOfTheSceneIsUsedUnlessAnotherIsGiven) {
    const test::TemporaryFolder folder;
    std::string text = kTriangle;
    nlohmann::json scene = nlohmann::json::parse(text);
    image::WritePng(folder / "white.png", {1, 1, {255, 255, 255, 255}});
    scene["images"] = nlohmann::json::parse(R"([{"uri": "white.png"}])");
    scene["scenes"][0]["extensions"]["EXT_lights_image_based"]["light"] = 0;
    scene["extensions"]["EXT_lights_image_based"]["lights"] =
        nlohmann::json::parse(R"([{"intensity": 0.25, "specularImages": [[0, 0, 0, 0, 0, 0]]}])");
    std::ofstream(folder / "triangle.gltf") << scene;
    std::ofstream(folder / "plain.gltf") << kTriangle;
    const auto corner = [&](const std::string& options, const std::string& messages = "") {
        const ProgramResult result =
            RunProgram(folder, "render triangle.gltf --size 8x8 --spp 1 -o a.exr " + options);
        EXPECT_EQ(result.exitCode, 0) << result.messages;
        EXPECT_EQ(result.messages.find("nothing emits light") != std::string::npos, !messages.empty())
            << result.messages;
        EXPECT_EQ(result.messages.find("--light studio") != std::string::npos, !messages.empty())
            << result.messages;
        return session::ReadRenderFile(folder / "a.exr").radiance[0];
    };
    EXPECT_NEAR(corner(""), 0.25f, 1e-6f);
    EXPECT_NEAR(corner("--env-tint 4,4,4"), 1.0f, 1e-6f);
    EXPECT_EQ(corner("--background 2,2,2"), 2.0f);
    EXPECT_EQ(corner("--background 0,0,0", "nothing emits light"), 0.0f);
    image::WriteHdr(folder / "sky.hdr", {2, 1, std::vector<float>(8, 0.5f)});
    EXPECT_NEAR(corner("--env sky.hdr"), 0.5f, 0.01f);
    // The background is recorded, so that a resumed render has it, too
    EXPECT_EQ(corner("--background 0,0,0", "nothing emits light"), 0.0f);
    const ProgramResult resumed = RunProgram(folder, "render triangle.gltf --resume a.exr --spp 2 --quiet");
    EXPECT_EQ(resumed.exitCode, 0) << resumed.messages;
    EXPECT_EQ(session::ReadRenderFile(folder / "a.exr").radiance[0], 0.0f);
    const ProgramResult refused = RunProgram(folder, "render plain.gltf --light none --env-tint 1,1,1");
    EXPECT_EQ(refused.exitCode, 2);
    EXPECT_NE(refused.messages.find(
                  "--env-tint is of a map: it needs --env or --light studio; plain.gltf has none"),
              std::string::npos)
        << refused.messages;
}

TEST(ProgramRender, UnlitSurfacesAreNoDarkness) {
    const test::TemporaryFolder folder;
    nlohmann::json scene = nlohmann::json::parse(kTriangle);
    const auto messages = [&](const nlohmann::json& material) {
        scene["materials"] = nlohmann::json::array({material});
        scene["meshes"][0]["primitives"][0]["material"] = 0;
        std::ofstream(folder / "triangle.gltf") << scene;
        const ProgramResult result =
            RunProgram(folder, "render triangle.gltf --size 8x8 --spp 1 --background 0,0,0 -o a.exr");
        EXPECT_EQ(result.exitCode, 0) << result.messages;
        return result.messages;
    };
    const nlohmann::json unlit = {{"KHR_materials_unlit", nlohmann::json::object()}};
    EXPECT_EQ(messages({{"extensions", unlit}}).find("nothing emits light"), std::string::npos);
    const std::vector<float>& radiance = session::ReadRenderFile(folder / "a.exr").radiance;
    EXPECT_EQ(*std::ranges::max_element(radiance), 1.0f);
    // An unlit material shows its base color, not its emission
    EXPECT_NE(messages({{"extensions", unlit},
                        {"emissiveFactor", {1, 1, 1}},
                        {"pbrMetallicRoughness", {{"baseColorFactor", {0, 0, 0, 1}}}}})
                  .find("nothing emits light"),
              std::string::npos);
    EXPECT_NE(messages(nlohmann::json::object()).find("nothing emits light"), std::string::npos);
}

}  // namespace
}  // namespace raygraph::program_environment_test
