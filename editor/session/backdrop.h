// The backdrop of pictures that are shown: what is behind the scene where a render leaves out the environment
// (PathSettings::isEnvironmentHidden). It is no light: the scene is lit, mirrored and refracted by the
// environment as ever. Threads: pure functions, for any thread.
#pragma once

#include <array>
#include <optional>

#include "base/api.h"
#include "editor/session/settings/picture_settings.h"
#include "editor/session/settings/scene_input.h"
#include "renderer/image/image.h"

namespace raygraph::session {

struct Backdrop {
    // Linear, 0 to 1: shown as it is, whatever exposure and tone curve are. None: the map.
    std::optional<std::array<float, 3>> color;
    image::ImageF map;  // radiance as GpuScene::SetEnvironmentMap takes it: shown as the scene is
};

// Returns the environment map of the picture, be it a file's, the scene's or the studio, with its tint, and
// blurred by `degrees` from 0.5 to 90, or as it is for 0: a texel is the mean of the radiance around it,
// weighted by exp(-a^2 / 2s^2) of the angle a, where s is `degrees`. PictureSettings::light must be decided
// (ChooseLight). None: there is no map.
RAYGRAPH_API std::optional<image::ImageF> BackdropMap(const SceneInput& input,
                                                      const PictureSettings& settings, float degrees);

// Returns what the centers of the pixels see of an equirectangular map; the picture has the size of `part`.
RAYGRAPH_API image::ImageF SeenOf(const image::ImageF& map, float rotation, const gpu::CameraRecord& camera,
                                  Extent2D size, const passes::Region& part);

// Returns the picture, of sRGB with an alpha that is not premultiplied, over an opaque one of its size, mixed
// in linear light.
RAYGRAPH_API image::Image8 Over(const image::Image8& picture, const image::Image8& behind);
// Over one linear color.
RAYGRAPH_API image::Image8 Over(const image::Image8& picture, const std::array<float, 3>& color);

}  // namespace raygraph::session
