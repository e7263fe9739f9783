#include "renderer/scene/gltf_materials.h"

#include <map>
#include <string>
#include <utility>

namespace raygraph::scene {
namespace {

// glTF's numbers of wraps and filters are OpenGL's.
WrapMode ReadWrap(int number) {
    switch (number) {
        case TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE:
            return WrapMode::ClampToEdge;
        case TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT:
            return WrapMode::MirroredRepeat;
        default:
            return WrapMode::Repeat;
    }
}

Sampler ReadSampler(const gltf::Sampler& file) {
    Sampler sampler;
    sampler.wrapU = ReadWrap(file.wrapS);
    sampler.wrapV = ReadWrap(file.wrapT);
    if (file.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST) sampler.magFilter = FilterMode::Nearest;
    const auto set = [&](FilterMode minFilter, bool usesMips, FilterMode mipFilter) {
        sampler.minFilter = minFilter;
        sampler.usesMips = usesMips;
        sampler.mipFilter = mipFilter;
    };
    switch (file.minFilter) {
        case TINYGLTF_TEXTURE_FILTER_NEAREST:
            set(FilterMode::Nearest, false, FilterMode::Nearest);
            break;
        case TINYGLTF_TEXTURE_FILTER_LINEAR:
            set(FilterMode::Linear, false, FilterMode::Nearest);
            break;
        case TINYGLTF_TEXTURE_FILTER_NEAREST_MIPMAP_NEAREST:
            set(FilterMode::Nearest, true, FilterMode::Nearest);
            break;
        case TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_NEAREST:
            set(FilterMode::Linear, true, FilterMode::Nearest);
            break;
        case TINYGLTF_TEXTURE_FILTER_NEAREST_MIPMAP_LINEAR:
            set(FilterMode::Nearest, true, FilterMode::Linear);
            break;
        default:
            set(FilterMode::Linear, true, FilterMode::Linear);
            break;
    }
    return sampler;
}

// Finite and in its range: the schema has seen to it.
float ToFloat(double number) {
    return static_cast<float>(number);
}

// A colour; left as it is when absent.
template <typename Color>
void ReadColor(const std::vector<double>& numbers, Color& color) {
    for (size_t i = 0; i < numbers.size(); ++i) color[static_cast<int>(i)] = ToFloat(numbers[i]);
}

// A texture as the file has it: no colour space, perhaps no image.
struct FileTexture {
    std::string name;
    uint32_t image = kNone;
    Sampler sampler;
};

// The properties of an extension, which tinygltf keeps as values of the types that the schema has checked.
class ExtensionReader {
  public:
    ExtensionReader(const gltf::ExtensionMap& extensions, const char* name) : m_name(name) {
        if (const auto found = extensions.find(name); found != extensions.end()) m_extension = &found->second;
    }

    bool IsPresent() const { return m_extension != nullptr; }
    const char* Name() const { return m_name; }
    float Number(const char* key, float absent) const {
        return Has(key) ? ToFloat(m_extension->Get(key).GetNumberAsDouble()) : absent;
    }
    // -1 is none.
    int Index(const char* key) const { return Has(key) ? m_extension->Get(key).GetNumberAsInt() : -1; }
    void Color(const char* key, glm::vec3& color) const {
        for (int i = 0; Has(key) && i < 3; ++i)
            color[i] = ToFloat(m_extension->Get(key).Get(i).GetNumberAsDouble());
    }
    gltf::TextureInfo Texture(const char* key) const {
        gltf::TextureInfo info;
        if (!Has(key)) return info;
        const gltf::Value& value = m_extension->Get(key);
        info.index = value.Get("index").GetNumberAsInt();
        if (value.Has("texCoord")) info.texCoord = value.Get("texCoord").GetNumberAsInt();
        return info;
    }

  private:
    bool Has(const char* key) const { return m_extension && m_extension->Has(key); }

    const char* m_name;
    const gltf::Value* m_extension = nullptr;
};

class MaterialImporter {
  public:
    MaterialImporter(GltfContext& context, const gltf::Model& model, SceneData& scene)
        : m_context(context), m_model(model), m_scene(scene), m_imageSlots(model.images.size(), kNone) {}

    std::vector<uint32_t> Import() {
        for (const gltf::Texture& texture : m_model.textures)
            m_fileTextures.push_back(ReadFileTexture(texture));
        for (size_t i = 0; i < m_model.materials.size(); ++i)
            m_scene.materials.push_back(ReadMaterial(m_model.materials[i], Place("materials")[i]));
        return std::move(m_images);
    }

  private:
    FileTexture ReadFileTexture(const gltf::Texture& file) const {
        FileTexture texture;
        texture.name = file.name;
        if (file.sampler >= 0)
            texture.sampler = ReadSampler(m_model.samplers[static_cast<size_t>(file.sampler)]);
        // The extension's image is the better one; `source` is there for readers without WebP.
        const int webp = ExtensionReader(file.extensions, "EXT_texture_webp").Index("source");
        texture.image = static_cast<uint32_t>(webp >= 0 ? webp : file.source);
        return texture;
    }

    // `info`: any of tinygltf's kinds of them.
    template <typename Info>
    TextureRef ReadTexture(const Info& info, ColorSpace colorSpace, const Place& where) {
        TextureRef ref;
        if (info.index < 0) return ref;
        ref.texCoord = info.texCoord;
        const auto index = static_cast<uint32_t>(info.index);
        const FileTexture& file = m_fileTextures[index];
        if (file.image == kNone) {
            m_context.Warn(where, "no image",
                           "textures[" + std::to_string(index) + "] has no image that can be read, left out");
            return ref;
        }
        const auto [slot, isNew] = m_textureSlots.try_emplace({index, colorSpace}, m_scene.textures.size());
        if (isNew) m_scene.textures.push_back({file.name, ImageSlot(file.image), file.sampler, colorSpace});
        ref.texture = static_cast<int32_t>(slot->second);
        return ref;
    }

    uint32_t ImageSlot(uint32_t image) {
        if (m_imageSlots[image] == kNone) {
            m_imageSlots[image] = static_cast<uint32_t>(m_images.size());
            m_images.push_back(image);
        }
        return m_imageSlots[image];
    }

    Material ReadMaterial(const gltf::Material& file, const Place& where) {
        const gltf::PbrMetallicRoughness& pbr = file.pbrMetallicRoughness;
        const Place pbrPlace = where["pbrMetallicRoughness"];
        Material material;
        material.name = file.name;
        ReadColor(pbr.baseColorFactor, material.baseColorFactor);
        material.baseColorTexture =
            ReadTexture(pbr.baseColorTexture, ColorSpace::Srgb, pbrPlace["baseColorTexture"]);
        material.metallicFactor = ToFloat(pbr.metallicFactor);
        material.roughnessFactor = ToFloat(pbr.roughnessFactor);
        material.metallicRoughnessTexture = ReadTexture(pbr.metallicRoughnessTexture, ColorSpace::Linear,
                                                        pbrPlace["metallicRoughnessTexture"]);
        material.normalTexture = ReadTexture(file.normalTexture, ColorSpace::Linear, where["normalTexture"]);
        material.normalScale = ToFloat(file.normalTexture.scale);
        material.occlusionTexture =
            ReadTexture(file.occlusionTexture, ColorSpace::Linear, where["occlusionTexture"]);
        material.occlusionStrength = ToFloat(file.occlusionTexture.strength);
        ReadColor(file.emissiveFactor, material.emissiveFactor);
        material.emissiveTexture =
            ReadTexture(file.emissiveTexture, ColorSpace::Srgb, where["emissiveTexture"]);
        if (file.alphaMode == "MASK") material.alphaMode = AlphaMode::Mask;
        if (file.alphaMode == "BLEND") material.alphaMode = AlphaMode::Blend;
        material.alphaCutoff = ToFloat(file.alphaCutoff);
        material.isDoubleSided = file.doubleSided;
        ReadExtensions(file.extensions, where["extensions"], material);
        // A double: an int does not hold all priorities
        if (file.extras.IsObject() && file.extras.Has("priority"))
            material.priority = static_cast<uint32_t>(file.extras.Get("priority").GetNumberAsDouble());
        return material;
    }

    void ReadExtensions(const gltf::ExtensionMap& extensions, const Place& where, Material& material) {
        const auto texture = [&](const ExtensionReader& extension, const char* key, ColorSpace colorSpace) {
            return ReadTexture(extension.Texture(key), colorSpace, where[extension.Name()][key]);
        };
        const ExtensionReader strength(extensions, "KHR_materials_emissive_strength");
        material.emissiveStrength = strength.Number("emissiveStrength", 1.0f);

        const ExtensionReader ior(extensions, "KHR_materials_ior");
        material.ior = ior.Number("ior", 1.5f);

        const ExtensionReader specular(extensions, "KHR_materials_specular");
        material.specularFactor = specular.Number("specularFactor", 1.0f);
        material.specularTexture = texture(specular, "specularTexture", ColorSpace::Linear);
        specular.Color("specularColorFactor", material.specularColorFactor);
        material.specularColorTexture = texture(specular, "specularColorTexture", ColorSpace::Srgb);

        const ExtensionReader transmission(extensions, "KHR_materials_transmission");
        material.transmissionFactor = transmission.Number("transmissionFactor", 0.0f);
        material.transmissionTexture = texture(transmission, "transmissionTexture", ColorSpace::Linear);

        const ExtensionReader volume(extensions, "KHR_materials_volume");
        material.thicknessFactor = volume.Number("thicknessFactor", 0.0f);
        volume.Color("attenuationColor", material.attenuationColor);
        material.attenuationDistance = volume.Number("attenuationDistance", 0.0f);

        material.isUnlit = ExtensionReader(extensions, "KHR_materials_unlit").IsPresent();
    }

    GltfContext& m_context;
    const gltf::Model& m_model;
    SceneData& m_scene;
    std::vector<FileTexture> m_fileTextures;
    std::map<std::pair<uint32_t, ColorSpace>, size_t> m_textureSlots;
    std::vector<uint32_t> m_imageSlots;  // By the file's image index.
    std::vector<uint32_t> m_images;
};

}  // namespace

std::vector<uint32_t> ReadMaterials(GltfContext& context, const gltf::Model& model, SceneData& scene) {
    return MaterialImporter(context, model, scene).Import();
}

}  // namespace raygraph::scene
