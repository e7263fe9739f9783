// What of a scene is hashed, and how: content_hash.h. Not installed. Whoever changes what is hashed raises
// kFormat in render_file_names.h. Threads: exclusive access.
#pragma once

#include <concepts>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <vector>

#include "renderer/image/image.h"
#include "renderer/scene/light_fields.h"
#include "renderer/scene/material_fields.h"

namespace raygraph::session {

// A number, or a vector or matrix of numbers: without padding.
template <typename T>
concept Plain = std::is_arithmetic_v<T> || std::is_enum_v<T> || requires {
    typename T::value_type;
    { T::length() } -> std::convertible_to<int>;
};

class ContentHasher {
  public:
    ContentHasher();
    ~ContentHasher();

    // Sixteen hexadecimal digits.
    std::string Text() const;

    template <typename... Values>
    void AddAll(const Values&... values) {
        (Add(values), ...);
    }

    void Add(const Plain auto& value) { AddBytes(&value, sizeof value); }
    void Add(std::string_view text) { AddRun(std::span(text)); }
    template <typename T>
    void Add(const std::optional<T>& value) {
        Add(value.has_value());
        if (value) Add(*value);
    }
    template <typename T>
    void Add(const std::vector<T>& values) {
        if constexpr (Plain<T>) {
            AddRun(std::span(values));
        } else {
            Add(uint64_t{values.size()});
            for (const T& value : values) Add(value);
        }
    }

    // Those of `fields`, a list of fields, that are not at their default, each with its name. So a field that
    // is added to Material leaves the hashes of scenes without it as they are, and their renders resumable.
    template <typename Owner, typename... Fields>
    void AddChanged(const Owner& owner, const std::tuple<Fields...>& fields) {
        const Owner atDefault;
        const auto addIfChanged = [&](const auto& field) {
            if (owner.*field.member == atDefault.*field.member) return;
            Add(std::string_view(field.name));
            Add(owner.*field.member);
        };
        std::apply([&](const auto&... field) { (addIfChanged(field), ...); }, fields);
        Add(std::string_view());  // the end: no field's name
    }

    // Each names all fields of its struct: one that is added to the struct does not compile until it is added
    // here, and to the hash if a picture can depend on it.
    void Add(const scene::Bounds& bounds) {
        const auto& [min, max] = bounds;
        AddAll(min, max);
    }
    void Add(const scene::Primitive& primitive) {
        // Without variants: `material` is that of the one that is shown
        const auto& [positions, normals, tangents, tangentTexCoord, frameTurns, uv0, uv1, colors, indices,
                     material, bounds, variants, radii, influences, targets, hasFlatNormals] = primitive;
        AddAll(positions, normals, tangents, uv0, uv1, colors, indices, material, bounds);
        // Scenes of triangles keep their hash, as do those that nothing deforms
        if (!radii.empty()) Add(radii);
        if (tangentTexCoord != scene::kNone) AddAll(std::string_view("tangents"), tangentTexCoord);
        if (!frameTurns.empty()) AddAll(std::string_view("turns"), frameTurns);
        if (!influences.IsEmpty()) AddAll(std::string_view("joints"), influences);
        if (!targets.empty()) AddAll(std::string_view("targets"), targets);
        if (hasFlatNormals && (!influences.IsEmpty() || !targets.empty())) Add(std::string_view("flat"));
    }
    void Add(const scene::JointInfluences& influences) {
        const auto& [perVertex, joints, weights, bounds] = influences;
        AddAll(perVertex, joints, weights);
    }
    void Add(const scene::MorphTarget& target) {
        const auto& [positions, normals, tangents, bounds] = target;
        AddAll(positions, normals, tangents);
    }
    void Add(const scene::Mesh& mesh) {
        const auto& [name, primitives, weights] = mesh;
        Add(primitives);
        if (!weights.empty()) Add(weights);
    }
    void Add(const scene::TextureRef& reference) {
        const auto& [texture, texCoord, transform] = reference;
        AddAll(texture, texCoord);
        if (transform != scene::TextureTransform{}) AddChanged(transform, scene::kTransformFields);
    }
    void Add(const scene::Material& material) {
        Add(material.name);
        AddChanged(material, scene::material_fields::kAll);
    }
    void Add(const scene::Sampler& sampler) {
        const auto& [wrapU, wrapV, magFilter, minFilter, mipFilter, usesMips] = sampler;
        AddAll(wrapU, wrapV, magFilter, minFilter, mipFilter, usesMips);
    }
    void Add(const scene::Texture& texture) {
        const auto& [name, image, sampler, colorSpace] = texture;
        AddAll(image, sampler, colorSpace);
    }
    void Add(const scene::ImageData& image) {
        const auto& [name, width, height, rgba, blocks, lowestAlpha] = image;
        AddAll(width, height, rgba);
        if (!blocks.IsEmpty()) Add(blocks);
    }
    void Add(const image::BlockLevels& blocks) {
        const auto& [coding, levels] = blocks;
        AddAll(coding, levels);
    }
    void Add(const scene::Node& node) {
        const auto& [name, parent, translation, translationRest, rotation, scale, matrix, mesh, isVisible,
                     skin, weights] = node;
        AddAll(name, parent, translation, translationRest, rotation, scale, matrix, mesh);
        if (!isVisible) Add(std::string_view("hidden"));
        if (skin != scene::kNone) AddAll(std::string_view("skin"), skin);
        if (!weights.empty()) AddAll(std::string_view("weights"), weights);
    }
    void Add(const scene::Instance& instance) {
        // Without objectToNode: objectToWorld follows from it
        const auto& [mesh, node, objectToWorld, translationRest, objectToNode, isDeformed, isCollapsed] =
            instance;
        AddAll(mesh, node, objectToWorld, translationRest);
        if (isDeformed) Add(std::string_view("deformed"));
        if (isCollapsed) Add(std::string_view("collapsed"));
    }
    void Add(const scene::Camera& camera) {
        const auto& [name, node, projection, yFov, aspectRatio, xMag, yMag, zNear, zFar, cameraToWorld,
                     translationRest] = camera;
        AddAll(name, node, projection, yFov, aspectRatio, xMag, yMag, zNear, zFar, cameraToWorld,
               translationRest);
    }
    void Add(const scene::Light& light) {
        const auto& [name, node, type, color, intensity, range, innerConeAngle, outerConeAngle, profile,
                     lightToWorld, translationRest] = light;
        AddAll(name, node, type, lightToWorld, translationRest);
        if (profile != scene::kNone) AddAll(std::string_view("profile"), profile);
        AddChanged(light, scene::light_fields::kAll);
    }
    void Add(const scene::LightProfile& profile) {
        const auto& [name, type, vertical, horizontal, candela] = profile;
        AddAll(name, type, vertical, horizontal, candela);
    }
    void Add(const scene::EnvironmentLight& light) {
        const auto& [name, faceSize, map] = light;
        Add(map);
    }
    void Add(const scene::SceneData& scene) {
        const auto& [name, meshes, materials, textures, images, nodes, nodeOrder, instances, cameras, lights,
                     profiles, environment, bounds, warnings, variants, variant, skins, animations] = scene;
        AddAll(meshes, materials, textures, images, nodes, nodeOrder, instances, cameras, lights, bounds);
        if (!profiles.empty()) Add(profiles);
        if (environment.IsPresent()) Add(environment);
        if (!skins.empty()) Add(skins);
        if (!animations.empty()) Add(animations);
    }
    void Add(const scene::Skin& skin) {
        const auto& [name, joints, inverseBinds] = skin;
        AddAll(joints, inverseBinds);
    }
    void Add(const scene::AnimationSampler& sampler) {
        const auto& [interpolation, width, times, values] = sampler;
        AddAll(interpolation, width, times, values);
    }
    void Add(const scene::AnimationTarget& target) {
        const auto& [property, field, object, element] = target;
        AddAll(property, field, object, element);
    }
    void Add(const scene::AnimationChannel& channel) {
        const auto& [sampler, target] = channel;
        AddAll(sampler, target);
    }
    // With its name, by which options may choose.
    void Add(const scene::Animation& animation) {
        const auto& [name, samplers, channels, duration, defect] = animation;
        AddAll(name, samplers, channels);
    }
    void Add(const image::ImageF& image) {
        const auto& [width, height, rgba] = image;
        AddAll(width, height, rgba);
    }

  private:
    // With its length, so that what lies in neighboring lists is not mixed up.
    template <typename T>
    void AddRun(std::span<T> values) {
        Add(uint64_t{values.size()});
        AddBytes(values.data(), values.size_bytes());
    }

    void AddBytes(const void* bytes, size_t size);

    struct State;
    std::unique_ptr<State> m_state;
};

}  // namespace raygraph::session
