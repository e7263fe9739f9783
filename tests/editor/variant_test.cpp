// Tests variants of a scene's materials in the editor.
#include <fstream>
#include <nlohmann/json.hpp>

#include "editor/session/file/content_hash.h"
#include "editor/session/session.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/model/variants.h"
#include "tests/editor/editor_test.h"
#include "tests/support/error_of.h"

namespace raygraph::editor::variant_test {

using VariantTest = EditorTest;

// In the Cornell box, the variant "paint" gives all meshes but the lamp one material.
TEST_F(VariantTest, IsShownInAllViewsAndIsNoEdit) {
    nlohmann::json json = nlohmann::json::parse(std::ifstream(test::SourceFile("scenes/cornell.gltf")));
    json["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "paint"}}, {{"name", "plain"}}};
    for (nlohmann::json& mesh : json["meshes"])
        for (nlohmann::json& primitive : mesh["primitives"])
            if (primitive["material"] != 3)
                primitive["extensions"]["KHR_materials_variants"]["mappings"] = {
                    {{"material", 0}, {"variants", {0}}}};
    const std::filesystem::path file = folder.Path() / "box.gltf", picture = folder.Path() / "picture.exr",
                                saved = folder.Path() / "saved.gltf";
    std::ofstream(file) << json;
    Workspace& work = editor.Work();
    const auto save = [&](const std::string& script) {
        Play("size 120x100\n" + script + "picture " + picture.string() + "\nexpect message sample\n");
        return session::ReadRenderFile(picture);
    };
    const auto hashOf = [](const std::filesystem::path& of, uint32_t variant) {
        scene::SceneData scene = scene::LoadGltf(of);
        scene::SetVariant(scene, variant);
        return session::HashOf(scene);
    };
    for (const std::string view : {"path-traced", "raster"}) {
        SCOPED_TRACE(view);
        Play("size 120x100\nbudget 0\nopen " + file.string() + "\nwait\nview " + view +
             "\nexpect variant none\n");
        const session::RenderFile plain = save("samples 1\n");
        const auto resets = [&] { return work.view.ResetCount(passes::ResetCause::Geometry); };
        const uint32_t before = resets();
        const session::RenderFile paint = save("variant paint\nexpect variant paint\nsamples 1\n");
        EXPECT_GT(resets(), before) << "samples of the other materials are gone";
        EXPECT_NE(paint.radiance, plain.radiance);
        EXPECT_EQ(paint.settings.at("variant"), "paint");
        EXPECT_EQ(paint.sceneHash, hashOf(file, 0));
        EXPECT_EQ(plain.settings.at("variant"), "");
        EXPECT_EQ(plain.sceneHash, hashOf(file, scene::kNone));
    }
    EXPECT_EQ(save("variant 1\nexpect variant plain\nsamples 1\n").sceneHash, hashOf(file, scene::kNone));
    Play("size 120x100\nvariant none\nexpect variant none\n");
    EXPECT_NE(std::string(testing::ErrorOf([&] { Play("variant red\n"); }).what())
                  .find("there is no variant \"red\""),
              std::string::npos);
    EXPECT_EQ(work.document.EditCount(), 0u);
    // Edits apply to the active materials, and saving keeps the variants
    Play("size 120x100\nvariant paint\nmouse 60 40\nclick left\nwait\n");
    ASSERT_EQ(work.selectedMaterial, 0u);
    Play("size 120x100\nmaterial base 0.25 0.5 1\nscene " + saved.string() +
         "\nexpect variant paint\nexpect edits 1\n");
    scene::SceneData scene = scene::LoadGltf(saved);
    EXPECT_EQ(scene.variants, (std::vector<std::string>{"paint", "plain"}));
    EXPECT_EQ(scene.materials[0].baseColorFactor, glm::vec4(0.25f, 0.5f, 1.0f, 1.0f));
    EXPECT_EQ(scene.meshes[0].primitives[1].material, 2u);
    EXPECT_EQ(save("samples 1\n").sceneHash, hashOf(saved, 0));
}

}  // namespace raygraph::editor::variant_test
