// Viewport is one view of a scene in a host's window or panel. Its inputs are a size, a camera and view
// settings, its output is a picture. It needs no window, and it submits nothing by itself: the host drives
// the frame.
//
//   Viewport viewport(renderer, scene);
//   viewport.SetSize({1280, 720});
//   viewport.SetCamera(view);
//   for (;;) {
//       renderer.BeginFrame();
//       TextureId shown = viewport.Declare();           // passes of the scene and of the viewport
//       ... passes of the host, which may read `shown` ...
//       renderer.Present(shown);                        // or HostImage::Show: vulkan_interop.h
//       renderer.Execute();
//   }
//
// Both the path-traced and the raster view are declared in every frame; passes that the shown picture does
// not need are culled. So a view that is toggled off costs no time, keeps its samples, and continues later.
// The real-time and the denoised picture, which can be made again, keep their memory for 60 frames only.
//
// Accumulation restarts by itself when something changes that the picture depends on: the viewport compares
// with what the last frame was declared from, and counts the causes (ResetCount). Settings that apply after
// accumulation, and all of ShowSettings and BudgetSettings, never restart it.
//
// Threads: that of the Renderer. Setters take effect with the next Declare, and may be called at any time.
// Renderer and scene outlive the viewport; destroying it drops an open frame that it is declared in.
// Viewports share only what the host gives to both: those on one Renderer need different names.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/api.h"
#include "editor/viewport/capture.h"
#include "editor/viewport/error_estimate.h"
#include "editor/viewport/pixel_requests.h"
#include "editor/viewport/real_time_errors.h"
#include "editor/viewport/view_settings.h"
#include "passes/accumulate.h"
#include "passes/compare.h"
#include "passes/raster.h"
#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/graph/renderer.h"
#include "renderer/scene/model/camera_view.h"

namespace raygraph::viewport {

struct ViewportDesc {
    std::string name =
        "viewport";  // prefix of its persistent textures; unique among the Renderer's viewports
    Extent2D size{};
};

// Holds the progress of the shown picture in submitted frames.
struct ViewportProgress {
    uint32_t pathTracedSamples = 0;   // per pixel
    double pathTracedFraction = 0.0;  // fraction of the pixels that already have the next sample
    uint32_t rasterSamples = 0;
    // The raster view stops there: one sample if it takes longer than the budget; 0: never.
    uint32_t rasterSamplesWanted = 0;
    // Factor by which the path-traced picture is coarser, in pixels along an edge: 1 once every pixel has a
    // sample, 0 while there is no picture.
    uint32_t coarseness = 0;
    // If true, the path-traced picture of the last declared frame has no samples of the present scene,
    // because pipelines are being made (PreparingView).
    bool isPreview = false;
    // Samples of the denoised picture that is shown (ShowSettings::isDenoised), pathTracedSamples or fewer;
    // 0: none is.
    uint32_t denoisedSamples = 0;
    uint32_t realTimeFrames = 0;  // frames that the real-time view has filtered so far
    // Milliseconds that such a frame takes on the device at full resolution, as the times of earlier ones
    // suggest; none before there are any.
    std::optional<double> realTimeMs;
};

// Holds the difference between the path-traced picture, of so many samples, and what it is compared with.
struct CompareNumbers {
    View view = View::Flip;  // Difference (of the luminance), RelativeError or Flip
    Compared compared = Compared::Raster;
    passes::MapStatistics numbers{};
    uint32_t pathTracedSamples = 0;
    uint32_t otherVersion = 0;  // samples of the raster view, or frames of the real-time one
};

class RAYGRAPH_API Viewport {
  public:
    Viewport(Renderer& renderer, GpuScene& scene, const ViewportDesc& desc = {});
    ~Viewport();
    Viewport(const Viewport&) = delete;
    Viewport& operator=(const Viewport&) = delete;

    // --- What to show ---
    // In pixels. Any size is legal; one without area shows nothing and keeps what has been accumulated.
    void SetSize(Extent2D size);
    Extent2D Size() const;
    // The aspect ratio is that of the size; the camera's is ignored.
    void SetCamera(const scene::CameraView& camera, const LensSettings& lens = {});
    const scene::CameraView& Camera() const;
    // Shows another scene of the same Renderer: ResetCause::Geometry. Edits of the scene itself are noticed.
    void SetScene(GpuScene& scene);
    GpuScene& Scene() const;

    void SetShow(const ShowSettings& settings);
    const ShowSettings& Show() const;
    void SetView(View view);  // sets ShowSettings::view
    void SetPaths(const PathSettings& settings);
    const PathSettings& Paths() const;
    // Sets the raster view; only that view restarts.
    void SetRaster(const passes::RasterSettings& settings);
    const passes::RasterSettings& Raster() const;
    // Takes indices of the scene's instances; others are ignored.
    void SetOutlined(std::vector<uint32_t> instances);
    void SetOutline(const OutlineSettings& settings);
    const OutlineSettings& Outline() const;
    void SetBudget(const BudgetSettings& settings);
    const BudgetSettings& Budget() const;

    // --- Frames ---
    // Call it once within an open frame: declares the scene's passes and the viewport's. Returns the picture,
    // rgba8 of the viewport's size, display-encoded and opaque; an invalid id for a size without area. It is
    // read-only for the host, since later frames may reuse it.
    TextureId Declare();
    // Declares a scene that several viewports show: `ids` are from its Declare in this frame. The host calls
    // the scene's SetViewpoint then.
    TextureId Declare(const SceneIds& ids);
    // Call it after Declare, in the same frame: returns a new picture, `picture` of Declare with an outline
    // around the visible part of the outlined instances. The picture of Declare, which can be saved, and the
    // accumulation have no outline. It costs nothing, and returns `picture`, if nothing is outlined, in
    // View::SideBySide, and for an invalid id. The outline is recomputed when camera, scene or selection have
    // changed, at a lower resolution while they change, and otherwise reused.
    TextureId DeclareOutline(TextureId picture);
    // Call it in an open frame without Declare: returns the picture of an earlier frame, in the size that it
    // had then; an invalid id if there is none. If the view shows both kinds of picture, or surfaces, it
    // returns one of them.
    TextureId DeclareLastPicture();
    // Renders a frame of this viewport alone: begins, declares, presents and executes it. Returns its
    // submission, an empty one for a size without area.
    rhi::Submission RenderFrame();

    // --- Questions about a pixel; none waits ---
    // Throw Error{Usage} outside of the size.
    Pick RequestPick(glm::uvec2 pixel);
    Inspection RequestInspection(glm::uvec2 pixel);
    // Requests samples of the path-traced view, whether it is shown or not, and the path of one of them: what
    // happens at each vertex. Samples are functions of their index, from 0 on, so that those of the picture
    // are traced again. The first path needs a pipeline of its own. Throw Error{Usage} also for no sample,
    // and for more than kMaxRequestedSamples.
    SamplesRequest RequestSamples(glm::uvec2 pixel, uint32_t first, uint32_t count);
    PathRequest RequestPath(glm::uvec2 pixel, uint32_t sample);
    static constexpr uint32_t kMaxRequestedSamples = 4096;
    // Requests the radiance of the raster view if that is shown, else of the path-traced one, with the
    // surface data of its pixels. With ShowSettings::isDenoised, the frame that answers denoises it. Not
    // answered while View::Surface or a size without area is shown.
    Capture RequestCapture();
    // Requests the error of the path-traced view; answered once it is shown and every pixel has a sample.
    NoiseRequest RequestNoise();
    // Requests the errors of the real-time view; answered once it is compared with the path-traced one and
    // every pixel of that has a sample. A request makes one frame measure, and no others.
    RealTimeErrorsRequest RequestRealTimeErrors();

    // --- What happened ---
    ViewportProgress Progress() const;
    // Returns how often the path-traced accumulation was restarted by the cause. Several changes of one kind
    // between two frames count as one restart.
    uint32_t ResetCount(passes::ResetCause cause) const;
    // Returns the numbers of the newest finished frame that showed a view with IsMeasured; none before.
    std::optional<CompareNumbers> Numbers();
    // Returns the GPU milliseconds of this viewport's last measured frame, all its passes; 0 before.
    double LastFrameMs() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

}  // namespace raygraph::viewport
