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
        for (const scene::Texture& texture : m_scene.textures) m_usesLeft[texture.image]++;
        Plan();
        std::vector<scene::Sampler> known;
        for (uint32_t i = 0; i < m_scene.textures.size(); ++i) {
            m_resources.textures.push_back(
                {.texture = Create(i),
                 .sampler = SamplerFor(m_device, m_scene.textures[i].sampler,
                                       m_settings.hasLevels ? m_settings.maxAnisotropy : 1.0f, known,
                                       m_resources.samplers)});
            const rhi::Texture& texture = m_resources.textures[i].texture;
            if (m_plan.choices[i].isBlocks)
                UploadBlocks(i, texture);
            else if (!IsMade(i))
                UploadImage(i, texture);
        }
        MakeLevels();
        for (TextureResources& texture : m_resources.textures)
            texture.slot =
                m_resources.textureTable.Add(texture.texture, m_resources.samplers[texture.sampler]);
    }

  private:
    scene::ImageData& ImageOf(uint32_t texture) { return m_scene.images[m_scene.textures[texture].image]; }
    rhi::Extent2D ExtentOf(uint32_t texture) {
        const scene::ImageData& image = ImageOf(texture);
        return {image.width, image.height};
    }
    bool HasLevels(uint32_t texture) const {
        return m_settings.hasLevels && m_scene.textures[texture].sampler.usesMips;
    }
    bool IsSrgb(uint32_t texture) const {
        return m_scene.textures[texture].colorSpace == scene::ColorSpace::Srgb;
    }
    // Of several levels, or smaller or rougher than its image, and not those of its file.
    bool IsMade(uint32_t texture) {
        const TextureChoice& choice = m_plan.choices[texture];
        if (choice.isBlocks) return false;
        const std::optional<PairedNormals>& normals = m_uses[texture].normals;
        const bool isRougher = normals && m_plan.choices[normals->texture].firstLevel > 0;
        const uint32_t levels = rhi::FullMipCount(ExtentOf(texture));
        return isRougher || (levels > 1 && (HasLevels(texture) || choice.firstLevel > 0));
    }

    TextureSizes SizesOf(uint32_t texture) {
        const image::BlockLevels& blocks = ImageOf(texture).blocks;
        const rhi::Format format = FormatOf(blocks.coding, IsSrgb(texture));
        if (blocks.IsEmpty() || format == rhi::Format::Undefined || !m_device.CanSample(format))
            return PlainTextureSizes(ExtentOf(texture), HasLevels(texture));
        std::vector<uint64_t> levelBytes;
        for (const std::vector<std::byte>& level : blocks.levels) levelBytes.push_back(level.size());
        return BlockTextureSizes(ExtentOf(texture), levelBytes, HasLevels(texture));
    }

    void Plan() {
        std::vector<TextureSizes> sizes;
        for (uint32_t i = 0; i < m_scene.textures.size(); ++i) sizes.push_back(SizesOf(i));
        m_plan = PlanTextures(sizes, m_settings.budget);
        m_uses = TextureUses(m_scene);
        // Normals that are not made here: nothing of them is lost, or, of those in blocks, not known
        for (TextureUse& use : m_uses)
            if (use.normals && !IsMade(use.normals->texture)) use.normals.reset();
        m_resources.textureBytes = m_plan.bytes;
        m_resources.reducedTextures = static_cast<uint32_t>(
            std::ranges::count_if(m_plan.choices, [](const auto& choice) { return choice.firstLevel > 0; }));
        m_resources.textureReduction = ReductionText(sizes, m_plan, m_settings.budget);
    }

    rhi::Texture Create(uint32_t index) {
        const scene::Texture& texture = m_scene.textures[index];
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

    void UploadImage(uint32_t texture, const rhi::Texture& target) {
        m_uploader.UploadTexture(target, std::as_bytes(std::span(ImageOf(texture).rgba)));
        DoneWith(texture);
    }

    void UploadBlocks(uint32_t texture, const rhi::Texture& target) {
        const image::BlockLevels& blocks = ImageOf(texture).blocks;
        std::vector<std::span<const std::byte>> levels;
        for (uint32_t level = 0; level < target.Desc().mipLevels; ++level)
            levels.push_back(blocks.levels[m_plan.choices[texture].firstLevel + level]);
        m_uploader.UploadTexture(target, levels);
        DoneWith(texture);
    }

    void DoneWith(uint32_t texture) {
        if (--m_usesLeft[m_scene.textures[texture].image] > 0) return;
        ImageOf(texture).rgba = {};
        ImageOf(texture).blocks = {};
    }

    // A frame for each texture, so that the memory of few is needed at a time. Of a normal map that roughness
    // depends on, the means are kept until that is made.
    void MakeLevels() {
        std::map<uint32_t, std::vector<uint32_t>> dependents;
        for (uint32_t i = 0; i < m_scene.textures.size(); ++i) {
            if (!IsMade(i)) continue;
            if (const std::optional<PairedNormals>& normals = m_uses[i].normals)
                dependents[normals->texture].push_back(i);
            else
                dependents.try_emplace(i);
        }
        if (dependents.empty()) return;
        Renderer renderer(m_device, {.name = "texture levels", .gpuTimes = false, .passMarks = false});
        for (const auto& [texture, rougher] : dependents) {
            std::optional<KeptMeans> means;
            if (!rougher.empty()) means = MeansToKeep(texture);
            MakeTexture(renderer, texture, means);
            for (const uint32_t roughness : rougher) MakeTexture(renderer, roughness, means);
        }
    }

    // Those of a normal map, over several frames.
    struct KeptMeans {
        rhi::Texture texture;
        rhi::Extent2D extent;  // of the image
        ResourceState state;
    };

    KeptMeans MeansToKeep(uint32_t texture) {
        const rhi::Extent2D extent = ExtentOf(texture);
        return {.texture =
                    m_device.CreateTexture({.name = "means of '" + ImageOf(texture).name + "'",
                                            .extent = rhi::MipExtent(extent, 1),
                                            .format = rhi::Format::Rgba32Float,
                                            .usage = rhi::TextureUsage::Sampled | rhi::TextureUsage::Storage,
                                            .mipLevels = rhi::FullMipCount(extent) - 1}),
                .extent = extent,
                .state = {}};
    }

    RoughnessWidening Widening(const PairedNormals& pair, const TextureMeans& means) const {
        const uint32_t first = m_plan.choices[pair.texture].firstLevel;
        const uint32_t count = m_resources.textures[pair.texture].texture.Desc().mipLevels;
        return {.normals = means,
                .firstNormals = first,
                .lastNormals = first + count - 1,
                .normalScale = pair.normalScale,
                .roughnessFactor = pair.roughnessFactor};
    }

    // `kept`: of the texture, to be filled, or of the normal map that its roughness depends on.
    void MakeTexture(Renderer& renderer, uint32_t texture, std::optional<KeptMeans>& kept) {
        // One image is read while the next one is copied: there are two at most
        if (m_frameBefore > 0) m_device.WaitFor(m_frameBefore);
        const rhi::Texture source =
            m_device.CreateTexture({.name = "image of '" + ImageOf(texture).name + "'",
                                    .extent = ExtentOf(texture),
                                    .format = rhi::Format::Rgba8Unorm,
                                    .usage = rhi::TextureUsage::Sampled | rhi::TextureUsage::CopySource |
                                             rhi::TextureUsage::CopyDestination});
        UploadImage(texture, source);
        m_uploader.Flush();
        renderer.BeginFrame();
        const TextureUse& use = m_uses[texture];
        TextureLevelSettings settings{.content = use.content,
                                      .widening = {},
                                      .means = {},
                                      .firstLevel = m_plan.choices[texture].firstLevel};
        if (kept) {
            const TextureId means = renderer.Import("normals", kept->texture, kept->state);
            if (use.normals)
                settings.widening = Widening(*use.normals, {.levels = means, .extent = kept->extent});
            else
                settings.means = means;
        }
        ResourceState sourceState{.layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL}, targetState;
        const TextureId image = renderer.Import("image", source, sourceState);
        const TextureId target =
            renderer.Import("texture", m_resources.textures[texture].texture, targetState);
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
    std::vector<uint32_t> m_usesLeft;  // of each image
    TexturePlan m_plan;
    std::vector<TextureUse> m_uses;
    uint64_t m_lastFrame = 0, m_frameBefore = 0;  // that made textures, as Device counts
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
