#include "renderer/scene/gltf_materials.h"

#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "base/text.h"
#include "renderer/scene/gltf_choice.h"
#include "renderer/scene/material_fields.h"

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

// A color; left as it is when absent.
template <typename Color>
void ReadColor(const std::vector<double>& numbers, Color& color) {
    for (size_t i = 0; i < numbers.size(); ++i) color[static_cast<int>(i)] = ToFloat(numbers[i]);
}

// A texture as the file has it: no color space, perhaps no image.
struct FileTexture {
    std::string name;
    uint32_t image = kNone;
    Sampler sampler;
};

// The properties of an extension, which tinygltf keeps as values of the types that the schema has checked.
class ExtensionReader {
  public:
    ExtensionReader(const gltf::ExtensionMap& extensions, const char* name) {
        if (const auto found = extensions.find(name); found != extensions.end()) m_extension = &found->second;
    }

    // -1 is none.
    int Index(const char* key) const { return Has(key) ? m_extension->Get(key).GetNumberAsInt() : -1; }
    // What is absent leaves the value as it is.
    void Read(const char* key, float& value) const {
        if (Has(key)) value = ToFloat(m_extension->Get(key).GetNumberAsDouble());
    }
    void Read(const char* key, glm::vec3& value) const {
        for (int i = 0; Has(key) && i < 3; ++i)
            value[i] = ToFloat(m_extension->Get(key).Get(i).GetNumberAsDouble());
    }
    // Without a key: whether the extension is there.
    void Read(const char* key, bool& value) const {
        if (*key == 0) value = m_extension != nullptr;
    }
    // Of no extension.
    void Read(const char*, glm::vec4&) const {}
    void Read(const char*, uint32_t&) const {}
    void Read(const char*, AlphaMode&) const {}
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
        // An extension's image is the better one; `source` is there for readers without it. Of several the
        // one that lost least: they are decoded to whole texels, so that a smaller one saves nothing here.
        int image = file.source;
        for (const char* extension : {"MSFT_texture_dds", "EXT_texture_webp"})
            if (const int better = ExtensionReader(file.extensions, extension).Index("source"); better >= 0)
                image = better;
        texture.image = static_cast<uint32_t>(image);
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
                           Text("textures[{}] has no image that can be read, left out", index));
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

    // The texture of a field; `info` is what its place in the file says.
    template <typename Info>
    void Read(const TextureField& field, const Info& info, const Place& where, Material& material) {
        const Place object = *field.object == 0 ? where : where[field.object];
        material.*field.member = ReadTexture(info, field.colorSpace, object[field.key]);
    }

    // In the order of the fields, which decides that of the textures.
    Material ReadMaterial(const gltf::Material& file, const Place& where) {
        const gltf::PbrMetallicRoughness& pbr = file.pbrMetallicRoughness;
        Material material;
        material.name = file.name;
        ReadColor(pbr.baseColorFactor, material.baseColorFactor);
        Read(FieldOf(&Material::baseColorTexture), pbr.baseColorTexture, where, material);
        material.metallicFactor = ToFloat(pbr.metallicFactor);
        material.roughnessFactor = ToFloat(pbr.roughnessFactor);
        Read(FieldOf(&Material::metallicRoughnessTexture), pbr.metallicRoughnessTexture, where, material);
        Read(FieldOf(&Material::normalTexture), file.normalTexture, where, material);
        material.normalScale = ToFloat(file.normalTexture.scale);
        Read(FieldOf(&Material::occlusionTexture), file.occlusionTexture, where, material);
        material.occlusionStrength = ToFloat(file.occlusionTexture.strength);
        ReadColor(file.emissiveFactor, material.emissiveFactor);
        Read(FieldOf(&Material::emissiveTexture), file.emissiveTexture, where, material);
        ReadChoice(file.alphaMode, material.alphaMode);
        material.alphaCutoff = ToFloat(file.alphaCutoff);
        material.isDoubleSided = file.doubleSided;
        const Place extensions = where["extensions"];
        ForEachMaterialField([&](const auto& field) {
            if (std::string_view(field.object).starts_with("KHR_"))
                ReadOfExtension(field, ExtensionReader(file.extensions, field.object), extensions, material);
        });
        // A double: an int does not hold all priorities
        const char* const priority = FieldOf(&Material::priority).key;
        if (file.extras.IsObject() && file.extras.Has(priority))
            material.priority = static_cast<uint32_t>(file.extras.Get(priority).GetNumberAsDouble());
        return material;
    }

    void ReadOfExtension(const TextureField& field, const ExtensionReader& extension, const Place& where,
                         Material& material) {
        Read(field, extension.Texture(field.key), where, material);
    }
    template <typename T>
    void ReadOfExtension(const MaterialField<T>& field, const ExtensionReader& extension, const Place&,
                         Material& material) {
        extension.Read(field.key, material.*field.member);
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
