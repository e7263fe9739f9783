#include "passes/path_settings.h"

#include "renderer/gpu_scene/camera_record.h"

namespace raygraph::passes {

TraceSettings FrameSettings(Extent2D extent, const scene::CameraView& camera, const LensSettings& lens,
                            const PathSettings& paths) {
    scene::CameraView view = camera;
    view.aspect = static_cast<float>(extent.width) / static_cast<float>(extent.height);
    TraceSettings settings;
    static_cast<PathSettings&>(settings) = paths;
    settings.extent = extent;
    settings.camera = ToRecord(view);
    settings.camera.lensRadius = lens.radius;
    settings.camera.focusDistance = lens.focusDistance;
    return settings;
}

}  // namespace raygraph::passes
