// The samples of docs/scenes.md compile. The first names a file that is not there, so they do not run.
#include "animation_headers.h"  // the includes of the page, which must suffice for its samples

#include "renderer/scene/camera_view.h"

namespace {

[[maybe_unused]] void ShowAClip(GpuScene& gpuScene, double seconds) {
#include "show_a_clip.inc"
}

[[maybe_unused]] void SetViewpoint(GpuScene& scene, const scene::CameraView& view) {
#include "set_viewpoint.inc"
}

}  // namespace
