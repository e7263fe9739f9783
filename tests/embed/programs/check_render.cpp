// check_render SCENE PICTURE: checks that the picture is what examples/4_offline_render.cpp renders, and that sessions
// of a host can resume it. Exits with 1 and one line if not.
#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

#include "editor/session/file/content_hash.h"
#include "editor/session/file/merge.h"
#include "editor/session/session.h"
#include "renderer/scene/gltf/load_gltf.h"

using namespace raygraph;  // NOLINT: an example
using session::Aov;

namespace {

constexpr uint32_t kSamples = 8, kLater = 12;

void Require(bool holds, const char* what) {
    if (!holds) throw std::runtime_error(std::string("not so: ") + what);
}

template <typename Call>
bool IsRefused(Call&& call, ErrorKind kind) {
    try {
        call();
    } catch (const Error& error) {
        return error.Kind() == kind;
    }
    return false;
}

void CheckFile(const session::RenderFile& render) {
    Require(render.size == Extent2D{64, 48}, "the picture has the size that was asked for");
    Require(render.samples == session::SampleRanges{{0, kSamples}}, "it has the samples that were asked for");
    Require(AovsOf(render) == session::AovSet{Aov::Albedo, Aov::Normal, Aov::Depth},
            "it has the channels that were asked for");
    Require(HasSums(render) && !render.variance.empty(), "it can be resumed");
    const auto isLit = [](float value) { return value > 0.0f; };
    Require(std::ranges::any_of(render.radiance, isLit), "there is light in it");
    Require(std::ranges::any_of(render.albedo, isLit), "there are surfaces in it");
    Require(render.depth.size() == session::PixelCount(render.size), "each pixel has a depth");
}

// Returns the render as a file stores it, where albedo and normals have three channels.
session::RenderFile Reread(const session::RenderFile& render) {
    session::WriteRenderFile("reread.exr", render);
    return session::ReadRenderFile("reread.exr");
}

// Requires that a resumed, a divided and a merged render have the bits of one run.
void GoOn(rhi::Device& device, const char* scene, const char* picture) {
    const session::ResumedRender before = session::ReadResumedRender(picture);
    session::Session resumed(device, session::LoadInput(scene), Resuming(before));
    uint32_t calls = 0;
    resumed.Run({.samples = kLater - 1}, [&](const session::ProgressState& state) {
        ++calls;
        Require(state.samplesWanted == kLater - 1, "progress is told of the rule");
    });
    Require(calls == kLater - 1 - kSamples, "progress is called for each sample");
    resumed.Run({.samples = kLater});
    const session::RenderFile render = resumed.Result().render;
    const session::SettingTexts& settings = before.render.settings;

    session::Session whole(device, session::LoadInput(scene),
                           {.settings = session::SettingsFrom(settings), .aovs = AovsOf(before.render)});
    whole.Run({.samples = kLater});
    const session::SessionResult once = whole.Result();
    Require(render.radiance == once.render.radiance, "a resumed render has the light of one run");
    Require(render.variance == once.render.variance, "a resumed render has the variance of one run");
    const session::RenderFile inFile = Reread(render), onceInFile = Reread(once.render);
    Require(inFile.albedo == onceInFile.albedo && inFile.sums.normal == onceInFile.sums.normal,
            "a resumed render has the surfaces of one run");
    Require(once.statistics.relativeError.has_value(), "the noise is estimated");
    Require(whole.Display().rgba.size() == 4 * session::PixelCount(render.size), "it can be displayed");

    session::Session rest(device, session::LoadInput(scene),
                          {.settings = session::SettingsFrom(settings),
                           .aovs = AovsOf(before.render),
                           .firstSample = kSamples});
    bool isEnough = false;
    const session::RunSummary run =
        rest.Run({.seconds = 1e6, .isStopRequested = [&] { return isEnough; }},
                 [&](const session::ProgressState&) { isEnough = rest.SampleCount() == kLater - kSamples; });
    Require(run.wasStopped && rest.SampleCount() == kLater - kSamples, "a run stops when it is told to");
    const session::RenderFile merged =
        session::Merge({{"before", before.render}, {"rest", rest.Result().render}});
    Require(merged.radiance == render.radiance, "merged renders have the bits of one run");
}

// Renders a scene and an environment of the host's own.
void LightByHost(rhi::Device& device, const char* file) {
    const auto lit = [&](float radiance) {
        session::SceneInput input = session::MakeInput(scene::LoadGltf(file), "ours");
        const image::ImageF map{.width = 2, .height = 1, .rgba = std::vector<float>(8, radiance)};
        session::SetEnvironment(input, map, "our sky");
        Require(input.environmentHash == session::HashOf(map), "a map is known by its content");
        return input;
    };
    const session::SessionDesc desc{.settings = {.size = {8, 8}}};
    session::Session session(device, lit(1.0f), desc);
    session.Run({.samples = 2});
    const session::ResumedRender before{"picture", session.Result().render};
    Require(before.render.sceneFile == "ours" && before.render.environmentFile == "our sky",
            "scene and environment are recorded");
    Require(session::Session(device, lit(1.0f), Resuming(before)).SampleCount() == 2,
            "a render goes on under its own sky");
    Require(IsRefused([&] { session::Session(device, lit(2.0f), Resuming(before)); }, ErrorKind::BadInput),
            "a render does not go on under another sky");
}

void Refuse(rhi::Device& device, const char* scene) {
    session::Session session(device, session::LoadInput(scene), {.settings = {.size = {8, 8}}});
    Require(IsRefused([&] { session.Result(); }, ErrorKind::Usage), "there is no result before a run");
    Require(IsRefused([&] { session.Run({}); }, ErrorKind::Usage), "a run has an end");
    session.Run({.samples = 1});
    Require(IsRefused([&] { session.Run({.samples = 0}); }, ErrorKind::Usage), "a run takes no samples back");
    Require(IsRefused(
                [&] {
                    session::Session(device, session::LoadInput(scene),
                                     {.settings = {.view = session::View::Albedo}, .aovs = {Aov::Direct}});
                },
                ErrorKind::Usage),
            "a picture without light has no parts of it");
    Require(IsRefused([] { session::LoadInput("missing.gltf"); }, ErrorKind::BadInput),
            "a missing scene is bad input");
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 3) return 2;
    try {
        CheckFile(session::ReadRenderFile(argv[2]));
        const auto device = rhi::Device::Create();
        GoOn(*device, argv[1], argv[2]);
        LightByHost(*device, argv[1]);
        Refuse(*device, argv[1]);
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "check_render: %s\n", error.what());
        return 1;
    }
}
