#include "editor/viewport/viewport.h"

#include <algorithm>
#include <cmath>

#include "base/text.h"
#include "editor/viewport/viewport_impl.h"
#include "passes/overlay.h"
#include "passes/trace.h"

namespace raygraph::viewport {

Viewport::Impl::Impl(Renderer& ofRenderer, GpuScene& ofScene, const ViewportDesc& desc)
    : renderer(ofRenderer),
      scene(&ofScene),
      name(desc.name),
      size(desc.size),
      pathTraced(desc.name),
      raster(desc.name),
      realTime(desc.name),
      denoised(desc.name + ".denoised"),
      pathTracedDisplay(desc.name + ".path-traced.display"),
      rasterDisplay(desc.name + ".raster.display"),
      realTimeDisplay(desc.name + ".real-time.display"),
      denoisedDisplay(desc.name + ".denoised.display"),
      blurredEnvironment(desc.name + ".blurred-environment"),
      compare(desc.name),
      outline(desc.name + ".outline"),
      realTimeErrors(desc.name + ".real-time.errors") {}

Viewport::Viewport(Renderer& renderer, GpuScene& scene, const ViewportDesc& desc)
    : m_impl(std::make_unique<Impl>(renderer, scene, desc)) {}

Viewport::~Viewport() {
    // It would refer to destroyed objects
    if (!m_impl->declaredIn.expired()) m_impl->renderer.DropFrame();
    m_impl->pathTraced.Release(m_impl->renderer);
    m_impl->raster.Release(m_impl->renderer);
    m_impl->ReleaseRealTime();
    m_impl->ReleaseDenoised();
    m_impl->pathTracedDisplay.Release(m_impl->renderer);
    m_impl->rasterDisplay.Release(m_impl->renderer);
    m_impl->blurredEnvironment.Release(m_impl->renderer);
    m_impl->compare.Release(m_impl->renderer);
    m_impl->outline.Release(m_impl->renderer);
    m_impl->realTimeErrors.Release(m_impl->renderer);
}

void Viewport::SetSize(Extent2D size) {
    m_impl->size = size;
}

Extent2D Viewport::Size() const {
    return m_impl->size;
}

void Viewport::SetCamera(const scene::CameraView& camera, const LensSettings& lens) {
    m_impl->camera = camera;
    m_impl->lens = lens;
}

const scene::CameraView& Viewport::Camera() const {
    return m_impl->camera;
}

void Viewport::SetScene(GpuScene& scene) {
    m_impl->scene = &scene;
}

GpuScene& Viewport::Scene() const {
    return *m_impl->scene;
}

void Viewport::SetShow(const ShowSettings& settings) {
    m_impl->show = settings;
}

const ShowSettings& Viewport::Show() const {
    return m_impl->show;
}

void Viewport::SetView(View view) {
    m_impl->show.view = view;
}

void Viewport::SetPaths(const PathSettings& settings) {
    m_impl->paths = settings;
}

const PathSettings& Viewport::Paths() const {
    return m_impl->paths;
}

void Viewport::SetRaster(const passes::RasterSettings& settings) {
    m_impl->rasterSettings = settings;
}

const passes::RasterSettings& Viewport::Raster() const {
    return m_impl->rasterSettings;
}

void Viewport::SetOutlined(std::vector<uint32_t> instances) {
    m_impl->outline.SetInstances(std::move(instances));
}

void Viewport::SetOutline(const OutlineSettings& settings) {
    m_impl->outlineSettings = settings;
}

const OutlineSettings& Viewport::Outline() const {
    return m_impl->outlineSettings;
}

void Viewport::SetBudget(const BudgetSettings& settings) {
    m_impl->budgetSettings = settings;
    m_impl->budget.SetLimit(settings.frameMs);
}

const BudgetSettings& Viewport::Budget() const {
    return m_impl->budgetSettings;
}

TextureId Viewport::Declare() {
    if (m_impl->size.IsEmpty()) return {};
    m_impl->scene->SetViewpoint(m_impl->camera.eye);
    return m_impl->Declare(m_impl->scene->Declare(m_impl->renderer));
}

TextureId Viewport::Declare(const SceneIds& ids) {
    if (m_impl->size.IsEmpty()) return {};
    return m_impl->Declare(ids);
}

TextureId Viewport::DeclareOutline(TextureId picture) {
    return m_impl->DeclareOutline(picture);
}

TextureId Viewport::DeclareLastPicture() {
    const ShowSettings shown = m_impl->ShownAs();
    if (shown.view == View::RealTime || ComparesRealTime(shown))
        if (const TextureId kept = m_impl->realTimeDisplay.DeclareLast(m_impl->renderer); kept.IsValid())
            return kept;
    if (Progress().denoisedSamples > 0)
        if (const TextureId kept = m_impl->denoisedDisplay.DeclareLast(m_impl->renderer); kept.IsValid())
            return kept;
    const CachedDisplay& first = ShowsRaster(shown) ? m_impl->rasterDisplay : m_impl->pathTracedDisplay;
    const TextureId kept = first.DeclareLast(m_impl->renderer);
    if (kept.IsValid()) return kept;
    const CachedDisplay& other =
        &first == &m_impl->rasterDisplay ? m_impl->pathTracedDisplay : m_impl->rasterDisplay;
    return other.DeclareLast(m_impl->renderer);
}

rhi::Submission Viewport::RenderFrame() {
    if (m_impl->size.IsEmpty()) return {};
    Renderer& renderer = m_impl->renderer;
    renderer.BeginFrame();
    try {
        renderer.Present(Declare());
        return renderer.Execute();
    } catch (...) {
        renderer.DropFrame();
        throw;
    }
}

namespace {

void RequirePixel(Extent2D size, glm::uvec2 pixel, const char* call) {
    if (pixel.x >= size.width || pixel.y >= size.height)
        throw MakeError(ErrorKind::Usage, "Viewport: {} of pixel {}, {} in {}x{}", call, pixel.x, pixel.y,
                        size.width, size.height);
}

}  // namespace

Pick Viewport::RequestPick(glm::uvec2 pixel) {
    RequirePixel(m_impl->size, pixel, "RequestPick");
    return m_impl->requests.RequestPick(pixel);
}

Inspection Viewport::RequestInspection(glm::uvec2 pixel) {
    RequirePixel(m_impl->size, pixel, "RequestInspection");
    return m_impl->requests.RequestInspection(pixel);
}

SamplesRequest Viewport::RequestSamples(glm::uvec2 pixel, uint32_t first, uint32_t count) {
    RequirePixel(m_impl->size, pixel, "RequestSamples");
    if (count == 0 || count > kMaxRequestedSamples || count - 1 > ~first)
        throw MakeError(ErrorKind::Usage,
                        "Viewport: RequestSamples of {} samples from {} on: must be 1 to {}", count, first,
                        kMaxRequestedSamples);
    return m_impl->requests.RequestSamples(pixel, first, count);
}

PathRequest Viewport::RequestPath(glm::uvec2 pixel, uint32_t sample) {
    RequirePixel(m_impl->size, pixel, "RequestPath");
    return m_impl->requests.RequestPath(pixel, sample);
}

Capture Viewport::RequestCapture() {
    return m_impl->captures.Request();
}

NoiseRequest Viewport::RequestNoise() {
    return m_impl->errors.Request();
}

RealTimeErrorsRequest Viewport::RequestRealTimeErrors() {
    return m_impl->realTimeErrors.Request();
}

ViewportProgress Viewport::Progress() const {
    const passes::Accumulation::Progress& progress = m_impl->pathTraced.Samples().Submitted();
    const Extent2D size = m_impl->size;
    const double pixels = double(size.width) * size.height;
    return {.pathTracedSamples = progress.sampleCount,
            .pathTracedFraction =
                pixels > 0.0 ? static_cast<double>(progress.cursor.PixelCount(size)) / pixels : 0.0,
            .rasterSamples = m_impl->raster.Samples().SampleCount(),
            .rasterSamplesWanted = m_impl->raster.TargetSamples(),
            .coarseness = m_impl->pathTraced.Coarseness(),
            .isPreview = m_impl->isPreview,
            .denoisedSamples = m_impl->denoisedIds.picture.IsValid()
                                   ? m_impl->denoised.SampleCount(m_impl->pathTraced.Samples())
                                   : 0,
            .realTimeFrames = m_impl->realTime.FrameCount(),
            .realTimeMs = m_impl->realTime.ExpectedMs(size)};
}

uint32_t Viewport::ResetCount(passes::ResetCause cause) const {
    return m_impl->pathTraced.Samples().ResetCount(cause);
}

std::optional<CompareNumbers> Viewport::Numbers() {
    return m_impl->compare.Numbers();
}

double Viewport::LastFrameMs() const {
    return m_impl->lastFrameMs;
}

// --- The frames of a Viewport ---

namespace {

using passes::ResetCause;

// Limits how many frames without times are remembered; fewer are ever in flight.
constexpr size_t kMaxTimedFrames = 16;
// Limits how many frames a view keeps its memory in that do not show it, for views that are toggled.
constexpr uint32_t kMaxUnseenFrames = 60;

bool ShowsDenoised(const ShowSettings& show) {
    return show.view == View::PathTraced && show.isDenoised;
}

}  // namespace

void Viewport::Impl::ReleaseRealTime() {
    realTime.Release(renderer);
    realTimeDisplay.Release(renderer);
}

void Viewport::Impl::ReleaseDenoised() {
    denoised.Release(renderer);
    denoisedDisplay.Release(renderer);
}

void Viewport::Impl::ReleaseUnseen(const ShowSettings& shownAs) {
    const auto hasExpired = [](bool isShown, uint32_t& unseenFrames) {
        unseenFrames = isShown ? 0 : unseenFrames + 1;
        return unseenFrames == kMaxUnseenFrames;
    };
    if (hasExpired(shownAs.view == View::RealTime || ComparesRealTime(shownAs), framesWithoutRealTime))
        ReleaseRealTime();
    if (hasExpired(ShowsDenoised(RequestedAs()), framesWithoutDenoised)) ReleaseDenoised();
}

void Viewport::Impl::Restart(ResetCause cause) {
    pathTraced.Reset(cause);
    raster.Reset(cause);
    realTime.NoteChange(cause);
    realTimeErrors.NoteChange();
    changedAt = Clock::now();
}

void Viewport::Impl::DetectChanges() {
    DrawnInputs now{.scene = scene,
                    .revisions = scene->Revisions(),
                    .camera = camera,
                    .lens = lens,
                    .paths = paths,
                    .rasterSettings = rasterSettings,
                    .size = size};
    now.camera.aspect = 1.0f;  // the aspect ratio of the size applies
    if (drawnInputs) {
        const DrawnInputs& before = *drawnInputs;
        const bool isNewScene = before.scene != now.scene;
        const auto note = [&](bool hasChanged, ResetCause cause) {
            if (hasChanged) Restart(cause);
            return hasChanged;
        };
        const SceneRevisions &old = before.revisions, &current = now.revisions;
        const bool hasNewGeometry =
            note(isNewScene || old.geometry != current.geometry, ResetCause::Geometry);
        if (!isNewScene) {
            note(old.transforms != current.transforms || old.shapes != current.shapes, ResetCause::Transform);
            note(old.materials != current.materials, ResetCause::Material);
            note(old.lights != current.lights, ResetCause::Light);
            note(old.environment != current.environment, ResetCause::Environment);
        }
        if (isNewScene) raster.ReleaseEnvironment(renderer);
        if (isNewScene) outline.Invalidate();
        const bool hasMoved =
            note(!(before.camera == now.camera && before.lens == now.lens), ResetCause::Camera);
        if (hasMoved) movedAt = Clock::now();
        note(!(before.size == now.size), ResetCause::Resize);
        const bool hasNewPaths = note(!(before.paths == now.paths), ResetCause::Settings);
        if (!(before.rasterSettings == now.rasterSettings)) raster.Reset(ResetCause::Settings);
        if (hasNewGeometry || hasNewPaths) {
            budget.Reset();
            realTime.ResetTimings();
            timedFrames.clear();
        }
    }
    drawnInputs = std::move(now);
}

void Viewport::Impl::UpdateBudgets() {
    const FrameTiming& timing = renderer.Timing();
    while (!timedFrames.empty() && timedFrames.front().frame < timing.frame) timedFrames.pop_front();
    if (timedFrames.empty() || timedFrames.front().frame != timing.frame) return;
    const TimedFrame timed = std::move(timedFrames.front());
    timedFrames.pop_front();
    const auto between = [&](PassId first, PassId end) {
        double sum = 0.0;
        for (const PassTiming& pass : timing.passes)
            if (pass.id.index >= first.index && pass.id.index < end.index) sum += pass.gpuMs;
        return sum;
    };
    lastFrameMs = 0.0;
    for (const PassTiming& pass : timing.passes) lastFrameMs += pass.gpuMs;
    if (timed.rasterPixels > 0)
        budget.AddRasterTiming(timed.rasterPixels, between(timed.firstDrawing, timed.endDrawing));
    realTime.AddTiming(timed.realTime.pixels, between(timed.realTime.first, timed.realTime.end));
    double tracing = 0.0;
    for (const PathTracedView::Tile& tile : timed.tiles) {
        const double ms = between(tile.first, tile.end);
        tracing += ms;
        budget.AddTileTiming(tile.height, tile.region, ms / tile.sampleCount);
    }
    const double denoising = between(timed.denoised.first, timed.denoised.end);
    denoised.AddTimings(timing, timed.denoised, denoising, budget.Expect(size.height, passes::WholeOf(size)));
    // A picture that was denoised in one frame may have taken long: the frames after it are to trace as much
    // as those before
    const bool isWhole = timed.denoised.isBegun && timed.denoised.isComplete;
    // Without tracing time, the view was culled
    if (tracing > 0.0) budget.AddOverheadTiming(lastFrameMs - tracing - (isWhole ? denoising : 0.0));
}

bool Viewport::Impl::IsRecent(const std::optional<Clock::time_point>& time) const {
    return time &&
           std::chrono::duration<double, std::milli>(Clock::now() - *time).count() < budgetSettings.settleMs;
}

ShowSettings Viewport::Impl::RequestedAs() const {
    ShowSettings requested = show;
    if (!paths.isEnvironmentHidden) return requested;
    requested.compared = Compared::Raster;
    if (requested.view == View::RealTime) {
        requested.isDenoised = true;
        requested.view = View::PathTraced;
    }
    return requested;
}

ShowSettings Viewport::Impl::ShownAs() const {
    ShowSettings shown = RequestedAs();
    const MotionView motion = budgetSettings.whileMoving;
    const bool isReplaced =
        (motion == MotionView::Raster && IsRecent(movedAt)) ||
        (motion == MotionView::Auto && IsRecent(changedAt) && isRasterReady && !isPreview &&
         PathTracedView::Exceeds(size, kCoarsestMotion, budget, budget.TracingMs()));
    if (shown.view == View::PathTraced && isReplaced) shown.view = View::Raster;
    // A host may blend it over its window
    shown.tonemap.isUnassociated &= paths.isEnvironmentHidden;
    shown.tonemap.isOpaque = !shown.tonemap.isUnassociated;
    return shown;
}

BudgetSettings Viewport::Impl::Limits(const ShowSettings& shownAs) {
    BudgetSettings limits = budgetSettings;
    if (!ShowsDenoised(shownAs) || IsRecent(changedAt)) return limits;
    const passes::Accumulation& samples = pathTraced.Samples();
    const uint32_t stop = captures.HasUnanswered() ? samples.SampleCount() + 1 : denoised.NextStop(samples);
    limits.maxSamples = limits.maxSamples > 0 ? std::min(limits.maxSamples, stop) : stop;
    return limits;
}

TextureId Viewport::Impl::DisplayDenoised(const SceneIds& ids, const passes::TraceSettings& settings,
                                          const PathTracedView::Ids& traced, TextureId display,
                                          const passes::TonemapSettings& tonemap,
                                          const std::optional<passes::Backdrop>& backdrop) {
    const passes::Accumulation& samples = pathTraced.Samples();
    // While something changes or pipelines are made, nothing may take long
    if (traced.isPreview || IsRecent(changedAt)) {
        denoisedIds = denoised.DeclareLast(renderer, size, samples);
    } else {
        const bool isLast =
            budgetSettings.maxSamples > 0 && samples.Declared().sampleCount >= budgetSettings.maxSamples;
        constexpr double kFrameShare = 0.35;  // as much as tracing then gets
        denoisedIds =
            denoised.Declare(renderer, ids, settings, samples,
                             {.frameMs = kFrameShare * budgetSettings.frameMs,
                              .isWanted = isLast,
                              .isUrgent = captures.HasUnanswered(),
                              .mayWait = budgetSettings.whilePreparing == PreparingView::PathTraced});
    }
    if (!denoisedIds.picture.IsValid()) return display;
    const passes::Accumulation::Progress made{.sampleCount = denoisedIds.samples, .cursor = {}};
    const TextureId shown = denoisedDisplay.Declare(renderer,
                                                    {.mean = denoisedIds.picture,
                                                     .before = made,
                                                     .after = made,
                                                     .tiles = {},
                                                     .resetCount = denoisedIds.version},
                                                    tonemap, backdrop);
    // Only the denoised picture is seen, but samples go on as long as what is shown needs their display
    return passes::Wipe(renderer, shown, display, 1.0f);
}

TextureId Viewport::Impl::DeclareSurface(const SceneIds& ids, const passes::TraceSettings& settings) {
    const TextureId values = passes::ViewValues(renderer, ids, settings, show.surface,
                                                passes::FilmPosition::Center, passes::SurfaceSource::Drawing);
    return passes::PaintView(renderer, values, show.surface);
}

TextureId Viewport::Impl::Declare(const SceneIds& ids) {
    if (!declaredIn.expired())
        throw MakeError(ErrorKind::Usage, "Viewport \"{}\": declared twice in one frame", name);
    declaredIn = renderer.OpenFrame();
    DetectChanges();
    UpdateBudgets();
    const passes::TraceSettings settings = passes::FrameSettings(size, camera, lens, paths);
    declaredScene = ids;
    declaredSettings = settings;
    ShowSettings shownAs = ShownAs();
    ReleaseUnseen(shownAs);
    if (shownAs.view == View::RealTime) {
        if (const TextureId shown = DeclareRealTime(ids, settings, shownAs.tonemap); shown.IsValid())
            return shown;
        shownAs.view = View::PathTraced;
    }
    const PathTracedView::PreviewSettings preview{
        // A preview is nothing to compare with
        .isOn = budgetSettings.whilePreparing == PreparingView::Preview && shownAs.view == View::PathTraced,
        .canHold = pathTracedDisplay.HasLast(renderer, size),
        .gain = std::exp2(-shownAs.tonemap.exposureEv)};
    const PathTracedView::Ids traced =
        pathTraced.Declare(renderer, ids, settings, budget, Limits(shownAs), IsRecent(changedAt), preview);
    const uint64_t pixels = uint64_t{size.width} * size.height;
    const uint32_t fittingScale = budget.RasterScale(pixels);
    const uint32_t rasterScale = IsRecent(changedAt) ? fittingScale : 1;
    // A sample that exceeds the limit is drawn once, not repeatedly for smooth edges
    const uint32_t rasterSamples =
        fittingScale > 1 && shownAs.view == View::Raster ? 1 : budgetSettings.maxRasterSamples;
    const PassId firstOfRaster = renderer.NextPass();
    const RasterView::Ids drawn =
        raster.Declare(renderer, ids, settings, rasterSettings, rasterSamples, rasterScale);
    // Pipelines are made before a movement needs them
    if (budgetSettings.whileMoving == MotionView::Auto && budget.IsLimited())
        isRasterReady = renderer.PreparePipelines(firstOfRaster, renderer.NextPass());

    std::optional<passes::Backdrop> backdrop;
    if (paths.isEnvironmentHidden && shownAs.backdrop)
        backdrop = passes::DeclareBackdrop(renderer, ids, *shownAs.backdrop, blurredEnvironment,
                                           settings.camera, size, passes::WholeOf(size));
    const passes::Accumulation &tracedSamples = pathTraced.Samples(), &drawnSamples = raster.Samples();
    CompareView::Pictures pictures{.pathTraced = traced.radiance,
                                   .other = drawn.radiance,
                                   .pathTracedSamples = tracedSamples.Declared().sampleCount,
                                   .otherVersion = drawnSamples.Declared().sampleCount,
                                   .coarseness = pathTraced.Coarseness(),
                                   .resetCount = tracedSamples.ResetCount() + drawnSamples.ResetCount()};
    pictures.pathTracedDisplay = traced.isHeld
                                     ? pathTracedDisplay.DeclareLast(renderer)
                                     : pathTracedDisplay.Declare(renderer,
                                                                 {.mean = traced.samples.mean,
                                                                  .before = tracedSamples.Submitted(),
                                                                  .after = tracedSamples.Declared(),
                                                                  .tiles = pathTraced.TilesOfSamples(),
                                                                  .resetCount = tracedSamples.ResetCount(),
                                                                  .base = traced.base,
                                                                  .baseScale = traced.baseScale,
                                                                  .finer = traced.finer,
                                                                  .finerTile = traced.finerTile,
                                                                  .isPreview = traced.isPreview},
                                                                 shownAs.tonemap, backdrop);
    denoisedIds = {};
    if (ShowsDenoised(shownAs))
        pictures.pathTracedDisplay =
            DisplayDenoised(ids, settings, traced, pictures.pathTracedDisplay, shownAs.tonemap, backdrop);
    const bool isRedrawn = !(drawnSamples.Submitted() == drawnSamples.Declared());
    const bool isDrawn = isRedrawn || drawn.baseScale > 1;
    std::vector<passes::Region> drawnTiles;
    if (isRedrawn) drawnTiles.push_back(passes::WholeOf(size));
    pictures.otherDisplay = rasterDisplay.Declare(renderer,
                                                  {.mean = drawn.samples.mean,
                                                   .before = drawnSamples.Submitted(),
                                                   .after = drawnSamples.Declared(),
                                                   .tiles = std::move(drawnTiles),
                                                   .resetCount = drawnSamples.ResetCount(),
                                                   .base = drawn.base,
                                                   .baseScale = drawn.baseScale},
                                                  shownAs.tonemap, backdrop);
    TimedFrame timed{.frame = renderer.FrameNumber(),
                     .firstDrawing = drawn.firstDrawing,
                     .endDrawing = drawn.endDrawing,
                     .denoised = denoisedIds};
    if (ComparesRealTime(shownAs)) {
        timed.realTime = realTime.Declare(renderer, ids, settings, budgetSettings.frameMs, false);
        // Errors are computed from floats
        pictures.other = passes::Upscale(renderer, timed.realTime.picture, size);
        pictures.otherDisplay = DisplayRealTime(timed.realTime.picture, {}, shownAs.tonemap);
        pictures.otherVersion = realTime.FrameCount();
        realTimeErrors.Declare(
            renderer, {.picture = pictures.other,
                       .display = pictures.otherDisplay,
                       .samples = traced.samples,
                       .progress = tracedSamples.Declared(),
                       .referenceDisplay = pictures.pathTracedDisplay,
                       .pixelsPerDegree = shownAs.pixelsPerDegree,
                       .seconds = std::chrono::duration<double>(Clock::now().time_since_epoch()).count()});
    }
    const TextureId shown = shownAs.view == View::Surface ? DeclareSurface(ids, settings)
                                                          : compare.Declare(renderer, shownAs, pictures);

    std::optional<PixelRequests::Shown> pathTracedShown, rasterShown;
    if (ShowsPathTraced(shownAs.view)) pathTracedShown = {traced.samples, tracedSamples.Declared()};
    if (ShowsRaster(shownAs)) rasterShown = {drawn.samples, drawnSamples.Declared()};
    AnswerRequests(ids, settings, pathTracedShown, rasterShown);

    if (shownAs.view == View::Raster && isDrawn)
        timed.rasterPixels = pixels / (uint64_t{rasterScale} * rasterScale);
    if (ShowsPathTraced(shownAs.view)) timed.tiles = pathTraced.DeclaredTiles();
    isPreview = traced.isPreview;
    renderer.OnSubmitted([this, timed = std::move(timed)] { NoteTimed(timed); });
    return shown;
}

TextureId Viewport::Impl::DisplayRealTime(TextureId picture, const passes::Accumulation::Progress& blended,
                                          const passes::TonemapSettings& tonemap) {
    if (blended.sampleCount == 0 || !(blended == realTimeBlended)) ++realTimeVersion;
    realTimeBlended = blended;
    const passes::Accumulation::Progress whole{.sampleCount = 1, .cursor = {}};
    return realTimeDisplay.Declare(
        renderer,
        {.mean = picture, .before = whole, .after = whole, .tiles = {}, .resetCount = realTimeVersion},
        tonemap, {});
}

// Blends the kept picture with the samples that have been accumulated since.
TextureId Viewport::Impl::DisplayHandOver(TextureId picture, const passes::AccumulatedIds& accumulated,
                                          const passes::TonemapSettings& tonemap) {
    const passes::Accumulation& samples = pathTraced.Samples();
    const PassId first = renderer.NextPass();
    const TextureId blended = passes::HandOver(renderer, picture, accumulated, samples.Declared());
    const bool isReady = budgetSettings.whilePreparing != PreparingView::Preview ||
                         renderer.PreparePipelines(first, renderer.NextPass());
    if (!isReady) return DisplayRealTime(picture, {}, tonemap);
    return DisplayRealTime(blended, samples.Declared(), tonemap);
}

TextureId Viewport::Impl::DeclareRealTime(const SceneIds& ids, const passes::TraceSettings& settings,
                                          const passes::TonemapSettings& tonemap) {
    const RealTimeView::Ids filtered = realTime.Declare(renderer, ids, settings, budgetSettings.frameMs);
    if (budgetSettings.whilePreparing == PreparingView::Preview &&
        !renderer.PreparePipelines(filtered.first, filtered.end))
        return {};
    TimedFrame timed{.frame = renderer.FrameNumber(), .realTime = filtered};
    denoisedIds = {};
    TextureId shown;
    std::optional<PixelRequests::Shown> reference;
    const passes::Accumulation& samples = pathTraced.Samples();
    if (filtered.isSettled) {
        const passes::AccumulatedIds accumulated =
            pathTraced.DeclareSamples(renderer, ids, settings, budget, budgetSettings);
        timed.tiles = pathTraced.DeclaredTiles();
        reference = {accumulated, samples.Declared()};
        shown = DisplayHandOver(filtered.picture, accumulated, tonemap);
    } else {
        shown = DisplayRealTime(filtered.picture, {}, tonemap);
    }
    AnswerRequests(ids, settings, reference, {});
    isPreview = false;
    renderer.OnSubmitted([this, timed = std::move(timed)] { NoteTimed(timed); });
    return shown;
}

void Viewport::Impl::AnswerRequests(const SceneIds& ids, const passes::TraceSettings& settings,
                                    const std::optional<PixelRequests::Shown>& pathTracedShown,
                                    const std::optional<PixelRequests::Shown>& rasterShown) {
    requests.DeclarePicks(renderer, ids, settings);
    requests.DeclareInspections(renderer, size, pathTracedShown, rasterShown);
    requests.DeclareSamples(renderer, ids, settings,
                            budgetSettings.whilePreparing == PreparingView::PathTraced);
    if (pathTracedShown) errors.Declare(renderer, pathTracedShown->samples, pathTracedShown->progress);
    const auto answerCaptures = [&](const PixelRequests::Shown& shown, bool isRaster,
                                    const std::optional<TextureId>& denoisedPicture) {
        captures.Declare(renderer, ids, settings,
                         {.samples = shown.samples,
                          .progress = shown.progress,
                          .denoised = denoisedPicture,
                          .isRaster = isRaster,
                          .camera = camera,
                          .lens = lens,
                          .paths = paths,
                          .raster = rasterSettings,
                          .environment = scene->ShownEnvironment()});
    };
    const ShowSettings requested = RequestedAs();
    if (ShowsPathTraced(requested.view) && pathTracedShown) {
        // A picture that is to be denoised is, however long its pipelines take
        if (!ShowsDenoised(requested))
            answerCaptures(*pathTracedShown, false, {});
        else if (denoisedIds.picture.IsValid() &&
                 denoisedIds.samples == pathTracedShown->progress.sampleCount)
            answerCaptures(*pathTracedShown, false, denoisedIds.picture);
    } else if (requested.view == View::Raster && rasterShown) {
        answerCaptures(*rasterShown, true, {});
    }
}

void Viewport::Impl::NoteTimed(const TimedFrame& timed) {
    timedFrames.push_back(timed);
    if (timedFrames.size() > kMaxTimedFrames) timedFrames.pop_front();
}

TextureId Viewport::Impl::DeclareOutline(TextureId picture) {
    if (outline.IsEmpty() || !picture.IsValid() || show.view == View::SideBySide) return picture;
    if (declaredIn.expired())
        throw MakeError(ErrorKind::Usage, "Viewport \"{}\": DeclareOutline comes after Declare", name);
    const bool isMoving = budget.IsLimited() && IsRecent(changedAt);
    // These are the frame's: setters may have been called since Declare
    return outline.Declare(renderer, declaredScene, drawnInputs->revisions, drawnInputs->camera,
                           declaredSettings, outlineSettings, isMoving, picture);
}

}  // namespace raygraph::viewport
