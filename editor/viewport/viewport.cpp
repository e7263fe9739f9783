#include "editor/viewport/viewport.h"

#include "base/text.h"
#include "editor/viewport/viewport_impl.h"

namespace raygraph::viewport {

Viewport::Impl::Impl(Renderer& ofRenderer, GpuScene& ofScene, const ViewportDesc& desc)
    : renderer(ofRenderer),
      scene(&ofScene),
      name(desc.name),
      size(desc.size),
      pathTraced(desc.name),
      raster(desc.name),
      pathTracedDisplay(desc.name + ".path-traced.display"),
      rasterDisplay(desc.name + ".raster.display"),
      compare(desc.name),
      outline(desc.name + ".outline") {}

Viewport::Viewport(Renderer& renderer, GpuScene& scene, const ViewportDesc& desc)
    : m_impl(std::make_unique<Impl>(renderer, scene, desc)) {}

Viewport::~Viewport() {
    // It would refer to destroyed objects
    if (!m_impl->declaredIn.expired()) m_impl->renderer.DropFrame();
    m_impl->pathTraced.Forget(m_impl->renderer);
    m_impl->raster.Forget(m_impl->renderer);
    m_impl->pathTracedDisplay.Forget(m_impl->renderer);
    m_impl->rasterDisplay.Forget(m_impl->renderer);
    m_impl->compare.Forget(m_impl->renderer);
    m_impl->outline.Forget(m_impl->renderer);
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
    const CachedDisplay& first =
        ShowsRaster(m_impl->ShownView()) ? m_impl->rasterDisplay : m_impl->pathTracedDisplay;
    const TextureId kept = first.DeclareLast(m_impl->renderer);
    if (kept.IsValid()) return kept;
    const CachedDisplay& other =
        &first == &m_impl->rasterDisplay ? m_impl->pathTracedDisplay : m_impl->rasterDisplay;
    return other.DeclareLast(m_impl->renderer);
}

uint64_t Viewport::RenderFrame() {
    if (m_impl->size.IsEmpty()) return 0;
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

Capture Viewport::RequestCapture() {
    return m_impl->captures.Request();
}

NoiseRequest Viewport::RequestNoise() {
    return m_impl->errors.Request();
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
            .isPreview = m_impl->isPreview};
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

}  // namespace raygraph::viewport
