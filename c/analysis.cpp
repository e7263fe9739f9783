// Pictures explained, compared and verified.
#include <algorithm>
#include <optional>
#include <utility>

#include "c/call.h"
#include "c/handles.h"
#include "editor/session/explain/explain.h"
#include "editor/session/explain/path_text.h"
#include "editor/session/verify/difference.h"
#include "editor/session/verify/verdict_text.h"
#include "editor/session/verify/verify.h"

using raygraph::c::Call;
using raygraph::c::Guarded;
namespace session = raygraph::session;

namespace raygraph::c {

namespace {

// Returns the picture of a file or of pixels, which errors call `name`.
session::Picture PictureOf(const Call& call, const char* path, const RgPixels* given, const std::string& name,
                           const Log& log) {
    if (path != nullptr) return session::ReadPicture(path, {}, log);
    const RgPixels pixels = call.Read(given, (name + ".pixels").c_str());
    session::Picture picture{.name = name};
    picture.radiance = FloatsOf(pixels);
    picture.size = {pixels.width, pixels.height};
    return picture;
}

session::Picture PictureOf(const Call& call, const RgCompared* given, const char* name, const Log& log) {
    const RgCompared of = call.Read(given, name);
    if ((of.picture != nullptr) + (of.path != nullptr) + (of.pixels != nullptr) != 1)
        call.Refuse(Text("{} has a picture, a path or pixels, and not exactly one is given", name));
    if (of.picture != nullptr) return session::PictureOf(of.picture->picture.render, name);
    return PictureOf(call, of.path, of.pixels, name, log);
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

RgResult rg_compare(RgDevice* device, const RgCompared* reference, const RgCompared* picture, float exposure,
                    RgDifference* difference) {
    return Guarded("rg_compare", [&](const Call& call) {
        const auto on = call.Required(device, "device").device;
        call.Read(difference, "difference");
        const session::Picture of = raygraph::c::PictureOf(call, reference, "reference", on->Log()),
                               with = raygraph::c::PictureOf(call, picture, "picture", on->Log());
        raygraph::Renderer renderer(*on);
        const session::PictureDifference found = session::Difference(renderer, of, with, exposure);
        RgDifference made{};
        made.relative_mse = found.relMse;
        made.relative_mse_of_noise = found.relMseOfNoise;
        made.flip = found.flip;
        made.ssim = found.ssim;
        std::ranges::copy(found.meanOfReference, made.mean_of_reference);
        std::ranges::copy(found.mean, made.mean);
        if (found.z) {
            made.has_noise = 1;
            made.z_rms = found.z->rms;
            made.z_beyond_three = found.z->beyondThree;
            std::ranges::copy(found.z->ofMean, made.z_of_mean);
            made.z_differs_without_noise = found.z->differsWithoutNoise;
        }
        call.Write(difference, "difference", made);
    });
}

RgResult rg_verify(RgDevice* device, RgScene* scene, const RgSettings* settings, const RgVerifyDesc* desc,
                   RgVerdict* verdict, char** text) {
    return Guarded("rg_verify", [&](const Call& call) {
        const auto on = call.Required(device, "device").device;
        session::EditedScene& of = call.Required(scene, "scene").scene;
        const RgVerifyDesc given = call.Read(desc, "desc");
        call.Read(verdict, "verdict");
        if ((given.path == nullptr) == (given.pixels == nullptr))
            call.Refuse("desc has a path or pixels, and neither or both are given");
        const session::Picture picture =
            raygraph::c::PictureOf(call, given.path, given.pixels, "desc", on->Log());
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
