#include "editor/app/scene_icons.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

namespace raygraph::editor {

namespace {

constexpr float kRadius = 9.0f;  // points
constexpr float kReach = 11.0f;  // points: distance at which an icon is hit
constexpr float kArrow = 20.0f;  // points: length of the line along a light

void DrawIcon(ImDrawList& list, const SceneIcon& icon, ImVec2 center, ImU32 color, float width) {
    const auto at = [&](float x, float y) { return ImVec2(center.x + x, center.y + y); };
    if (!icon.light) {
        const ImVec2 lens[] = {at(2, 0), at(9, -6), at(9, 6)};
        list.AddRect(at(-9, -6), at(3, 6), color, 2.0f, 0, width);
        list.AddPolyline(lens, 3, color, ImDrawFlags_Closed, width);
        return;
    }
    const auto line = [&](glm::vec2 way, float from, float to) {
        list.AddLine(at(from * way.x, from * way.y), at(to * way.x, to * way.y), color, width);
    };
    list.AddCircle(center, 4.0f, color, 0, width);
    if (*icon.light == scene::LightType::Point) {
        for (int i = 0; i < 8; ++i) {
            const float angle = static_cast<float>(i) * glm::quarter_pi<float>();
            line({std::cos(angle), std::sin(angle)}, 6.0f, kRadius);
        }
        return;
    }
    line(icon.direction, 4.0f, kArrow);
    if (*icon.light == scene::LightType::Directional) {
        const glm::vec2 aside = 6.0f * glm::vec2(-icon.direction.y, icon.direction.x);
        for (const float side : {-1.0f, 1.0f})
            list.AddLine(
                at(side * aside.x, side * aside.y),
                at(side * aside.x + kArrow * icon.direction.x, side * aside.y + kArrow * icon.direction.y),
                color, width);
        return;
    }
    constexpr float kHalfCone = 0.4f;
    for (const float angle : {-kHalfCone, kHalfCone}) {
        const float c = std::cos(angle), s = std::sin(angle);
        line({c * icon.direction.x - s * icon.direction.y, s * icon.direction.x + c * icon.direction.y}, 4.0f,
             kArrow);
    }
}

}  // namespace

std::vector<SceneIcon> IconsOf(const Workspace& work, const PictureMap& map) {
    std::vector<SceneIcon> icons;
    if (!work.panels.icons || work.view.Show().view == viewport::View::SideBySide) return icons;
    const scene::CameraView& view = map.View();
    const auto add = [&](uint32_t node, std::optional<scene::LightType> light) {
        if (node == scene::kNone || !work.document.IsPresent(node)) return;
        const glm::mat4x3& nodeToWorld = work.document.WorldTransform(node);
        const float depth = glm::dot(nodeToWorld[3] - glm::vec3(view.eye), view.forward);
        const std::optional<glm::vec2> place = map.PlaceOf(nodeToWorld[3]);
        if (!place || depth < std::max(view.zNear, 1e-3f * work.camera.Distance())) return;
        const glm::vec3 along = -nodeToWorld[2];
        const float length = glm::length(along);
        glm::vec2 direction(glm::dot(along, view.right), -glm::dot(along, view.up));
        if (length > 0.0f) direction /= length;
        icons.push_back({node, light, *place, depth, direction});
    };
    const scene::SceneData& scene = work.document.Scene();
    for (const scene::Light& light : scene.lights) add(light.node, light.type);
    for (const scene::Camera& camera : scene.cameras) add(camera.node, std::nullopt);
    std::ranges::stable_sort(icons, std::ranges::greater(), &SceneIcon::depth);
    return icons;
}

std::optional<uint32_t> IconAt(const std::vector<SceneIcon>& icons, glm::vec2 place) {
    for (auto icon = icons.rbegin(); icon != icons.rend(); ++icon)
        if (glm::length(icon->place - place) <= kReach) return icon->node;
    return std::nullopt;
}

void DrawIcons(const Workspace& work, ImVec2 corner, glm::vec2 size) {
    if (!(size.x > 0.0f && size.y > 0.0f)) return;
    constexpr ImU32 kShadow = IM_COL32(0, 0, 0, 160), kHidden = IM_COL32(140, 140, 140, 220),
                    kPlain = IM_COL32(240, 225, 170, 255), kSelected = IM_COL32(255, 160, 50, 255);
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.PushClipRect(corner, {corner.x + size.x, corner.y + size.y}, true);
    for (const SceneIcon& icon : IconsOf(work, PictureMap(work.camera.View(), size))) {
        const ImVec2 center{corner.x + icon.place.x, corner.y + icon.place.y};
        const bool isSelected = std::ranges::count(work.selectedNodes, icon.node) > 0;
        const ImU32 color = isSelected ? kSelected : !work.document.IsVisible(icon.node) ? kHidden : kPlain;
        DrawIcon(list, icon, center, kShadow, 3.5f);
        DrawIcon(list, icon, center, color, 1.5f);
    }
    list.PopClipRect();
}

}  // namespace raygraph::editor
