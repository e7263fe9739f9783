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
    ImageChoice images;
    Sampler sampler;
};

// A texture as a material names it.
struct FileTextureInfo {
    int index = -1;
    int texCoord = 0;
    TextureTransform transform;
};

// The properties of an extension, which tinygltf keeps as values of the types that the schema has checked.
class ExtensionReader {
  public:
    ExtensionReader(const gltf::ExtensionMap& extensions, const char* name) {
        if (const auto found = extensions.find(name); found != extensions.end()) m_extension = &found->second;
    }
    // The one of an object that is itself in an extension.
    ExtensionReader(const gltf::Value& object, const char* name) {
        if (!object.Has("extensions")) return;
        const gltf::Value& extensions = object.Get("extensions");
        if (extensions.Has(name)) m_extension = &extensions.Get(name);
    }
    explicit ExtensionReader(const gltf::Value* extension) : m_extension(extension) {}

    // What is in one of its objects.
    ExtensionReader In(const std::string& object) const {
        return ExtensionReader(m_extension && m_extension->Has(object) ? &m_extension->Get(object) : nullptr);
    }

    // What is absent leaves the value as it is.
    void Read(const char* key, int& value) const {
        if (Has(key)) value = m_extension->Get(key).GetNumberAsInt();
    }
    void Read(const char* key, float& value) const {
        if (Has(key)) value = ToFloat(m_extension->Get(key).GetNumberAsDouble());
    }
    double Number(const char* key, double absent) const {
        return Has(key) ? m_extension->Get(key).GetNumberAsDouble() : absent;
    }
    template <int Length>
    void Read(const char* key, glm::vec<Length, float>& value) const {
        for (int i = 0; Has(key) && i < Length; ++i)
            value[i] = ToFloat(m_extension->Get(key).Get(i).GetNumberAsDouble());
    }
    // Without a key: whether the extension is there.
    void Read(const char* key, bool& value) const {
        if (*key == 0) value = m_extension != nullptr;
    }
    // Of no extension.
    void Read(const char*, uint32_t&) const {}
    void Read(const char*, AlphaMode&) const {}
    FileTextureInfo Texture(const char* key) const {
        FileTextureInfo info;
        if (!Has(key)) return info;
        const gltf::Value& value = m_extension->Get(key);
        info.index = value.Get("index").GetNumberAsInt();
        if (value.Has("texCoord")) info.texCoord = value.Get("texCoord").GetNumberAsInt();
        ExtensionReader(value, kTextureTransform).ReadTransform(info);
        return info;
    }
    // Of KHR_texture_transform, whose set of texture coordinates is the one to be transformed.
    void ReadTransform(FileTextureInfo& info) const {
        ForEachTransformField([&](const auto& field) { Read(field.key, info.transform.*field.member); });
        Read("texCoord", info.texCoord);
    }

  private:
    bool Has(const char* key) const { return m_extension && m_extension->Has(key); }

    const gltf::Value* m_extension = nullptr;
};

// `info`: any of tinygltf's kinds of them.
template <typename Info>
FileTextureInfo ReadTextureInfo(const Info& info) {
    FileTextureInfo read{.index = info.index, .texCoord = info.texCoord, .transform = {}};
    ExtensionReader(info.extensions, kTextureTransform).ReadTransform(read);
    return read;
}

class MaterialImporter {
  public:
    MaterialImporter(GltfContext& context, const gltf::Model& model, SceneData& scene)
        : m_context(context), m_model(model), m_scene(scene) {}

    std::vector<ImageChoice> Import() {
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
        const auto add = [&](int image) {
            if (image >= 0) texture.images.push_back(static_cast<uint32_t>(image));
        };
        for (const char* extension : {"EXT_texture_webp", "MSFT_texture_dds", "KHR_texture_basisu"}) {
            int image = -1;
            ExtensionReader(file.extensions, extension).Read("source", image);
            add(image);
        }
        add(file.source);
        return texture;
    }

    TextureRef ReadTexture(const FileTextureInfo& info, ColorSpace colorSpace, const Place& where) {
        TextureRef ref;
        if (info.index < 0) return ref;
        ref.texCoord = info.texCoord;
        ref.transform = info.transform;
        const auto index = static_cast<uint32_t>(info.index);
        const FileTexture& file = m_fileTextures[index];
        if (file.images.empty()) {
            m_context.Warn(where, "no image",
                           Text("textures[{}] has no image that can be read, left out", index));
            return ref;
        }
        const auto [slot, isNew] = m_textureSlots.try_emplace({index, colorSpace}, m_scene.textures.size());
        if (isNew) m_scene.textures.push_back({file.name, ImageSlot(file.images), file.sampler, colorSpace});
        ref.texture = static_cast<int32_t>(slot->second);
        return ref;
    }

    uint32_t ImageSlot(const ImageChoice& choice) {
        const auto [slot, isNew] = m_imageSlots.try_emplace(choice, static_cast<uint32_t>(m_images.size()));
        if (isNew) m_images.push_back(choice);
        return slot->second;
    }

    // The texture of a field; `info` is what its place in the file says.
    void Read(const TextureField& field, const FileTextureInfo& info, const Place& where,
              Material& material) {
        const Place object = *field.object == 0 ? where : where[field.object];
        material.*field.member = ReadTexture(info, field.colorSpace, object[field.key]);
    }

    // In the order of the fields, which decides that of the textures.
    Material ReadMaterial(const gltf::Material& file, const Place& where) {
        const gltf::PbrMetallicRoughness& pbr = file.pbrMetallicRoughness;
        constexpr TextureField kBaseColor = FieldOf(&Material::baseColorTexture);
        constexpr TextureField kMetallicRoughness = FieldOf(&Material::metallicRoughnessTexture);
        constexpr TextureField kNormal = FieldOf(&Material::normalTexture);
        constexpr TextureField kOcclusion = FieldOf(&Material::occlusionTexture);
        constexpr TextureField kEmissive = FieldOf(&Material::emissiveTexture);
        constexpr const char* kPriority = FieldOf(&Material::priority).key;
        Material material;
        const auto readTexture = [&](const TextureField& field, const auto& info) {
            Read(field, ReadTextureInfo(info), where, material);
        };
        material.name = file.name;
        if (file.extensions.contains(material_fields::kSpecularGlossiness)) {
            ReadGlossiness(file, where, material);
        } else {
            ReadColor(pbr.baseColorFactor, material.baseColorFactor);
            readTexture(kBaseColor, pbr.baseColorTexture);
            material.metallicFactor = ToFloat(pbr.metallicFactor);
            material.roughnessFactor = ToFloat(pbr.roughnessFactor);
            readTexture(kMetallicRoughness, pbr.metallicRoughnessTexture);
        }
        readTexture(kNormal, file.normalTexture);
        material.normalScale = ToFloat(file.normalTexture.scale);
        readTexture(kOcclusion, file.occlusionTexture);
        material.occlusionStrength = ToFloat(file.occlusionTexture.strength);
        ReadColor(file.emissiveFactor, material.emissiveFactor);
        readTexture(kEmissive, file.emissiveTexture);
        ReadChoice(file.alphaMode, material.alphaMode);
        material.alphaCutoff = ToFloat(file.alphaCutoff);
        material.isDoubleSided = file.doubleSided;
        const Place extensions = where["extensions"];
        ForEachFieldOf(material, [&](const auto& field) {
            if (std::string_view(field.object).starts_with("KHR_"))
                ReadOfExtension(field, ExtensionReader(file.extensions, field.object), extensions, material);
        });
        constexpr const char* kMediumTexture = "multiscatterColorTexture";
        if (ExtensionReader(file.extensions, material_fields::kVolumeScatter).Texture(kMediumTexture).index >=
            0)
            m_context.Warn(extensions[material_fields::kVolumeScatter][kMediumTexture], "texture of a medium",
                           "is not read: a medium is the same everywhere");
        // A double: an int does not hold all priorities
        if (file.extras.IsObject() && file.extras.Has(kPriority))
            material.priority = static_cast<uint32_t>(file.extras.Get(kPriority).GetNumberAsDouble());
        return material;
    }

    // What KHR_materials_pbrSpecularGlossiness stands for, but for what is in the places of its own, which
    // are read as those of other extensions are.
    void ReadGlossiness(const gltf::Material& file, const Place& where, Material& material) {
        material.isSpecularGlossiness = true;
        material.metallicFactor = 0.0f;
        material.ior = 0.0f;
        const char* const others[] = {FieldOf(&Material::ior).object, material_fields::kSpecular};
        for (const char* other : others)
            if (file.extensions.contains(other))
                m_context.Warn(where["extensions"][other], "beside specular-glossiness",
                               "has no effect: the material is one of KHR_materials_pbrSpecularGlossiness");
    }

    void ReadOfExtension(const TextureField& field, const ExtensionReader& extension, const Place& where,
                         Material& material) {
        Read(field, extension.Texture(field.key), where, material);
    }
    template <typename T>
    void ReadOfExtension(const MaterialField<T>& field, const ExtensionReader& extension, const Place&,
                         Material& material) {
        const KeyParts parts = KeyPartsOf(field.key);
        if (IsGlossiness(field))
            material.roughnessFactor = ToFloat(1.0 - extension.Number(field.key, 1.0));
        else if (parts.object.empty())
            extension.Read(field.key, material.*field.member);
        else
            extension.In(std::string(parts.object)).Read(parts.key.data(), material.*field.member);
    }

    GltfContext& m_context;
    const gltf::Model& m_model;
    SceneData& m_scene;
    std::vector<FileTexture> m_fileTextures;
    std::map<std::pair<uint32_t, ColorSpace>, size_t> m_textureSlots;
    std::map<ImageChoice, uint32_t> m_imageSlots;
    std::vector<ImageChoice> m_images;
};

}  // namespace

std::vector<ImageChoice> ReadMaterials(GltfContext& context, const gltf::Model& model, SceneData& scene) {
    return MaterialImporter(context, model, scene).Import();
}

}  // namespace raygraph::scene
