// PictureSettings holds the settings that change the linear picture of a render. All of them are recorded in
// its file, and compared when it is resumed or merged. Threads: plain values and pure functions, for any
// thread.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/api.h"
#include "base/error.h"
#include "editor/session/settings/light_groups.h"
#include "passes/raster.h"
#include "passes/trace.h"
#include "passes/views.h"
#include "renderer/gpu_scene/lights/own_light.h"
#include "renderer/scene/geometry/round_primitives.h"
#include "renderer/scene/model/camera_view.h"

namespace raygraph::session {

using passes::View;  // selects what the picture's RGB shows

// Gives the times when the shutter opens and closes, in seconds after PictureSettings::at: samples see the
// scene at times between.
struct Shutter {
    double open = 0.0;
    double close = 0.0;  // above `open`

    bool operator==(const Shutter&) const = default;
};

// The help of a setting of pointsAndLines ends with this.
inline constexpr const char* kRadiusHelp =
    ": in meters, or with % of the diagonal of the scene's bounds (off: left out)";

struct PictureSettings {
    Extent2D size{1280, 720};            // pixels, 1 to 16384 per side
    std::optional<passes::Region> crop;  // rendered part of the picture; none: all of it
    View view = View::PathTraced;
    std::string camera;        // see scene::ChooseView; CameraText converts a view, scene::ToText an orbit
    std::string scene;         // glTF scene by name or index; "": the file's default
    std::string variant;       // variant of the materials, by name or index; "": none
    std::optional<double> at;  // time of the animations, in seconds; none: the rest pose
    std::string clips;         // animations in effect, see scene::FindClips
    std::optional<Shutter> shutter;        // motion blur; none: all samples see the scene at `at`
    scene::PointsAndLines pointsAndLines;  // radii of the scene's points and lines; off: left out
    float aperture = 0.0f;                 // lens radius in meters; 0: a pinhole
    float focusDistance = 0.0f;            // meters; 0: DefaultFocus
    passes::PathSettings paths{};
    passes::RasterSettings raster{};   // only the shadows are recorded: the others have no option
    float environmentRotation = 0.0f;  // degrees about +y
    std::array<float, 3> environmentTint{1.0f, 1.0f, 1.0f};  // factor on a map's radiance
    // The constant radiance where no map is given. None: the scene's own environment, the studio, or black.
    std::optional<std::array<float, 3>> background;
    // Puts a ground under the scene's bounds at rest (scene::GroundUnder). With paths.isEnvironmentHidden,
    // only the shadow on it is seen.
    bool hasGround = false;
    // Selects whether the studio is the environment: a session decides what Auto leaves open
    // (light_settings.h), and records its decision. Studio excludes a background and a map.
    DefaultLight light = DefaultLight::Auto;
    // If true, pixels get as many samples as the picture's error needs, instead of equally many
    // (adaptive_frames.h).
    bool isAdaptive = false;
    uint64_t textureBudget = 0;  // bytes for all textures on the device; 0: GpuSceneDesc's default
    std::vector<LightGroupPatterns> lightGroups;
};

// Returns the part of the picture that is rendered.
inline passes::Region RenderedPart(const PictureSettings& settings) {
    return settings.crop.value_or(passes::WholeOf(settings.size));
}

// Returns whether a part of the view can be rendered with the same bits as in the whole, which holds for all
// that rays find.
inline bool CanCrop(View view) {
    return view != View::Raster && view != View::Overdraw;
}

inline uint64_t PixelCount(Extent2D size) {
    return uint64_t{size.width} * size.height;
}

// Reports an invalid setting. what() begins with the setting's name, as in "seed: ...".
class RAYGRAPH_API SettingError : public Error {
  public:
    using Error::Error;
};

// Names the setting that a session decides if it is left open.
inline constexpr std::string_view kLightSetting = "light";

// Holds settings as texts by name: "seed" is "1". The names are those of the options of `raygraph render`.
using SettingTexts = std::map<std::string, std::string, std::less<>>;

// Returns every setting.
RAYGRAPH_API SettingTexts Texts(const PictureSettings& settings);

// Returns `defaults`, overridden by the texts. Throws SettingError of kind Usage for an invalid text, and for
// a crop outside of the picture; names of other settings are ignored.
RAYGRAPH_API PictureSettings SettingsFrom(const SettingTexts& texts, const PictureSettings& defaults = {});

// Returns the first setting whose texts differ: "seed: 1 against 2"; empty if all agree. A setting that one
// side lacks has its default there.
RAYGRAPH_API std::string FirstDifference(const SettingTexts& a, const SettingTexts& b);

// Returns whether this text leaves the setting to the session (kLightSetting), so that it agrees with every
// value that the session may have chosen.
RAYGRAPH_API bool IsOpen(std::string_view setting, std::string_view text);

// Returns a time as the setting `at` has it; "" for none.
RAYGRAPH_API std::string AtText(const std::optional<double>& at);

// Returns the distance in focus where no other is given, in meters along the view: that of the middle of the
// scene's bounds; 1 if this is not ahead, or there is none.
RAYGRAPH_API float DefaultFocus(const scene::CameraView& view, const scene::Bounds& bounds);

// Returns "eye target up fov" or "eye target up HEIGHTm", which reads back as the same view but for rounding.
RAYGRAPH_API std::string CameraText(const scene::CameraView& view);

}  // namespace raygraph::session
