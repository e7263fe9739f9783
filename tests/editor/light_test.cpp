// Tests of the light in which the editor shows the open scene.
#include "editor/session/file/render_file.h"
#include "renderer/image/image.h"
#include "tests/editor/editor_test.h"

namespace raygraph::editor::light_test {

namespace {

class LightTest : public EditorTest {
  protected:
    static std::string Open(const char* name) {
        return "size 320x200\nopen " + test::SourceFile(std::string("scenes/") + name).string() + "\nwait\n";
    }
    bool HasStudio() { return editor.Work().gpu.ShownEnvironment().defaultLight == DefaultLight::Studio; }
    std::string LightOfSaved() {
        const std::string file = (folder.Path() / "saved.exr").string();
        Play("view raster\nsamples 1\npicture " + file + "\nexpect message sample\n");
        return session::ReadRenderFile(file).settings.at("light");
    }
};

}  // namespace

TEST_F(LightTest, ASceneWithoutLightIsShownInTheStudioAndSavedSo) {
    Play(Open("furnace_sphere.gltf"));
    EXPECT_TRUE(HasStudio());
    EXPECT_EQ(LightOfSaved(), "studio");
    Play(Open("cornell.gltf"));
    EXPECT_FALSE(HasStudio());
    EXPECT_EQ(LightOfSaved(), "none");
}

TEST_F(LightTest, TheStudioIsTurnedOnAndOffForScenesToCome) {
    editor.Work().UseLight(DefaultLight::None);
    Play(Open("furnace_sphere.gltf"));
    EXPECT_FALSE(HasStudio());
    editor.Work().UseLight(DefaultLight::Studio);
    EXPECT_TRUE(HasStudio());
    Play(Open("cornell.gltf"));
    EXPECT_TRUE(HasStudio()) << "it is asked for";
}

TEST_F(LightTest, AllThreeChoicesAreThereInWhateverOrder) {
    EXPECT_EQ(editor.Work().Light(), DefaultLight::Auto);
    for (const DefaultLight before : {DefaultLight::None, DefaultLight::Studio}) {
        editor.Work().UseLight(before);
        Play(Open("furnace_sphere.gltf"));
        editor.Work().UseLight(DefaultLight::Auto);
        EXPECT_EQ(editor.Work().Light(), DefaultLight::Auto);
        EXPECT_TRUE(HasStudio());
        Play(Open("cornell.gltf"));
        EXPECT_FALSE(HasStudio()) << "the scene has a lamp";
    }
}

TEST_F(LightTest, AMapTakesItsPlaceUntilItIsRemoved) {
    Play(Open("furnace_sphere.gltf"));
    image::WriteHdr(folder.Path() / "sky.hdr", {2, 1, std::vector<float>(8, 0.5f)});
    Play("size 320x200\nopen " + (folder.Path() / "sky.hdr").string() + "\nwait\n");
    EXPECT_FALSE(HasStudio());
    editor.Work().RemoveEnvironmentMap();
    EXPECT_TRUE(HasStudio());
}

}  // namespace raygraph::editor::light_test
