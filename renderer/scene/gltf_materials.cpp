#include "renderer/scene/gltf_materials.h"

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>

namespace raygraph::scene {
namespace {

WrapMode ReadWrap(const JsonValue& value) {
    switch (value.UnsignedOr(10497)) {
        case 10497:
            return WrapMode::Repeat;
        case 33648:
            return WrapMode::MirroredRepeat;
        case 33071:
            return WrapMode::ClampToEdge;
        default:
            value.Fail("is " + value.Shown() + ", must be 10497, 33648 or 33071");
    }
}

// glTF's filter numbers are OpenGL's.
Sampler ReadSampler(const JsonValue& value) {
    Sampler sampler;
    sampler.wrapU = ReadWrap(value.RequireObject()["wrapS"]);
    sampler.wrapV = ReadWrap(value["wrapT"]);
    const JsonValue mag = value["magFilter"];
    switch (mag.UnsignedOr(9729)) {
        case 9728:
            sampler.magFilter = FilterMode::Nearest;
            break;
        case 9729:
            break;
        default:
            mag.Fail("is " + mag.Shown() + ", must be 9728 or 9729");
    }
    const JsonValue min = value["minFilter"];
    const auto set = [&](FilterMode minFilter, bool usesMips, FilterMode mipFilter) {
        sampler.minFilter = minFilter;
        sampler.usesMips = usesMips;
        sampler.mipFilter = mipFilter;
    };
    switch (min.UnsignedOr(9987)) {
        case 9728:
            set(FilterMode::Nearest, false, FilterMode::Nearest);
            break;
        case 9729:
            set(FilterMode::Linear, false, FilterMode::Nearest);
            break;
        case 9984:
            set(FilterMode::Nearest, true, FilterMode::Nearest);
            break;
        case 9985:
            set(FilterMode::Linear, true, FilterMode::Nearest);
            break;
        case 9986:
            set(FilterMode::Nearest, true, FilterMode::Linear);
            break;
        case 9987:
            set(FilterMode::Linear, true, FilterMode::Linear);
            break;
        default:
            min.Fail("is " + min.Shown() + ", must be 9728, 9729 or 9984 to 9987");
    }
    return sampler;
}

// A texture as the file has it: no colour space, perhaps no image.
struct FileTexture {
    std::string name;
    uint32_t image = kNone;
    Sampler sampler;
};

constexpr float kUnbounded = std::numeric_limits<float>::max();
constexpr uint64_t kMostPriority = std::numeric_limits<uint32_t>::max();

class MaterialImporter {
  public:
    MaterialImporter(GltfContext& context, const JsonValue& root, SceneData& scene)
        : m_context(context), m_root(root), m_scene(scene), m_imageSlots(root["images"].Count(), kNone) {}

    std::vector<uint32_t> Import() {
        CheckImages();
        ReadTextures();
        const JsonValue materials = m_root["materials"];
        for (size_t i = 0; i < materials.Count(); ++i)
            m_scene.materials.push_back(ReadMaterial(materials.At(i)));
        return std::move(m_images);
    }

  private:
    void CheckImages() {
        const JsonValue images = m_root["images"];
        for (size_t i = 0; i < images.Count(); ++i) {
            const JsonValue image = images.At(i).RequireObject();
            if (image["uri"].IsPresent() == image["bufferView"].IsPresent())
                image.Fail("must have either a uri or a bufferView");
            image["uri"].StringOr("");
            image["bufferView"].IndexOr(kNone, m_root["bufferViews"].Count(), "bufferViews");
        }
    }

    void ReadTextures() {
        std::vector<Sampler> samplers;
        const JsonValue samplerValues = m_root["samplers"];
        for (size_t i = 0; i < samplerValues.Count(); ++i)
            samplers.push_back(ReadSampler(samplerValues.At(i)));
        const JsonValue values = m_root["textures"];
        for (size_t i = 0; i < values.Count(); ++i) {
            const JsonValue value = values.At(i);
            FileTexture texture;
            texture.name = value.RequireObject()["name"].StringOr("");
            const uint32_t sampler = value["sampler"].IndexOr(kNone, samplers.size(), "samplers");
            if (sampler != kNone) texture.sampler = samplers[sampler];
            texture.image = value["source"].IndexOr(kNone, m_imageSlots.size(), "images");
            // The extension's image is the better one; `source` is there for readers without WebP.
            const JsonValue webp = value["extensions"]["EXT_texture_webp"]["source"];
            texture.image = webp.IndexOr(texture.image, m_imageSlots.size(), "images");
            m_fileTextures.push_back(std::move(texture));
        }
    }

    // Checks a reference to a texture that nothing reads: its image is not opened for it. Returns the index.
    uint32_t CheckTexture(const JsonValue& value) {
        if (!value.IsPresent()) return kNone;
        value.RequireObject()["texCoord"].UnsignedOr(0);
        return value["index"].Index(m_fileTextures.size(), "textures");
    }

    TextureRef ReadTexture(const JsonValue& value, ColorSpace colorSpace) {
        TextureRef ref;
        const uint32_t index = CheckTexture(value);
        if (index == kNone) return ref;
        const uint64_t texCoord = value["texCoord"].UnsignedOr(0);
        if (texCoord > 1) {
            m_context.Warn(
                value["texCoord"], "texCoord",
                "is " + std::to_string(texCoord) + ", taken as 0: TEXCOORD_0 and TEXCOORD_1 are read");
        } else {
            ref.texCoord = static_cast<int32_t>(texCoord);
        }
        const FileTexture& file = m_fileTextures[index];
        if (file.image == kNone) {
            m_context.Warn(value, "no image",
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

    // Puts a factor into its range with a warning. `max` may be infinite.
    float Clamped(const JsonValue& where, float value, float min, float max) {
        const float clamped = std::clamp(value, min, max);
        if (clamped != value)
            m_context.Warn(where, "factor", "is " + where.Shown() + ", out of range, put into it");
        return clamped;
    }

    float Factor(const JsonValue& value, float absent, float max) {
        return Clamped(value, value.FloatOr(absent), 0.0f, max);
    }

    // A colour whose channels are clamped to [0, max]; left as it is when absent.
    void ColorFactor(const JsonValue& value, glm::vec3& color, float max) {
        value.FloatsIfPresent({&color.x, 3});
        for (int i = 0; i < 3; ++i) color[i] = Clamped(value, color[i], 0.0f, max);
    }

    Material ReadMaterial(const JsonValue& value) {
        Material material;
        material.name = value.RequireObject()["name"].StringOr("");
        const JsonValue pbr = value["pbrMetallicRoughness"];
        const JsonValue baseColor = pbr["baseColorFactor"];
        baseColor.FloatsIfPresent({&material.baseColorFactor.x, 4});
        for (int i = 0; i < 4; ++i)
            material.baseColorFactor[i] = Clamped(baseColor, material.baseColorFactor[i], 0.0f, 1.0f);
        material.baseColorTexture = ReadTexture(pbr["baseColorTexture"], ColorSpace::Srgb);
        material.metallicFactor = Factor(pbr["metallicFactor"], 1.0f, 1.0f);
        material.roughnessFactor = Factor(pbr["roughnessFactor"], 1.0f, 1.0f);
        material.metallicRoughnessTexture = ReadTexture(pbr["metallicRoughnessTexture"], ColorSpace::Linear);
        material.normalTexture = ReadTexture(value["normalTexture"], ColorSpace::Linear);
        material.normalScale = value["normalTexture"]["scale"].FloatOr(1.0f);
        material.occlusionTexture = ReadTexture(value["occlusionTexture"], ColorSpace::Linear);
        material.occlusionStrength = Factor(value["occlusionTexture"]["strength"], 1.0f, 1.0f);
        // Above 1 is out of the standard's range, but files from before KHR_materials_emissive_strength mean
        // it.
        ColorFactor(value["emissiveFactor"], material.emissiveFactor, kUnbounded);
        material.emissiveTexture = ReadTexture(value["emissiveTexture"], ColorSpace::Srgb);
        material.alphaMode = ReadAlphaMode(value["alphaMode"]);
        material.alphaCutoff = Factor(value["alphaCutoff"], 0.5f, kUnbounded);
        material.isDoubleSided = value["doubleSided"].BoolOr(false);
        ReadExtensions(value["extensions"], material);
        material.priority = ReadPriority(value["extras"]);
        return material;
    }

    void ReadExtensions(const JsonValue& extensions, Material& material) {
        const JsonValue strength = extensions["KHR_materials_emissive_strength"]["emissiveStrength"];
        material.emissiveStrength = Factor(strength, 1.0f, kUnbounded);

        const JsonValue ior = extensions["KHR_materials_ior"]["ior"];
        material.ior = ior.FloatOr(1.5f);
        if (material.ior != 0.0f) material.ior = Clamped(ior, material.ior, 1.0f, Material::kMostIor);

        const JsonValue specular = extensions["KHR_materials_specular"];
        material.specularFactor = Factor(specular["specularFactor"], 1.0f, 1.0f);
        material.specularTexture = ReadTexture(specular["specularTexture"], ColorSpace::Linear);
        ColorFactor(specular["specularColorFactor"], material.specularColorFactor, kUnbounded);
        material.specularColorTexture = ReadTexture(specular["specularColorTexture"], ColorSpace::Srgb);

        const JsonValue transmission = extensions["KHR_materials_transmission"];
        material.transmissionFactor = Factor(transmission["transmissionFactor"], 0.0f, 1.0f);
        material.transmissionTexture = ReadTexture(transmission["transmissionTexture"], ColorSpace::Linear);

        const JsonValue volume = extensions["KHR_materials_volume"];
        material.thicknessFactor = Factor(volume["thicknessFactor"], 0.0f, kUnbounded);
        CheckTexture(volume["thicknessTexture"]);
        ColorFactor(volume["attenuationColor"], material.attenuationColor, 1.0f);
        const JsonValue distance = volume["attenuationDistance"];
        material.attenuationDistance = distance.FloatOr(0.0f);
        if (distance.IsPresent() && !(material.attenuationDistance > 0.0f)) {
            m_context.Warn(distance, "distance",
                           "is " + distance.Shown() + ", must be above 0, taken as infinite");
            material.attenuationDistance = 0.0f;
        }

        const JsonValue unlit = extensions["KHR_materials_unlit"];
        material.isUnlit = unlit.IsPresent() && unlit.RequireObject().IsPresent();
    }

    // `extras` belongs to applications: what is no priority as we mean it may be another's, and only warns.
    uint32_t ReadPriority(const JsonValue& extras) {
        if (!extras.IsObject() || !extras["priority"].IsPresent()) return 0;
        const JsonValue priority = extras["priority"];
        const std::optional<uint64_t> number = priority.TryUnsigned();
        if (number && *number <= kMostPriority) return static_cast<uint32_t>(*number);
        m_context.Warn(priority, "priority",
                       "is " + priority.Shown() + ", must be a whole number of 0 to " +
                           std::to_string(kMostPriority) + ", taken as 0");
        return 0;
    }

    static AlphaMode ReadAlphaMode(const JsonValue& value) {
        const std::string mode = value.StringOr("OPAQUE");
        if (mode == "OPAQUE") return AlphaMode::Opaque;
        if (mode == "MASK") return AlphaMode::Mask;
        if (mode == "BLEND") return AlphaMode::Blend;
        value.Fail("is " + value.Shown() + ", must be OPAQUE, MASK or BLEND");
    }

    GltfContext& m_context;
    JsonValue m_root;
    SceneData& m_scene;
    std::vector<FileTexture> m_fileTextures;
    std::map<std::pair<uint32_t, ColorSpace>, size_t> m_textureSlots;
    std::vector<uint32_t> m_imageSlots;  // By the file's image index.
    std::vector<uint32_t> m_images;
};

}  // namespace

std::vector<uint32_t> ReadMaterials(GltfContext& context, const JsonValue& root, SceneData& scene) {
    return MaterialImporter(context, root, scene).Import();
}

}  // namespace raygraph::scene
