#include "renderer/gpu_scene/materials/texture_set.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "base/error.h"
#include "base/text.h"
#include "renderer/gpu_scene/materials/texture_plan.h"
#include "renderer/graph/renderer.h"
#include "shaders/shared/texture_levels.h"

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

}  // namespace

TextureSet::TextureSet(rhi::Device& device, const rhi::Texture& defaultTexture,
                       const rhi::Sampler& defaultSampler, float maxAnisotropy)
    : m_device(device),
      m_maxAnisotropy(maxAnisotropy),
      m_table(std::make_unique<rhi::TextureTable>(device, 1, defaultTexture, defaultSampler)) {}

const rhi::Sampler& TextureSet::SamplerFor(const scene::Sampler& wanted) {
    const auto found = std::ranges::find(m_samplerDescs, wanted);
    if (found != m_samplerDescs.end()) return m_samplers[static_cast<size_t>(found - m_samplerDescs.begin())];
    const bool isSmooth = wanted.usesMips && wanted.minFilter == scene::FilterMode::Linear;
    m_samplers.reserve(m_samplers.size() + 1);
    m_samplerDescs.reserve(m_samplers.size() + 1);
    m_samplers.push_back(m_device.CreateSampler({.name = "material sampler",
                                                 .magFilter = ToRhi(wanted.magFilter),
                                                 .minFilter = ToRhi(wanted.minFilter),
                                                 .mipFilter = ToRhi(wanted.mipFilter),
                                                 .addressU = ToRhi(wanted.wrapU),
                                                 .addressV = ToRhi(wanted.wrapV),
                                                 .maxAnisotropy = isSmooth ? m_maxAnisotropy : 1.0f}));
    m_samplerDescs.push_back(wanted);
    return m_samplers.back();
}

// Slots that were just removed are still in use by frames in flight, so that the table grows past them.
void TextureSet::Reserve(uint32_t slots) {
    if (m_table->FreeCount() >= slots) return;
    const uint32_t needed = m_table->Capacity() - m_table->FreeCount() + slots;
    const uint32_t doubled = std::min(2 * m_table->Capacity(), rhi::kMaxTextureTableSlots);
    if (needed > rhi::kMaxTextureTableSlots)
        throw MakeError(ErrorKind::Usage, "GpuScene: {} textures, a shader can read {}", needed,
                        rhi::kMaxTextureTableSlots);
    m_table =
        std::make_unique<rhi::TextureTable>(m_device, std::max(needed, m_count > 0 ? doubled : 1), *m_table);
}

std::vector<uint32_t> TextureSet::Add(std::span<const SceneTexture> textures) {
    std::vector<uint32_t> indices;
    for (uint32_t i = 0; i < m_entries.size() && indices.size() < textures.size(); ++i)
        if (!m_entries[i].image) indices.push_back(i);
    const auto size = static_cast<uint32_t>(m_entries.size() + textures.size() - indices.size());
    for (auto i = static_cast<uint32_t>(m_entries.size()); i < size; ++i) indices.push_back(i);
    std::vector<const rhi::Sampler*> samplers;
    for (const SceneTexture& texture : textures) SamplerFor(texture.sampler);
    for (const SceneTexture& texture : textures) samplers.push_back(&SamplerFor(texture.sampler));
    Reserve(static_cast<uint32_t>(textures.size()));
    m_entries.resize(size);
    for (size_t i = 0; i < textures.size(); ++i)
        m_entries[indices[i]] = {textures[i].image, m_table->Add(textures[i].image->Shown(), *samplers[i]),
                                 textures[i].sampler};
    m_count += static_cast<uint32_t>(textures.size());
    return indices;
}

void TextureSet::Remove(uint32_t index) {
    m_table->Remove(std::exchange(m_entries[index], {}).slot);
    --m_count;
}

std::vector<const SceneImage*> TextureSet::Images() const {
    std::vector<const SceneImage*> images;
    for (const Entry& entry : m_entries)
        if (entry.image) images.push_back(entry.image.get());
    std::ranges::sort(images);
    images.erase(std::unique(images.begin(), images.end()), images.end());
    return images;
}

uint64_t TextureSet::Bytes() const {
    uint64_t bytes = 0;
    for (const SceneImage* image : Images()) bytes += image->bytes;
    return bytes;
}

uint32_t TextureSet::ReducedImages() const {
    return static_cast<uint32_t>(std::ranges::count_if(Images(), &SceneImage::isReduced));
}

// --- Uploads ---

namespace {

// Returns Undefined for sRGB if there are no such blocks: formats of one or two channels are data.
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

}  // namespace

class TextureUpload::Impl {
  public:
    Impl(rhi::Device& device, rhi::Uploader& uploader, scene::SceneData& scene,
         const TextureUploadSettings& settings)
        : m_device(device),
          m_uploader(uploader),
          m_scene(scene),
          m_settings(settings),
          m_usesLeft(scene.images.size(), 0) {
        ShareImages();
        Plan();
        m_images.resize(m_shown.size());
        m_transfers.resize(m_shown.size());
        m_rougher.resize(m_shown.size());
        for (uint32_t i = 0; i < m_shown.size(); ++i) {
            m_bytes += CopyBytes(i);
            if (IsMade(i) && UseOf(i).normals) m_rougher[NormalsOf(*UseOf(i).normals)].push_back(i);
        }
    }

    bool Continue(uint32_t texture, uint64_t& budget, bool mayWait) {
        const uint32_t index = m_imageOf[texture];
        if (m_images[index]) return true;
        // The means of a normal map are kept until the roughness textures that depend on it are made
        const std::optional<PairedNormals>& normals = UseOf(index).normals;
        const uint32_t first = normals ? NormalsOf(*normals) : index;
        if (!m_images[first] && !ContinueImage(first, budget, mayWait)) return false;
        for (const uint32_t rougher : m_rougher[first])
            if (!m_images[rougher] && !ContinueImage(rougher, budget, mayWait)) return false;
        m_means.erase(first);
        return m_images[index] != nullptr;
    }

    bool IsBusy() const { return !m_device.HasCompleted(m_lastFrame); }

    SceneTexture Get(uint32_t texture) const {
        return {m_images[m_imageOf[texture]], m_scene.textures[texture].sampler};
    }
    uint64_t Bytes() const { return m_bytes; }
    uint64_t CopiedBytes() const { return m_copiedBytes; }
    uint64_t PendingBytes() const {
        uint64_t bytes = 0;
        for (size_t i = 0; i < m_images.size(); ++i)
            if (!m_images[i]) bytes += m_plan.choices[i].bytes;
        return bytes;
    }
    const std::string& Reduction() const { return m_reduction; }

  private:
    // One image of the scene may become several on the device: in another color space, without levels, or
    // with differently averaged levels. Each is identified by the first texture that uses it.
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
            m_imageOf.push_back(image);
            if (found != ofImage.end()) continue;
            ofImage.push_back(image);
            m_shown.push_back(i);
            ++m_usesLeft[m_scene.textures[i].image];
        }
    }

    // From here on, `index` is that of an image on the device.
    const scene::Texture& TextureOf(uint32_t index) const { return m_scene.textures[m_shown[index]]; }
    const TextureUse& UseOf(uint32_t index) const { return m_uses[m_shown[index]]; }
    // Returns the image of the normal map with which a roughness texture is paired.
    uint32_t NormalsOf(const PairedNormals& pair) const { return m_imageOf[pair.texture]; }
    // Returns the lowest alpha as far as it is known.
    float LowestAlphaOf(uint32_t index) {
        return static_cast<float>(ImageOf(index).lowestAlpha.value_or(0)) / 255.0f;
    }
    scene::ImageData& ImageOf(uint32_t index) { return m_scene.images[TextureOf(index).image]; }
    rhi::Extent2D ExtentOf(uint32_t index) {
        const scene::ImageData& image = ImageOf(index);
        return {image.width, image.height};
    }
    bool HasLevels(const scene::Texture& texture) const {
        return m_settings.makesMipLevels && texture.sampler.usesMips;
    }
    bool HasLevels(uint32_t index) const { return HasLevels(TextureOf(index)); }
    bool IsSrgb(uint32_t index) const { return TextureOf(index).colorSpace == scene::ColorSpace::Srgb; }
    // Tells whether levels are made on the device: the image has several, is smaller or rougher than its
    // source, and its levels are not those of the file.
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
        // A normal map that is not made here loses no detail or, in blocks, an unknown amount of it
        for (TextureUse& use : m_uses)
            if (use.normals && !IsMade(NormalsOf(*use.normals))) use.normals.reset();
        m_reduction = ReductionText(sizes, m_plan, m_settings.budget);
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

    // Returns the levels of an image that are copied, or the one level from which they are made.
    std::vector<std::span<const std::byte>> CopiedLevels(uint32_t index) {
        const scene::ImageData& image = ImageOf(index);
        const TextureChoice& choice = m_plan.choices[index];
        if (!choice.isBlocks) return {std::as_bytes(std::span(image.rgba))};
        const size_t end = HasLevels(index) ? image.blocks.levels.size() : choice.firstLevel + size_t{1};
        return {image.blocks.levels.begin() + choice.firstLevel,
                image.blocks.levels.begin() + static_cast<ptrdiff_t>(end)};
    }
    uint64_t CopyBytes(uint32_t index) {
        uint64_t bytes = 0;
        for (const std::span<const std::byte> level : CopiedLevels(index)) bytes += level.size();
        return bytes;
    }

    // Describes an image that is being copied to the device.
    struct Transfer {
        rhi::Texture texture;  // the texture that is shown, or the source from which its levels are made
        rhi::Texture made;     // the texture with the levels that are made
        rhi::Uploader::TextureTransfer rows;
    };

    // One image is read while the next one is copied: at most two are in work.
    bool WouldBlock() const {
        return m_uploader.WouldBlock() || !m_device.HasCompleted(m_frameBefore) ||
               (m_renderer && m_renderer->WouldBlock());
    }

    bool ContinueImage(uint32_t index, uint64_t& budget, bool mayWait) {
        if (budget == 0 || (!mayWait && WouldBlock())) return false;
        std::unique_ptr<Transfer>& transfer = m_transfers[index];
        if (!transfer) {
            if (IsMade(index)) m_device.WaitFor(m_frameBefore);
            transfer = std::make_unique<Transfer>();
            transfer->texture = IsMade(index) ? CreateSource(index) : Create(index);
            transfer->rows = {.target = &transfer->texture, .levels = CopiedLevels(index)};
        }
        if (!transfer->rows.IsComplete()) {
            const uint64_t copied = m_uploader.Continue(transfer->rows, budget);
            m_copiedBytes += copied;
            budget -= std::min(copied, budget);
        }
        if (!transfer->rows.IsComplete()) return false;
        if (IsMade(index) && !MakeImage(index, *transfer, mayWait)) return false;
        const TextureChoice& choice = m_plan.choices[index];
        auto image = std::make_shared<SceneImage>(SceneImage{
            .bytes = choice.bytes, .isReduced = choice.firstLevel > 0, .lowestAlpha = LowestAlphaOf(index)});
        image->texture = std::move(IsMade(index) ? transfer->made : transfer->texture);
        m_images[index] = std::move(image);
        transfer.reset();
        ReleaseSources(index);
        return true;
    }

    void ReleaseSources(uint32_t index) {
        if (--m_usesLeft[TextureOf(index).image] > 0) return;
        ImageOf(index).rgba = {};
        ImageOf(index).blocks = {};
    }

    // Holds the means of a normal map, kept over several frames.
    struct StoredMeans {
        rhi::Texture texture;
        rhi::Extent2D extent;  // that of the image
        ResourceState state;
    };

    StoredMeans CreateMeans(uint32_t index) {
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
        const uint32_t count = m_images[NormalsOf(pair)]->texture.Desc().mipLevels;
        return {.normals = means,
                .firstNormals = first,
                .lastNormals = first + count - 1,
                .normalScale = pair.normalScale,
                .roughnessFactor = pair.roughnessFactor};
    }

    rhi::Texture CreateSource(uint32_t index) {
        return m_device.CreateTexture({.name = "image of '" + ImageOf(index).name + "'",
                                       .extent = ExtentOf(index),
                                       .format = rhi::Format::Rgba8Unorm,
                                       .usage = rhi::TextureUsage::Sampled | rhi::TextureUsage::CopySource |
                                                rhi::TextureUsage::CopyDestination});
    }

    // Makes one image per frame, so that memory for few is needed at a time. Returns false if its pipelines
    // are not compiled and it may not wait for them.
    bool MakeImage(uint32_t index, Transfer& transfer, bool mayWait) {
        m_uploader.Flush();
        if (!m_renderer)
            m_renderer.emplace(m_device,
                               RendererDesc{.name = "texture levels", .gpuTimes = false, .passMarks = false});
        Renderer& renderer = *m_renderer;
        renderer.BeginFrame();
        if (!transfer.made) transfer.made = Create(index);
        const TextureUse& use = UseOf(index);
        TextureLevelSettings settings{.content = use.content,
                                      .widening = {},
                                      .means = {},
                                      .firstLevel = m_plan.choices[index].firstLevel};
        if (use.normals) {
            StoredMeans& kept = m_means.at(NormalsOf(*use.normals));
            const TextureId means = renderer.Import("normals", kept.texture, kept.state);
            settings.widening = Widening(*use.normals, {.levels = means, .extent = kept.extent});
        } else if (!m_rougher[index].empty()) {
            StoredMeans& kept = m_means.insert_or_assign(index, CreateMeans(index)).first->second;
            settings.means = renderer.Import("normals", kept.texture, kept.state);
        }
        ResourceState sourceState{.layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL}, madeState;
        const TextureId image = renderer.Import("image", transfer.texture, sourceState);
        const TextureId target = renderer.Import("texture", transfer.made, madeState);
        const TextureLevels levels = MakeTextureLevels(renderer, image, target, settings);
        renderer.Export(levels.texture, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
        if (settings.means) renderer.Export(levels.means->levels, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
        if (!mayWait && !renderer.PreparePipelines()) {
            renderer.DropFrame();
            return false;
        }
        m_frameBefore = std::exchange(m_lastFrame, renderer.Execute());
        return true;
    }

    rhi::Device& m_device;
    rhi::Uploader& m_uploader;
    scene::SceneData& m_scene;
    TextureUploadSettings m_settings;
    std::vector<uint32_t> m_usesLeft;                         // by image of the scene
    std::vector<TextureUse> m_uses;                           // indexed by texture
    std::vector<uint32_t> m_imageOf;                          // by texture: its image on the device
    std::vector<std::shared_ptr<const SceneImage>> m_images;  // on the device; null: not complete
    // By image on the device: the first texture that uses it.
    std::vector<uint32_t> m_shown;
    std::map<uint32_t, std::vector<uint32_t>> m_shownOf;  // images on the device, by image of the scene
    TexturePlan m_plan;                                   // for the images on the device
    std::string m_reduction;
    std::vector<std::unique_ptr<Transfer>> m_transfers;  // by image on the device
    // By normal map: the images whose roughness depends on it.
    std::vector<std::vector<uint32_t>> m_rougher;
    std::map<uint32_t, StoredMeans> m_means;  // by normal map
    uint64_t m_bytes = 0, m_copiedBytes = 0;
    std::optional<Renderer> m_renderer;
    rhi::Submission m_lastFrame, m_frameBefore;  // of the frames that made textures
};

TextureUpload::TextureUpload(rhi::Device& device, rhi::Uploader& uploader, scene::SceneData& scene,
                             const TextureUploadSettings& settings)
    : m_impl(std::make_unique<Impl>(device, uploader, scene, settings)) {}
TextureUpload::~TextureUpload() = default;
TextureUpload::TextureUpload(TextureUpload&& other) noexcept = default;

bool TextureUpload::Continue(uint32_t texture, uint64_t& budget, bool mayWait) {
    return m_impl->Continue(texture, budget, mayWait);
}
bool TextureUpload::IsBusy() const {
    return m_impl->IsBusy();
}
uint64_t TextureUpload::PendingBytes() const {
    return m_impl->PendingBytes();
}
SceneTexture TextureUpload::Get(uint32_t texture) const {
    return m_impl->Get(texture);
}
uint64_t TextureUpload::Bytes() const {
    return m_impl->Bytes();
}
uint64_t TextureUpload::CopiedBytes() const {
    return m_impl->CopiedBytes();
}
const std::string& TextureUpload::Reduction() const {
    return m_impl->Reduction();
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

// --- Passes that make mip levels ---

namespace {

static_assert(static_cast<uint32_t>(TexelContent::Data) == gpu::kTexelsData);
static_assert(static_cast<uint32_t>(TexelContent::Color) == gpu::kTexelsColor);
static_assert(static_cast<uint32_t>(TexelContent::TransparentColor) == gpu::kTexelsTransparentColor);
static_assert(static_cast<uint32_t>(TexelContent::Normals) == gpu::kTexelsNormals);

uint64_t TexelCount(Extent2D extent) {
    return uint64_t{extent.width} * extent.height;
}

// Returns the level of the normal map whose texels are as large as those of level `level` of the image.
float MatchingLevel(const TextureMeans& normals, Extent2D image, uint32_t level) {
    const double ratio =
        static_cast<double>(TexelCount(normals.extent)) / static_cast<double>(TexelCount(image));
    return static_cast<float>(level + 0.5 * std::log2(ratio));
}

// Returns the level of the normal map whose variance widens the roughness of this level. The target's first
// level is also read from near, where all levels of the normal map are visible.
float NormalsLod(const RoughnessWidening& widening, Extent2D image, uint32_t level, bool isFirst) {
    const auto first = static_cast<float>(widening.firstNormals);
    if (isFirst) return first;
    return std::clamp(MatchingLevel(widening.normals, image, level), first,
                      static_cast<float>(widening.lastNormals));
}

}  // namespace

TextureLevels MakeTextureLevels(Renderer& renderer, TextureId image, TextureId target,
                                const TextureLevelSettings& settings) {
    const Extent2D extent = renderer.Desc(image).extent;
    const GraphTextureDesc wanted = renderer.Desc(target);
    const uint32_t levelCount = rhi::FullMipCount(extent);
    if (settings.firstLevel >= levelCount || wanted.extent != rhi::MipExtent(extent, settings.firstLevel))
        throw MakeError(
            ErrorKind::Usage, "MakeTextureLevels: an image of {}x{} texels has no level {} of {}x{} texels",
            extent.width, extent.height, settings.firstLevel, wanted.extent.width, wanted.extent.height);
    const uint32_t last = settings.firstLevel + wanted.levels - 1;  // FullMipCount bounds wanted.levels
    TextureLevels made{.texture = target, .means = {}};
    const auto& widening = settings.widening;
    const bool widensImage = settings.firstLevel == 0 && widening && widening->firstNormals > 0;
    TextureId means, encoded, widenedImage;
    if (levelCount > 1 || widensImage) {
        // The means of a normal map are read by roughness textures, so that all levels are needed
        const bool isAll = settings.content == TexelContent::Normals;
        const GraphTextureDesc chain{.extent = rhi::MipExtent(extent, 1),
                                     .format = Format::Rgba32Float,
                                     .levels = std::max(isAll ? levelCount - 1 : last, 1u)};
        means = settings.means ? *settings.means : renderer.CreateTexture("textureMeans", chain);
        encoded = renderer.CreateTexture(
            "textureLevels", {.extent = chain.extent, .format = Format::Rgba8Unorm, .levels = chain.levels});
        if (widensImage)
            widenedImage =
                renderer.CreateTexture("widenedImage", {.extent = extent, .format = Format::Rgba8Unorm});
        const uint32_t end = std::min(chain.levels + 1, levelCount);
        for (uint32_t level = widensImage ? 0 : 1; level < end; ++level)
            renderer.AddPass(
                "TextureLevel", PassKind::Compute,
                [&](PassBuilder& pass) {
                    pass.Compute(widening ? "scene/texture_level_widened.comp" : "scene/texture_level.comp");
                    gpu::TextureLevelConstants constants{
                        .texels = static_cast<uint32_t>(settings.content),
                        .isFirst = level <= 1 ? 1u : 0u,
                        .normalsLod = 0.0f,
                        .hasOtherTexels = 0,
                        .slopeScale = 0.0f,
                        .roughnessFactor = 1.0f,
                    };
                    if (widening) {
                        pass.Reads("normals", widening->normals.levels, rhi::SamplerDesc{});
                        constants.normalsLod =
                            NormalsLod(*widening, extent, level, level == settings.firstLevel);
                        constants.hasOtherTexels =
                            constants.normalsLod != MatchingLevel(widening->normals, extent, level);
                        constants.slopeScale = widening->normalScale;
                        constants.roughnessFactor = widening->roughnessFactor;
                    }
                    pass.Constants(constants);
                    if (level <= 1)
                        pass.Reads("finer", image, rhi::SamplerDesc{});
                    else
                        pass.Reads("finer", means, rhi::Level(level - 2), rhi::SamplerDesc{});
                    means = pass.Writes("means", means, rhi::Level(std::max(level, 1u) - 1));
                    if (level == 0)
                        widenedImage = pass.Writes("encoded", widenedImage);
                    else
                        encoded = pass.Writes("encoded", encoded, rhi::Level(level - 1));
                },
                [size = rhi::MipExtent(extent, level)](CommandList& commands) {
                    commands.DispatchOver(size);
                });
        if (levelCount > 1) made.means = {.levels = means, .extent = extent};
    }
    const TextureId top = widensImage ? widenedImage : image;
    renderer.AddPass(
        "CopyTextureLevels", PassKind::Transfer,
        [&](PassBuilder& pass) {
            if (settings.firstLevel == 0) pass.CopiesFrom(top);
            if (last > 0) pass.CopiesFrom(encoded);
            made.texture = pass.CopiesTo(target);
        },
        [top, encoded, copied = target, first = settings.firstLevel, last](CommandList& commands,
                                                                           const PassResources& resources) {
            for (uint32_t level = first; level <= last; ++level) {
                const rhi::Texture& source = resources.Texture(level == 0 ? top : encoded);
                commands.CopyTexture(source, {.level = level == 0 ? 0 : level - 1}, resources.Texture(copied),
                                     {.level = level - first});
            }
        });
    return made;
}

}  // namespace raygraph
