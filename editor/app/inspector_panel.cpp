// Draws the inspector: what the active node is made of, and its fields.
#include <imgui.h>
#include <imgui_internal.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <glm/gtc/type_ptr.hpp>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/text.h"
#include "editor/app/inspector_fields.h"
#include "editor/app/mesh_facts.h"
#include "editor/app/panels.h"
#include "editor/app/ui.h"
#include "renderer/scene/model/scene_fields.h"

namespace raygraph::editor {

namespace {

constexpr ImGuiSliderFlags kBounded = ImGuiSliderFlags_AlwaysClamp;
constexpr float kTooltipSeconds = 0.6f;

// Ends a step of the history when the user releases the item.
void EndStepAfterItem(Workspace& work) {
    if (ImGui::IsItemDeactivatedAfterEdit()) work.document.Settle();
}

void VisibilityField(Workspace& work, uint32_t node) {
    bool isVisible = work.document.Scene().nodes[node].isVisible;
    if (ImGui::Checkbox("visible", &isVisible)) {
        work.Apply(VisibilityEdit{node, isVisible});
        work.document.Settle();
    }
    if (isVisible && !work.document.IsVisible(node)) {
        ImGui::SameLine();
        ImGui::TextDisabled("hidden by a node above it");
    }
}

// Draws three numbers with as many decimals as there is room for, three at most.
bool ThreeNumbers(const char* label, glm::vec3& value, float speed) {
    const ImGuiStyle& style = ImGui::GetStyle();
    constexpr float kPadding = 3.0f;
    const float width = (ImGui::CalcItemWidth() - 2.0f * style.ItemInnerSpacing.x) / 3.0f - 2.0f * kPadding;
    const auto fits = [&](const char* format) {
        for (int i = 0; i < 3; ++i) {
            std::array<char, 64> text;
            std::snprintf(text.data(), text.size(), format, static_cast<double>(value[i]));
            if (ImGui::CalcTextSize(text.data()).x > width) return false;
        }
        return true;
    };
    constexpr std::array kFormats{"%.3f", "%.2f", "%.1f", "%.0f"};
    const auto format = std::ranges::find_if(kFormats.begin(), kFormats.end() - 1, fits);
    ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {kPadding, style.FramePadding.y});
    const bool isEdited =
        ImGui::DragFloat3(label, glm::value_ptr(value), speed, 0.0f, 0.0f, *format,
                          format == kFormats.begin() ? 0 : ImGuiSliderFlags_NoRoundToFormat);
    ImGui::PopStyleVar();
    return isEdited;
}

void TransformFields(Workspace& work, uint32_t node) {
    const glm::mat4x3 local = work.document.LocalTransform(node);
    const Placement before = PlacementOf(local);
    Placement placed = before;
    const float step = std::max(0.002f * work.document.Scene().bounds.Radius(), 1e-4f);
    bool isEdited = false, isSettled = false;
    const auto field = [&](const char* name, glm::vec3& value, float speed) {
        isEdited |= ThreeNumbers(name, value, speed);
        isSettled |= ImGui::IsItemDeactivatedAfterEdit();
    };
    field("position", placed.translation, step);
    field("rotation", placed.degrees, 0.5f);
    field("scale", placed.scale, 0.01f);
    if (isEdited && glm::all(glm::greaterThan(glm::abs(placed.scale), glm::vec3(1e-9f))))
        work.Apply(TransformEdit{node, Placed(local, before, placed)});
    if (isSettled) work.document.Settle();
}

// Makes the next widget leave room for its label: all labels form a column.
void ReserveLabelWidth() {
    constexpr float kColumn = 0.42f;
    ImGui::SetNextItemWidth((1.0f - kColumn) * ImGui::GetContentRegionAvail().x);
}

// Draws a widget for a field, by its type, range and unit. Returns true if the value was edited.
template <typename Owner>
bool Widget(const char* label, float& value, const scene::Field<Owner, float>& field, std::string_view unit) {
    const NumberStyle style = StyleOf(value, field.range, unit, field.ZeroIsInfinite());
    const char* const format = style.format.c_str();
    if (style.isAngle) {
        float shown = value;  // the widget rounds it even if nothing is edited
        const bool isEdited = ImGui::SliderAngle(label, &shown, glm::degrees(style.min),
                                                 glm::degrees(style.max), format, kBounded);
        if (isEdited) value = std::clamp(shown, style.min, style.max);
        return isEdited;
    }
    if (style.isSlider) return ImGui::SliderFloat(label, &value, style.min, style.max, format, kBounded);
    ImGui::BeginDisabled(style.isInfinite);
    const float speed = std::max(0.01f * std::abs(value), 0.005f);
    bool isEdited = ImGui::DragFloat(label, &value, speed, style.min, style.max, format, kBounded);
    ImGui::EndDisabled();
    if (!field.ZeroIsInfinite()) return isEdited;
    bool isInfinite = style.isInfinite;
    if (ImGui::Checkbox(Text("infinite##{}", label).c_str(), &isInfinite)) {
        value = isInfinite ? 0.0f : FiniteValue(field);
        isEdited = true;
    }
    return isEdited;
}
template <typename Owner, int Length>
bool Widget(const char* label, glm::vec<Length, float>& value,
            const scene::Field<Owner, glm::vec<Length, float>>& field, std::string_view) {
    const glm::vec<Length, float> before = value;
    glm::vec3 color(value);
    bool isEdited = ColorFields(label, color);
    for (int c = 0; c < 3; ++c) value[c] = color[c];
    if constexpr (Length == 4) {
        ReserveLabelWidth();
        isEdited |= ImGui::SliderFloat("opacity", &value[3], 0.0f, 1.0f, "%.3f", kBounded);
    }
    if (isEdited) value = Bounded(before, value, field.range);  // fields for typing have no bounds
    return isEdited;
}
bool Widget(const char* label, glm::vec2& value, const scene::TransformField<glm::vec2>& field,
            std::string_view) {
    const glm::vec2 before = value;
    if (!ImGui::DragFloat2(label, glm::value_ptr(value), 0.005f, 0.0f, 0.0f, "%.3f")) return false;
    value = Bounded(before, value, field.range);
    return true;
}
bool Widget(const char* label, bool& value, const scene::MaterialField<bool>&, std::string_view) {
    return ImGui::Checkbox(label, &value);
}
bool Widget(const char* label, uint32_t& value, const scene::MaterialField<uint32_t>&, std::string_view) {
    return ImGui::DragScalar(label, ImGuiDataType_U32, &value, 0.05f);
}
bool Widget(const char* label, scene::AlphaMode& value, const scene::MaterialField<scene::AlphaMode>&,
            std::string_view) {
    static constexpr auto kTexts = Texts(scene::AlphaMode{});
    int chosen = static_cast<int>(value);
    const bool isEdited = ImGui::Combo(label, &chosen, kTexts.data(), static_cast<int>(kTexts.size()));
    value = static_cast<scene::AlphaMode>(chosen);
    return isEdited;
}

// Copies, pastes and resets the field that was drawn last, by its menu on the right button and by Ctrl+C and
// Ctrl+V while the pointer is over it. Returns true if the value was changed.
template <typename Value, typename Owner>
bool ValueMenu(Value& value, const scene::Field<Owner, Value>& field, std::string_view unit) {
    const bool isHovered = ImGui::IsItemHovered();
    const ImGuiIO& io = ImGui::GetIO();
    bool isReset = false, isCopied = false, isPasted = false;
    if (isHovered && io.KeyCtrl && !io.WantTextInput) {
        isCopied = ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_C), false);
        isPasted = ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_V), false);
    }
    ImGui::PushID(field.name);
    if (isHovered && ImGui::IsMouseReleased(ImGuiMouseButton_Right)) ImGui::OpenPopup("value");
    if (ImGui::BeginPopup("value")) {
        isReset = ImGui::MenuItem("Reset");
        isCopied |= ImGui::MenuItem("Copy", "Ctrl+C");
        isPasted |= ImGui::MenuItem("Paste", "Ctrl+V");
        ImGui::EndPopup();
    } else if (isHovered && ImGui::GetCurrentContext()->HoveredIdTimer > kTooltipSeconds) {
        std::string place = *field.object == 0 ? field.key : Text("{}: {}", field.object, field.key);
        if (!unit.empty()) place += Text(", in {}", unit);
        ImGui::SetTooltip("%s", place.c_str());
    }
    ImGui::PopID();
    if (isReset) value = Owner().*field.member;
    if constexpr (std::is_floating_point_v<Value> || requires { Value::length(); }) {
        constexpr size_t kCount = sizeof(Value) / sizeof(float);
        float* const numbers = reinterpret_cast<float*>(&value);
        if (isCopied) ImGui::SetClipboardText(ValueText({numbers, kCount}).c_str());
        const char* const text = isPasted ? ImGui::GetClipboardText() : nullptr;
        const std::vector<float> pasted = NumbersFrom(text ? text : "");
        // A color without alpha keeps that of the field
        if (pasted.size() != kCount && (kCount != 4 || pasted.size() != 3)) return isReset;
        for (size_t i = 0; i < pasted.size(); ++i)
            numbers[i] = std::clamp(pasted[i], field.range.min, field.range.max);
        return true;
    }
    return isReset;
}

// Draws a field's widget as one item. Ends a step of the history when the user releases any part of it.
template <typename Value, typename Field>
bool Edits(Workspace& work, Value& value, const Field& field, std::string_view unit) {
    const std::string label = LabelOf(field.name);
    ReserveLabelWidth();
    ImGui::BeginGroup();
    bool isEdited = Widget(label.c_str(), value, field, unit);
    ImGui::EndGroup();
    EndStepAfterItem(work);
    if (ValueMenu(value, field, unit)) {
        work.document.Settle();
        isEdited = true;
    }
    return isEdited;
}

// Draws a small picture of the texture in a square.
void Thumbnail(Workspace& work, uint32_t texture) {
    constexpr float kSide = 52.0f;  // points
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    ImGui::Dummy({kSide, kSide});
    if (!ImGui::IsItemVisible()) return;
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.AddRectFilled(corner, {corner.x + kSide, corner.y + kSide}, ImGui::GetColorU32(ImGuiCol_FrameBg));
    const std::optional<Thumbnails::Picture> picture = work.thumbnails.Show(work.document, texture);
    if (!picture) return;
    const glm::vec2 extent = picture->to - picture->from;
    const glm::vec2 size = kSide * extent / std::max(extent.x, extent.y), edge = 0.5f * (kSide - size);
    const ImVec2 from{corner.x + edge.x, corner.y + edge.y};
    list.AddImage(ThumbnailTexture(), from, {from.x + size.x, from.y + size.y},
                  {picture->from.x, picture->from.y}, {picture->to.x, picture->to.y});
}

// Draws a texture: its picture and what it is, a button that exchanges its image, and its transform. Returns
// true if the transform was edited.
bool TextureFields(Workspace& work, const char* fieldName, scene::TextureRef& texture) {
    if (!texture.IsPresent()) return false;
    const auto index = static_cast<uint32_t>(texture.texture);
    const ImageFacts image = work.document.ImageOf(index);
    const bool isSrgb = work.document.Scene().textures[index].colorSpace == scene::ColorSpace::Srgb;
    const std::string embedded = image.name.empty() ? "embedded" : Text("{} (embedded)", image.name);
    const std::string place = image.file.empty() ? embedded : image.file;
    ImGui::PushID(fieldName);
    ImGui::BeginGroup();
    Thumbnail(work, index);
    ImGui::SameLine();
    ImGui::BeginGroup();
    ImGui::TextUnformatted(LabelOf(fieldName).c_str());
    ImGui::TextDisabled(
        "%s", (image.isReplaced ? std::filesystem::path(place).filename().string() : place).c_str());
    ImGui::TextDisabled("%u x %u, %s, %s", image.width, image.height, isSrgb ? "sRGB" : "linear",
                        ChannelsOf(fieldName));
    ImGui::EndGroup();
    ImGui::EndGroup();
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", place.c_str());
    if (ImGui::SmallButton("exchange...")) work.imageToReplace = index;
    ImGui::SameLine();
    bool isEdited = false;
    if (ImGui::TreeNode("transform")) {
        scene::ForEachTransformField([&](const auto& field) {
            isEdited |= Edits(work, texture.transform.*field.member, field, field.unit);
        });
        ImGui::TreePop();
    }
    ImGui::PopID();
    return isEdited;
}

void MaterialFields(Workspace& work, uint32_t index) {
    scene::Material material = work.document.Scene().materials[index];
    ImGui::PushID(static_cast<int>(index));
    std::vector<std::string> groups;
    scene::ForEachFieldOf(material, [&](const auto& field) {
        if (std::string group = GroupOf(field.object, field.name); std::ranges::count(groups, group) == 0)
            groups.push_back(std::move(group));
    });
    bool isEdited = false;
    for (const std::string& group : groups) {
        const bool isOpen = !IsUnused(material, group) || group == "Base";
        if (!ImGui::CollapsingHeader(group.c_str(), isOpen ? ImGuiTreeNodeFlags_DefaultOpen : 0)) continue;
        scene::ForEachFieldOf(material, [&](const auto& field) {
            if (GroupOf(field.object, field.name) != group ||
                !Counts(material, field.object, field.key, field.name))
                return;
            if constexpr (std::is_same_v<decltype(field.member), scene::TextureRef scene::Material::*>)
                isEdited |= TextureFields(work, field.name, material.*field.member);
            else
                isEdited |= Edits(work, material.*field.member, field, field.unit);
        });
    }
    if (isEdited) work.Apply(MaterialEdit{index, material});
    ImGui::PopID();
}

void LightFields(Workspace& work, uint32_t index) {
    scene::Light light = work.document.Scene().lights[index];
    ImGui::PushID(static_cast<int>(index));
    bool isEdited = false;
    scene::ForEachLightField(light, [&](const auto& field) {
        isEdited |= Edits(work, light.*field.member, field, scene::UnitOf(field, light));
    });
    if (isEdited) work.Apply(LightEdit{index, light});
    ImGui::PopID();
}

// Returns the picked material, if any, else those of the node's mesh.
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

// Draws the color as the screen shows it, and a picker once it is clicked.
bool ColorSwatch(const char* label, glm::vec3& linear) {
    PickedColor picked = ToPicked(linear);
    const ImVec4 shown{picked.encoded.x, picked.encoded.y, picked.encoded.z, 1.0f};
    const std::string name = Text("picker of {}", label);
    const ImGuiColorEditFlags flags = ImGuiColorEditFlags_NoTooltip | ImGuiColorEditFlags_NoAlpha;
    if (ImGui::ColorButton(Text("##{}", name).c_str(), shown, flags)) ImGui::OpenPopup(name.c_str());
    if (!ImGui::BeginPopup(name.c_str())) return false;
    ImGui::TextDisabled("sRGB; the fields beside it are linear");
    ImGui::SetNextItemWidth(220.0f);
    const bool isEdited =
        ImGui::ColorPicker3("##picker", glm::value_ptr(picked.encoded),
                            ImGuiColorEditFlags_DisplayRGB | ImGuiColorEditFlags_DisplayHex |
                                ImGuiColorEditFlags_NoSidePreview | ImGuiColorEditFlags_NoOptions);
    if (picked.brightness > 1.0f) ImGui::TextDisabled("times %.4g", static_cast<double>(picked.brightness));
    ImGui::EndPopup();
    if (!isEdited) return false;
    linear = ToLinear(picked);
    return true;
}

}  // namespace

bool ColorFields(const char* label, glm::vec3& linear) {
    const float width = ImGui::CalcItemWidth();
    bool isEdited = ColorSwatch(label, linear);
    ImGui::SameLine();
    ImGui::PushItemWidth(width - ImGui::GetFrameHeight() - ImGui::GetStyle().ItemSpacing.x);
    isEdited |= ThreeNumbers(label, linear, 0.005f);
    ImGui::PopItemWidth();
    return isEdited;
}

float WidthBesideLabels() {
    return -std::min(90.0f, 0.45f * ImGui::GetContentRegionAvail().x);
}

void InspectorPanel(Workspace& work) {
    if (!work.selectedNode) {
        ImGui::TextDisabled("Nothing is selected.");
        return;
    }
    const uint32_t node = *work.selectedNode;
    const scene::SceneData& scene = work.document.Scene();
    ImGui::TextUnformatted(work.document.NameOf(node).c_str());
    if (work.selectedNodes.size() > 1)
        ImGui::TextDisabled("the last of %zu selected nodes", work.selectedNodes.size());
    VisibilityField(work, node);
    ImGui::PushItemWidth(WidthBesideLabels());
    if (work.document.IsPlacedBySkin(node))
        ImGui::TextDisabled("moves with its joints");
    else
        TransformFields(work, node);
    for (const uint32_t material : MaterialsOf(work, node)) {
        ImGui::Separator();
        const std::string& name = scene.materials[material].name;
        ImGui::Text("Material %s", name.empty() ? std::to_string(material).c_str() : name.c_str());
        MaterialFields(work, material);
    }
    for (uint32_t light = 0; light < scene.lights.size(); ++light) {
        if (scene.lights[light].node != node) continue;
        ImGui::Separator();
        ImGui::Text("Light %s", scene.lights[light].name.c_str());
        LightFields(work, light);
    }
    ImGui::PopItemWidth();
    if (const uint32_t mesh = scene.nodes[node].mesh; mesh != scene::kNone) {
        ImGui::Separator();
        const std::string& name = scene.meshes[mesh].name;
        ImGui::Text("Mesh %s", name.empty() ? std::to_string(mesh).c_str() : name.c_str());
        ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
        for (const std::string& line : LinesOf(work.document.FactsOfMesh(mesh)))
            ImGui::TextWrapped("%s", line.c_str());
        ImGui::PopStyleColor();
    }
}

}  // namespace raygraph::editor
