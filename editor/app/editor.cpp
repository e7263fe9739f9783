#include "editor/app/editor.h"

#include <imgui_internal.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>

#include "base/files.h"
#include "base/printable.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "editor/app/file_content.h"
#include "editor/app/panels.h"
#include "editor/app/render_words.h"
#include "editor/app/scene_icons.h"
#include "renderer/graph/readback_values.h"
#include "renderer/image/exr.h"
#include "renderer/image/image.h"

namespace raygraph::editor {

namespace {

constexpr float kMessageSeconds = 8.0f;
constexpr float kWideSide = 300.0f, kLeastPanel = 100.0f;   // points: widths of the side panels
constexpr float kSideShare = 0.26f, kMostSideShare = 0.4f;  // of the window's width; the latter by choice
constexpr float kBottom = 230.0f;                           // points: minimal height of the lower panel
constexpr float kBottomShare = 0.34f;  // height of the lower panel as a fraction of the window's
constexpr float kStatus = 28.0f;
constexpr float kOutline = 2.0f;
constexpr ImGuiWindowFlags kFixed = ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize |
                                    ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings |
                                    ImGuiWindowFlags_NoBringToFrontOnFocus;

// Draws a panel at a fixed position.
template <typename Body>
void Panel(const char* title, ImVec2 position, ImVec2 size, Body&& body) {
    ImGui::SetNextWindowPos(position);
    ImGui::SetNextWindowSize(size);
    if (ImGui::Begin(title, nullptr, kFixed)) body();
    ImGui::End();
}

// Draws a border between panels. Returns the mouse's place while the user drags it, and 0 after a double
// click, which gives the panel its own size back.
std::optional<ImVec2> Border(const char* name, ImVec2 from, ImVec2 to) {
    constexpr float kBorderReach = 3.0f;
    const bool isUpright = from.x == to.x;
    const ImVec2 reach = isUpright ? ImVec2{kBorderReach, 0.0f} : ImVec2{0.0f, kBorderReach};
    const ImVec2 size{std::max(to.x - from.x + 2.0f * reach.x, 1.0f),
                      std::max(to.y - from.y + 2.0f * reach.y, 1.0f)};
    ImGui::SetNextWindowPos({from.x - reach.x, from.y - reach.y});
    ImGui::SetNextWindowSize(size);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0.0f, 0.0f});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, {1.0f, 1.0f});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 0.0f);
    ImGui::Begin(name, nullptr,
                 (kFixed & ~ImGuiWindowFlags_NoBringToFrontOnFocus) | ImGuiWindowFlags_NoDecoration |
                     ImGuiWindowFlags_NoBackground | ImGuiWindowFlags_NoFocusOnAppearing);
    ImGui::InvisibleButton(name, size);
    const bool isHeld = ImGui::IsItemActive(),
               isReset = ImGui::IsItemHovered() && ImGui::IsMouseDoubleClicked(0);
    if (isHeld || ImGui::IsItemHovered()) {
        ImGui::SetMouseCursor(isUpright ? ImGuiMouseCursor_ResizeEW : ImGuiMouseCursor_ResizeNS);
        ImGui::GetWindowDrawList()->AddLine(from, to, ImGui::GetColorU32(ImGuiCol_SeparatorHovered), 2.0f);
    }
    ImGui::End();
    ImGui::PopStyleVar(3);
    if (isReset) return ImVec2{0.0f, 0.0f};
    const ImVec2 dragged = ImGui::GetMouseDragDelta(0, 1.0f);
    if (!isHeld || (dragged.x == 0.0f && dragged.y == 0.0f)) return std::nullopt;
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    return ImVec2{std::max(mouse.x, 1.0f), std::max(mouse.y, 1.0f)};
}

// Returns the width of a side panel of which the user has chosen `chosen` points, or 0.
float SideWidth(float chosen, float window) {
    const float own = std::min(kSideShare * window, kWideSide);
    return std::floor(chosen > 0.0f ? std::min(std::max(chosen, kLeastPanel), kMostSideShare * window) : own);
}

// Draws what is seen through a transparent picture.
void DrawCheckers(ImVec2 corner, ImVec2 size) {
    constexpr float kSquare = 16.0f, kMostRows = 60.0f;  // points
    constexpr ImU32 kDark = IM_COL32(96, 96, 96, 255), kLight = IM_COL32(140, 140, 140, 255);
    const float side = std::max(kSquare, std::ceil(size.y / kMostRows));
    ImDrawList& list = *ImGui::GetWindowDrawList();
    const ImVec2 end{corner.x + size.x, corner.y + size.y};
    list.AddRectFilled(corner, end, kDark);
    list.PushClipRect(corner, end, true);
    for (float y = 0.0f; y < size.y; y += side)
        for (float x = std::fmod(y, 2.0f * side); x < size.x; x += 2.0f * side)
            list.AddRectFilled({corner.x + x, corner.y + y}, {corner.x + x + side, corner.y + y + side},
                               kLight);
    list.PopClipRect();
}

constexpr double kPipelineLifetime = 300.0;  // in seconds of frames that do not use the pipeline

}  // namespace

Editor::Editor(rhi::Device& device, EditorOptions options)
    : m_work(device, options.shaders, std::move(options.log), options.textureBudget),
      m_render(std::move(options.render)) {}

bool Editor::IsBusy() const {
    return m_work.IsLoading() || m_isPicking || m_work.IsFocusPending() || m_work.explained.IsPending() ||
           !m_saving.empty() || !m_savingRenders.empty() || m_render.Queue().IsBusy() || m_worker.IsBusy() ||
           !m_pictureFile.empty() || !m_windowFile.empty();
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
    m_work.renderer.ReleasePipelines(kPipelineLifetime);
    if (m_isReloading && !m_isQuitting && !m_work.renderer.IsPreparingPipelines()) ReloadShaders();
    FinishLoading();
    for (const std::filesystem::path& file : input.dropped) Open(file);
    ApplyPick();
    FinishSaving();
    m_render.Update(m_work);
    m_work.Observe();
    if (input.isClosing) Leave();
    if (input.extent.IsEmpty()) return !m_isQuitting || IsSaving(false);
    const auto points = [&](uint32_t pixels) {
        return static_cast<uint32_t>(std::lround(static_cast<float>(pixels) / input.scale));
    };
    m_windowSize = {points(input.extent.width), points(input.extent.height)};
    ChooseBudget(input);
    m_work.Animate(IsPlaybackPaused() ? 0.0 : double{input.seconds});
    m_work.messageAge += input.seconds;
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

bool Editor::HasSample() const {
    const viewport::ViewportProgress progress = m_work.view.Progress();
    return !progress.isPreview &&
           (!viewport::ShowsPathTraced(m_work.view.Show().view) || progress.pathTracedSamples > 0);
}

bool Editor::IsPlaybackPaused() const {
    const bool isTakingPictures = m_work.view.Show().view != viewport::View::Surface;
    return m_gizmo.IsHeld() || !m_pictureFile.empty() ||
           (isTakingPictures && std::ranges::any_of(m_savingRenders, std::not_fn(&SavingRender::isTaken)));
}

bool Editor::DrawFrame(Screen& screen, const FrameInput& input) {
    Renderer& renderer = m_work.renderer;
    m_work.ShowBackdrop();
    m_work.view.SetCamera(RenderedView(m_work), m_work.Lens());
    m_work.view.SetOutline({.width = std::min(kOutline * input.scale, 8.0f)});
    renderer.BeginFrame();
    const std::optional<TextureId> target = screen.Begin(renderer, input.extent);
    if (!target) {
        renderer.DropFrame();
        return false;
    }
    const TextureId picture = m_work.view.Declare();
    const TextureId outlined = m_work.view.DeclareOutline(picture);
    const TextureId drawn = m_ui.Draw(renderer, *target, outlined,
                                      m_work.thumbnails.Declare(renderer, m_work.gpu, m_work.document));
    if (!m_pictureFile.empty() && picture.IsValid() && HasSample())
        m_saving.push_back({std::exchange(m_pictureFile, {}), renderer.ReadBack(picture), false, true,
                            m_work.view.Progress().denoisedSamples});
    if (!m_windowFile.empty())
        m_saving.push_back({std::exchange(m_windowFile, {}), renderer.ReadBack(drawn),
                            renderer.Desc(drawn).format == rhi::Format::Bgra8Unorm, false});
    m_isPreparing = !screen.TryEnd(renderer, drawn);
    return !m_isPreparing;
}

void Editor::DrawLastPicture(Screen& screen, const FrameInput& input) {
    Renderer& renderer = m_work.renderer;
    renderer.BeginFrame();
    if (m_work.IsLoading()) static_cast<void>(m_work.gpu.Declare(renderer));  // declares the copies
    if (const std::optional<TextureId> target = screen.Begin(renderer, input.extent))
        screen.End(renderer, m_ui.Draw(renderer, *target, m_work.view.DeclareLastPicture(), {}));
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
        m_work.ContinueChoosingView();
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
        const std::optional<KeyPress>& key = m_work.keys.Of(row.action)[0];
        if (ImGui::MenuItem(row.label, key ? MenuKey(KeyText(*key)).c_str() : "", IsOn(row.action),
                            WhyNot(row.action).empty()))
            Perform(row.action);
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
    if (ImGui::BeginMenu("Add")) {
        MenuEntries(Menu::AddMenu);
        ImGui::EndMenu();
    }
    if (ImGui::BeginMenu("Camera")) {
        const std::vector<scene::Camera>& cameras = m_work.document.Scene().cameras;
        for (uint32_t i = 0; i < cameras.size(); ++i) {
            if (!m_work.document.IsPresent(cameras[i].node)) continue;
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

// Draws the menu *Add* of the key, which opens at the pointer.
void Editor::AddMenu() {
    if (std::exchange(m_opensAddMenu, false)) ImGui::OpenPopup("Add");
    if (!ImGui::BeginPopup("Add")) return;
    ImGui::TextDisabled("Add");
    MenuEntries(Menu::AddMenu);
    ImGui::EndPopup();
}

void Editor::BuildUi(const FrameInput& input) {
    MenuBar();
    AddMenu();
    m_dialog.Draw(m_work.recent);
    m_render.Draw(m_work, m_dialog);
    m_unsaved.Draw(input);
    if (m_work.imageToReplace) ShowReplaceImageDialog(*std::exchange(m_work.imageToReplace, std::nullopt));
    const ImVec2 window = ImGui::GetIO().DisplaySize;
    PanelSizes& sizes = m_work.panelSizes;
    const float top = ImGui::GetFrameHeight(), bottom = window.y - kStatus;
    float left = 0.0f, right = window.x, lower = bottom;
    m_work.isHierarchyFocused = false;
    if (m_work.panels.hierarchy) {
        left = SideWidth(sizes.left, window.x);
        Panel("Scene", {0.0f, top}, {left, bottom - top}, [&] { HierarchyPanel(m_work); });
        if (const auto mouse = Border("left border", {left, top}, {left, bottom}))
            sizes.left = mouse->x > 0.0f ? std::max(mouse->x, kLeastPanel) : 0.0f;
    }
    if (m_work.panels.inspector) {
        const float side = SideWidth(sizes.right, window.x), x = window.x - side;
        const float half = std::floor(top + sizes.inspector * (bottom - top));
        Panel("Inspector", {x, top}, {side, half - top}, [&] { InspectorPanel(m_work); });
        Panel("View", {x, half}, {side, bottom - half}, [&] { SettingsPanel(m_work); });
        if (const auto mouse = Border("right border", {x, top}, {x, bottom}))
            sizes.right = mouse->x > 0.0f ? std::max(window.x - mouse->x, kLeastPanel) : 0.0f;
        if (const auto mouse = Border("inspector border", {x, half}, {window.x, half}))
            sizes.inspector = mouse->y > 0.0f ? std::clamp((mouse->y - top) / std::max(bottom - top, 1.0f),
                                                           kInspectorRange.min, kInspectorRange.max)
                                              : PanelSizes().inspector;
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
            HelpPanel(m_work);
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
                            Lower{"Log", m_work.panels.log, LogPanel},
                            Lower{"Path", m_work.panels.path, PathPanel}};
    const auto count = static_cast<float>(std::ranges::count_if(panels, &Lower::isShown));
    if (count == 0.0f) return 0.0f;
    PanelSizes& sizes = m_work.panelSizes;
    const float window = ImGui::GetIO().DisplaySize.y;
    const float own = std::max(kBottom, kBottomShare * window);
    const float height = std::floor(
        sizes.lower > 0.0f ? std::clamp(sizes.lower, kLeastPanel, std::max(kLeastPanel, 0.7f * window))
                           : own);
    if (const auto mouse = Border("lower border", {left, bottom - height}, {right, bottom - height}))
        sizes.lower = mouse->y > 0.0f ? std::max(bottom - mouse->y, kLeastPanel) : 0.0f;
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
    if (!m_work.backdrop)
        DrawCheckers(corner,
                     {static_cast<float>(across) / input.scale, static_cast<float>(down) / input.scale});
    ImGui::GetWindowDrawList()->AddImage(PictureTexture(), corner,
                                         {corner.x + static_cast<float>(across) / input.scale,
                                          corner.y + static_cast<float>(down) / input.scale});
    DrawPath(m_work, corner, glm::vec2(across, down) / input.scale);
    DrawIcons(m_work, corner, glm::vec2(across, down) / input.scale);
    m_gizmo.Draw(m_work, corner, glm::vec2(across, down) / input.scale);
    DrawComparison(m_work, corner, glm::vec2(across, down) / input.scale);
    if (m_work.selectedNode) {
        ImGui::SetCursorPos({8.0f, 8.0f});
        GizmoButtons(m_work);
    }
    m_isViewHovered = ImGui::IsWindowHovered() && !ImGui::IsAnyItemHovered() && !ImGui::IsAnyItemActive();
    if (const std::optional<SceneLoader::Progress> progress = m_work.LoadProgress()) {
        ImGui::SetCursorPos({0.5f * width - 160.0f, 0.5f * height});
        ImGui::ProgressBar(progress->fraction, {320.0f, 0.0f}, progress->stage.c_str());
    } else if (IsPreparing()) {
        const char* text =
            m_isPreparing ? "Making the shaders for this picture" : "Preview: the path tracer is being made";
        const ImVec2 size = ImGui::CalcTextSize(text);
        TextOverPicture({corner.x + 0.5f * (width - size.x),
                         corner.y + (m_isPreparing ? 0.5f * height : height - 2.0f * size.y)},
                        text);
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
    const viewport::ShowSettings& show = m_work.view.Show();
    const viewport::View view = show.view;
    ImGui::Text("%s%s", Name(view), viewport::ComparesRealTime(show) ? " of real-time" : "");
    ImGui::SameLine();
    const Extent2D size = m_work.view.Size();
    const uint32_t samples =
        viewport::ShowsPathTraced(view) ? progress.pathTracedSamples : progress.rasterSamples;
    ImGui::TextDisabled("%ux%u  %s  %.1f ms", size.width, size.height, Counted(samples, "sample").c_str(),
                        m_work.view.LastFrameMs());
    if (progress.denoisedSamples > 0) {
        ImGui::SameLine();
        ImGui::TextDisabled("denoised at %u", progress.denoisedSamples);
    }
    if (IsMeasured(view))
        if (const std::optional<viewport::CompareNumbers> numbers = m_work.view.Numbers()) {
            ImGui::SameLine();
            ImGui::Text("mean %.4f, maximum %.3f, against %s", numbers->numbers.mean,
                        numbers->numbers.maximum, Counted(numbers->pathTracedSamples, "sample").c_str());
        }
    m_render.DrawStatus();
    if (!m_work.message.empty()) {
        ImGui::SameLine();
        ImVec4 color = m_work.isMessageError ? ImVec4{0.95f, 0.38f, 0.33f, 1.0f}
                                             : ImGui::GetStyleColorVec4(ImGuiCol_Text);
        color.w = std::clamp(kMessageSeconds - m_work.messageAge, 0.0f, 1.0f);  // it fades in the last second
        ImGui::TextColored(color, "  %s", m_work.message.c_str());
    }
    ImGui::End();
}

// --- Keys and mouse ---

namespace {

constexpr float kTurn = 0.006f;       // radians per point of mouse movement
constexpr float kClickReach = 4.0f;   // points of movement that still count as a click
constexpr float kFlySpeed = 0.6f;     // distances to the pivot per second
constexpr float kLongestStep = 0.1f;  // seconds: longest time step of a frame's flight

// Closes menus, lists and color pickers, but no dialog.
void CloseMenus() {
    const ImVector<ImGuiPopupData>& open = ImGui::GetCurrentContext()->OpenPopupStack;
    int first = open.Size;
    while (first > 0 && open[first - 1].Window && !(open[first - 1].Window->Flags & ImGuiWindowFlags_Modal))
        --first;
    if (first < open.Size) ImGui::ClosePopupToLevel(first, true);
}

}  // namespace

void Editor::UseBookmark(size_t slot, bool isKept) {
    std::optional<Bookmark>& bookmark = m_work.bookmarks.at(slot);
    if (isKept) {
        bookmark = {m_work.camera.View(), m_work.camera.Distance()};
        m_work.ShowMessage(Text("camera kept under Shift+{}", slot + 1));
    } else if (bookmark) {
        m_work.camera.Set(bookmark->view, bookmark->distance);
    } else {
        m_work.ShowMessage(Text("there is no camera under Shift+{0}: Ctrl+Shift+{0} keeps one", slot + 1));
    }
}

void Editor::Copy(const std::string& text) {
    ImGui::SetClipboardText(text.c_str());
    const bool isUnsaved = m_work.document.IsEdited() && text.starts_with("raygraph");
    m_work.ShowMessage(Text("copied {}{}", text, isUnsaved ? "; unsaved edits are not in its file" : ""));
}

void Editor::Perform(Action action) {
    const viewport::View view = m_work.view.Show().view;
    if (view == viewport::View::PathTraced || view == viewport::View::RealTime) m_tracedView = view;
    const auto toggle = [&](viewport::View to) { m_work.view.SetView(view == to ? m_tracedView : to); };
    if (bool Panels::*const panel = Row(action).panel) m_work.panels.*panel ^= true;
    switch (action) {
        case Action::Open:
            return ShowOpenDialog();
        case Action::SaveScene:
            return SaveEdits();
        case Action::SaveSceneAs:
            return ShowSaveSceneDialog();
        case Action::SavePicture:
            return ShowSavePictureDialog();
        case Action::Screenshot:
            return SavePicture(ScreenshotName());
        case Action::RenderImage:
            return m_render.Open(m_work);
        case Action::Quit:
            return Leave();
        case Action::Undo:
            return m_work.Undo();
        case Action::Redo:
            return m_work.Redo();
        case Action::Duplicate:
            return m_work.DuplicateSelection();
        case Action::Delete:
            return m_work.DeleteSelection();
        case Action::Rename:
            return m_work.StartRename();
        case Action::Hide:
            return m_work.ToggleVisibility();
        case Action::AddMenu:
            m_opensAddMenu = true;
            return;
        case Action::AddPoint:
            return m_work.AddLight(scene::LightType::Point);
        case Action::AddSpot:
            return m_work.AddLight(scene::LightType::Spot);
        case Action::AddDirectional:
            return m_work.AddLight(scene::LightType::Directional);
        case Action::AddEmpty:
            return m_work.AddEmpty();
        case Action::AddCamera:
            return m_work.AddCamera();
        case Action::Frame:
            return m_work.FrameSelection();
        case Action::SceneCamera:
            return m_work.UseCamera(m_work.FirstCamera());
        case Action::Front:
            return m_work.camera.LookAlong({0.0f, 0.0f, -1.0f});
        case Action::Back:
            return m_work.camera.LookAlong({0.0f, 0.0f, 1.0f});
        case Action::Right:
            return m_work.camera.LookAlong({-1.0f, 0.0f, 0.0f});
        case Action::Left:
            return m_work.camera.LookAlong({1.0f, 0.0f, 0.0f});
        case Action::Top:
            return m_work.camera.LookAlong({0.0f, -1.0f, 0.0f});
        case Action::Bottom:
            return m_work.camera.LookAlong({0.0f, 1.0f, 0.0f});
        case Action::Orthographic:
            return m_work.camera.ToggleOrthographic();
        case Action::PickFocus:
            return m_work.PickFocus(!m_work.IsPickingFocus());
        case Action::CopyCamera:
            return Copy(CameraOption(m_work));
        case Action::CopyCommand:
            return Copy(RenderCommand(m_work));
        case Action::Play:
            return m_work.timeline.Toggle();
        case Action::Stop:
            return m_work.timeline.Stop();
        case Action::Loop:
            m_work.timeline.isLooping ^= true;
            return;
        case Action::Hierarchy:
        case Action::Inspector:
        case Action::Timeline:
        case Action::Statistics:
        case Action::Graph:
        case Action::Log:
        case Action::Path:
        case Action::Icons:
        case Action::Help:
            return;  // handled above
        case Action::Raster:
            return toggle(viewport::View::Raster);
        case Action::Wipe:
            return toggle(viewport::View::Wipe);
        case Action::NextView:
            return m_work.view.SetView(
                static_cast<viewport::View>((static_cast<uint32_t>(view) + 1) % viewport::kViewCount));
        case Action::Move:
            m_work.tool = GizmoTool::Move;
            return;
        case Action::Rotate:
            m_work.tool = GizmoTool::Rotate;
            return;
        case Action::Scale:
            m_work.tool = GizmoTool::Scale;
            return;
        case Action::Space:
            m_work.toolSpace = m_work.toolSpace == GizmoSpace::World ? GizmoSpace::Local : GizmoSpace::World;
            return;
        case Action::Pivot:
            m_work.pivot = m_work.pivot == GizmoPivot::Middle ? GizmoPivot::Origin : GizmoPivot::Middle;
            return;
        case Action::Cancel:
            if (m_work.panels.help)
                m_work.panels.help = false;
            else if (m_render.IsOpen())
                m_render.Close();
            else if (m_work.IsPickingFocus())
                m_work.PickFocus(false);
            else if (!m_gizmo.Cancel(m_work))
                m_work.Select(std::nullopt);
            return;
        case Action::ReloadShaders:
            return ReloadShaders();
        case Action::Count:
            return;
    }
}

void Editor::ReloadShaders() {
    if (!m_work.hasShaderSources) {
        m_work.ShowMessage("no shader sources to reload from: start with --shaders FOLDER");
        return;
    }
    Renderer& renderer = m_work.renderer;
    m_isReloading = renderer.IsPreparingPipelines();
    if (m_isReloading) {
        m_work.ShowMessage("shaders are reloaded once the pipelines are there");
        return;
    }
    const double before = renderer.PipelineCreationMs();  // grows with each pipeline that is made
    const std::vector<std::string> messages = renderer.ReloadShaders();
    if (!messages.empty())
        m_work.ShowMessage(messages.front());
    else
        m_work.ShowMessage(renderer.PipelineCreationMs() > before ? "shaders reloaded"
                                                                  : "no shader has changed");
}

std::string Editor::WhyNot(Action action) const {
    const bool hasScene = !m_work.document.File().empty();
    switch (action) {
        case Action::SaveScene:
        case Action::SaveSceneAs:
            return hasScene ? "" : "there is no scene to save";
        case Action::AddMenu:
        case Action::AddPoint:
        case Action::AddSpot:
        case Action::AddDirectional:
        case Action::AddEmpty:
        case Action::AddCamera:
            return hasScene ? "" : "there is no scene to add to";
        case Action::CopyCommand:
        case Action::RenderImage:
            return hasScene ? "" : "there is no scene to render";
        case Action::PickFocus:
            return m_work.camera.View().projection == scene::Projection::Perspective
                       ? ""
                       : "an orthographic camera has no lens";
        case Action::Undo:
            return m_work.document.CanUndo() ? "" : "there is nothing to undo";
        case Action::Redo:
            return m_work.document.CanRedo() ? "" : "there is nothing to redo";
        case Action::Duplicate:
        case Action::Delete:
        case Action::Rename:
        case Action::Hide:
            return m_work.selectedNode ? "" : "nothing is selected";
        default:
            return Row(action).menu == Menu::AnimationMenu && m_work.timeline.IsEmpty()
                       ? "the scene has no animation"
                       : "";
    }
}

bool Editor::IsOn(Action action) const {
    if (action == Action::Play) return m_work.timeline.IsPlaying();
    if (action == Action::Loop) return m_work.timeline.isLooping;
    bool Panels::*const panel = Row(action).panel;
    return panel && m_work.panels.*panel;
}

void Editor::BindKey(const KeyPress& press) {
    const Action action = *std::exchange(m_work.actionToBind, std::nullopt);
    if (press == KeyPress{Key::Escape}) return;
    const bool isRemoved = press == KeyPress{Key::Backspace} || press == KeyPress{Key::Delete};
    std::string loser;
    for (const ActionRow& row : Actions())
        if (row.action != action && std::ranges::count(m_work.keys.Of(row.action), press) > 0)
            loser = row.help;
    m_work.keys.Bind(action, isRemoved ? editor::Keys{} : editor::Keys{press});
    if (!loser.empty()) m_work.ShowMessage(Text("{} is no longer: {}", KeyText(press), loser));
}

void Editor::Keys(const FrameInput& input) {
    const ImGuiIO& io = ImGui::GetIO();
    if (io.WantTextInput) return;
    if (ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopupId)) {
        // Dialogs take Escape themselves: what they ask is answered by it
        if (std::ranges::count(input.pressed, Key::Escape) > 0) CloseMenus();
        return;
    }
    if (m_drag == MouseButton::Right) return;  // the right button flies
    for (const Key key : input.pressed) {
        const KeyPress press{key, input.isControl, input.isShift};
        if (m_work.actionToBind) {
            BindKey(press);
        } else if (HierarchyKey(m_work, press)) {
            continue;
        } else if (input.isShift && key >= Key::Digit1 && key <= Key::Digit9) {
            UseBookmark(static_cast<size_t>(key) - static_cast<size_t>(Key::Digit1), input.isControl);
        } else if (const std::optional<Action> action = m_work.keys.ActionOf(press)) {
            const std::string why = WhyNot(*action);
            if (why.empty())
                Perform(*action);
            else
                m_work.ShowMessage(Text("{}: {}", KeyText(press), why));
        } else {
            const std::string help = m_work.keys.TextOf(Action::Help);
            m_work.ShowMessage(Text("{} does nothing{}", KeyText(press),
                                    help.empty() ? "" : Text("; {} lists the keys", help)));
        }
    }
}

void Editor::Fly(const FrameInput& input) {
    const auto axis = [&](Key forward, Key back) {
        return static_cast<float>(input.IsDown(forward)) - static_cast<float>(input.IsDown(back));
    };
    const glm::vec3 way(axis(Key::D, Key::A), axis(Key::E, Key::Q), axis(Key::W, Key::S));
    if (way == glm::vec3(0.0f)) return;
    const float hurry = (input.isShift ? 5.0f : 1.0f) * (input.isControl ? 0.2f : 1.0f);
    const float seconds = std::min(input.seconds, kLongestStep);
    m_work.camera.Fly(hurry * kFlySpeed * m_work.camera.Distance() * seconds * way);
}

void Editor::Mouse(const FrameInput& input) {
    const glm::vec2 moved = (input.mouse - std::exchange(m_lastMouse, input.mouse)) / input.scale;
    const Extent2D size = m_work.view.Size();
    const bool mayTake =
        m_isViewHovered && !m_drag && !m_work.IsPickingFocus() && !input.IsDown(MouseButton::Right);
    m_gizmo.Update(m_work, input, (input.mouse - glm::vec2(m_viewOrigin)) / input.scale,
                   glm::vec2(size.width, size.height) / input.scale, mayTake);
    if (m_gizmo.IsHeld()) return;
    if (!m_drag) {
        if (m_isViewHovered && input.wheel != 0.0f) m_work.camera.Dolly(input.wheel);
        for (const MouseButton button : {MouseButton::Left, MouseButton::Right, MouseButton::Middle})
            if (m_isViewHovered && input.IsDown(button) && !m_drag) {
                m_drag = button;
                m_pressedAt = input.mouse;
                m_hasMoved = false;
            }
        return;
    }
    if (!input.IsDown(*m_drag)) {
        const glm::ivec2 pixel = glm::ivec2(m_pressedAt) - m_viewOrigin;
        if (m_drag == MouseButton::Left && !m_hasMoved && pixel.x >= 0 && pixel.y >= 0 &&
            pixel.x < static_cast<int>(size.width) && pixel.y < static_cast<int>(size.height)) {
            m_drag.reset();
            if (m_work.IsPickingFocus()) return m_work.FocusOn(glm::uvec2(pixel));
            const PictureMap map(m_work.camera.View(), glm::vec2(size.width, size.height) / input.scale);
            if (const auto node = IconAt(IconsOf(m_work, map), glm::vec2(pixel) / input.scale)) {
                m_work.Select(node);
                m_work.nodeToReveal = node;
            } else {
                m_pick = m_work.view.RequestPick(glm::uvec2(pixel));
                m_isPicking = true;
            }
            if (m_work.panels.path) m_work.explained.Ask(m_work.view, glm::uvec2(pixel));
        }
        m_drag.reset();
        return;
    }
    if (glm::length(input.mouse - m_pressedAt) > kClickReach * input.scale) m_hasMoved = true;
    if (m_drag == MouseButton::Right) {
        if (moved != glm::vec2(0.0f)) m_work.camera.Turn(kTurn * glm::vec2(moved.x, -moved.y));
        Fly(input);
    } else if (m_hasMoved && moved != glm::vec2(0.0f)) {
        const bool isPan =
            input.isShift || (m_drag == MouseButton::Middle && m_work.keys.Preset() != KeyPreset::Blender);
        const float height = static_cast<float>(std::max(size.height, 1u)) / input.scale;
        if (isPan)
            m_work.camera.Pan(glm::vec2(moved.x, -moved.y) / height);
        else
            m_work.camera.Orbit(kTurn * glm::vec2(-moved.x, moved.y));
    }
}

void Editor::ApplyPick() {
    if (!m_isPicking || !m_pick.IsReady()) return;
    m_isPicking = false;
    const viewport::PickResult result = m_pick.Result();
    m_work.Select(std::nullopt);
    const scene::SceneData& scene = m_work.document.Scene();
    if (!result.isHit || result.instance >= scene.instances.size() ||
        result.material >= scene.materials.size())
        return;
    const uint32_t node = m_work.document.Scene().instances[result.instance].node;
    if (node == scene::kNone) return;
    m_work.Select(node, result.material);
    m_work.nodeToReveal = node;
}

}  // namespace raygraph::editor
