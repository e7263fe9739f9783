// The creation of buffers, textures, samplers and memory blocks. A failed call of Vulkan leaves its handle
// undefined, so that an owner gets the handle after a success only.

#include <algorithm>

#include "base/text.h"
#include "rhi/device_impl.h"

namespace raygraph::rhi {
namespace {

VkBufferUsageFlags ToVk(BufferUsage usage) {
    VkBufferUsageFlags flags = VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
    const auto add = [&](BufferUsage bit, VkBufferUsageFlags flag) {
        if (Has(usage, bit)) flags |= flag;
    };
    add(BufferUsage::Storage, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    add(BufferUsage::Uniform, VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT);
    add(BufferUsage::Index, VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
    add(BufferUsage::Vertex, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
    add(BufferUsage::Indirect, VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT);
    add(BufferUsage::CopySource, VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
    add(BufferUsage::CopyDestination, VK_BUFFER_USAGE_TRANSFER_DST_BIT);
    add(BufferUsage::BuildInput, VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR);
    add(BufferUsage::AccelerationStructure, VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR);
    add(BufferUsage::ShaderBindingTable, VK_BUFFER_USAGE_SHADER_BINDING_TABLE_BIT_KHR);
    return flags;
}

VkImageUsageFlags ToVk(TextureUsage usage) {
    VkImageUsageFlags flags = 0;
    const auto add = [&](TextureUsage bit, VkImageUsageFlags flag) {
        if (Has(usage, bit)) flags |= flag;
    };
    add(TextureUsage::Sampled, VK_IMAGE_USAGE_SAMPLED_BIT);
    add(TextureUsage::Storage, VK_IMAGE_USAGE_STORAGE_BIT);
    add(TextureUsage::ColorTarget, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT);
    add(TextureUsage::DepthTarget, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT);
    add(TextureUsage::CopySource, VK_IMAGE_USAGE_TRANSFER_SRC_BIT);
    add(TextureUsage::CopyDestination, VK_IMAGE_USAGE_TRANSFER_DST_BIT);
    return flags;
}

template <typename CreateInfo>
void Share(CreateInfo& info, std::span<const uint32_t> families) {
    if (families.size() < 2) return;
    info.sharingMode = VK_SHARING_MODE_CONCURRENT;
    info.queueFamilyIndexCount = static_cast<uint32_t>(families.size());
    info.pQueueFamilyIndices = families.data();
}

VkBufferCreateInfo CreateInfo(const BufferDesc& desc, std::span<const uint32_t> families) {
    VkBufferCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
    info.size = desc.size;
    info.usage = ToVk(desc.usage);
    Share(info, families);
    return info;
}

// Textures that shaders only read are shared by all queues. Others are not, because drivers compress targets
// and storage images only if one queue family at a time may access them.
bool IsSharedByDesc(const TextureDesc& desc) {
    using enum TextureUsage;
    return desc.isShared || Has(Sampled | CopySource | CopyDestination, desc.usage);
}

VkImageCreateInfo CreateInfo(const TextureDesc& desc, std::span<const uint32_t> families) {
    VkImageCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO;
    info.imageType = VK_IMAGE_TYPE_2D;
    info.format = ToVk(desc.format);
    info.extent = {desc.extent.width, desc.extent.height, 1};
    info.mipLevels = desc.mipLevels;
    info.arrayLayers = desc.layers;
    if (desc.layers >= 6 && desc.extent.width == desc.extent.height)
        info.flags = VK_IMAGE_CREATE_CUBE_COMPATIBLE_BIT;
    info.samples = VK_SAMPLE_COUNT_1_BIT;
    info.tiling = VK_IMAGE_TILING_OPTIMAL;
    info.usage = ToVk(desc.usage);
    if (IsSharedByDesc(desc)) Share(info, families);
    return info;
}

MemoryRequirements ToRequirements(const VkMemoryRequirements& r) {
    return {r.size, r.alignment, r.memoryTypeBits};
}

std::string Describe(const BufferDesc& desc) {
    return Text("buffer '{}' ({} bytes)", desc.name, desc.size);
}

std::string Describe(const TextureDesc& desc) {
    return Text("texture '{}' ({}x{} {})", desc.name, desc.extent.width, desc.extent.height,
                Name(desc.format));
}

[[noreturn]] void Reject(const std::string& subject, const std::string& reason) {
    throw MakeError(ErrorKind::Usage, "{}: {}", subject, reason);
}

void CheckDesc(const Device& device, const BufferDesc& desc) {
    if (desc.size == 0) Reject(Describe(desc), "its size is zero");
    if (desc.usage == BufferUsage::None) Reject(Describe(desc), "it has no usage");
    if (desc.size > device.Info().maxBufferBytes)
        throw MakeError(ErrorKind::OutOfMemory, "{}: the device's largest buffer has {} bytes",
                        Describe(desc), device.Info().maxBufferBytes);
}

// Checks without the device first, then whether the device supports such images.
void CheckDesc(const InstanceFunctions& vk, VkPhysicalDevice device, const DeviceInfo& info,
               const TextureDesc& desc) {
    const std::string subject = Describe(desc);
    if (desc.extent.IsEmpty()) Reject(subject, "its extent is empty");
    if (desc.format == Format::Undefined) Reject(subject, "it has no format");
    if (desc.usage == TextureUsage::None) Reject(subject, "it has no usage");
    if (BlockSide(desc.format) > 1 && !info.optional.textureCompressionBc)
        Reject(subject, info.name + " has no compressed textures (textureCompressionBC)");
    if (desc.mipLevels == 0 || desc.mipLevels > FullMipCount(desc.extent))
        Reject(subject,
               Text("{} mip levels, possible are 1 to {}", desc.mipLevels, FullMipCount(desc.extent)));
    if (desc.layers == 0 || desc.layers > info.maxTextureLayers)
        Reject(subject, Text("{} layers, possible are 1 to {}", desc.layers, info.maxTextureLayers));
    const VkImageCreateInfo image = CreateInfo(desc, {});
    VkPhysicalDeviceImageFormatInfo2 ask{};
    ask.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_IMAGE_FORMAT_INFO_2;
    ask.format = image.format;
    ask.type = image.imageType;
    ask.tiling = image.tiling;
    ask.usage = image.usage;
    ask.flags = image.flags;
    VkImageFormatProperties2 answer{VK_STRUCTURE_TYPE_IMAGE_FORMAT_PROPERTIES_2, nullptr, {}};
    if (vk.vkGetPhysicalDeviceImageFormatProperties2(device, &ask, &answer) != VK_SUCCESS)
        Reject(subject, info.name + " has no such format for this usage");
    const VkExtent3D largest = answer.imageFormatProperties.maxExtent;
    if (desc.extent.width > largest.width || desc.extent.height > largest.height)
        Reject(subject, Text("the device's largest texture is {}x{}", largest.width, largest.height));
    if (desc.layers > answer.imageFormatProperties.maxArrayLayers)
        Reject(subject, Text("{} layers, {} allows {} for this usage", desc.layers, info.name,
                             answer.imageFormatProperties.maxArrayLayers));
}

void CheckFits(const std::string& subject, const MemoryRequirements& needed,
               const MemoryRequirements& given) {
    if (needed.size > given.size)
        Reject(subject, Text("needs {} bytes, its memory block has {}", needed.size, given.size));
    if ((needed.memoryTypeBits & given.memoryTypeBits) != given.memoryTypeBits)
        Reject(subject, "its memory block is of a memory type that it cannot use");
    if (needed.alignment > given.alignment)
        Reject(subject,
               Text("needs alignment {}, its memory block has {}", needed.alignment, given.alignment));
}

}  // namespace

MemoryRequirements Device::RequirementsOf(const BufferDesc& desc) {
    CheckDesc(*this, desc);
    const VkBufferCreateInfo info = CreateInfo(desc, QueueFamilies());
    VkDeviceBufferMemoryRequirements ask{VK_STRUCTURE_TYPE_DEVICE_BUFFER_MEMORY_REQUIREMENTS, nullptr, &info};
    VkMemoryRequirements2 answer{VK_STRUCTURE_TYPE_MEMORY_REQUIREMENTS_2, nullptr, {}};
    Vk().vkGetDeviceBufferMemoryRequirements(Handle(), &ask, &answer);
    return ToRequirements(answer.memoryRequirements);
}

MemoryRequirements Device::RequirementsOf(const TextureDesc& desc) {
    CheckDesc(m_impl->instanceFunctions, PhysicalDevice(), Info(), desc);
    const VkImageCreateInfo info = CreateInfo(desc, QueueFamilies());
    VkDeviceImageMemoryRequirements ask{};
    ask.sType = VK_STRUCTURE_TYPE_DEVICE_IMAGE_MEMORY_REQUIREMENTS;
    ask.pCreateInfo = &info;
    VkMemoryRequirements2 answer{VK_STRUCTURE_TYPE_MEMORY_REQUIREMENTS_2, nullptr, {}};
    Vk().vkGetDeviceImageMemoryRequirements(Handle(), &ask, &answer);
    return ToRequirements(answer.memoryRequirements);
}

Buffer Device::CreateBuffer(const BufferDesc& desc) {
    CheckDesc(*this, desc);
    const std::string subject = Describe(desc);
    RequireMemory(subject, desc.size);
    const VkBufferCreateInfo info = CreateInfo(desc, QueueFamilies());
    // The whole buffer is aligned, so that an address at offset 0 always is.
    uint64_t alignment = 16;
    if (Has(desc.usage, BufferUsage::Storage))
        alignment = std::max<uint64_t>(alignment, Info().scratchAlignment);
    if (Has(desc.usage, BufferUsage::ShaderBindingTable))
        alignment = std::max<uint64_t>(alignment, Info().shaderGroupBaseAlignment);
    const MemoryRequest request{
        .name = desc.name.c_str(),
        .kind = desc.memory,
        .alignment = alignment,
        .mustBeDeviceLocal = Has(desc.usage, BufferUsage::AccelerationStructure),  // every ray traverses it
        .isOnlyCopied = Has(BufferUsage::CopySource | BufferUsage::CopyDestination, desc.usage),
        .isDedicated = desc.hasOwnMemory};
    // The owner is complete before it has anything to free.
    Buffer buffer;
    buffer.m_desc = desc;
    buffer.m_device = this;
    CheckMemory(m_impl->allocator->CreateBuffer(info, request, buffer.m_buffer, buffer.m_memory), subject);
    buffer.m_mapped = buffer.m_memory.mapped;
    buffer.m_isShared = info.sharingMode == VK_SHARING_MODE_CONCURRENT;
    TrackMemory(buffer.m_memory, subject, desc.memory == MemoryKind::Device);
    SetName(VK_OBJECT_TYPE_BUFFER, reinterpret_cast<uint64_t>(buffer.m_buffer), desc.name);
    return buffer;
}

Buffer Device::CreateBuffer(const BufferDesc& desc, const MemoryBlock& memory) {
    if (desc.memory != MemoryKind::Device)
        Reject(Describe(desc), "a buffer in a memory block is Device memory");
    CheckFits(Describe(desc), RequirementsOf(desc), memory.Requirements());
    const VkBufferCreateInfo info = CreateInfo(desc, QueueFamilies());
    VkBuffer handle = VK_NULL_HANDLE;
    Check(Vk().vkCreateBuffer(Handle(), &info, AllocationCallbacks(), &handle), Describe(desc));
    Buffer buffer;
    buffer.m_desc = desc;
    buffer.m_buffer = handle;
    buffer.m_isShared = info.sharingMode == VK_SHARING_MODE_CONCURRENT;
    buffer.m_device = this;
    const VkBindBufferMemoryInfo bind{VK_STRUCTURE_TYPE_BIND_BUFFER_MEMORY_INFO, nullptr, handle,
                                      memory.m_memory.memory, memory.m_memory.offset};
    Check(Vk().vkBindBufferMemory2(Handle(), 1, &bind), Describe(desc));
    SetName(VK_OBJECT_TYPE_BUFFER, reinterpret_cast<uint64_t>(buffer.m_buffer), desc.name);
    return buffer;
}

Buffer Device::WrapBuffer(const BufferDesc& desc, VkBuffer buffer) {
    if (!buffer) Reject(Describe(desc), "the host's buffer is null");
    CheckDesc(*this, desc);
    if (desc.memory != MemoryKind::Device) Reject(Describe(desc), "a host's buffer is Device memory");
    Buffer wrapped;
    wrapped.m_desc = desc;
    wrapped.m_buffer = buffer;
    wrapped.m_ownsBuffer = false;
    wrapped.m_isShared = desc.isShared;
    wrapped.m_device = this;
    return wrapped;
}

void Device::Free(VkBuffer buffer, const MemoryAllocation& memory) noexcept {
    Vk().vkDestroyBuffer(Handle(), buffer, AllocationCallbacks());
    FreeMemory(memory);
}

void Device::Free(VkImage image, VkImageView view, const MemoryAllocation& memory) noexcept {
    Vk().vkDestroyImageView(Handle(), view, AllocationCallbacks());
    Vk().vkDestroyImage(Handle(), image, AllocationCallbacks());
    FreeMemory(memory);
}

VkImageView Device::CreateView(const Texture& texture, const Subresources& part, ImageShape shape) {
    VkImageViewCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO;
    info.image = texture.m_image;
    info.viewType = shape == ImageShape::Plain   ? VK_IMAGE_VIEW_TYPE_2D
                    : shape == ImageShape::Array ? VK_IMAGE_VIEW_TYPE_2D_ARRAY
                                                 : VK_IMAGE_VIEW_TYPE_CUBE;
    info.format = ToVk(texture.m_desc.format);
    info.subresourceRange = texture.RangeOf(part);
    VkImageView view = VK_NULL_HANDLE;
    Check(Vk().vkCreateImageView(Handle(), &info, AllocationCallbacks(), &view),
          Describe(texture.m_desc) + ": vkCreateImageView");
    SetName(VK_OBJECT_TYPE_IMAGE_VIEW, reinterpret_cast<uint64_t>(view), texture.m_desc.name);
    return view;
}

// Names the image and creates the view if its usage needs one. The texture owns its image already.
void Device::Finish(Texture& texture) {
    const TextureDesc& desc = texture.m_desc;
    if (texture.m_ownsImage)
        SetName(VK_OBJECT_TYPE_IMAGE, reinterpret_cast<uint64_t>(texture.m_image), desc.name);
    constexpr VkImageUsageFlags kViewed = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT |
                                          VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT |
                                          VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
    if ((ToVk(desc.usage) & kViewed) == 0) return;  // copies need no view, and Vulkan allows none
    texture.m_view = CreateView(texture, Resolved({}, desc.mipLevels, desc.layers),
                                desc.layers == 1 ? ImageShape::Plain : ImageShape::Array);
}

Texture Device::CreateTexture(const TextureDesc& desc) {
    const std::string subject = Describe(desc);
    RequireMemory(subject, RequirementsOf(desc).size);
    const VkImageCreateInfo info = CreateInfo(desc, QueueFamilies());
    Texture texture;
    texture.m_desc = desc;
    texture.m_isShared = info.sharingMode == VK_SHARING_MODE_CONCURRENT;
    texture.m_device = this;
    CheckMemory(
        m_impl->allocator->CreateImage(info, {.name = desc.name.c_str()}, texture.m_image, texture.m_memory),
        subject);
    TrackMemory(texture.m_memory, subject, true);
    Finish(texture);
    return texture;
}

Texture Device::CreateTexture(const TextureDesc& desc, const MemoryBlock& memory) {
    CheckFits(Describe(desc), RequirementsOf(desc), memory.Requirements());
    const VkImageCreateInfo info = CreateInfo(desc, QueueFamilies());
    VkImage image = VK_NULL_HANDLE;
    Check(Vk().vkCreateImage(Handle(), &info, AllocationCallbacks(), &image), Describe(desc));
    Texture texture;
    texture.m_desc = desc;
    texture.m_image = image;
    texture.m_isShared = info.sharingMode == VK_SHARING_MODE_CONCURRENT;
    texture.m_device = this;
    const VkBindImageMemoryInfo bind{VK_STRUCTURE_TYPE_BIND_IMAGE_MEMORY_INFO, nullptr, image,
                                     memory.m_memory.memory, memory.m_memory.offset};
    Check(Vk().vkBindImageMemory2(Handle(), 1, &bind), Describe(desc));
    Finish(texture);
    return texture;
}

Texture Device::WrapTexture(const TextureDesc& desc, VkImage image) {
    if (!image) Reject(Describe(desc), "the host's image is null");
    CheckDesc(m_impl->instanceFunctions, PhysicalDevice(), Info(), desc);
    Texture texture;
    texture.m_desc = desc;
    texture.m_image = image;
    texture.m_ownsImage = false;
    texture.m_isShared = desc.isShared;
    texture.m_device = this;
    Finish(texture);
    return texture;
}

bool Device::HasFormatFeatures(Format format, VkFormatFeatureFlags needed) const {
    VkFormatProperties2 properties{VK_STRUCTURE_TYPE_FORMAT_PROPERTIES_2, nullptr, {}};
    m_impl->instanceFunctions.vkGetPhysicalDeviceFormatProperties2(PhysicalDevice(), rhi::ToVk(format),
                                                                   &properties);
    return (properties.formatProperties.optimalTilingFeatures & needed) == needed;
}

bool Device::CanGenerateMips(Format format) const {
    return HasFormatFeatures(format, VK_FORMAT_FEATURE_BLIT_SRC_BIT | VK_FORMAT_FEATURE_BLIT_DST_BIT |
                                         VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT);
}

bool Device::CanSample(Format format) const {
    if (BlockSide(format) > 1 && !Info().optional.textureCompressionBc) return false;
    return HasFormatFeatures(format, VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT |
                                         VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT |
                                         VK_FORMAT_FEATURE_TRANSFER_DST_BIT);
}

Sampler Device::CreateSampler(const SamplerDesc& desc) {
    const auto filter = [](Filter f) { return f == Filter::Nearest ? VK_FILTER_NEAREST : VK_FILTER_LINEAR; };
    const auto address = [](AddressMode mode) {
        switch (mode) {
            case AddressMode::Repeat:
                return VK_SAMPLER_ADDRESS_MODE_REPEAT;
            case AddressMode::MirroredRepeat:
                return VK_SAMPLER_ADDRESS_MODE_MIRRORED_REPEAT;
            case AddressMode::ClampToEdge:
                break;
        }
        return VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
    };
    VkSamplerCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO;
    info.magFilter = filter(desc.magFilter);
    info.minFilter = filter(desc.minFilter);
    info.mipmapMode =
        desc.mipFilter == Filter::Nearest ? VK_SAMPLER_MIPMAP_MODE_NEAREST : VK_SAMPLER_MIPMAP_MODE_LINEAR;
    info.addressModeU = address(desc.addressU);
    info.addressModeV = address(desc.addressV);
    info.addressModeW = VK_SAMPLER_ADDRESS_MODE_REPEAT;
    info.maxLod = VK_LOD_CLAMP_NONE;
    if (!(desc.maxAnisotropy >= 1.0f))
        Reject(Text("sampler '{}'", desc.name),
               Text("maxAnisotropy {}, must be at least 1", desc.maxAnisotropy));
    info.maxAnisotropy = std::min(desc.maxAnisotropy, Info().maxAnisotropy);
    info.anisotropyEnable = info.maxAnisotropy > 1.0f ? VK_TRUE : VK_FALSE;
    VkSampler handle = VK_NULL_HANDLE;
    Check(Vk().vkCreateSampler(Handle(), &info, AllocationCallbacks(), &handle),
          "sampler '" + desc.name + "': vkCreateSampler");
    Sampler sampler;
    sampler.m_sampler = handle;
    sampler.m_device = this;
    SetName(VK_OBJECT_TYPE_SAMPLER, reinterpret_cast<uint64_t>(sampler.m_sampler), desc.name);
    return sampler;
}

MemoryBlock Device::CreateMemoryBlock(const std::string& name, const MemoryRequirements& requirements) {
    const std::string subject = Text("memory block '{}' ({} bytes)", name, requirements.size);
    if (requirements.size == 0) Reject(subject, "its size is zero");
    RequireMemory(subject, requirements.size);
    const VkMemoryRequirements needed{requirements.size, requirements.alignment, requirements.memoryTypeBits};
    MemoryBlock block;
    block.m_device = this;
    CheckMemory(m_impl->allocator->Allocate(needed, {.name = name.c_str()}, block.m_memory), subject);
    // The block has one memory type from here on, which bound resources must be able to use.
    block.m_requirements = {requirements.size, requirements.alignment, 1u << block.m_memory.memoryType};
    TrackMemory(block.m_memory, subject, true);
    return block;
}

// --- Memory accounting: use, budget, limit ---

MemoryStatistics Device::Memory() const {
    return m_impl->memory.Statistics();
}

std::vector<MemoryHeap> Device::MemoryHeaps() const {
    VkPhysicalDeviceMemoryBudgetPropertiesEXT budget{};
    budget.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MEMORY_BUDGET_PROPERTIES_EXT;
    const bool hasBudget = Info().optional.memoryBudget;
    VkPhysicalDeviceMemoryProperties2 properties{
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MEMORY_PROPERTIES_2, hasBudget ? &budget : nullptr, {}};
    m_impl->instanceFunctions.vkGetPhysicalDeviceMemoryProperties2(PhysicalDevice(), &properties);
    std::vector<MemoryHeap> heaps;
    for (uint32_t i = 0; i < properties.memoryProperties.memoryHeapCount; ++i) {
        const VkMemoryHeap& heap = properties.memoryProperties.memoryHeaps[i];
        heaps.push_back({.isDeviceLocal = (heap.flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) != 0,
                         .sizeBytes = heap.size,
                         .budgetBytes = hasBudget ? budget.heapBudget[i] : heap.size * 8 / 10,
                         .usedBytes = hasBudget ? budget.heapUsage[i] : m_impl->memory.UsedOfHeap(i)});
    }
    return heaps;
}

void Device::LimitMemory(uint64_t bytes) {
    m_impl->memoryLimit = bytes;
}

uint64_t Device::MemoryLimit() const {
    return m_impl->memoryLimit;
}

void Device::RequireMemory(const std::string& subject, uint64_t bytes) {
    const uint64_t limit = m_impl->memoryLimit;
    if (limit == 0) return;
    const uint64_t used = Memory().usedBytes;
    if (used <= limit && bytes <= limit - used) return;
    throw Error(ErrorKind::OutOfMemory,
                Text("{}: {} of the limit of {} bytes are in use", subject, used, limit),
                VK_ERROR_OUT_OF_DEVICE_MEMORY);
}

void Device::CheckMemory(VkResult result, const std::string& subject) {
    if (result != VK_ERROR_OUT_OF_DEVICE_MEMORY) return Check(result, subject);
    // Drivers return various errors for allocations on a lost device, and the allocator treats each as
    // full memory.
    uint64_t completed = 0;
    if (m_impl->QueryCompleted(QueueKind::Main, completed) == VK_ERROR_DEVICE_LOST)
        Check(VK_ERROR_DEVICE_LOST, subject);
    std::string text;
    for (const MemoryHeap& heap : MemoryHeaps())
        if (heap.isDeviceLocal)
            text += (text.empty() ? " (device memory: " : ", ") + BytesText(heap.usedBytes) + " of " +
                    BytesText(heap.budgetBytes) + " in use";
    Check(result, subject + text + (text.empty() ? "" : ")"));
}

void Device::TrackMemory(MemoryAllocation& memory, const std::string& subject, bool isForDevice) {
    const VkMemoryType& type = m_impl->memoryProperties.memoryTypes[memory.memoryType];
    memory.isFallback = isForDevice && (type.propertyFlags & VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT) == 0;
    if (m_impl->memory.Add(memory, type.heapIndex))
        WriteLog(Log(), LogLevel::Warning, log_category::kMemory,
                 "device memory is full: {} lies in the memory of the host, which is slow", subject);
}

void Device::FreeMemory(const MemoryAllocation& memory) noexcept {
    if (!memory) return;
    m_impl->memory.Remove(memory, m_impl->memoryProperties.memoryTypes[memory.memoryType].heapIndex);
    m_impl->allocator->Free(memory);
}

}  // namespace raygraph::rhi
