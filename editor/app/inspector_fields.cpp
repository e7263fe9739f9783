#include "editor/app/inspector_fields.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/quaternion.hpp>
#include <type_traits>
#include <utility>

#include "base/text.h"
#include "editor/session/settings/parse.h"
#include "editor/session/verify/picture.h"
#include "renderer/scene/model/scene_fields.h"

namespace raygraph::editor {

namespace {

constexpr float kMaxDragged = 1e7f;  // limit for numbers without a bound of their own
constexpr float kMaxTurn = 2.0f * glm::pi<float>();
constexpr float kMinFinite =
    0.001f;  // smallest number that the format shows; dragging does not reach 0, which is infinite

// Returns false only if `place` is a texture's place in the file, and the material lacks that texture.
bool IsPresentOrNoTexture(const scene::Material& material, std::string_view place) {
    bool isPresent = true;
    scene::ForEachMaterialField([&](const auto& field) {
        if constexpr (std::is_same_v<decltype(field.member), scene::TextureRef scene::Material::*>)
            if (field.key == place) isPresent = (material.*field.member).IsPresent();
    });
    return isPresent;
}

}  // namespace

std::string LabelOf(std::string_view name) {
    for (const std::string_view ending : {"Factor", "Mode"})
        if (name.ends_with(ending)) name.remove_suffix(ending.size());
    for (const std::string_view beginning : {"is"})
        if (name.starts_with(beginning)) name.remove_prefix(beginning.size());
    std::string label;
    for (const char c : name) {
        const bool isUpper = c >= 'A' && c <= 'Z';
        if (isUpper && !label.empty()) label += ' ';
        label += isUpper ? static_cast<char>(c + 32) : c;
    }
    return label;
}

bool Counts(const scene::Material& material, std::string_view object, std::string_view key,
            std::string_view name) {
    constexpr std::string_view kVolume = scene::FieldOf(&scene::Material::thicknessFactor).object;
    const scene::KeyParts parts = scene::KeyPartsOf(key);
    if (!IsPresentOrNoTexture(material, parts.object.empty() ? object : parts.object)) return false;
    if (object == kVolume || name == "priority") return material.IsTransmissive();
    if (name == "isSpecularGlossiness") return false;  // a material's model cannot be changed
    if (name == "alphaCutoff") return material.alphaMode == scene::AlphaMode::Mask;
    return true;
}

std::string GroupOf(std::string_view object, std::string_view name) {
    constexpr std::string_view kPrefix = "KHR_materials_";
    if (name.starts_with("emissive")) return "Emission";
    if (!object.starts_with(kPrefix) || name == "isUnlit" || name == "isSpecularGlossiness") return "Base";
    object.remove_prefix(kPrefix.size());
    if (object == "ior") return "Specular";
    if (object == "pbrSpecularGlossiness") return "Base";
    std::string group(object);
    std::ranges::replace(group, '_', ' ');
    group[0] = static_cast<char>(group[0] - 32);
    return group;
}

bool IsUnused(const scene::Material& material, std::string_view group) {
    const scene::Material unchanged;
    bool isUnused = true;
    scene::ForEachMaterialField([&](const auto& field) {
        if (GroupOf(field.object, field.name) != group) return;
        if constexpr (std::is_same_v<decltype(field.member), scene::TextureRef scene::Material::*>)
            isUnused &= !(material.*field.member).IsPresent();
        else
            isUnused &= material.*field.member == unchanged.*field.member;
    });
    return isUnused;
}

const char* ChannelsOf(std::string_view field) {
    constexpr std::pair<std::string_view, const char*> kChannels[] = {
        {"baseColorTexture", "RGBA"},
        {"metallicRoughnessTexture", "GB"},
        {"normalTexture", "RGB"},
        {"occlusionTexture", "R"},
        {"emissiveTexture", "RGB"},
        {"specularTexture", "A"},
        {"specularColorTexture", "RGB"},
        {"transmissionTexture", "R"},
        {"clearcoatTexture", "R"},
        {"clearcoatRoughnessTexture", "G"},
        {"clearcoatNormalTexture", "RGB"},
        {"sheenColorTexture", "RGB"},
        {"sheenRoughnessTexture", "A"},
        {"anisotropyTexture", "RGB"},
        {"iridescenceTexture", "R"},
        {"iridescenceThicknessTexture", "G"},
        {"diffuseTransmissionTexture", "A"},
        {"diffuseTransmissionColorTexture", "RGB"},
        {"retroreflectionTexture", "R"},
        {"scatterStrengthTexture", "A"},
        {"scatterColorTexture", "RGB"},
    };
    for (const auto& [name, channels] : kChannels)
        if (name == field) return channels;
    return "";
}

PickedColor ToPicked(const glm::vec3& linear) {
    PickedColor picked;
    picked.brightness = std::max({linear.x, linear.y, linear.z, 1.0f});
    for (int c = 0; c < 3; ++c) {
        const float x = std::max(linear[c], 0.0f) / picked.brightness;
        picked.encoded[c] = session::Transfer().Encode(x);
    }
    return picked;
}

glm::vec3 ToLinear(const PickedColor& color) {
    glm::vec3 linear;
    for (int c = 0; c < 3; ++c) linear[c] = color.brightness * session::Transfer().Decode(color.encoded[c]);
    return linear;
}

std::string ValueText(std::span<const float> value) {
    std::string text;
    for (const float number : value) text += Text("{}{}", text.empty() ? "" : " ", session::ToText(number));
    return text;
}

std::vector<float> NumbersFrom(std::string_view text) {
    std::vector<float> numbers;
    while (!text.empty()) {
        const size_t start = text.find_first_not_of(" \t\n,;()[]");
        if (start == text.npos) break;
        text.remove_prefix(start);
        float number = 0.0f;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
        if (error != std::errc() || !std::isfinite(number)) return {};
        text.remove_prefix(static_cast<size_t>(end - text.data()));
        numbers.push_back(number);
    }
    return numbers;
}

NumberStyle StyleOf(float value, const scene::FieldRange& range, std::string_view unit, bool zeroIsInfinite) {
    NumberStyle style;
    style.min = range.HasMin() ? range.min : -kMaxDragged;
    style.max = range.HasMax() ? range.max : kMaxDragged;
    if (zeroIsInfinite) style.min = std::max(style.min, kMinFinite);
    style.isAngle = unit == "rad";
    if (style.isAngle) {
        style.min = std::max(style.min, -kMaxTurn);
        style.max = std::min(style.max, kMaxTurn);
    }
    style.isSlider = style.isAngle || (range.HasMin() && range.HasMax() && range.max <= 1.0f);
    style.isInfinite = zeroIsInfinite && value == 0.0f;
    style.format = unit.empty() ? "%.3f" : Text("%.3f {}", unit);
    if (style.isAngle) style.format = "%.1f deg";
    if (style.isInfinite) style.format = "infinite";
    return style;
}

// --- Transforms as numbers ---

namespace {

glm::quat Turn(const Placement& placed) {
    return glm::quat(glm::radians(placed.degrees));
}

}  // namespace

Placement PlacementOf(const glm::mat4x3& local) {
    Placement placed;
    placed.translation = local[3];
    glm::mat3 turn(1.0f);
    for (int i = 0; i < 3; ++i) {
        placed.scale[i] = glm::length(local[i]);
        if (placed.scale[i] > 0.0f) turn[i] = local[i] / placed.scale[i];
    }
    if (glm::determinant(turn) < 0.0f) {
        placed.scale.x = -placed.scale.x;
        turn[0] = -turn[0];
    }
    // This orthonormal frame turns with the matrix, and scaling along its axes does not change it
    const glm::vec3 normal = glm::cross(turn[0], turn[1]);
    if (glm::length(normal) > 1e-6f) {
        turn[2] = glm::normalize(normal);
        turn[1] = glm::cross(turn[2], turn[0]);
    }
    placed.degrees = glm::degrees(glm::eulerAngles(glm::normalize(glm::quat_cast(turn)))) +
                     0.0f;  // adding 0 turns -0 into 0
    return placed;
}

glm::mat4x3 Placed(const glm::mat4x3& local, const Placement& before, const Placement& after) {
    glm::mat3 axes(local);
    if (after.degrees != before.degrees)
        axes = glm::mat3_cast(Turn(after) * glm::conjugate(Turn(before))) * axes;
    for (int i = 0; i < 3; ++i) {
        if (after.scale[i] == before.scale[i]) continue;
        if (before.scale[i] != 0.0f)
            axes[i] *= after.scale[i] / before.scale[i];
        else
            axes[i] = after.scale[i] * glm::mat3_cast(Turn(after))[i];
    }
    return {axes[0], axes[1], axes[2], after.translation};
}

}  // namespace raygraph::editor
