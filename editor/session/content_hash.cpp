#include "editor/session/content_hash.h"

// All of it is compiled in, so that hosts need no library for it.
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <concepts>
#include <memory>
#include <optional>
#include <span>
#include <type_traits>
#include <vector>

#include "renderer/scene/material_fields.h"

namespace raygraph::session {

namespace {

// A number, or a vector or matrix of numbers: without padding.
template <typename T>
concept Plain = std::is_arithmetic_v<T> || std::is_enum_v<T> || requires {
    typename T::value_type;
    { T::length() } -> std::convertible_to<int>;
};

class ContentHash {
  public:
    ContentHash() : m_state(XXH3_createState()) {
        if (!m_state) throw std::bad_alloc();
        XXH3_64bits_reset(m_state.get());
    }

    template <typename... Values>
    void AddAll(const Values&... values) {
        (Add(values), ...);
    }

    void Add(const Plain auto& value) { XXH3_64bits_update(m_state.get(), &value, sizeof value); }
    void Add(const std::string& text) { AddRun(std::span(text)); }
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

    // Each names all fields of its struct: one that is added to the struct does not compile until it is added
    // here, and to the hash if a picture can depend on it.
    void Add(const scene::Bounds& bounds) {
        const auto& [min, max] = bounds;
        AddAll(min, max);
    }
    void Add(const scene::Primitive& primitive) {
        const auto& [positions, normals, tangents, uv0, uv1, colors, indices, material, bounds] = primitive;
        AddAll(positions, normals, tangents, uv0, uv1, colors, indices, material, bounds);
    }
    void Add(const scene::Mesh& mesh) {
        const auto& [name, primitives] = mesh;
        Add(primitives);
    }
    void Add(const scene::TextureRef& reference) {
        const auto& [texture, texCoord] = reference;
        AddAll(texture, texCoord);
    }
    void Add(const scene::Material& material) {
        Add(material.name);
        scene::ForEachMaterialField([&](const auto& field) { Add(material.*field.member); });
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
        const auto& [name, width, height, rgba] = image;
        AddAll(width, height, rgba);
    }
    void Add(const scene::Node& node) {
        const auto& [name, parent, translation, translationRest, rotation, scale, matrix, mesh] = node;
        AddAll(name, parent, translation, translationRest, rotation, scale, matrix, mesh);
    }
    void Add(const scene::Instance& instance) {
        const auto& [mesh, node, objectToWorld, translationRest] = instance;
        AddAll(mesh, node, objectToWorld, translationRest);
    }
    void Add(const scene::Camera& camera) {
        const auto& [name, node, projection, yFov, aspectRatio, xMag, yMag, zNear, zFar, cameraToWorld,
                     translationRest] = camera;
        AddAll(name, node, projection, yFov, aspectRatio, xMag, yMag, zNear, zFar, cameraToWorld,
               translationRest);
    }
    void Add(const scene::Light& light) {
        const auto& [name, node, type, color, intensity, range, innerConeAngle, outerConeAngle, lightToWorld,
                     translationRest] = light;
        AddAll(name, node, type, color, intensity, range, innerConeAngle, outerConeAngle, lightToWorld,
               translationRest);
    }
    void Add(const scene::SceneData& scene) {
        const auto& [name, meshes, materials, textures, images, nodes, nodeOrder, instances, cameras, lights,
                     bounds, warnings] = scene;
        AddAll(meshes, materials, textures, images, nodes, nodeOrder, instances, cameras, lights, bounds);
    }
    void Add(const image::ImageF& image) {
        const auto& [width, height, rgba] = image;
        AddAll(width, height, rgba);
    }

    std::string Text() const {
        constexpr std::string_view kDigits = "0123456789abcdef";
        const uint64_t hash = XXH3_64bits_digest(m_state.get());
        std::string text;
        for (int shift = 60; shift >= 0; shift -= 4) text += kDigits[(hash >> shift) & 15];
        return text;
    }

  private:
    // With its length, so that what lies in neighboring lists is not mixed up.
    template <typename T>
    void AddRun(std::span<T> values) {
        Add(uint64_t{values.size()});
        XXH3_64bits_update(m_state.get(), values.data(), values.size_bytes());
    }

    struct FreeState {
        void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
    };
    std::unique_ptr<XXH3_state_t, FreeState> m_state;
};

template <typename T>
std::string TextOf(const T& content) {
    ContentHash hash;
    hash.Add(content);
    return hash.Text();
}

}  // namespace

std::string HashOf(const scene::SceneData& scene) {
    return TextOf(scene);
}

std::string HashOf(const image::ImageF& image) {
    return TextOf(image);
}

}  // namespace raygraph::session
