// Shows the explained path of a pixel: as a table of its vertices, and as lines in the picture.
#include <imgui.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/text.h"
#include "editor/app/gizmo.h"
#include "editor/app/panels.h"
#include "editor/session/explain/path_text.h"

namespace raygraph::editor {

namespace {

constexpr ImU32 kPathRay = IM_COL32(90, 200, 250, 255), kPathEscaping = IM_COL32(90, 140, 230, 255);
constexpr ImU32 kPathLit = IM_COL32(255, 215, 90, 255), kPathOccluded = IM_COL32(225, 80, 80, 255);
constexpr ImU32 kPathVertex = IM_COL32(255, 255, 255, 255), kPathShadow = IM_COL32(0, 0, 0, 130);

ImU32 ColorOf(PathLine::Kind kind) {
    switch (kind) {
        case PathLine::Kind::Ray:
            return kPathRay;
        case PathLine::Kind::Escaping:
            return kPathEscaping;
        case PathLine::Kind::Lit:
            return kPathLit;
        case PathLine::Kind::Occluded:
            return kPathOccluded;
    }
    return kPathRay;
}

// Returns the ends of a line in the picture, cut off where it is behind the eye; nothing if all of it is.
std::optional<std::pair<glm::vec2, glm::vec2>> ProjectLine(const PictureMap& map, glm::dvec3 from,
                                                           glm::dvec3 to) {
    constexpr double kNearest = 1e-3;  // meters
    const scene::CameraView& view = map.View();
    const auto depth = [&](const glm::dvec3& point) {
        return glm::dot(point - view.eye, glm::dvec3(view.forward));
    };
    if (view.projection == scene::Projection::Perspective) {
        const double first = depth(from), last = depth(to);
        if (first < kNearest && last < kNearest) return std::nullopt;
        const glm::dvec3 cut = from + (kNearest - first) / (last - first) * (to - from);
        if (first < kNearest) from = cut;
        if (last < kNearest) to = cut;
    }
    const std::optional<glm::vec2> a = map.PlaceOf(from), b = map.PlaceOf(to);
    if (!a || !b) return std::nullopt;
    return std::pair(*a, *b);
}

void SelectObject(Workspace& work, const gpu::PathVertexRecord& vertex) {
    const scene::SceneData& scene = work.document.Scene();
    if (vertex.instance >= scene.instances.size()) return;
    const uint32_t node = scene.instances[vertex.instance].node;
    if (node >= scene.nodes.size()) return;
    work.Select(node,
                vertex.material < scene.materials.size() ? std::optional(vertex.material) : std::nullopt);
    work.nodeToReveal = node;
    work.FrameSelection();
}

void SampleChoice(Workspace& work, const session::Explanation& shown) {
    const auto last = static_cast<int>(shown.values.size()) - 1;
    const session::ExplainedPath& path = work.explained.Path();
    int sample = static_cast<int>(path.sample);
    ImGui::BeginDisabled(!work.explained.IsCurrent(work.view) || work.explained.IsPending());
    ImGui::SetNextItemWidth(110.0f);
    if (ImGui::InputInt("sample", &sample))
        work.explained.AskPath(work.view, static_cast<uint32_t>(std::clamp(sample, 0, last)));
    ImGui::SameLine();
    if (ImGui::Button("Brightest")) work.explained.AskPath(work.view, session::BrightestOf(shown, 1).front());
    ImGui::EndDisabled();
    ImGui::SameLine();
    ImGui::Text("of %zu, pixel %u,%u", shown.values.size(), shown.pixel.x, shown.pixel.y);
    if (!work.explained.IsCurrent(work.view)) {
        ImGui::SameLine();
        ImGui::TextDisabled("before the view changed");
    }
    ImGui::TextWrapped("%.3g %.3g %.3g, %.3g %% of the pixel's variance: %s",
                       static_cast<double>(path.value.x), static_cast<double>(path.value.y),
                       static_cast<double>(path.value.z), 100.0 * path.varianceShare,
                       session::CauseOf(path, shown.names).c_str());
}

void VertexTable(Workspace& work, const session::Explanation& shown) {
    constexpr ImGuiTableFlags kFlags =
        ImGuiTableFlags_ScrollY | ImGuiTableFlags_RowBg | ImGuiTableFlags_SizingStretchProp;
    if (!ImGui::BeginTable("vertices", 4, kFlags)) return;
    ImGui::TableSetupScrollFreeze(0, 1);
    ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthFixed, 24.0f);
    ImGui::TableSetupColumn("meets", 0, 1.1f);
    ImGui::TableSetupColumn("goes on", 0, 0.9f);
    ImGui::TableSetupColumn("light", 0, 1.5f);
    ImGui::TableHeadersRow();
    const session::ExplainedPath& path = work.explained.Path();
    for (size_t i = 0; i < path.vertices.size(); ++i) {
        const session::VertexRow row = session::RowOf(path.vertices[i], shown.names);
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        if (ImGui::Selectable(std::to_string(i + 1).c_str(), i == work.explained.vertex,
                              ImGuiSelectableFlags_SpanAllColumns))
            work.explained.vertex = i;
        for (const std::string& cell : {row.place, row.next, row.light}) {
            ImGui::TableNextColumn();
            ImGui::TextUnformatted(cell.c_str());
        }
    }
    ImGui::EndTable();
}

void VertexDetails(Workspace& work, const session::Explanation& shown) {
    const session::ExplainedPath& path = work.explained.Path();
    const size_t count = path.vertices.size();
    size_t& vertex = work.explained.vertex;
    vertex = std::min(vertex, count - 1);
    ImGui::BeginDisabled(vertex == 0);
    if (ImGui::ArrowButton("previous", ImGuiDir_Up)) --vertex;
    ImGui::EndDisabled();
    ImGui::SameLine();
    ImGui::BeginDisabled(vertex + 1 >= count);
    if (ImGui::ArrowButton("next", ImGuiDir_Down)) ++vertex;
    ImGui::EndDisabled();
    ImGui::SameLine();
    ImGui::BeginDisabled(path.vertices[vertex].instance == gpu::kNoRecord);
    if (ImGui::Button("Go to object")) SelectObject(work, path.vertices[vertex]);
    ImGui::EndDisabled();
    for (const std::string& line : session::LinesOf(path, vertex, shown.names, shown.origin))
        ImGui::TextWrapped("%s", line.c_str());
}

}  // namespace

void PathPanel(Workspace& work) {
    const std::optional<session::Explanation>& shown = work.explained.Shown();
    if (!shown) {
        ImGui::TextDisabled(work.explained.IsPending()
                                ? "The path is being traced; the first one needs a program to be made."
                                : "Click into the picture: the path of the pixel's brightest sample.");
        return;
    }
    SampleChoice(work, *shown);
    ImGui::BeginChild("table", {0.6f * ImGui::GetContentRegionAvail().x, 0.0f});
    VertexTable(work, *shown);
    ImGui::EndChild();
    ImGui::SameLine();
    ImGui::BeginChild("details");
    VertexDetails(work, *shown);
    ImGui::EndChild();
}

void DrawPath(const Workspace& work, ImVec2 corner, glm::vec2 size) {
    const std::optional<session::Explanation>& shown = work.explained.Shown();
    if (!shown || !work.panels.path || work.view.Show().view == viewport::View::SideBySide) return;
    if (!(size.x > 0.0f && size.y > 0.0f)) return;
    const PictureMap map(work.camera.View(), size);
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.PushClipRect(corner, {corner.x + size.x, corner.y + size.y}, true);
    const double reach = 2.0 * std::max(static_cast<double>(work.document.Scene().bounds.Radius()), 1e-3);
    const std::vector<PathLine> lines = LinesOfPath(work.explained.Path(), shown->origin, reach);
    // The selected vertex is drawn last, over the others
    for (const bool isSelected : {false, true})
        for (const PathLine& line : lines) {
            if ((line.vertex == work.explained.vertex) != isSelected) continue;
            const auto ends = ProjectLine(map, line.from, line.to);
            if (!ends) continue;
            const ImVec2 from{corner.x + ends->first.x, corner.y + ends->first.y};
            const ImVec2 to{corner.x + ends->second.x, corner.y + ends->second.y};
            const float width = isSelected ? 3.0f : 1.5f;
            list.AddLine(from, to, kPathShadow, width + 2.0f);
            list.AddLine(from, to, ColorOf(line.kind), width);
            if (line.kind == PathLine::Kind::Ray) {
                list.AddCircleFilled(to, isSelected ? 6.0f : 4.5f, kPathShadow);
                list.AddCircleFilled(to, isSelected ? 5.0f : 3.5f, isSelected ? kPathVertex : kPathRay);
            }
        }
    list.PopClipRect();
}

}  // namespace raygraph::editor
