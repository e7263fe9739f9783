#include "editor/cli/content_hash.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace raygraph::cli {

namespace {

void AddTexture(ContentHash& hash, const scene::TextureRef& reference) {
    hash.Add(reference.texture);
    hash.Add(reference.texCoord);
}

void AddPrimitive(ContentHash& hash, const scene::Primitive& primitive) {
    hash.Add(primitive.positions);
    hash.Add(primitive.normals);
    hash.Add(primitive.tangents);
    hash.Add(primitive.uv0);
    hash.Add(primitive.uv1);
    hash.Add(primitive.colors);
    hash.Add(primitive.indices);
    hash.Add(primitive.material);
}

void AddMaterial(ContentHash& hash, const scene::Material& material) {
    hash.Add(material.baseColorFactor);
    AddTexture(hash, material.baseColorTexture);
    hash.Add(material.metallicFactor);
    hash.Add(material.roughnessFactor);
    AddTexture(hash, material.metallicRoughnessTexture);
    AddTexture(hash, material.normalTexture);
    hash.Add(material.normalScale);
    hash.Add(material.emissiveFactor);
    hash.Add(material.emissiveStrength);
    AddTexture(hash, material.emissiveTexture);
    hash.Add(material.alphaMode);
    hash.Add(material.alphaCutoff);
    hash.Add(material.isDoubleSided);
}

void AddTextureAndImage(ContentHash& hash, const scene::SceneData& scene) {
    for (const scene::Texture& texture : scene.textures) {
        hash.Add(texture.image);
        hash.Add(texture.sampler.wrapU);
        hash.Add(texture.sampler.wrapV);
        hash.Add(texture.sampler.magFilter);
        hash.Add(texture.sampler.minFilter);
        hash.Add(texture.colorSpace);
    }
    for (const scene::ImageData& image : scene.images) {
        hash.Add(image.width);
        hash.Add(image.rgba);
    }
}

void AddCamerasAndLights(ContentHash& hash, const scene::SceneData& scene) {
    for (const scene::Camera& camera : scene.cameras) {
        hash.Add(camera.projection);
        hash.Add(camera.yFov);
        hash.Add(camera.xMag);
        hash.Add(camera.yMag);
        hash.Add(camera.cameraToWorld);
    }
    for (const scene::Light& light : scene.lights) {
        hash.Add(light.type);
        hash.Add(light.color);
        hash.Add(light.intensity);
        hash.Add(light.innerConeAngle);
        hash.Add(light.outerConeAngle);
        hash.Add(light.lightToWorld);
    }
}

}  // namespace

void ContentHash::AddBytes(std::span<const std::byte> bytes) {
    for (size_t i = 0; i < bytes.size(); i += sizeof(uint64_t)) {
        uint64_t word = 0;
        std::memcpy(&word, bytes.data() + i, std::min(sizeof(word), bytes.size() - i));
        // One round of a multiplicative hash; the shift carries high bits back down
        m_hash = (m_hash ^ word) * 0x2545F4914F6CDD1Du;
        m_hash ^= m_hash >> 29;
    }
}

std::string ContentHash::Text() const {
    constexpr std::string_view kDigits = "0123456789abcdef";
    std::string text;
    for (int shift = 60; shift >= 0; shift -= 4) text += kDigits[(m_hash >> shift) & 15];
    return text;
}

std::string HashOf(const scene::SceneData& scene) {
    ContentHash hash;
    for (const scene::Mesh& mesh : scene.meshes)
        for (const scene::Primitive& primitive : mesh.primitives) AddPrimitive(hash, primitive);
    for (const scene::Material& material : scene.materials) AddMaterial(hash, material);
    AddTextureAndImage(hash, scene);
    for (const scene::Instance& instance : scene.instances) {
        hash.Add(instance.mesh);
        hash.Add(instance.objectToWorld);
    }
    AddCamerasAndLights(hash, scene);
    return hash.Text();
}

std::string HashOf(const image::ImageF& image) {
    ContentHash hash;
    hash.Add(image.width);
    hash.Add(image.rgba);
    return hash.Text();
}

}  // namespace raygraph::cli
