// Tests a flawed file of each extension as a user meets it: one line, and exit code 4.
#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "renderer/image/image.h"
#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::program_hostile_test {
namespace {

using Json = nlohmann::json;

// Makes a triangle with a material, a texture and an image, to which all extensions apply.
Json Scene() {
    return Json::parse(R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "extensions": {}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0, "extensions": {}}]}],
        "materials": [{"emissiveTexture": {"index": 0, "extensions": {}}, "extensions": {}}],
        "textures": [{"source": 0, "extensions": {}}],
        "images": [{"uri": "data:,%89PNG"}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3}],
        "bufferViews": [{"buffer": 0, "byteLength": 36, "extensions": {}}],
        "buffers": [{"byteLength": 36, "uri": "data:,)" +
                       std::string(36, '0') + R"("}], "extensions": {}})");
}

struct Row {
    const char* where;  // JSON pointer of the flaw
    const char* value;
    const char* message;  // follows "bad.gltf: "
};

const Row kRows[] = {
    {"/materials/0/extensions/KHR_materials_sheen", R"({"sheenColorFactor": [1, 1]})",
     "materials[0].extensions.KHR_materials_sheen.sheenColorFactor: has 2 elements, must have 3"},
    {"/materials/0/extensions/KHR_materials_dispersion", R"({"dispersion": "strong"})",
     "materials[0].extensions.KHR_materials_dispersion.dispersion: is \"strong\", must be a number"},
    {"/materials/0/extensions/KHR_materials_volume_scatter", R"({"multiscatterColorFactor": 1})",
     "materials[0].extensions.KHR_materials_volume_scatter.multiscatterColorFactor: is 1, must be an array"},
    {"/materials/0/extensions/KHR_materials_diffuse_transmission",
     R"({"diffuseTransmissionTexture": {"index": 7}})",
     "materials[0].extensions.KHR_materials_diffuse_transmission.diffuseTransmissionTexture.index: is 7, but "
     "there is 1 texture"},
    {"/materials/0/extensions/KHR_materials_iridescence", R"({"iridescenceTexture": {}})",
     "materials[0].extensions.KHR_materials_iridescence.iridescenceTexture.index: is absent, must be a whole "
     "number of at least 0"},
    {"/materials/0/extensions/KHR_materials_anisotropy", "[]",
     "materials[0].extensions.KHR_materials_anisotropy: is an array, must be an object"},
    {"/materials/0/extensions/KHR_materials_clearcoat",
     R"({"clearcoatNormalTexture": {"index": 0, "scale": []}})",
     "materials[0].extensions.KHR_materials_clearcoat.clearcoatNormalTexture.scale: is an array, must be a "
     "number"},
    {"/materials/0/extensions/KHR_materials_pbrSpecularGlossiness", R"({"diffuseFactor": [1, 1, 1]})",
     "materials[0].extensions.KHR_materials_pbrSpecularGlossiness.diffuseFactor: has 3 elements, must have "
     "4"},
    {"/materials/0/emissiveTexture/extensions/KHR_texture_transform", R"({"offset": 3})",
     "materials[0].emissiveTexture.extensions.KHR_texture_transform.offset: is 3, must be an array"},
    {"/extensions/KHR_materials_variants", R"({"variants": {}})",
     "extensions.KHR_materials_variants.variants: is an object, must be an array"},
    {"/meshes/0/primitives/0/extensions/KHR_materials_variants",
     R"({"mappings": [{"variants": [0], "material": 0}]})",
     "meshes[0].primitives[0].extensions.KHR_materials_variants.mappings[0].variants[0]: is 0, but there are "
     "0 "
     "variants"},
    {"/nodes/0/extensions/KHR_node_visibility", R"({"visible": 0})",
     "nodes[0].extensions.KHR_node_visibility.visible: is 0, must be true or false"},
    {"/nodes/0/extensions/EXT_mesh_gpu_instancing", R"({"attributes": {"ROTATION": 0}})",
     "nodes[0].extensions.EXT_mesh_gpu_instancing.attributes.ROTATION: "},
    {"/bufferViews/0/extensions/EXT_meshopt_compression",
     R"({"buffer": 0, "byteLength": 36, "byteStride": 12, "count": 3, "mode": "ATTRIBUTES"})",
     "bufferViews[0].extensions.EXT_meshopt_compression: 36 bytes are no ATTRIBUTES of 3 elements of 12 "
     "bytes"},
    {"/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression",
     R"({"bufferView": 0, "attributes": {"POSITION": 0}})",
     "meshes[0].primitives[0].extensions.KHR_draco_mesh_compression: its bytes are not those of Draco"},
    {"/accessors/0/componentType", "5125",  // KHR_mesh_quantization has at most 16 bits
     "meshes[0].primitives[0].attributes.POSITION: accessors[0] must be VEC3 of float, byte or short"},
    {"/images/0/uri", R"("data:,RIFF%10%00%00%00WEBPVP8L")", "images[0]: "},
    {"/images/0/uri", R"("data:,DDS %7C%00%00%00")", "images[0]: "},
    {"/images/0/uri", R"("data:,%ABKTX 20%BB%0D%0A%1A%0A%00%00%00%00")", "images[0]: "},
    {"/images/0/uri", R"("data:,%FF%D8%FF%E0%00%10")", "images[0]: "},
};

TEST(ProgramHostileFiles, EachIsRefusedWithOneLine) {
    const test::TemporaryFolder folder;
    for (const Row& row : kRows) {
        Json scene = Scene();
        scene[Json::json_pointer(row.where)] = Json::parse(row.value);
        std::ofstream(folder / "bad.gltf") << scene;
        const test::ProgramResult result = test::RunProgram(folder, "info bad.gltf");
        EXPECT_EQ(result.exitCode, 4) << row.where;
        EXPECT_EQ(result.output, "") << row.where;
        const std::string start = "raygraph: ";
        EXPECT_TRUE(result.messages.starts_with(start)) << result.messages;
        EXPECT_EQ(result.messages.find('\n') + 1, result.messages.size()) << result.messages;
        EXPECT_NE(result.messages.find(std::string("bad.gltf: ") + row.message), std::string::npos)
            << row.where << ": " << result.messages << "  lacks " << row.message;
    }
}

// Every command that loads a scene takes --root, a further folder that it may read from.
TEST(ProgramHostileFiles, RootAllowsFilesBelowAnotherFolder) {
    const test::TemporaryFolder folder;
    std::filesystem::create_directories(folder / "scenes");
    std::filesystem::create_directories(folder / "textures");
    image::WritePng(folder / "textures/w.png", {1, 1, {255, 255, 255, 255}});
    Json scene = Scene();
    scene["images"][0]["uri"] = "../textures/w.png";
    std::ofstream(folder / "scenes/a.gltf") << scene;
    const char* const commands[] = {
        "info scenes/a.gltf",
        "graph scenes/a.gltf --size 8x8",
        "render scenes/a.gltf --size 8x8 --spp 1 --background 1,1,1 -o a.exr",
        "bench scenes/a.gltf --size 8x8 --frames 1 --rounds 1 --max-depth 2",
    };
    for (const char* command : commands) {
        const test::ProgramResult refused = test::RunProgram(folder, command);
        EXPECT_EQ(refused.exitCode, 4) << command;
        EXPECT_EQ(refused.messages,
                  "raygraph: a.gltf: images[0].uri: \"../textures/w.png\": leads out of the "
                  "scene's folder; --root FOLDER allows what is below another folder\n");
        const test::ProgramResult read = test::RunProgram(folder, std::string(command) + " --root .");
        EXPECT_EQ(read.exitCode, 0) << command << ": " << read.messages;
    }
    // The editor stays open and reports it.
    std::ofstream(folder / "script") << "wait\n";
    const std::string edit = "edit scenes/a.gltf --headless-script script";
    const test::ProgramResult refused = test::RunProgram(folder, edit);
    RAYGRAPH_SKIP_WITHOUT_EDITOR(refused);
    EXPECT_NE(refused.messages.find("leads out of the scene's folder"), std::string::npos)
        << refused.messages;
    const test::ProgramResult read = test::RunProgram(folder, edit + " --root .");
    EXPECT_EQ(read.exitCode, 0);
    EXPECT_EQ(read.messages, "");
}

TEST(ProgramHostileFiles, RootThatIsNoFolderIsNamed) {
    const test::TemporaryFolder folder;
    std::ofstream(folder / "a.gltf") << Scene();
    for (const char* command :
         {"info a.gltf", "graph a.gltf", "render a.gltf", "bench a.gltf", "edit a.gltf", "edit"}) {
        const test::ProgramResult gone = test::RunProgram(folder, std::string(command) + " --root gone");
        RAYGRAPH_SKIP_WITHOUT_EDITOR(gone);
        EXPECT_EQ(gone.exitCode, 4) << command;
        EXPECT_EQ(gone.messages, "raygraph: --root: \"gone\": No such file or directory\n") << command;
        const test::ProgramResult file = test::RunProgram(folder, std::string(command) + " --root a.gltf");
        EXPECT_EQ(file.exitCode, 4) << command;
        EXPECT_EQ(file.messages, "raygraph: --root: \"a.gltf\": it is not a folder\n") << command;
    }
    EXPECT_EQ(test::RunProgram(folder, "info --devices --root .").messages,
              "raygraph: --root is of a scene file, and --devices lists none\n");
}

TEST(ProgramHostileFiles, NamesDoNotActOnTheTerminal) {
    const char* const lines[] = {
        "render \x1b[2J.gltf -o a.png",
        "render @cornell.gltf --spp 1 --size 8x8 --env \x1b[2J.hdr -o a.png",
        "render @cornell.gltf --spp 1 --size 8x8 --root \x1b[2J -o a.png",
        "render @cornell.gltf --spp 1 --size 8x8 --settings-from \x1b[2J.exr -o a.png",
        "render @cornell.gltf --spp 2 --size 8x8 --resume \x1b[2J.exr -o a.exr",
        "render @cornell.gltf --spp 1 --size 8x8 -o \x1b[2J/a.png",
        "info \x1b[2J.glb",
        "merge \x1b[2J.exr b.exr -o c.exr",
        "bench --compare \x1b[2J b",
    };
    for (const char* line : lines) {
        const test::ProgramResult result = test::RunProgram(test::TemporaryFolder(), line);
        EXPECT_NE(result.exitCode, 0) << line;
        EXPECT_EQ(result.messages.find('\x1b'), std::string::npos) << line;
        EXPECT_NE(result.messages.find("?[2J"), std::string::npos) << result.messages;
        EXPECT_EQ(std::ranges::count(result.messages, '\n'), 1) << result.messages;
    }
}

}  // namespace
}  // namespace raygraph::program_hostile_test
