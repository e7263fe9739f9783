// Pictures explained and verified.
#include <algorithm>
#include <optional>
#include <utility>

#include "c/call.h"
#include "c/handles.h"
#include "editor/session/explain/explain.h"
#include "editor/session/explain/path_text.h"
#include "editor/session/verify/verdict_text.h"
#include "editor/session/verify/verify.h"

using raygraph::c::Call;
using raygraph::c::Guarded;
namespace session = raygraph::session;

namespace raygraph::c {

namespace {

session::Picture PictureOf(const Call& call, const RgVerifyDesc& desc, const Log& log) {
    if ((desc.path == nullptr) == (desc.pixels == nullptr))
        call.Refuse("desc has a path or pixels, and neither or both are given");
    if (desc.path != nullptr) return session::ReadPicture(desc.path, {}, log);
    const RgPixels pixels = call.Read(desc.pixels, "desc.pixels");
    session::Picture picture{.name = "the picture"};
    picture.radiance = FloatsOf(pixels);
    picture.size = {pixels.width, pixels.height};
    return picture;
}

}  // namespace

}  // namespace raygraph::c

RgResult rg_explain(RgDevice* device, RgScene* scene, const RgSettings* settings, uint32_t x, uint32_t y,
                    char** text) {
    return Guarded("rg_explain", [&](const Call& call) {
        const auto on = call.Required(device, "device").device;
        session::EditedScene& of = call.Required(scene, "scene").scene;
        call.Required(text, "text");
        const session::PictureSettings with =
            session::SettingsFor(of, raygraph::c::OptionsOf(settings).settings);
        of.Update();
        *text = raygraph::c::CopyOf(session::Describe(
            session::Explain(*on, of.InputFor(with.at.has_value()), with, {.pixel = {x, y}})));
    });
}

RgResult rg_verify(RgDevice* device, RgScene* scene, const RgSettings* settings, const RgVerifyDesc* desc,
                   RgVerdict* verdict, char** text) {
    return Guarded("rg_verify", [&](const Call& call) {
        const auto on = call.Required(device, "device").device;
        session::EditedScene& of = call.Required(scene, "scene").scene;
        const RgVerifyDesc given = call.Read(desc, "desc");
        call.Read(verdict, "verdict");
        const session::Picture picture = raygraph::c::PictureOf(call, given, on->Log());
        const session::SettingTexts texts = raygraph::c::OptionsOf(settings).settings;
        session::VerifyDesc judged{.settings = session::SettingsFor(of, texts)};
        if (!texts.contains("size")) judged.settings.size = picture.size;
        if (given.tolerance != 0.0) judged.tolerance.relative = given.tolerance;
        if (given.max_samples != 0) judged.maxSamples = given.max_samples;
        judged.minSamples = std::min(judged.minSamples, judged.maxSamples);
        judged.cache = raygraph::c::TextOr(given.cache_directory);
        judged.log = on->Log();
        of.Update();
        const session::VerifyResult result =
            session::Verify(*on, of.InputFor(judged.settings.at.has_value()), judged).Check(picture);
        RgVerdict made{};
        made.is_right = result.verdict.isRight ? 1 : 0;
        made.is_decided = result.verdict.isDecided ? 1 : 0;
        made.reference_samples = result.referenceSamples;
        made.relative_mse = result.verdict.difference.relMse;
        made.flip = result.verdict.difference.flip;
        made.ssim = result.verdict.difference.ssim;
        if (text != nullptr) *text = raygraph::c::CopyOf(session::Describe(result, picture.name));
        call.Write(verdict, "verdict", made);
    });
}
