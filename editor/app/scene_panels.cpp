// What is in the scene: hierarchy and inspector.
#include <imgui.h>

#include <algorithm>

#define GLM_ENABLE_EXPERIMENTAL
#include <glm/gtc/type_ptr.hpp>
#include <glm/gtx/matrix_decompose.hpp>
#include <string>

#include "editor/app/panels.h"

namespace raygraph::editor {

namespace {

std::string NameOf(const scene::SceneData& scene, uint32_t node) {
    const scene::Node& of = scene.nodes[node];
    if (!of.name.empty()) return of.name;
    if (of.mesh != scene::kNone && !scene.meshes[of.mesh].name.empty()) return scene.meshes[of.mesh].name;
    return "node " + std::to_string(node);
}

void NodeTree(Workspace& work, uint32_t node) {
    const std::vector<uint32_t>& children = work.document.Children()[node];
    ImGuiTreeNodeFlags flags = ImGuiTreeNodeFlags_OpenOnArrow | ImGuiTreeNodeFlags_SpanAvailWidth;
    if (children.empty()) flags |= ImGuiTreeNodeFlags_Leaf | ImGuiTreeNodeFlags_NoTreePushOnOpen;
    if (work.selectedNode == node) flags |= ImGuiTreeNodeFlags_Selected;
    const bool isOpen = ImGui::TreeNodeEx(reinterpret_cast<void*>(uintptr_t{node} + 1), flags, "%s",
                                          NameOf(work.document.Scene(), node).c_str());
    if (ImGui::IsItemClicked()) {
        work.selectedNode = node;
        work.selectedMaterial.reset();
    }
    if (isOpen && !children.empty()) {
        for (const uint32_t child : children) NodeTree(work, child);
        ImGui::TreePop();
    }
}

// Ends the history's step where the user lets go.
void SettleAfterItem(Workspace& work) {
    if (ImGui::IsItemDeactivatedAfterEdit()) work.document.Settle();
}

void TransformFields(Workspace& work, uint32_t node) {
    const glm::mat4x3 local = work.document.Scene().nodes[node].LocalTransform();
    glm::vec3 scale, translation, skew;
    glm::quat rotation;
    glm::vec4 perspective;
    glm::decompose(glm::mat4(local), scale, rotation, translation, skew, perspective);
    glm::vec3 degrees = glm::degrees(glm::eulerAngles(rotation));
    const float step = std::max(0.002f * work.document.Scene().bounds.Radius(), 1e-4f);
    bool isEdited = false, isSettled = false;
    const auto field = [&](const char* name, glm::vec3& value, float speed) {
        isEdited |= ImGui::DragFloat3(name, glm::value_ptr(value), speed, 0.0f, 0.0f, "%.3f");
        isSettled |= ImGui::IsItemDeactivatedAfterEdit();
    };
    field("position", translation, step);
    field("rotation", degrees, 0.5f);
    field("scale", scale, 0.01f);
    if (isEdited && glm::all(glm::greaterThan(glm::abs(scale), glm::vec3(1e-6f)))) {
        const glm::mat4 turned = glm::translate(glm::mat4(1.0f), translation) *
                                 glm::mat4_cast(glm::quat(glm::radians(degrees))) *
                                 glm::scale(glm::mat4(1.0f), scale);
        work.Apply(TransformEdit{node, glm::mat4x3(turned)});
    }
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
    edited(ImGui::SliderFloat("metallic", &material.metallicFactor, 0.0f, 1.0f));
    edited(ImGui::SliderFloat("roughness", &material.roughnessFactor, 0.0f, 1.0f));
    edited(ImGui::ColorEdit3("emissive", glm::value_ptr(material.emissiveFactor), kLinear));
    edited(ImGui::DragFloat("strength", &material.emissiveStrength, 0.05f, 0.0f, 1e6f));
    edited(ImGui::SliderFloat("ior", &material.ior, 1.0f, 2.5f));
    edited(ImGui::SliderFloat("specular", &material.specularFactor, 0.0f, 1.0f));
    if (material.IsTransmissive())
        edited(ImGui::SliderFloat("transmission", &material.transmissionFactor, 0.01f, 1.0f));
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
    isEdited |= ImGui::DragFloat("intensity", &light.intensity, 0.1f, 0.0f, 1e7f, unit);
    SettleAfterItem(work);
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
    for (const uint32_t root : work.document.Roots()) NodeTree(work, root);
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
