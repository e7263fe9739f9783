#include "renderer/scene/gltf/materials.h"

#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "base/text.h"
#include "renderer/scene/gltf/choice_names.h"
#include "renderer/scene/gltf/reader.h"
#include "renderer/scene/model/scene_fields.h"

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

// Reads a color; leaves it as it is when absent.
template <typename Color>
void ReadColor(const std::vector<double>& numbers, Color& color) {
    for (size_t i = 0; i < numbers.size(); ++i) color[static_cast<int>(i)] = ToFloat(numbers[i]);
}

// Describes a texture as the file has it: no color space, perhaps no image.
struct FileTexture {
    std::string name;
    ImageChoice images;
    Sampler sampler;
};

// Describes a texture as a material names it.
struct FileTextureInfo {
    int index = -1;
    int texCoord = 0;
    TextureTransform transform;
};

// Reads KHR_texture_transform, whose set of texture coordinates is the one to be transformed.
void ReadTransform(const ValueReader& extension, FileTextureInfo& info) {
    ForEachTransformField(
        [&](const auto& field) { extension.Read(field.key, info.transform.*field.member); });
    extension.Read("texCoord", info.texCoord);
}

// `info` is any of tinygltf's kinds of texture infos.
template <typename Info>
FileTextureInfo ReadTextureInfo(const Info& info) {
    FileTextureInfo read{.index = info.index, .texCoord = info.texCoord, .transform = {}};
    ReadTransform(ValueReader(info.extensions, kTextureTransform), read);
    return read;
}
// Reads a texture that is in an extension.
FileTextureInfo ReadTextureInfo(const ValueReader& file) {
    FileTextureInfo info;
    file.Read("index", info.index);
    file.Read("texCoord", info.texCoord);
    ReadTransform(file.In("extensions").In(kTextureTransform), info);
    return info;
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
            ValueReader(file.extensions, extension).Read("source", image);
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

    // Reads the texture of a field; `info` is what its place in the file says.
    void Read(const TextureField& field, const FileTextureInfo& info, const Place& where,
              Material& material) {
        const Place object = *field.object == 0 ? where : where[field.object];
        material.*field.member = ReadTexture(info, field.colorSpace, object[field.key]);
    }

    // Reads the fields in their order, which determines that of the textures.
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
        if (file.extensions.contains(kSpecularGlossiness)) {
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
                ReadOfExtension(field, ValueReader(file.extensions, field.object), extensions, material);
        });
        constexpr const char* kMedium = FieldOf(&Material::multiscatterColorFactor).object;
        constexpr const char* kMediumTexture = "multiscatterColorTexture";
        if (ValueReader(file.extensions, kMedium).In(kMediumTexture))
            m_context.Warn(extensions[kMedium][kMediumTexture], "texture of a medium",
                           "is not read: a medium is the same everywhere");
        if (material.BoundsMedium() && material.scatterStrengthFactor > 0.0f &&
            (material.scatterStrengthTexture.IsPresent() || material.scatterColorTexture.IsPresent()))
            m_context.Warn(extensions[FieldOf(&Material::scatterStrengthFactor).object],
                           "texture of a medium",
                           "has textures, which are not read: a medium is the same everywhere");
        // The number is read as a double, since an int does not hold all priorities
        if (file.extras.IsObject() && file.extras.Has(kPriority))
            material.priority = static_cast<uint32_t>(file.extras.Get(kPriority).GetNumberAsDouble());
        return material;
    }

    // Reads what KHR_materials_pbrSpecularGlossiness stands for, except for its own properties, which are
    // read like those of other extensions.
    void ReadGlossiness(const gltf::Material& file, const Place& where, Material& material) {
        material.isSpecularGlossiness = true;
        material.metallicFactor = 0.0f;
        material.ior = 0.0f;
        const char* const others[] = {FieldOf(&Material::ior).object,
                                      FieldOf(&Material::specularFactor).object};
        for (const char* other : others)
            if (file.extensions.contains(other))
                m_context.Warn(where["extensions"][other], "beside specular-glossiness",
                               "has no effect: the material is one of KHR_materials_pbrSpecularGlossiness");
    }

    void ReadOfExtension(const TextureField& field, const ValueReader& extension, const Place& where,
                         Material& material) {
        Read(field, ReadTextureInfo(extension.In(field.key)), where, material);
    }
    template <typename T>
    void ReadOfExtension(const MaterialField<T>& field, const ValueReader& extension, const Place&,
                         Material& material) {
        const KeyParts parts = KeyPartsOf(field.key);
        const ValueReader object = parts.object.empty() ? extension : extension.In(std::string(parts.object));
        if constexpr (std::is_same_v<T, bool>) {
            if (*field.key == 0) material.*field.member = static_cast<bool>(extension);
        } else if constexpr (requires { object.Read("", material.*field.member); }) {
            if (IsGlossiness(field)) {
                double glossiness = 1.0;
                extension.Read(field.key, glossiness);
                material.roughnessFactor = ToFloat(1.0 - glossiness);
            } else {
                object.Read(std::string(parts.key), material.*field.member);
            }
        }
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
