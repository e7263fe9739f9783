// The objects behind the handles of the C interface. Each keeps what it was made with, so that a host may
// destroy handles in any order. For c/ alone. Threads: as c/raygraph.h says.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "c/raygraph.h"
#include "editor/session/binding/edited_scene.h"
#include "editor/session/binding/finished_picture.h"
#include "rhi/device.h"

struct RgDevice {
    std::shared_ptr<raygraph::rhi::Device> device;
};

struct RgScene {
    raygraph::session::EditedScene scene;
    // Changes with what rg_gpu_scene_update cannot apply; no two scenes have the same.
    uint64_t structure = NextStructure();

    static uint64_t NextStructure() {
        static std::atomic<uint64_t> last{0};
        return ++last;
    }
};

struct RgSettings {
    raygraph::session::SettingTexts texts;            // as they were set
    mutable raygraph::session::SettingTexts answers;  // of rg_settings_get
};

struct RgPicture {
    raygraph::session::FinishedPicture picture;
    std::vector<raygraph::session::PictureChannel> channels;
};

namespace raygraph::c {

// Holds settings in the two parts that a render takes.
struct RenderOptions {
    session::SettingTexts settings;
    session::PictureRequest request;
};
// `settings` may be null.
RenderOptions OptionsOf(const RgSettings* settings);

// Returns that of 16 numbers (session::TransformOf).
inline scene::PlacedTransform TransformAt(const double* matrix) {
    return session::TransformOf(std::span<const double, 16>(matrix, 16));
}

// Throws Error{Usage} for pixels without data, area, or 3 or 4 channels.
void RequirePixels(const RgPixels& pixels, size_t bytesPerNumber);
// Returns RGBA floats with an alpha of 1 where there are three channels.
std::vector<float> FloatsOf(const RgPixels& pixels);

}  // namespace raygraph::c
