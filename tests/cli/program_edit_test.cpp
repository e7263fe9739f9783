// Tests the editor as the program runs it from a script. It needs a device.
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "renderer/image/image.h"
#include "renderer/scene/model/camera_view.h"
#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::program_edit_test {
namespace {

using test::RunProgram;
using test::SceneFile;

TEST(ProgramEdit, SavedExrIsTheRenderThatItsOwnSettingsDescribe) {
    const test::TemporaryFolder folder;
    std::ofstream(folder.Path() / "script.txt")
        << "budget 0\nsize 120x100\nopen " << SceneFile("cornell.gltf") << "\nwait\nsamples 3\npicture "
        << (folder.Path() / "edit.exr").string() << "\nexpect message sample\n";
    const test::ProgramResult edited = RunProgram(folder, "edit --validate --headless-script script.txt");
    RAYGRAPH_SKIP_WITHOUT_EDITOR(edited);
    ASSERT_EQ(edited.exitCode, 0) << edited.messages;
    const session::RenderFile saved = session::ReadRenderFile(folder / "edit.exr");
    EXPECT_EQ(saved.sceneFile, "cornell.gltf");
    for (const session::Aov aov : {session::Aov::Albedo, session::Aov::Normal, session::Aov::Depth,
                                   session::Aov::Instance, session::Aov::Material})
        EXPECT_TRUE(AovsOf(saved).Has(aov)) << Name(aov);

    std::string line =
        Text("render @cornell.gltf -o render.exr --spp {} --aov depth,instance", SampleCount(saved.samples));
    for (const char* setting : {"camera", "size", "background", "seed", "texture-lod"})
        line += Text(" --{} '{}'", setting, saved.settings.at(setting));
    const test::ProgramResult rendered = RunProgram(folder, line);
    ASSERT_EQ(rendered.exitCode, 0) << rendered.messages;
    const session::RenderFile plain = session::ReadRenderFile(folder / "render.exr");
    EXPECT_EQ(saved.settings, plain.settings);
    // The camera is written as decimals, so a few paths differ
    size_t unlike = 0;
    for (size_t i = 0; i < plain.radiance.size(); ++i)
        unlike +=
            std::abs(saved.radiance[i] - plain.radiance[i]) > 1e-3f * (1.0f + std::abs(plain.radiance[i]));
    EXPECT_LT(unlike, plain.radiance.size() / 100);
    size_t otherInstance = 0;
    for (size_t i = 0; i < plain.instance.size(); ++i)
        otherInstance += saved.instance[i] != plain.instance[i];
    EXPECT_LT(otherInstance, 4u);
}

TEST(ProgramEdit, SavedExrSaysHowAnOrthographicCameraSawATurnedSky) {
    const test::TemporaryFolder folder;
    nlohmann::json scene = nlohmann::json::parse(std::ifstream(SceneFile("cornell.gltf")));
    scene["cameras"][0] = {
        {"type", "orthographic"},
        {"orthographic", {{"xmag", 1.0}, {"ymag", 0.75}, {"znear", 0.01}, {"zfar", 100.0}}}};
    std::ofstream(folder / "flat.gltf") << scene;
    const image::ImageF sky{8, 4, std::vector<float>(8 * 4 * 4, 0.5f)};
    image::WriteHdr(folder.Path() / "sky.hdr", sky);
    std::ofstream(folder.Path() / "script.txt")
        << "size 120x100\nopen " << (folder / "flat.gltf").string() << "\nwait\nopen "
        << (folder / "sky.hdr").string() << "\nwait\nsamples 1\npicture " << (folder / "edit.exr").string()
        << "\n";
    const test::ProgramResult edited = RunProgram(folder, "edit --headless-script script.txt");
    RAYGRAPH_SKIP_WITHOUT_EDITOR(edited);
    ASSERT_EQ(edited.exitCode, 0) << edited.messages;
    const session::RenderFile saved = session::ReadRenderFile(folder / "edit.exr");
    EXPECT_EQ(saved.environmentFile, "sky.hdr");
    EXPECT_EQ(saved.settings.at("env-tint"), "1,1,1");
    EXPECT_TRUE(saved.settings.at("camera").ends_with("1.5m")) << saved.settings.at("camera");

    const test::ProgramResult rendered =
        RunProgram(folder, Text("render flat.gltf -o render.exr --spp 1 --aov depth,instance --env sky.hdr "
                                "--env-tint 0.5,1,2 --camera '{}' --size {}",
                                saved.settings.at("camera"), saved.settings.at("size")));
    ASSERT_EQ(rendered.exitCode, 0) << rendered.messages;
    const session::RenderFile plain = session::ReadRenderFile(folder / "render.exr");
    EXPECT_EQ(plain.settings.at("camera"), saved.settings.at("camera"));
    ASSERT_EQ(plain.instance[0], 0xFFFFFFFFu) << "the corner sees the sky";
    for (const size_t c : {0u, 1u, 2u}) {
        EXPECT_NEAR(saved.radiance[c], 0.5f, 1e-3f);
        EXPECT_NEAR(plain.radiance[c], 0.25f * float(1u << c), 1e-3f) << "tinted";
    }
    size_t otherInstance = 0;
    for (size_t i = 0; i < plain.instance.size(); ++i)
        otherInstance += saved.instance[i] != plain.instance[i];
    EXPECT_LT(otherInstance, 4u);

    const uint64_t total = SampleCount(saved.samples) + 2;
    const std::string resume = Text("render flat.gltf --resume edit.exr --spp {} -o more.exr", total);
    EXPECT_EQ(RunProgram(folder, resume).exitCode, 4) << "without the map";
    const test::ProgramResult resumed = RunProgram(folder, resume + " --env sky.hdr");
    ASSERT_EQ(resumed.exitCode, 0) << resumed.messages;
    EXPECT_NEAR(session::ReadRenderFile(folder / "more.exr").radiance[0], 0.5f, 1e-3f);
}

// Returns the fraction of texels that differ by more than their rounding.
double ShareUnlike(const std::vector<float>& a, const std::vector<float>& b) {
    EXPECT_EQ(a.size(), b.size());
    size_t unlike = 0;
    for (size_t i = 0; i < a.size(); ++i) unlike += std::abs(a[i] - b[i]) > 1e-3f * (1.0f + std::abs(b[i]));
    return static_cast<double>(unlike) / static_cast<double>(a.size());
}

TEST(ProgramEdit, SavedExrIsResumedByRender) {
    const test::TemporaryFolder folder;
    std::ofstream(folder.Path() / "script.txt")
        << "budget 0\nsize 120x100\nopen " << SceneFile("cornell.gltf") << "\nwait\nsamples 3\npicture "
        << (folder.Path() / "edit.exr").string() << "\nexpect message sample\n";
    const test::ProgramResult edited = RunProgram(folder, "edit --headless-script script.txt");
    RAYGRAPH_SKIP_WITHOUT_EDITOR(edited);
    ASSERT_EQ(edited.exitCode, 0) << edited.messages;
    const session::RenderFile saved = session::ReadRenderFile(folder / "edit.exr");
    const uint64_t before = SampleCount(saved.samples);

    const test::ProgramResult resumed = RunProgram(
        folder, Text("render @cornell.gltf --resume edit.exr --spp {} -o resumed.exr", before + 5));
    ASSERT_EQ(resumed.exitCode, 0) << resumed.messages;
    EXPECT_NE(resumed.output.find("5 of them new"), std::string::npos) << resumed.output;
    const session::RenderFile more = session::ReadRenderFile(folder / "resumed.exr");
    EXPECT_EQ(more.samples, (session::SampleRanges{{0, static_cast<uint32_t>(before + 5)}}));
    EXPECT_TRUE(HasSums(more)) << "it can be resumed again";

    const test::ProgramResult whole = RunProgram(
        folder, Text("render @cornell.gltf --camera '{}' --size {} --spp {} --aov albedo,normal -o whole.exr",
                     saved.settings.at("camera"), saved.settings.at("size"), before + 5));
    ASSERT_EQ(whole.exitCode, 0) << whole.messages;
    const session::RenderFile once = session::ReadRenderFile(folder / "whole.exr");
    // The camera is written as decimals, so a few paths of the first samples differ
    EXPECT_LT(ShareUnlike(more.radiance, once.radiance), 0.02);
    EXPECT_GT(ShareUnlike(saved.radiance, once.radiance), 0.2) << "there are samples to add";
    EXPECT_EQ(more.albedo, once.albedo) << "of all samples, not of the pixels' centers";
    EXPECT_EQ(more.sums.normal, once.sums.normal);
}

TEST(ProgramEdit, SavedExrOfAnEditedSceneIsNotResumed) {
    const test::TemporaryFolder folder;
    std::ofstream(folder.Path() / "script.txt")
        << "size 640x400\nopen " << SceneFile("cornell.gltf")
        << "\nwait\nview raster\nframes 3\nmouse 320 120\nclick left\nwait\nmaterial base 1 0 0\n"
        << "expect edits 1\nsize 120x100\nview path-traced\nsamples 1\npicture "
        << (folder.Path() / "edit.exr").string() << "\nexpect message sample\n";
    const test::ProgramResult edited = RunProgram(folder, "edit --headless-script script.txt");
    RAYGRAPH_SKIP_WITHOUT_EDITOR(edited);
    ASSERT_EQ(edited.exitCode, 0) << edited.messages;
    const test::ProgramResult resumed = RunProgram(folder, "render @cornell.gltf --resume edit.exr --spp 9");
    EXPECT_EQ(resumed.exitCode, 4);
    EXPECT_NE(resumed.messages.find("saved by the editor"), std::string::npos) << resumed.messages;
}

// A script runs with the options of a render.
TEST(ProgramEdit, OpensWithTheCameraEnvironmentAndViewThatAreAskedFor) {
    const test::TemporaryFolder folder;
    image::ImageF sky{8, 4, std::vector<float>(8 * 4 * 4, 1.0f)};
    for (size_t i = 0; i < 8 * 4; ++i) sky.rgba[4 * i] = 0.25f;  // less red
    image::WriteHdr(folder.Path() / "sky.hdr", sky);
    std::ofstream(folder / "script.txt")
        << "size 120x100\nwait\nexpect view raster\nview path-traced\nsamples 2\npicture "
        << (folder / "edit.exr").string() << "\nexpect message sample\n";
    const std::string options =
        "edit @furnace_sphere.gltf --env sky.hdr --view raster --camera '0.5 1 6 0 0 0 0 1 0 30' ";
    const test::ProgramResult edited = RunProgram(folder, options + "--headless-script script.txt");
    RAYGRAPH_SKIP_WITHOUT_EDITOR(edited);
    ASSERT_EQ(edited.exitCode, 0) << edited.messages;
    const session::RenderFile saved = session::ReadRenderFile(folder / "edit.exr");
    EXPECT_EQ(saved.environmentFile, "sky.hdr");
    const scene::CameraView seen = scene::ViewFromText(saved.settings.at("camera"), 1.0f);
    EXPECT_NEAR(glm::distance(seen.eye, glm::dvec3(0.5, 1.0, 6.0)), 0.0, 1e-5);
    EXPECT_NEAR(glm::degrees(seen.yFov), 30.0f, 1e-3f);
    // The upper left corner shows the sky
    EXPECT_NEAR(saved.radiance[0], 0.25f, 1e-3f);
    EXPECT_NEAR(saved.radiance[1], 1.0f, 1e-2f);
}

TEST(ProgramEdit, ACameraOfTheSceneIsTakenByNameAndByIndex) {
    const test::TemporaryFolder folder;
    nlohmann::json scene = nlohmann::json::parse(std::ifstream(SceneFile("cornell.gltf")));
    scene["cameras"].push_back(
        {{"type", "perspective"}, {"name", "door"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.01}}}});
    scene["nodes"].push_back({{"camera", 1}, {"translation", {0.0, 0.2, 0.9}}});
    scene["scenes"][0]["nodes"].push_back(scene["nodes"].size() - 1);
    std::ofstream(folder / "two.gltf") << scene;
    for (const auto& [choice, eye] : {std::pair{"door", 0.9}, std::pair{"1", 0.9}, std::pair{"0", 1.0796}}) {
        std::ofstream(folder / "script.txt")
            << "size 120x100\nwait\nsamples 1\npicture " << (folder / "edit.exr").string() << "\nwait\n";
        const test::ProgramResult edited =
            RunProgram(folder, Text("edit two.gltf --camera {} --headless-script script.txt", choice));
        RAYGRAPH_SKIP_WITHOUT_EDITOR(edited);
        ASSERT_EQ(edited.exitCode, 0) << edited.messages;
        const session::RenderFile saved = session::ReadRenderFile(folder / "edit.exr");
        EXPECT_NEAR(scene::ViewFromText(saved.settings.at("camera"), 1.0f).eye.z, eye, 1e-4) << choice;
    }
    std::ofstream(folder / "script.txt") << "wait\nexpect message there is no camera \"window\"\n";
    const test::ProgramResult none =
        RunProgram(folder, "edit two.gltf --camera window --headless-script script.txt");
    EXPECT_EQ(none.exitCode, 0) << none.messages
                                << "the status line says it, as of what else cannot be loaded";
}

TEST(ProgramEdit, EveryViewCanBeTheFirst) {
    const test::TemporaryFolder folder;
    std::ofstream(folder / "script.txt")
        << "size 120x100\nwait\nframes 2\npicture " << (folder / "a.png").string() << "\nwait\n";
    std::map<std::string, std::string> pictures;
    for (const char* view : {"raster", "wipe", "side-by-side", "albedo", "normals", "depth", "overdraw"}) {
        const test::ProgramResult edited =
            RunProgram(folder, Text("edit @cornell.gltf --view {} --headless-script script.txt", view));
        RAYGRAPH_SKIP_WITHOUT_EDITOR(edited);
        ASSERT_EQ(edited.exitCode, 0) << edited.messages;
        std::ifstream file(folder / "a.png", std::ios::binary);
        const auto [at, isNew] =
            pictures.emplace(std::string(std::istreambuf_iterator<char>(file), {}), view);
        EXPECT_TRUE(isNew) << view << " looks like " << at->second;
    }
}

TEST(ProgramEdit, RefusesWhatItCannotBeginWith) {
    const test::TemporaryFolder folder;
    const auto expect = [&](const std::string& line, int exitCode, const std::string& text) {
        const test::ProgramResult result = RunProgram(folder, line + " --headless-script none.txt");
        EXPECT_EQ(result.exitCode, exitCode) << result.messages;
        EXPECT_NE(result.messages.find(text), std::string::npos) << result.messages;
    };
    expect("edit --camera 0", 2, "--camera looks at a scene: it needs a FILE");
    expect("edit @cornell.gltf --camera '0 0 0 0 0 0 0 1 0 40'", 2, "--camera");
    expect("edit @cornell.gltf --view cubist", 2, "side-by-side, difference, relative-error, flip");
    const test::ProgramResult edited = RunProgram(folder, "edit --env sky.png --headless-script none.txt");
    RAYGRAPH_SKIP_WITHOUT_EDITOR(edited);
    expect("edit --env sky.png", 4, "sky.png: an environment map ends in .hdr or .exr");
}

}  // namespace
}  // namespace raygraph::program_edit_test
