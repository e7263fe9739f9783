// Verify compares somebody's picture of a scene with the reference that this program path-traces of it, and
// says whether it is right and, if it is not, what is off.
//
//   session::Verify verify(*device, session::LoadInput("scene.gltf"), {.settings = settings});
//   const session::VerifyResult result = verify.Check(session::ReadPicture("raster.exr"));
//   if (!result.verdict.isRight) Report(result);
//
// Threads: one at a time, as a Session; the device may be in use by others.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/api.h"
#include "base/log.h"
#include "editor/session/file/render_file.h"
#include "editor/session/run.h"
#include "editor/session/settings/picture_settings.h"
#include "editor/session/settings/scene_input.h"
#include "editor/session/verify/diagnosis.h"
#include "editor/session/verify/picture.h"
#include "editor/session/verify/verdict.h"
#include "rhi/device.h"

namespace raygraph::session {

// The seed of references, unless the settings have another than 0: pictures of this program rarely have it,
// and are independent of the reference then.
inline constexpr uint32_t kReferenceSeed = 0x7ef;

struct VerifyDesc {
    // Settings of the reference; `view` may be a view of surfaces or the raster view, for a picture that is
    // meant to be one. The picture has their size.
    PictureSettings settings;
    Tolerance tolerance;
    // The reference gets more samples until the verdict does not depend on its noise, or it has the most.
    uint32_t minSamples = 64, maxSamples = 1024;
    // Folder of references, made when needed, with a file for each Key and state of the shaders. "": none is
    // stored.
    std::filesystem::path cache;
    float exposureEv = 0.0f;                             // with which FLIP and SSIM see the pictures
    std::function<void(const ProgressState&)> progress;  // of the samples of the reference
    // Ends them early: what there is is stored, and Check throws. Empty: never.
    std::function<bool()> isStopRequested;
    Log log;
};

// Sets Tolerance::relative of the pixels of objects or materials; infinity: they do not count.
struct RegionRule {
    bool isMaterial = false;
    std::string pattern;  // shell pattern of names
    float relative = 0.0f;
};

// Parses "object:PATTERN=X" or "material:PATTERN=X"; X is a number or "ignore". Throws Error{Usage} that
// quotes the text.
RAYGRAPH_API RegionRule ParseRegion(std::string_view text);

struct CheckOptions {
    std::vector<RegionRule> regions;  // later ones override earlier ones
    // Both have the size of the picture, or none.
    Picture mask;                                 // pixels that are black in it do not count
    Picture accepted;                             // a difference to the reference that counts as right
    std::optional<uint32_t> pictureSamples = {};  // of NoiseOf
};

struct VerifyResult {
    Verdict verdict;
    Diagnosis diagnosis;  // of a picture that is not right
    uint64_t referenceSamples = 0;
    uint64_t newSamples = 0;  // of those, rendered by this call
};

class RAYGRAPH_API Verify {
  public:
    // Takes the scene; nothing is uploaded before samples are needed. Throws SettingError and Error as
    // Session does, at the latest in Check.
    Verify(rhi::Device& device, SceneInput input, VerifyDesc desc);
    ~Verify();
    Verify(const Verify&) = delete;
    Verify& operator=(const Verify&) = delete;

    // Renders what the reference lacks, stores it in the cache after each doubling, and judges the picture.
    // With a crop, the picture may be a whole one. Before anything is rendered it throws Error{BadInput} for
    // a picture, a mask or an accepted difference of another size, and for a picture of colors of a view that
    // paints values; Error{Usage} for a region that no object or material is in. Throws Error{Io} if it was
    // stopped, and as Session::Run does. Calls of several Verify objects with one file of the cache wait for
    // each other.
    VerifyResult Check(const Picture& picture, const CheckOptions& options = {});

    // Returns the picture as it is compared, after a call of Check: the part that the crop has; and normals n
    // as (n + coverage) / 2, as in a .png, with the coverage of the reference.
    Picture AsJudged(const Picture& picture) const;

    // Returns a text that is another one for another reference: scene, map, settings, version.
    std::string Key() const;
    // Returns the reference; it has samples after a call of Check.
    const Picture& Reference() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

// Returns a group for each material that emits and is used, and each light, by name, at most eight: what
// settings without groups are verified with.
RAYGRAPH_API std::vector<LightGroupPatterns> GroupsOfAllLights(const scene::SceneData& scene);

}  // namespace raygraph::session
