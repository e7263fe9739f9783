#include "renderer/gpu_scene/texture_upload.h"

#include <algorithm>
#include <map>
#include <utility>

#include "renderer/gpu_scene/texture_levels.h"
#include "renderer/gpu_scene/texture_plan.h"
#include "renderer/gpu_scene/texture_uses.h"
#include "renderer/graph/renderer.h"

namespace raygraph {

namespace {

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
uint32_t SamplerFor(rhi::Device& device, const scene::Sampler& wanted, float maxAnisotropy,
                    std::vector<scene::Sampler>& known, std::vector<rhi::Sampler>& samplers) {
    const auto found = std::find(known.begin(), known.end(), wanted);
    const auto index = static_cast<uint32_t>(found - known.begin());
    if (found == known.end()) {
        known.push_back(wanted);
        const bool isSmooth = wanted.usesMips && wanted.minFilter == scene::FilterMode::Linear;
        samplers.push_back(device.CreateSampler({.name = "material sampler",
                                                 .magFilter = ToRhi(wanted.magFilter),
                                                 .minFilter = ToRhi(wanted.minFilter),
                                                 .mipFilter = ToRhi(wanted.mipFilter),
                                                 .addressU = ToRhi(wanted.wrapU),
                                                 .addressV = ToRhi(wanted.wrapV),
                                                 .maxAnisotropy = isSmooth ? maxAnisotropy : 1.0f}));
    }
    return index;
}

// Undefined where a color has no such blocks: those of one or two channels are data.
rhi::Format FormatOf(image::BlockCoding coding, bool isSrgb) {
    using image::BlockCoding;
    using rhi::Format;
    switch (coding) {
        case BlockCoding::Bc1Opaque:
            return isSrgb ? Format::Bc1Srgb : Format::Bc1Unorm;
        case BlockCoding::Bc1:
            return isSrgb ? Format::Bc1AlphaSrgb : Format::Bc1AlphaUnorm;
        case BlockCoding::Bc2:
            return isSrgb ? Format::Bc2Srgb : Format::Bc2Unorm;
        case BlockCoding::Bc3:
            return isSrgb ? Format::Bc3Srgb : Format::Bc3Unorm;
        case BlockCoding::Bc4:
            return isSrgb ? Format::Undefined : Format::Bc4Unorm;
        case BlockCoding::Bc5:
            return isSrgb ? Format::Undefined : Format::Bc5Unorm;
        case BlockCoding::Bc7:
            return isSrgb ? Format::Bc7Srgb : Format::Bc7Unorm;
        case BlockCoding::None:
            break;
    }
    return Format::Undefined;
}

class SceneTextures {
  public:
    SceneTextures(rhi::Device& device, rhi::Uploader& uploader, scene::SceneData& scene,
                  const TextureUploadSettings& settings, SceneResources& resources)
        : m_device(device),
          m_uploader(uploader),
          m_scene(scene),
          m_settings(settings),
          m_resources(resources),
          m_usesLeft(scene.images.size(), 0) {}

    void Upload() {
        ShareImages();
        Plan();
        for (uint32_t i = 0; i < m_shown.size(); ++i) {
            const rhi::Texture& image = m_resources.textureImages.emplace_back(Create(i));
            if (m_plan.choices[i].isBlocks)
                UploadBlocks(i, image);
            else if (!IsMade(i))
                UploadImage(i, image);
        }
        MakeLevels();
        FillTable();
    }

  private:
    // An image of the scene may be several on the device: in another color space, without levels, or with
    // levels of other contents. Each is known by the first texture that it is.
    void ShareImages() {
        m_uses = TextureUses(m_scene);
        for (uint32_t i = 0; i < m_scene.textures.size(); ++i) {
            const auto isSame = [&](uint32_t other) {
                const scene::Texture &a = m_scene.textures[i], &b = m_scene.textures[other];
                return a.image == b.image && a.colorSpace == b.colorSpace && HasLevels(a) == HasLevels(b) &&
                       m_uses[i] == m_uses[other];
            };
            std::vector<uint32_t>& ofImage = m_shownOf[m_scene.textures[i].image];
            const auto found =
                std::ranges::find_if(ofImage, [&](uint32_t image) { return isSame(m_shown[image]); });
            const uint32_t image = found == ofImage.end() ? static_cast<uint32_t>(m_shown.size()) : *found;
            m_resources.textures.push_back({.image = image});
            if (found != ofImage.end()) continue;
            ofImage.push_back(image);
            m_shown.push_back(i);
            ++m_usesLeft[m_scene.textures[i].image];
        }
    }

    void FillTable() {
        std::vector<scene::Sampler> known;
        const float maxAnisotropy = m_settings.hasLevels ? m_settings.maxAnisotropy : 1.0f;
        for (size_t i = 0; i < m_scene.textures.size(); ++i)
            m_resources.textures[i].sampler =
                SamplerFor(m_device, m_scene.textures[i].sampler, maxAnisotropy, known, m_resources.samplers);
        const auto capacity = static_cast<uint32_t>(std::max<size_t>(1, m_resources.textures.size()));
        m_resources.textureTable = std::make_unique<rhi::TextureTable>(
            m_device, capacity, *m_settings.defaultTexture, *m_settings.defaultSampler);
        for (TextureResources& texture : m_resources.textures)
            texture.slot = m_resources.textureTable->Add(m_resources.textureImages[texture.image],
                                                         m_resources.samplers[texture.sampler]);
    }

    // From here on, `index` is that of an image on the device.
    const scene::Texture& TextureOf(uint32_t index) const { return m_scene.textures[m_shown[index]]; }
    const TextureUse& UseOf(uint32_t index) const { return m_uses[m_shown[index]]; }
    // Of the normals that it is paired with.
    uint32_t NormalsOf(const PairedNormals& pair) const { return m_resources.textures[pair.texture].image; }
    scene::ImageData& ImageOf(uint32_t index) { return m_scene.images[TextureOf(index).image]; }
    rhi::Extent2D ExtentOf(uint32_t index) {
        const scene::ImageData& image = ImageOf(index);
        return {image.width, image.height};
    }
    bool HasLevels(const scene::Texture& texture) const {
        return m_settings.hasLevels && texture.sampler.usesMips;
    }
    bool HasLevels(uint32_t index) const { return HasLevels(TextureOf(index)); }
    bool IsSrgb(uint32_t index) const { return TextureOf(index).colorSpace == scene::ColorSpace::Srgb; }
    // Of several levels, or smaller or rougher than its image, and not those of its file.
    bool IsMade(uint32_t index) {
        const TextureChoice& choice = m_plan.choices[index];
        if (choice.isBlocks) return false;
        const std::optional<PairedNormals>& normals = UseOf(index).normals;
        const bool isRougher = normals && m_plan.choices[NormalsOf(*normals)].firstLevel > 0;
        const uint32_t levels = rhi::FullMipCount(ExtentOf(index));
        return isRougher || (levels > 1 && (HasLevels(index) || choice.firstLevel > 0));
    }

    TextureSizes SizesOf(uint32_t index) {
        const image::BlockLevels& blocks = ImageOf(index).blocks;
        const rhi::Format format = FormatOf(blocks.coding, IsSrgb(index));
        if (blocks.IsEmpty() || format == rhi::Format::Undefined || !m_device.CanSample(format))
            return PlainTextureSizes(ExtentOf(index), HasLevels(index));
        std::vector<uint64_t> levelBytes;
        for (const std::vector<std::byte>& level : blocks.levels) levelBytes.push_back(level.size());
        return BlockTextureSizes(ExtentOf(index), levelBytes, HasLevels(index));
    }

    void Plan() {
        std::vector<TextureSizes> sizes;
        for (uint32_t i = 0; i < m_shown.size(); ++i) sizes.push_back(SizesOf(i));
        m_plan = PlanTextures(sizes, m_settings.budget);
        // Normals that are not made here: nothing of them is lost, or, of those in blocks, not known
        for (TextureUse& use : m_uses)
            if (use.normals && !IsMade(NormalsOf(*use.normals))) use.normals.reset();
        m_resources.textureBytes = m_plan.bytes;
        m_resources.reducedTextures = static_cast<uint32_t>(
            std::ranges::count_if(m_plan.choices, [](const auto& choice) { return choice.firstLevel > 0; }));
        m_resources.textureReduction = ReductionText(sizes, m_plan, m_settings.budget);
    }

    rhi::Texture Create(uint32_t index) {
        const scene::Texture& texture = TextureOf(index);
        const scene::ImageData& image = ImageOf(index);
        const TextureChoice& choice = m_plan.choices[index];
        const rhi::Extent2D extent = rhi::MipExtent(ExtentOf(index), choice.firstLevel);
        const auto levels = choice.isBlocks
                                ? static_cast<uint32_t>(image.blocks.levels.size()) - choice.firstLevel
                                : rhi::FullMipCount(extent);
        const rhi::Format plain = IsSrgb(index) ? rhi::Format::Rgba8Srgb : rhi::Format::Rgba8Unorm;
        return m_device.CreateTexture(
            {.name = texture.name.empty() ? image.name : texture.name,
             .extent = extent,
             .format = choice.isBlocks ? FormatOf(image.blocks.coding, IsSrgb(index)) : plain,
             .mipLevels = HasLevels(index) ? levels : 1});
    }

    void UploadImage(uint32_t index, const rhi::Texture& target) {
        m_uploader.UploadTexture(target, std::as_bytes(std::span(ImageOf(index).rgba)));
        DoneWith(index);
    }

    void UploadBlocks(uint32_t index, const rhi::Texture& target) {
        const image::BlockLevels& blocks = ImageOf(index).blocks;
        std::vector<std::span<const std::byte>> levels;
        for (uint32_t level = 0; level < target.Desc().mipLevels; ++level)
            levels.push_back(blocks.levels[m_plan.choices[index].firstLevel + level]);
        m_uploader.UploadTexture(target, levels);
        DoneWith(index);
    }

    void DoneWith(uint32_t index) {
        if (--m_usesLeft[TextureOf(index).image] > 0) return;
        ImageOf(index).rgba = {};
        ImageOf(index).blocks = {};
    }

    // A frame for each image, so that the memory of few is needed at a time. Of a normal map that roughness
    // depends on, the means are kept until that is made.
    void MakeLevels() {
        std::map<uint32_t, std::vector<uint32_t>> dependents;
        for (uint32_t i = 0; i < m_shown.size(); ++i) {
            if (!IsMade(i)) continue;
            if (const std::optional<PairedNormals>& normals = UseOf(i).normals)
                dependents[NormalsOf(*normals)].push_back(i);
            else
                dependents.try_emplace(i);
        }
        if (dependents.empty()) return;
        Renderer renderer(m_device, {.name = "texture levels", .gpuTimes = false, .passMarks = false});
        for (const auto& [index, rougher] : dependents) {
            std::optional<KeptMeans> means;
            if (!rougher.empty()) means = MeansToKeep(index);
            MakeImage(renderer, index, means);
            for (const uint32_t roughness : rougher) MakeImage(renderer, roughness, means);
        }
    }

    // Those of a normal map, over several frames.
    struct KeptMeans {
        rhi::Texture texture;
        rhi::Extent2D extent;  // of the image
        ResourceState state;
    };

    KeptMeans MeansToKeep(uint32_t index) {
        const rhi::Extent2D extent = ExtentOf(index);
        return {.texture =
                    m_device.CreateTexture({.name = "means of '" + ImageOf(index).name + "'",
                                            .extent = rhi::MipExtent(extent, 1),
                                            .format = rhi::Format::Rgba32Float,
                                            .usage = rhi::TextureUsage::Sampled | rhi::TextureUsage::Storage,
                                            .mipLevels = rhi::FullMipCount(extent) - 1}),
                .extent = extent,
                .state = {}};
    }

    RoughnessWidening Widening(const PairedNormals& pair, const TextureMeans& means) const {
        const uint32_t first = m_plan.choices[NormalsOf(pair)].firstLevel;
        const uint32_t count = m_resources.textureImages[NormalsOf(pair)].Desc().mipLevels;
        return {.normals = means,
                .firstNormals = first,
                .lastNormals = first + count - 1,
                .normalScale = pair.normalScale,
                .roughnessFactor = pair.roughnessFactor};
    }

    // `kept`: of the image, to be filled, or of the normal map that its roughness depends on.
    void MakeImage(Renderer& renderer, uint32_t index, std::optional<KeptMeans>& kept) {
        // One image is read while the next one is copied: there are two at most
        if (m_frameBefore > 0) m_device.WaitFor(m_frameBefore);
        const rhi::Texture source =
            m_device.CreateTexture({.name = "image of '" + ImageOf(index).name + "'",
                                    .extent = ExtentOf(index),
                                    .format = rhi::Format::Rgba8Unorm,
                                    .usage = rhi::TextureUsage::Sampled | rhi::TextureUsage::CopySource |
                                             rhi::TextureUsage::CopyDestination});
        UploadImage(index, source);
        m_uploader.Flush();
        renderer.BeginFrame();
        const TextureUse& use = UseOf(index);
        TextureLevelSettings settings{.content = use.content,
                                      .widening = {},
                                      .means = {},
                                      .firstLevel = m_plan.choices[index].firstLevel};
        if (kept) {
            const TextureId means = renderer.Import("normals", kept->texture, kept->state);
            if (use.normals)
                settings.widening = Widening(*use.normals, {.levels = means, .extent = kept->extent});
            else
                settings.means = means;
        }
        ResourceState sourceState{.layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL}, targetState;
        const TextureId image = renderer.Import("image", source, sourceState);
        const TextureId target = renderer.Import("texture", m_resources.textureImages[index], targetState);
        const TextureLevels made = MakeTextureLevels(renderer, image, target, settings);
        renderer.Export(made.texture, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
        if (settings.means) renderer.Export(made.means->levels, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
        m_frameBefore = std::exchange(m_lastFrame, renderer.Execute());
    }

    rhi::Device& m_device;
    rhi::Uploader& m_uploader;
    scene::SceneData& m_scene;
    const TextureUploadSettings& m_settings;
    SceneResources& m_resources;
    std::vector<uint32_t> m_usesLeft;  // of each image of the scene
    std::vector<TextureUse> m_uses;    // of each texture
    std::vector<uint32_t> m_shown;     // the first texture that each image on the device is
    std::map<uint32_t, std::vector<uint32_t>> m_shownOf;  // images on the device, by image of the scene
    TexturePlan m_plan;                                   // of the images on the device
    uint64_t m_lastFrame = 0, m_frameBefore = 0;          // that made textures, as Device counts
};

}  // namespace

void UploadTextures(rhi::Device& device, rhi::Uploader& uploader, scene::SceneData& scene,
                    const TextureUploadSettings& settings, SceneResources& resources) {
    SceneTextures(device, uploader, scene, settings, resources).Upload();
}

uint64_t DefaultTextureBudget(const rhi::Device& device) {
    rhi::MemoryHeap largest;
    for (const rhi::MemoryHeap& heap : device.MemoryHeaps())
        if (heap.isDeviceLocal && heap.budgetBytes > largest.budgetBytes) largest = heap;
    uint64_t whole = largest.budgetBytes;
    uint64_t left = whole - std::min(largest.usedBytes, whole);
    if (const uint64_t limit = device.MemoryLimit(); limit > 0) {
        whole = std::min(whole, limit);
        left = std::min(left, limit - std::min(device.Memory().usedBytes, limit));
    }
    return std::min(whole / 2, left);
}

}  // namespace raygraph
