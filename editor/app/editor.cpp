#include "editor/app/editor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>

#include "base/stopwatch.h"
#include "base/text.h"
#include "editor/app/panels.h"

namespace raygraph::editor {

namespace {

constexpr float kSide = 300.0f;        // points: maximal width of the side panels
constexpr float kSideShare = 0.24f;    // their width as a fraction of the window's
constexpr float kBottom = 230.0f;      // points: minimal height of the lower panel
constexpr float kBottomShare = 0.34f;  // its height as a fraction of the window's
constexpr float kStatus = 28.0f;
constexpr float kOutline = 2.0f;
constexpr ImGuiWindowFlags kFixed = ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize |
                                    ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings |
                                    ImGuiWindowFlags_NoBringToFrontOnFocus;

// Draws a panel at a fixed place.
template <typename Body>
void Panel(const char* title, ImVec2 position, ImVec2 size, Body&& body) {
    ImGui::SetNextWindowPos(position);
    ImGui::SetNextWindowSize(size);
    if (ImGui::Begin(title, nullptr, kFixed)) body();
    ImGui::End();
}

constexpr double kPipelineLifetime = 300.0;  // in seconds of frames that do not use the pipeline

}  // namespace

Editor::Editor(rhi::Device& device, EditorOptions options)
    : m_work(device, options.shaders, std::move(options.log), options.textureBudget) {}

bool Editor::IsBusy() const {
    return m_work.IsLoading() || m_isPicking || !m_saving.empty() || !m_savingRenders.empty() ||
           m_worker.IsBusy() || !m_pictureFile.empty() || !m_windowFile.empty();
}

bool Editor::IsPreparing() const {
    const bool isPreview =
        viewport::ShowsPathTraced(m_work.view.Show().view) && m_work.view.Progress().isPreview;
    // Each frame copies a part of an arriving scene
    const bool isMoving = (m_work.IsLoading() && !m_work.loader.IsLoading()) || m_work.timeline.IsPlaying();
    return !isMoving && (m_isAwaiting || m_isPreparing || isPreview);
}

void Editor::ChooseBudget(const FrameInput& input) {
    constexpr float kIdleSeconds = 1.0f;
    constexpr double kIdleFactor = 4.0;
    m_idleSeconds = input.IsActiveSince(m_lastInput) ? 0.0f : m_idleSeconds + input.seconds;
    m_lastInput = input;
    viewport::BudgetSettings budget = m_work.view.Budget();
    const bool isLong = m_work.allowsLongFrames && m_idleSeconds > kIdleSeconds;
    budget.frameMs = m_work.frameMs * (isLong ? kIdleFactor : 1.0);
    m_work.view.SetBudget(budget);
}

bool Editor::Frame(const FrameInput& given, Screen& screen) {
    FrameInput ignored;
    ignored.extent = given.extent;
    ignored.scale = given.scale;
    const FrameInput& input = m_isQuitting ? ignored : given;
    m_work.renderer.ForgetPipelines(kPipelineLifetime);
    if (m_isReloading && !m_isQuitting && !m_work.renderer.IsPreparingPipelines()) ReloadShaders();
    FinishLoading();
    for (const std::filesystem::path& file : input.dropped) Open(file);
    ApplyPick();
    FinishSaving();
    m_work.Observe();
    if (input.isClosing) Leave();
    if (input.extent.IsEmpty()) return !m_isQuitting || IsSaving(false);
    const auto points = [&](uint32_t pixels) {
        return static_cast<uint32_t>(std::lround(static_cast<float>(pixels) / input.scale));
    };
    m_windowSize = {points(input.extent.width), points(input.extent.height)};
    ChooseBudget(input);
    m_work.Animate(IsPlaybackPaused() ? 0.0 : double{input.seconds});
    const Stopwatch watch;
    m_ui.Begin(input);
    Keys(input);
    Mouse(input);
    BuildUi(input);
    m_ui.End();
    m_work.uiMs = watch.Milliseconds();
    const bool hasDrawn = Draw(screen, input);
    return !m_isQuitting || IsSaving(hasDrawn);
}

bool Editor::IsPlaybackPaused() const {
    const bool isTakingPictures = m_work.view.Show().view != viewport::View::Surface;
    return m_gizmo.IsHeld() ||
           (isTakingPictures && std::ranges::any_of(m_savingRenders, std::not_fn(&SavingRender::isTaken)));
}

bool Editor::DrawFrame(Screen& screen, const FrameInput& input) {
    Renderer& renderer = m_work.renderer;
    m_work.view.SetCamera(m_work.camera.View());
    m_work.view.SetOutline({.width = std::min(kOutline * input.scale, 8.0f)});
    renderer.BeginFrame();
    const std::optional<TextureId> target = screen.Begin(renderer, input.extent);
    if (!target) {
        renderer.DropFrame();
        return false;
    }
    const TextureId picture = m_work.view.Declare();
    const TextureId drawn = m_ui.Draw(renderer, *target, m_work.view.DeclareOutline(picture));
    if (!m_pictureFile.empty() && picture.IsValid() && !m_work.view.Progress().isPreview)
        m_saving.push_back({std::exchange(m_pictureFile, {}), renderer.ReadBack(picture), false});
    if (!m_windowFile.empty())
        m_saving.push_back({std::exchange(m_windowFile, {}), renderer.ReadBack(drawn),
                            renderer.Desc(drawn).format == rhi::Format::Bgra8Unorm});
    m_isPreparing = !screen.TryEnd(renderer, drawn);
    return !m_isPreparing;
}

void Editor::DrawLastPicture(Screen& screen, const FrameInput& input) {
    Renderer& renderer = m_work.renderer;
    renderer.BeginFrame();
    if (m_work.IsLoading()) static_cast<void>(m_work.gpu.Declare(renderer));  // declares the copies
    if (const std::optional<TextureId> target = screen.Begin(renderer, input.extent))
        screen.End(renderer, m_ui.Draw(renderer, *target, m_work.view.DeclareLastPicture()));
    else
        renderer.DropFrame();
}

bool Editor::Draw(Screen& screen, const FrameInput& input) {
    Renderer& renderer = m_work.renderer;
    m_frameError.clear();
    const std::filesystem::path picturePath = m_pictureFile, windowPath = m_windowFile;
    const size_t savingBefore = m_saving.size();
    // Readbacks of a dropped frame never arrive, so the next frame saves
    const auto drop = [&] {
        renderer.DropFrame();
        m_saving.erase(m_saving.begin() + static_cast<std::ptrdiff_t>(savingBefore), m_saving.end());
        m_pictureFile = picturePath;
        m_windowFile = windowPath;
    };
    try {
        m_isAwaiting = m_work.IsLoading() && m_work.document.File().empty() && !m_work.hasDrawn &&
                       m_work.view.Budget().whilePreparing == viewport::PreparingView::Preview;
        const bool isDrawn = !m_isAwaiting && DrawFrame(screen, input);
        if (m_isAwaiting || m_isPreparing) {
            drop();
            DrawLastPicture(screen, input);
        }
        if (!isDrawn) return false;
        HandleCaptures();
        m_work.hasDrawn = true;
        m_droppedFrame.clear();
        return true;
    } catch (const Error& error) {
        if (error.Kind() == ErrorKind::DeviceLost || error.Kind() == ErrorKind::OutOfMemory) throw;
        m_frameError = error.what();
        m_work.ReportErrorOnce(m_frameError, m_droppedFrame, log_category::kGraph);
        drop();
        return false;
    }
}

void Editor::MenuEntries(Menu menu) {
    for (const ActionRow& row : Actions()) {
        if (row.menu != menu) continue;
        if (row.beginsGroup) ImGui::Separator();
        const std::string key = row.keys[0] ? KeyText(*row.keys[0]) : "";
        if (ImGui::MenuItem(row.label, key.c_str(), IsOn(row.action), CanDo(row.action))) Do(row.action);
        if (row.action == Action::Open && ImGui::BeginMenu("Recent", !m_work.recent.empty())) {
            for (const std::filesystem::path& file : std::vector(m_work.recent))
                if (ImGui::MenuItem(file.c_str())) Open(file);
            ImGui::EndMenu();
        }
    }
}

void Editor::MenuBar() {
    if (!ImGui::BeginMainMenuBar()) return;
    if (ImGui::BeginMenu("File")) {
        MenuEntries(Menu::FileMenu);
        ImGui::EndMenu();
    }
    if (ImGui::BeginMenu("Edit")) {
        MenuEntries(Menu::EditMenu);
        ImGui::EndMenu();
    }
    if (ImGui::BeginMenu("Camera")) {
        const std::vector<scene::Camera>& cameras = m_work.document.Scene().cameras;
        for (uint32_t i = 0; i < cameras.size(); ++i) {
            const std::string name = cameras[i].name.empty() ? Text("Camera {}", i) : cameras[i].name;
            if (ImGui::MenuItem(Text("{}##{}", name, i).c_str())) m_work.UseCamera(i);
        }
        MenuEntries(Menu::CameraMenu);
        ImGui::EndMenu();
    }
    if (ImGui::BeginMenu("Animation")) {
        MenuEntries(Menu::AnimationMenu);
        ImGui::EndMenu();
    }
    if (ImGui::BeginMenu("Panels")) {
        MenuEntries(Menu::PanelMenu);
        ImGui::EndMenu();
    }
    ImGui::EndMainMenuBar();
}

void Editor::BuildUi(const FrameInput& input) {
    MenuBar();
    m_dialog.Draw();
    m_unsaved.Draw(input);
    const ImVec2 window = ImGui::GetIO().DisplaySize;
    const float side = std::floor(std::min(kSide, kSideShare * window.x));
    const float top = ImGui::GetFrameHeight(), bottom = window.y - kStatus;
    float left = 0.0f, right = window.x, lower = bottom;
    if (m_work.panels.hierarchy) {
        Panel("Scene", {0.0f, top}, {side, bottom - top}, [&] { HierarchyPanel(m_work); });
        left = side;
    }
    if (m_work.panels.inspector) {
        const float x = window.x - side, half = std::floor(top + 0.58f * (bottom - top));
        Panel("Inspector", {x, top}, {side, half - top}, [&] { InspectorPanel(m_work); });
        Panel("View", {x, half}, {side, bottom - half}, [&] { SettingsPanel(m_work); });
        right = x;
    }
    lower = bottom - LowerPanels(left, right, bottom);
    lower -= TimelineStrip(left, right, lower);
    ViewArea(input, left, top, right - left, lower - top);
    StatusBar(bottom, window.x, kStatus);
    if (m_work.panels.help) {
        ImGui::SetNextWindowPos({0.5f * window.x, 0.5f * window.y}, ImGuiCond_Always, {0.5f, 0.5f});
        if (ImGui::Begin("Help", &m_work.panels.help,
                         ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoSavedSettings))
            HelpPanel();
        ImGui::End();
    }
}

// Places the panels side by side with equal widths; returns their height.
float Editor::LowerPanels(float left, float right, float bottom) {
    struct Lower {
        const char* title;
        bool isShown;
        void (*draw)(Workspace&);
    };
    const std::array panels{Lower{"Statistics", m_work.panels.statistics, StatisticsPanel},
                            Lower{"Render graph", m_work.panels.graph, GraphPanel},
                            Lower{"Log", m_work.panels.log, LogPanel}};
    const auto count = static_cast<float>(std::ranges::count_if(panels, &Lower::isShown));
    if (count == 0.0f) return 0.0f;
    const float height = std::floor(std::max(kBottom, kBottomShare * ImGui::GetIO().DisplaySize.y));
    float x = left, taken = 0.0f;
    for (const Lower& panel : panels) {
        if (!panel.isShown) continue;
        const float end = std::floor(left + (right - left) * ++taken / count);
        Panel(panel.title, {x, bottom - height}, {end - x, height}, [&] { panel.draw(m_work); });
        x = end;
    }
    return height;
}

// Draws the timeline below the picture; returns its height.
float Editor::TimelineStrip(float left, float right, float bottom) {
    if (!m_work.panels.timeline || m_work.timeline.IsEmpty()) return 0.0f;
    const ImGuiStyle& style = ImGui::GetStyle();
    const float height =
        std::ceil(2.0f * ImGui::GetFrameHeight() + style.ItemSpacing.y + 2.0f * style.WindowPadding.y);
    ImGui::SetNextWindowPos({left, bottom - height});
    ImGui::SetNextWindowSize({right - left, height});
    if (ImGui::Begin("Timeline", nullptr, kFixed | ImGuiWindowFlags_NoTitleBar)) TimelinePanel(m_work);
    ImGui::End();
    return height;
}

void Editor::ViewArea(const FrameInput& input, float left, float top, float width, float height) {
    const auto pixels = [&](float points) { return static_cast<int>(std::lround(points * input.scale)); };
    m_viewOrigin = {pixels(left), pixels(top)};
    const int across = std::max(pixels(left + width) - m_viewOrigin.x, 0);
    const int down = std::max(pixels(top + height) - m_viewOrigin.y, 0);
    m_work.view.SetSize({static_cast<uint32_t>(across), static_cast<uint32_t>(down)});
    if (across == 0 || down == 0) return;
    ImGui::SetNextWindowPos({left, top});
    ImGui::SetNextWindowSize({width, height});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0.0f, 0.0f});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 0.0f);
    ImGui::Begin("Picture", nullptr,
                 kFixed | ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoScrollWithMouse |
                     ImGuiWindowFlags_NoBackground);
    ImGui::PopStyleVar(2);
    // One pixel of the picture is one of the window
    const ImVec2 corner{static_cast<float>(m_viewOrigin.x) / input.scale,
                        static_cast<float>(m_viewOrigin.y) / input.scale};
    ImGui::GetWindowDrawList()->AddImage(PictureTexture(), corner,
                                         {corner.x + static_cast<float>(across) / input.scale,
                                          corner.y + static_cast<float>(down) / input.scale});
    m_gizmo.Draw(m_work, corner, glm::vec2(across, down) / input.scale);
    if (m_work.selectedNode) {
        ImGui::SetCursorPos({8.0f, 8.0f});
        GizmoButtons(m_work);
    }
    m_isViewHovered = ImGui::IsWindowHovered() && !ImGui::IsAnyItemHovered();
    if (const std::optional<SceneLoader::Progress> progress = m_work.LoadProgress()) {
        ImGui::SetCursorPos({0.5f * width - 160.0f, 0.5f * height});
        ImGui::ProgressBar(progress->fraction, {320.0f, 0.0f}, progress->stage.c_str());
    } else if (IsPreparing()) {
        const char* text =
            m_isPreparing ? "Making the shaders for this picture" : "Preview: the path tracer is being made";
        const ImVec2 size = ImGui::CalcTextSize(text);
        ImGui::SetCursorPos(
            {0.5f * (width - size.x), m_isPreparing ? 0.5f * height : height - 2.0f * size.y});
        ImGui::TextUnformatted(text);
    }
    ImGui::End();
}

void Editor::StatusBar(float top, float width, float height) {
    ImGui::SetNextWindowPos({0.0f, top});
    ImGui::SetNextWindowSize({width, height});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {10.0f, 5.0f});
    ImGui::Begin("Status", nullptr, kFixed | ImGuiWindowFlags_NoDecoration);
    ImGui::PopStyleVar();
    const viewport::ViewportProgress progress = m_work.view.Progress();
    const viewport::View view = m_work.view.Show().view;
    ImGui::Text("%s", Name(view));
    ImGui::SameLine();
    const Extent2D size = m_work.view.Size();
    ImGui::TextDisabled("%ux%u  %u samples  %.1f ms", size.width, size.height,
                        viewport::ShowsPathTraced(view) ? progress.pathTracedSamples : progress.rasterSamples,
                        m_work.view.LastFrameMs());
    if (IsMeasured(view))
        if (const std::optional<viewport::CompareNumbers> numbers = m_work.view.Numbers()) {
            ImGui::SameLine();
            ImGui::Text("mean %.4f, maximum %.3f", numbers->numbers.mean, numbers->numbers.maximum);
        }
    if (!m_work.message.empty()) {
        ImGui::SameLine();
        ImGui::TextColored({0.91f, 0.56f, 0.20f, 1.0f}, "  %s", m_work.message.c_str());
    }
    ImGui::End();
}

}  // namespace raygraph::editor
