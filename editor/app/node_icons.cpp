#include "editor/app/node_icons.h"

#include <cmath>
#include <glm/gtc/constants.hpp>

namespace raygraph::editor {

namespace {

constexpr float kLine = 1.2f;  // points

}  // namespace

void DrawNodeIcon(ImDrawList& list, NodeKind kind, ImVec2 center, ImU32 color) {
    const auto at = [&](float x, float y) { return ImVec2(center.x + x, center.y + y); };
    const auto line = [&](ImVec2 from, ImVec2 to) { list.AddLine(from, to, color, kLine); };
    switch (kind) {
        case NodeKind::Mesh: {  // a cube
            const ImVec2 outline[] = {at(0, -6),   at(5.5f, -3), at(5.5f, 3),
                                      at(0, 6.5f), at(-5.5f, 3), at(-5.5f, -3)};
            list.AddPolyline(outline, 6, color, ImDrawFlags_Closed, kLine);
            for (const ImVec2 corner : {at(0, 6.5f), at(5.5f, -3), at(-5.5f, -3)}) line(at(0, 0), corner);
            return;
        }
        case NodeKind::Light:
            list.AddCircle(center, 2.8f, color, 0, kLine);
            for (int i = 0; i < 8; ++i) {
                const float angle = static_cast<float>(i) * glm::quarter_pi<float>();
                const float x = std::cos(angle), y = std::sin(angle);
                line(at(4.5f * x, 4.5f * y), at(6.8f * x, 6.8f * y));
            }
            return;
        case NodeKind::Camera: {
            const ImVec2 lens[] = {at(2, 0), at(6.5f, -4), at(6.5f, 4)};
            list.AddRect(at(-6.5f, -4), at(2.5f, 4), color, 1.5f, 0, kLine);
            list.AddPolyline(lens, 3, color, ImDrawFlags_Closed, kLine);
            return;
        }
        case NodeKind::Joint: {  // a bone
            const ImVec2 bone[] = {at(-4.5f, 4.5f), at(-3, -1), at(5, -5), at(1, 3)};
            list.AddPolyline(bone, 4, color, ImDrawFlags_Closed, kLine);
            list.AddCircleFilled(at(-4.5f, 4.5f), 2.0f, color);
            return;
        }
        case NodeKind::Empty:  // axes
            line(at(-6, 0), at(6, 0));
            line(at(0, -6), at(0, 6));
            line(at(-3, 3), at(3, -3));
            return;
    }
}

void DrawEye(ImDrawList& list, bool isOpen, ImVec2 center, ImU32 color) {
    const auto at = [&](float x, float y) { return ImVec2(center.x + x, center.y + y); };
    list.AddBezierQuadratic(at(-6.5f, 0), at(0, 7), at(6.5f, 0), color, kLine);
    if (isOpen) {
        list.AddBezierQuadratic(at(-6.5f, 0), at(0, -7), at(6.5f, 0), color, kLine);
        list.AddCircleFilled(center, 2.0f, color);
        return;
    }
    for (const float side : {-1.0f, 0.0f, 1.0f})  // lashes
        list.AddLine(at(4.0f * side, 3.5f - std::abs(side)), at(5.5f * side, 6.5f - 1.5f * std::abs(side)),
                     color, kLine);
}

}  // namespace raygraph::editor
