// Tests that images of the open scene are exchanged, shown as thumbnails, and saved.
#include <gtest/gtest.h>
#include <array>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "base/files.h"
#include "renderer/image/image.h"
#include "renderer/scene/gltf/container.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/gltf/save_gltf.h"
#include "tests/editor/editor_test.h"
#include "tests/scene/gltf_document.h"

namespace raygraph::editor::images_test {

namespace {

constexpr std::array<uint8_t, 4> kOld{255, 0, 0, 255}, kNew{0, 0, 255, 255};

class ImagesTest : public EditorTest {
  protected:
    void Write(const std::filesystem::path& name, std::span<const std::byte> bytes) {
        std::filesystem::create_directories((folder.Path() / name).parent_path());
        AtomicFile file(folder.Path() / name);
        file.Write(bytes);
        file.Commit();
    }
    // Returns a triangle whose texture has this image, an element of "images".
    static test::GltfDocument Textured(const test::Json& image) {
        test::GltfDocument document;
        test::Json& triangle = document.AddTriangle();
        document.Add("images", image);
        document.Add("textures", {{"source", 0}});
        triangle["material"] =
            document.AddMaterial({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
        return document;
    }
    // Exchanges the image by the dialog. The new one is in another folder.
    void Exchange() {
        editor.Work().imageToReplace = 0;
        Play("size 320x200\nframes 2\nkey ctrl+a\ntext " + (folder.Path() / "elsewhere/new.png").string() +
             "\nframes 1\nkey enter\nframes 2\nexpect message the image is new.png now\nexpect edits 1\n");
    }
    static std::string Place(const std::filesystem::path& saved) {
        const test::Json json = test::Json::parse(scene::ReadGltfJson(saved));
        const test::Json& image = json["images"][0];
        return image.contains("uri") ? image["uri"].get<std::string>().substr(0, 22) : "a view";
    }
};

}  // namespace

TEST_F(ImagesTest, AreExchangedAndSavedWhereTheyWereAndUndoGivesTheFileBack) {
    const test::Bytes old = test::MakePng(1, 1, kOld);
    Write("elsewhere/new.png", test::MakePng(3, 2, kNew));
    Write("scene/old.png", old);
    Write("scene/new.png", old);  // of the same name, and not to be replaced
    Write("scene/data.gltf", test::ToBytes(Textured({{"uri", test::DataUri(old)}}).Text()));
    Write("scene/file.gltf", test::ToBytes(Textured({{"uri", "old.png"}}).Text()));
    test::GltfDocument embedded = Textured({{"mimeType", "image/png"}, {"bufferView", 0}});
    embedded.json["buffers"].insert(embedded.json["buffers"].begin(),
                                    test::Json({{"byteLength", old.size()}}));
    for (test::Json& view : embedded.json["bufferViews"]) view["buffer"] = view["buffer"].get<int>() + 1;
    embedded.json["bufferViews"].push_back({{"buffer", 0}, {"byteLength", old.size()}});
    embedded.json["images"][0]["bufferView"] = embedded.json["bufferViews"].size() - 1;
    Write("scene/embedded.glb", test::MakeGlb(embedded.Text(), &old));
    // Bytes that another view has as well cannot be dropped
    test::GltfDocument shared = embedded;
    shared.json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", 4}, {"byteLength", 8}});
    Write("scene/shared.glb", test::MakeGlb(shared.Text(), &old));
    struct Row {
        const char *file, *place;
    };
    for (const Row& row : {Row{"data.gltf", "data:image/png;base64,"}, Row{"file.gltf", "new-2.png"},
                           Row{"embedded.glb", "a view"}, Row{"shared.glb", "a view"}}) {
        SCOPED_TRACE(row.file);
        const auto saved = [&](const char* name) {
            const std::filesystem::path to = folder.Path() / "scene" / (name + std::string(row.file));
            Play("size 320x200\nscene " + to.string() + "\n");
            return to;
        };
        Play("size 320x200\nview raster\nopen " + (folder.Path() / "scene" / row.file).string() + "\nwait\n");
        const std::filesystem::path before = saved("before-");
        Exchange();
        const std::filesystem::path after = saved("after-");
        const scene::ImageData image = scene::LoadGltf(after).images.at(0);
        EXPECT_EQ(image.width, 3u);
        EXPECT_EQ((std::array{image.rgba[0], image.rgba[1], image.rgba[2], image.rgba[3]}), kNew);
        EXPECT_EQ(Place(after), row.place);
        const std::vector<std::byte> bytes = ReadFile(after);
        const bool hasOld = !std::ranges::search(bytes, old).empty();
        EXPECT_EQ(hasOld, row.file == std::string("shared.glb"));
        EXPECT_EQ(image.name, row.file == std::string("file.gltf") ? "new-2.png" : "new");
        EXPECT_EQ(ReadFile(saved("again-")), bytes);
        Play("size 320x200\nkey ctrl+z\nexpect edits 0\n");
        EXPECT_EQ(ReadFile(saved("undone-")), ReadFile(before));
    }
    EXPECT_EQ(ReadFile(folder.Path() / "scene/new.png"), old);
}

// The image comes first in the chunk, so that all else moves.
TEST_F(ImagesTest, OfAGlbLeaveItsOtherViewsAsTheyWere) {
    const test::Bytes old = test::MakePng(9, 7, kOld);
    Write("elsewhere/new.png", test::MakePng(3, 2, kNew));
    test::GltfDocument document = Textured({{"mimeType", "image/png"}, {"bufferView", 0}});
    test::Bytes binary = old;
    test::Json& views = document.json["bufferViews"];
    for (size_t i = 0; i < views.size(); ++i) {
        const std::string uri = document.json["buffers"][i]["uri"];
        const test::Bytes bytes = scene::DecodeDataUri(uri, 1000);
        binary.resize((binary.size() + 3) / 4 * 4);
        views[i]["buffer"] = 0;
        views[i]["byteOffset"] = binary.size();
        binary.insert(binary.end(), bytes.begin(), bytes.end());
    }
    document.json["images"][0]["bufferView"] = views.size();
    views.push_back({{"buffer", 0}, {"byteLength", old.size()}});
    document.json["buffers"] = test::Json::array({{{"byteLength", binary.size()}}});
    Write("scene.glb", test::MakeGlb(document.Text(), &binary));
    const scene::SceneData before = scene::LoadGltf(folder / "scene.glb");
    Play("size 320x200\nview raster\nopen " + (folder / "scene.glb").string() + "\nwait\n");
    Exchange();
    Play("size 320x200\nkey ctrl+s\nframes 2\nexpect edits 1\n");
    const scene::SceneData after = scene::LoadGltf(folder / "scene.glb");
    EXPECT_EQ(after.images.at(0).width, 3u);
    EXPECT_EQ(after.meshes.at(0).primitives.at(0).positions, before.meshes.at(0).primitives.at(0).positions);
    // The file has lost the old image, the history has not
    Play("size 320x200\nkey ctrl+z\nkey ctrl+s\nframes 2\n");
    EXPECT_EQ(ReadFile(folder / "scene.glb"), test::MakeGlb(document.Text(), &binary));
}

TEST_F(ImagesTest, AreOfTheSceneForWhichTheDialogAsked) {
    Write("elsewhere/new.png", test::MakePng(3, 2, kNew));
    for (const char* name : {"scene/a.gltf", "scene/b.gltf"})
        Write(name, test::ToBytes(Textured({{"uri", test::DataUri(test::MakePng(1, 1, kOld))}}).Text()));
    Play("size 320x200\nview raster\nopen " + (folder / "scene/a.gltf").string() + "\nwait\n");
    editor.Work().imageToReplace = 0;
    Play("size 320x200\nframes 2\nopen " + (folder / "scene/b.gltf").string() + "\nwait\nkey ctrl+a\ntext " +
         (folder / "elsewhere/new.png").string() +
         "\nframes 1\nkey enter\nframes 2\nexpect message its scene has been closed\nexpect edits 0\n");
}

TEST_F(ImagesTest, OfTheEnvironmentStayWhereATextureIsExchanged) {
    test::GltfDocument document = Textured({{"uri", test::DataUri(test::MakePng(1, 1, kOld))}});
    document.json["extensionsUsed"] = {"EXT_lights_image_based"};
    document.json["extensions"]["EXT_lights_image_based"]["lights"] =
        test::Json::array({{{"irradianceCoefficients", test::Json(9, test::Json{0.5, 0.25, 0})},
                            {"specularImageSize", 1},
                            {"specularImages", test::Json::array({test::Json(6, 0)})}}});
    document.json["scenes"][0]["extensions"]["EXT_lights_image_based"]["light"] = 0;
    Write("elsewhere/new.png", test::MakePng(3, 3, kNew));
    Write("scene.gltf", test::ToBytes(document.Text()));
    const std::filesystem::path saved = folder / "saved.gltf";
    Play("size 320x200\nview raster\nopen " + (folder / "scene.gltf").string() + "\nwait\n");
    Exchange();
    Play("size 320x200\nscene " + saved.string() + "\n");
    const scene::SceneData before = scene::LoadGltf(folder / "scene.gltf"), after = scene::LoadGltf(saved);
    EXPECT_EQ(after.images.at(after.textures.at(0).image).width, 3u);
    EXPECT_TRUE(after.environment.map.rgba == before.environment.map.rgba);
    EXPECT_FALSE(before.environment.map.rgba.empty());
}

TEST_F(ImagesTest, AreShownAtOnceAndABadFileChangesNothing) {
    Write("elsewhere/new.png", test::MakePng(3, 2, kNew));
    Write("broken.png", test::ToBytes("\x89PNG and no more"));
    Play("size 640x700\nview raster\nopen " + test::SourceFile("scenes/checker_floor.gltf").string() +
         "\nwait\nselect floor\nframes 4\n");
    Workspace& work = editor.Work();
    work.gpu.SetEnvironment({.radiance = glm::vec3(1.0f)});
    const auto picture = [&](const char* name) {
        Play("size 640x700\nsamples 1\npicture " + (folder.Path() / name).string() + "\n");
        return ReadFile(folder.Path() / name);
    };
    // Returns the number of blue pixels in the panels at the right.
    const auto blue = [&] {
        const std::filesystem::path file = folder.Path() / "window.png";
        Play("size 640x700\nframes 4\nwindow " + file.string() + "\n");
        const image::Image8 window = image::DecodeImage8(ReadFile(file), "window");
        size_t count = 0;
        for (size_t i = 0; i < window.rgba.size(); i += 4)
            count += i / 4 % window.width > 480 && window.rgba[i] < 40 && window.rgba[i + 2] > 200;
        return count;
    };
    const std::vector<std::byte> before = picture("before.png");
    EXPECT_TRUE(work.thumbnails.Show(work.document, 0)) << "it was made";
    EXPECT_EQ(work.renderer.DescribePlan().find("Thumbnail"), std::string::npos) << "and is kept";
    EXPECT_EQ(blue(), 0u);
    EXPECT_NE(work.ReplaceImage(0, folder.Path() / "broken.png").find("broken.png"), std::string::npos);
    EXPECT_NE(work.ReplaceImage(0, folder.Path() / "none.png"), "");
    EXPECT_EQ(work.document.EditCount(), 0u);
    EXPECT_EQ(picture("refused.png"), before);
    EXPECT_EQ(work.ReplaceImage(0, folder.Path() / "elsewhere/new.png"), "");
    EXPECT_NE(picture("after.png"), before);
    EXPECT_GT(blue(), 500u);
    EXPECT_EQ(work.document.ImageOf(0).width, 3u);
    Play("size 640x700\nkey ctrl+z\nexpect edits 0\n");
    EXPECT_EQ(picture("undone.png"), before);
    EXPECT_EQ(blue(), 0u);
    Play("size 640x700\nkey ctrl+y\n");
    EXPECT_GT(blue(), 500u);
}

}  // namespace raygraph::editor::images_test
