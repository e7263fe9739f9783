#include "renderer/gpu_scene/scene_resources.h"

#include <algorithm>
#include <cstring>

#include "renderer/gpu_scene/spatial_order.h"

namespace raygraph {

namespace {

constexpr uint64_t kStreamAlignment = 16;

// Collects the streams of one mesh, then uploads them into one buffer.
class StreamPacker {
  public:
    // Offset of the stream in the buffer to come, or kAbsent for an empty one.
    template <typename T>
    uint64_t Append(const std::vector<T>& values) {
        if (values.empty()) return kAbsent;
        const uint64_t offset = (m_bytes.size() + kStreamAlignment - 1) / kStreamAlignment * kStreamAlignment;
        m_bytes.resize(offset + values.size() * sizeof(T));
        std::memcpy(m_bytes.data() + offset, values.data(), values.size() * sizeof(T));
        return offset;
    }
    std::span<const std::byte> Bytes() const { return m_bytes; }

    static constexpr uint64_t kAbsent = ~uint64_t{0};

  private:
    std::vector<std::byte> m_bytes;
};

void AddressFrom(uint64_t& offset, VkDeviceAddress base) {
    offset = offset == StreamPacker::kAbsent ? 0 : base + offset;
}

// Uploads one mesh and appends its geometry records. The primitives of `mesh` are emptied.
MeshResources UploadMesh(rhi::Device& device, rhi::Uploader& uploader, rhi::BlasBuilder& builder,
                         scene::Mesh& mesh, std::span<const scene::Material> materials,
                         std::vector<gpu::GeometryRecord>& records) {
    MeshResources result;
    result.firstGeometry = static_cast<uint32_t>(records.size());
    StreamPacker packer;
    rhi::BlasDesc blas;
    blas.name = mesh.name.empty() ? "mesh" : mesh.name;
    for (scene::Primitive& primitive : mesh.primitives) {
        if (primitive.indices.empty()) continue;
        const std::vector<uint32_t> originalOrder = SortTriangles(primitive.positions, primitive.indices);
        // Offsets now, addresses once the buffer exists
        records.push_back({
            .positions = packer.Append(primitive.positions),
            .indices = packer.Append(primitive.indices),
            .normals = packer.Append(primitive.normals),
            .tangents = packer.Append(primitive.tangents),
            .uv0 = packer.Append(primitive.uv0),
            .uv1 = packer.Append(primitive.uv1),
            .colors = packer.Append(primitive.colors),
            .primitives = packer.Append(originalOrder),
            .material = primitive.material,
            .padding = 0,
        });
        blas.triangles.push_back({
            .vertexCount = static_cast<uint32_t>(primitive.positions.size()),
            .triangleCount = static_cast<uint32_t>(primitive.TriangleCount()),
            .isOpaque = materials[primitive.material].alphaMode == scene::AlphaMode::Opaque,
        });
        result.bounds.Extend(primitive.bounds);
        result.triangleCount += primitive.TriangleCount();
        primitive = {};
    }
    result.geometryCount = static_cast<uint32_t>(records.size()) - result.firstGeometry;
    if (result.geometryCount == 0) return result;

    result.streams = device.CreateBuffer({.name = blas.name + " streams",
                                          .size = packer.Bytes().size(),
                                          .usage = rhi::BufferUsage::Storage | rhi::BufferUsage::BuildInput |
                                                   rhi::BufferUsage::CopyDestination});
    uploader.UploadBuffer(result.streams, 0, packer.Bytes());
    const VkDeviceAddress base = result.streams.Address();
    for (uint32_t i = 0; i < result.geometryCount; i++) {
        gpu::GeometryRecord& record = records[result.firstGeometry + i];
        for (uint64_t* field : {&record.positions, &record.indices, &record.normals, &record.tangents,
                                &record.uv0, &record.uv1, &record.colors, &record.primitives})
            AddressFrom(*field, base);
        blas.triangles[i].vertices = record.positions;
        blas.triangles[i].indices = record.indices;
    }
    result.blas = builder.Add(blas);
    return result;
}

rhi::Filter ToRhi(scene::FilterMode mode) {
    return mode == scene::FilterMode::Nearest ? rhi::Filter::Nearest : rhi::Filter::Linear;
}

rhi::AddressMode ToRhi(scene::WrapMode mode) {
    switch (mode) {
        case scene::WrapMode::Repeat:
            return rhi::AddressMode::Repeat;
        case scene::WrapMode::MirroredRepeat:
            return rhi::AddressMode::MirroredRepeat;
        case scene::WrapMode::ClampToEdge:
            return rhi::AddressMode::ClampToEdge;
    }
    return rhi::AddressMode::Repeat;
}

// Samplers are few: equal ones are shared.
uint32_t SamplerFor(rhi::Device& device, const scene::Sampler& wanted, std::vector<scene::Sampler>& known,
                    std::vector<rhi::Sampler>& samplers) {
    const auto found = std::find(known.begin(), known.end(), wanted);
    const auto index = static_cast<uint32_t>(found - known.begin());
    if (found == known.end()) {
        known.push_back(wanted);
        samplers.push_back(device.CreateSampler({.name = "material sampler",
                                                 .magFilter = ToRhi(wanted.magFilter),
                                                 .minFilter = ToRhi(wanted.minFilter),
                                                 .mipFilter = ToRhi(wanted.mipFilter),
                                                 .addressU = ToRhi(wanted.wrapU),
                                                 .addressV = ToRhi(wanted.wrapV)}));
    }
    return index;
}

void UploadTextures(rhi::Device& device, rhi::Uploader& uploader, scene::SceneData& scene,
                    SceneResources& resources) {
    std::vector<uint32_t> usesLeft(scene.images.size(), 0);
    for (const scene::Texture& texture : scene.textures) usesLeft[texture.image]++;
    std::vector<scene::Sampler> known;
    for (const scene::Texture& texture : scene.textures) {
        scene::ImageData& image = scene.images[texture.image];
        TextureResources result;
        const bool isSrgb = texture.colorSpace == scene::ColorSpace::Srgb;
        result.texture =
            device.CreateTexture({.name = texture.name.empty() ? image.name : texture.name,
                                  .extent = {image.width, image.height},
                                  .format = isSrgb ? rhi::Format::Rgba8Srgb : rhi::Format::Rgba8Unorm});
        uploader.UploadTexture(result.texture, std::as_bytes(std::span(image.rgba)));
        result.sampler = SamplerFor(device, texture.sampler, known, resources.samplers);
        resources.textureBytes += image.rgba.size();
        resources.textures.push_back(std::move(result));
        if (--usesLeft[texture.image] == 0) image.rgba = {};
    }
    for (TextureResources& texture : resources.textures)
        texture.slot = resources.textureTable.Add(texture.texture, resources.samplers[texture.sampler]);
}

uint32_t TextureField(const scene::TextureRef& reference, const std::vector<TextureResources>& textures) {
    if (!reference.IsPresent()) return gpu::kNoTexture;
    constexpr uint32_t kSecondTexCoord = 0x80000000u;
    return textures[static_cast<size_t>(reference.texture)].slot |
           (reference.texCoord == 1 ? kSecondTexCoord : 0u);
}

// A table on the device; one zero record where there is none, since an empty buffer cannot be bound.
template <typename T>
rhi::Buffer UploadTable(rhi::Device& device, rhi::Uploader& uploader, const char* name,
                        std::span<const T> records) {
    const T none{};
    const std::span<const T> content = records.empty() ? std::span<const T>(&none, 1) : records;
    rhi::Buffer buffer =
        device.CreateBuffer({.name = name,
                             .size = content.size_bytes(),
                             .usage = rhi::BufferUsage::Storage | rhi::BufferUsage::CopyDestination});
    uploader.UploadBuffer(buffer, 0, std::as_bytes(content));
    return buffer;
}

}  // namespace

SceneResources::~SceneResources() {
    for (const TextureResources& texture : textures) textureTable.Remove(texture.slot);
}

gpu::MaterialRecord ToRecord(const scene::Material& values, const gpu::MaterialRecord& textures) {
    gpu::MaterialRecord record = textures;
    record.baseColor = values.baseColorFactor;
    record.emission = values.EmittedRadiance();
    record.metallic = values.metallicFactor;
    record.roughness = values.roughnessFactor;
    record.normalScale = values.normalScale;
    record.alphaCutoff = values.alphaCutoff;
    record.alphaMode = static_cast<uint32_t>(values.alphaMode);
    record.doubleSided = values.isDoubleSided ? 1u : 0u;
    return record;
}

std::unique_ptr<SceneResources> UploadScene(rhi::Device& device, rhi::Uploader& uploader,
                                            rhi::BlasBuilder& builder, rhi::TextureTable& table,
                                            scene::SceneData& scene) {
    auto resources = std::make_unique<SceneResources>(table);
    std::vector<gpu::GeometryRecord> records;
    for (scene::Mesh& mesh : scene.meshes) {
        resources->meshes.push_back(UploadMesh(device, uploader, builder, mesh, scene.materials, records));
        if (resources->meshes.back().streams)
            resources->geometryBytes += resources->meshes.back().streams.Size();
    }
    UploadTextures(device, uploader, scene, *resources);
    for (const scene::Material& material : scene.materials) {
        gpu::MaterialRecord textures{};
        textures.baseColorTexture = TextureField(material.baseColorTexture, resources->textures);
        textures.metallicRoughnessTexture =
            TextureField(material.metallicRoughnessTexture, resources->textures);
        textures.normalTexture = TextureField(material.normalTexture, resources->textures);
        textures.emissiveTexture = TextureField(material.emissiveTexture, resources->textures);
        resources->materialRecords.push_back(ToRecord(material, textures));
    }
    resources->geometryCount = static_cast<uint32_t>(records.size());
    resources->geometries = UploadTable<gpu::GeometryRecord>(device, uploader, "geometries", records);
    resources->materials =
        UploadTable<gpu::MaterialRecord>(device, uploader, "materials", resources->materialRecords);
    return resources;
}

}  // namespace raygraph
