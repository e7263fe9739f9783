// What is in the scene: hierarchy and inspector.
#include <imgui.h>

#include "base/text.h"

#include <algorithm>

#include <glm/gtc/type_ptr.hpp>
#include <string>
#include <utility>

#include "editor/app/panels.h"
#include "editor/app/placement.h"
#include "renderer/scene/material_fields.h"

namespace raygraph::editor {

namespace {

constexpr ImGuiSliderFlags kBounded = ImGuiSliderFlags_AlwaysClamp;

std::string NameOf(const scene::SceneData& scene, uint32_t node) {
    const scene::Node& of = scene.nodes[node];
    if (!of.name.empty()) return of.name;
    if (of.mesh != scene::kNone && !scene.meshes[of.mesh].name.empty()) return scene.meshes[of.mesh].name;
    return Text("node {}", node);
}

void NodeRow(Workspace& work, const Hierarchy::Row& row) {
    const uint32_t node = row.node;
    ImGuiTreeNodeFlags flags = ImGuiTreeNodeFlags_OpenOnArrow | ImGuiTreeNodeFlags_SpanAvailWidth |
                               ImGuiTreeNodeFlags_NoTreePushOnOpen;
    if (work.hierarchy.Children(node).empty()) flags |= ImGuiTreeNodeFlags_Leaf;
    if (work.selectedNode == node) flags |= ImGuiTreeNodeFlags_Selected;
    const float indent = 14.0f * static_cast<float>(std::min(row.depth, 40u)) + 0.01f;
    ImGui::Indent(indent);
    ImGui::SetNextItemOpen(work.hierarchy.IsOpen(node));
    const bool isOpen = ImGui::TreeNodeEx(reinterpret_cast<void*>(uintptr_t{node} + 1), flags, "%s",
                                          NameOf(work.document.Scene(), node).c_str());
    if (ImGui::IsItemToggledOpen())
        work.hierarchy.SetOpen(node, isOpen);
    else if (ImGui::IsItemClicked())
        work.Select(node);
    ImGui::Unindent(indent);
}

// Ends the history's step where the user lets go.
void SettleAfterItem(Workspace& work) {
    if (ImGui::IsItemDeactivatedAfterEdit()) work.document.Settle();
}

void TransformFields(Workspace& work, uint32_t node) {
    const glm::mat4x3 local = work.document.LocalTransform(node);
    const Placement before = PlacementOf(local);
    Placement placed = before;
    const float step = std::max(0.002f * work.document.Scene().bounds.Radius(), 1e-4f);
    bool isEdited = false, isSettled = false;
    const auto field = [&](const char* name, glm::vec3& value, float speed) {
        isEdited |= ImGui::DragFloat3(name, glm::value_ptr(value), speed, 0.0f, 0.0f, "%.3f");
        isSettled |= ImGui::IsItemDeactivatedAfterEdit();
    };
    field("position", placed.translation, step);
    field("rotation", placed.degrees, 0.5f);
    field("scale", placed.scale, 0.01f);
    if (isEdited && glm::all(glm::greaterThan(glm::abs(placed.scale), glm::vec3(1e-9f))))
        work.Apply(TransformEdit{node, Placed(local, before, placed)});
    if (isSettled) work.document.Settle();
}

void MaterialFields(Workspace& work, uint32_t index) {
    scene::Material material = work.document.Scene().materials[index];
    ImGui::PushID(static_cast<int>(index));
    bool isEdited = false;
    const auto edited = [&](bool isChanged) {
        isEdited |= isChanged;
        SettleAfterItem(work);
    };
    constexpr ImGuiColorEditFlags kLinear = ImGuiColorEditFlags_Float | ImGuiColorEditFlags_HDR;
    edited(ImGui::ColorEdit4("base colour", glm::value_ptr(material.baseColorFactor), kLinear));
    const auto slider = [&](const char* label, float scene::Material::*member) {
        const scene::FieldRange range = scene::FieldOf(member).range;
        edited(ImGui::SliderFloat(label, &(material.*member), range.least, range.most, "%.3f", kBounded));
    };
    slider("metallic", &scene::Material::metallicFactor);
    slider("roughness", &scene::Material::roughnessFactor);
    edited(ImGui::ColorEdit3("emissive", glm::value_ptr(material.emissiveFactor), kLinear));
    edited(ImGui::DragFloat("strength", &material.emissiveStrength, 0.05f, 0.0f, 1e6f, "%.3f", kBounded));
    edited(ImGui::SliderFloat("ior", &material.ior, 1.0f, 2.5f, "%.3f", kBounded));
    slider("specular", &scene::Material::specularFactor);
    if (material.IsTransmissive())
        edited(
            ImGui::SliderFloat("transmission", &material.transmissionFactor, 0.01f, 1.0f, "%.3f", kBounded));
    // Fields that are typed into know no bounds
    const scene::FieldRange color = scene::FieldOf(&scene::Material::baseColorFactor).range;
    material.baseColorFactor = glm::clamp(material.baseColorFactor, color.least, color.most);
    // glTF wants colors of at most 1, and has `strength` for more; a file that has more keeps it
    const glm::vec3 before = work.document.Scene().materials[index].emissiveFactor;
    material.emissiveFactor =
        glm::clamp(material.emissiveFactor, glm::vec3(0.0f), glm::max(before, glm::vec3(1.0f)));
    if (isEdited) work.Apply(MaterialEdit{index, material});
    ImGui::PopID();
}

void LightFields(Workspace& work, uint32_t index) {
    scene::Light light = work.document.Scene().lights[index];
    ImGui::PushID(static_cast<int>(index));
    bool isEdited = ImGui::ColorEdit3("colour", glm::value_ptr(light.color),
                                      ImGuiColorEditFlags_Float | ImGuiColorEditFlags_HDR);
    SettleAfterItem(work);
    const char* unit = light.type == scene::LightType::Directional ? "%.3f lx" : "%.3f cd";
    isEdited |= ImGui::DragFloat("intensity", &light.intensity, 0.1f, 0.0f, 1e7f, unit, kBounded);
    SettleAfterItem(work);
    const glm::vec3 before = work.document.Scene().lights[index].color;  // as for materials
    light.color = glm::clamp(light.color, glm::vec3(0.0f), glm::max(before, glm::vec3(1.0f)));
    if (isEdited) work.Apply(LightEdit{index, light});
    ImGui::PopID();
}

// Those of the node's mesh, or the one that was picked.
std::vector<uint32_t> MaterialsOf(const Workspace& work, uint32_t node) {
    if (work.selectedMaterial) return {*work.selectedMaterial};
    std::vector<uint32_t> materials;
    const scene::SceneData& scene = work.document.Scene();
    if (const uint32_t mesh = scene.nodes[node].mesh; mesh != scene::kNone)
        for (const scene::Primitive& primitive : scene.meshes[mesh].primitives)
            if (std::ranges::find(materials, primitive.material) == materials.end())
                materials.push_back(primitive.material);
    return materials;
}

}  // namespace

void HierarchyPanel(Workspace& work) {
    if (work.document.Roots().empty()) {
        ImGui::TextDisabled("No scene is open.");
        ImGui::TextWrapped("Drop a .gltf or .glb file here, or use File > Open.");
        return;
    }
    ImGui::BeginChild("nodes");
    if (work.nodeToReveal) {
        const size_t row = work.hierarchy.Reveal(*std::exchange(work.nodeToReveal, std::nullopt));
        const float height = ImGui::GetTextLineHeightWithSpacing(), place = static_cast<float>(row) * height;
        const float shown = ImGui::GetWindowHeight();
        if (place < ImGui::GetScrollY() || place + height > ImGui::GetScrollY() + shown)
            ImGui::SetScrollY(std::max(place - 0.5f * shown, 0.0f));
    }
    // A row that is opened changes the list: from the next frame on
    const std::vector<Hierarchy::Row>& rows = work.hierarchy.Rows();
    ImGuiListClipper clipper;
    clipper.Begin(static_cast<int>(rows.size()), ImGui::GetTextLineHeightWithSpacing());
    while (clipper.Step())
        for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; i++)
            NodeRow(work, rows[static_cast<size_t>(i)]);
    ImGui::EndChild();
}

void InspectorPanel(Workspace& work) {
    if (!work.selectedNode) {
        ImGui::TextDisabled("Nothing is selected.");
        return;
    }
    const uint32_t node = *work.selectedNode;
    const scene::SceneData& scene = work.document.Scene();
    ImGui::TextUnformatted(NameOf(scene, node).c_str());
    ImGui::PushItemWidth(-90.0f);
    TransformFields(work, node);
    for (const uint32_t material : MaterialsOf(work, node)) {
        ImGui::Separator();
        const std::string& name = scene.materials[material].name;
        ImGui::Text("Material %s", name.empty() ? std::to_string(material).c_str() : name.c_str());
        MaterialFields(work, material);
    }
    for (uint32_t light = 0; light < scene.lights.size(); light++) {
        if (scene.lights[light].node != node) continue;
        ImGui::Separator();
        ImGui::Text("Light %s", scene.lights[light].name.c_str());
        LightFields(work, light);
    }
    ImGui::PopItemWidth();
}

}  // namespace raygraph::editor
