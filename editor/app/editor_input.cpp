// Handles keys and mouse of the editor.
#include <algorithm>
#include <cmath>

#include "base/text.h"
#include "editor/app/editor.h"

namespace raygraph::editor {

namespace {

constexpr float kTurn = 0.006f;       // radians per point of mouse movement
constexpr float kClickReach = 4.0f;   // points of movement that still count as a click
constexpr float kFlySpeed = 0.6f;     // distances to the pivot per second
constexpr float kLongestStep = 0.1f;  // seconds: longest time step of a frame's flight

}  // namespace

void Editor::UseBookmark(size_t slot, bool isKept) {
    std::optional<Bookmark>& bookmark = m_work.bookmarks.at(slot);
    if (isKept) {
        bookmark = {m_work.camera.View(), m_work.camera.Distance()};
        m_work.Say(Text("camera kept under {}", slot + 1));
    } else if (bookmark) {
        m_work.camera.Set(bookmark->view, bookmark->distance);
    }
}

void Editor::Do(Action action) {
    const viewport::View view = m_work.view.Show().view;
    const auto toggle = [&](viewport::View to) {
        m_work.view.SetView(view == to ? viewport::View::PathTraced : to);
    };
    if (bool Panels::*const panel = Row(action).panel) m_work.panels.*panel ^= true;
    switch (action) {
        case Action::Open:
            return ShowOpenDialog();
        case Action::SaveScene:
            return ShowSaveSceneDialog();
        case Action::SavePicture:
            return ShowSavePictureDialog();
        case Action::Screenshot:
            return SavePicture("raygraph.png");
        case Action::Quit:
            return Leave();
        case Action::Undo:
            return m_work.Undo();
        case Action::Redo:
            return m_work.Redo();
        case Action::Hide:
            return m_work.ToggleVisibility();
        case Action::Frame:
            return m_work.FrameSelection();
        case Action::SceneCamera:
            return m_work.UseCamera(m_work.document.Scene().cameras.empty() ? std::nullopt
                                                                            : std::optional<uint32_t>(0));
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
            if (!m_gizmo.Cancel(m_work)) m_work.Select(std::nullopt);
            return;
        case Action::ReloadShaders:
            return ReloadShaders();
        case Action::Count:
            return;
    }
}

void Editor::ReloadShaders() {
    if (!m_work.hasShaderSources) {
        m_work.Say("no shader sources to reload from: start with --shaders FOLDER");
        return;
    }
    Renderer& renderer = m_work.renderer;
    m_isReloading = renderer.IsPreparingPipelines();
    if (m_isReloading) {
        m_work.Say("shaders are reloaded once the pipelines are there");
        return;
    }
    const double before = renderer.PipelineCreationMs();  // grows with each pipeline that is made
    const std::vector<std::string> messages = renderer.ReloadShaders();
    if (!messages.empty())
        m_work.Say(messages.front());
    else
        m_work.Say(renderer.PipelineCreationMs() > before ? "shaders reloaded" : "no shader has changed");
}

bool Editor::CanDo(Action action) const {
    if (action == Action::SaveScene) return !m_work.document.File().empty();
    if (action == Action::Undo) return m_work.document.CanUndo();
    if (action == Action::Redo) return m_work.document.CanRedo();
    if (action == Action::Hide) return m_work.selectedNode.has_value();
    if (Row(action).menu == Menu::AnimationMenu) return !m_work.timeline.IsEmpty();
    return true;
}

bool Editor::IsOn(Action action) const {
    if (action == Action::Play) return m_work.timeline.IsPlaying();
    if (action == Action::Loop) return m_work.timeline.isLooping;
    bool Panels::*const panel = Row(action).panel;
    return panel && m_work.panels.*panel;
}

void Editor::Keys(const FrameInput& input) {
    const ImGuiIO& io = ImGui::GetIO();
    if (io.WantTextInput || ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopupId)) return;
    if (m_drag == MouseButton::Right) return;  // the right button flies
    for (const Key key : input.pressed) {
        if (key >= Key::Digit1 && key <= Key::Digit9)
            UseBookmark(static_cast<size_t>(key) - static_cast<size_t>(Key::Digit1), input.isControl);
        else if (const std::optional<Action> action = ActionOf({key, input.isControl, input.isShift}))
            Do(*action);
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
    const bool mayTake = m_isViewHovered && !m_drag && !input.IsDown(MouseButton::Right);
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
            m_pick = m_work.view.RequestPick(glm::uvec2(pixel));
            m_isPicking = true;
        }
        m_drag.reset();
        return;
    }
    if (glm::length(input.mouse - m_pressedAt) > kClickReach * input.scale) m_hasMoved = true;
    if (m_drag == MouseButton::Right) {
        if (moved != glm::vec2(0.0f)) m_work.camera.Turn(kTurn * glm::vec2(moved.x, -moved.y));
        Fly(input);
    } else if (m_hasMoved && moved != glm::vec2(0.0f)) {
        const bool isPan = m_drag == MouseButton::Middle || input.isShift;
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
