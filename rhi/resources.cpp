#include "rhi/resources.h"

#include "base/text.h"
#include "rhi/device.h"

namespace raygraph::rhi {

void Buffer::Release() noexcept {
    if (!m_buffer || !m_ownsBuffer) return;
    Device* device = m_device;
    device->Retire([device, buffer = m_buffer, memory = m_memory] { device->Free(buffer, memory); });
}

Buffer& Buffer::operator=(Buffer&& other) noexcept {
    if (this == &other) return *this;
    Release();
    m_device = std::exchange(other.m_device, nullptr);
    m_desc = std::exchange(other.m_desc, {});
    m_buffer = std::exchange(other.m_buffer, VK_NULL_HANDLE);
    m_memory = std::exchange(other.m_memory, {});
    m_mapped = std::exchange(other.m_mapped, nullptr);
    m_ownsBuffer = std::exchange(other.m_ownsBuffer, true);
    m_isShared = std::exchange(other.m_isShared, false);
    return *this;
}

VkDeviceAddress Buffer::Address() const {
    if (!m_buffer) return 0;
    const VkBufferDeviceAddressInfo ask{VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO, nullptr, m_buffer};
    return m_device->Vk().vkGetBufferDeviceAddress(m_device->Handle(), &ask);
}

Buffer::~Buffer() {
    Release();
}

std::span<std::byte> Buffer::Mapped() const {
    if (!m_mapped) return {};
    return {m_mapped, static_cast<size_t>(m_desc.size)};
}

VkImageSubresourceRange Texture::RangeOf(const Subresources& part) const {
    const VkImageAspectFlags aspect =
        IsDepth(m_desc.format) ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
    return {aspect, part.level, part.levelCount, part.layer, part.layerCount};
}

VkImageSubresourceRange Texture::WholeRange() const {
    return RangeOf(Resolved({}, m_desc.mipLevels, m_desc.layers));
}

VkImageView Texture::View(const Subresources& requested, ImageShape shape) const {
    const Subresources part = Resolved(requested, m_desc.mipLevels, m_desc.layers);
    const ImageShape own = m_desc.layers == 1 ? ImageShape::Plain : ImageShape::Array;
    if (shape == own && part == Resolved({}, m_desc.mipLevels, m_desc.layers)) return m_view;
    for (const PartView& known : m_partViews)
        if (known.part == part && known.shape == shape) return known.view;
    const auto fail = [&](const std::string& why) {
        throw MakeError(ErrorKind::Usage, "texture '{}' ({}x{} {}): a view as {}: {}", m_desc.name,
                        m_desc.extent.width, m_desc.extent.height, Name(m_desc.format), Name(shape), why);
    };
    const std::string missing = DescribeMissing(part, m_desc.mipLevels, m_desc.layers);
    if (!missing.empty()) fail(missing);
    const bool isCube = part.layerCount == 6 && m_desc.extent.width == m_desc.extent.height;
    if (shape == ImageShape::Plain && part.layerCount != 1)
        fail(Text("{} layers, it takes 1", part.layerCount));
    if (shape == ImageShape::Cube && !isCube)
        fail(Text("{} layers of {}x{}, it takes 6 square ones", part.layerCount, m_desc.extent.width,
                  m_desc.extent.height));
    m_partViews.reserve(m_partViews.size() + 1);
    return m_partViews.emplace_back(PartView{part, shape, m_device->CreateView(*this, part, shape)}).view;
}

void Texture::Release() noexcept {
    if (!m_image) return;
    Device* device = m_device;
    VkImage image = m_ownsImage ? m_image : VK_NULL_HANDLE;
    for (const PartView& part : m_partViews)
        device->Retire([device, view = part.view] { device->Free(VK_NULL_HANDLE, view, {}); });
    m_partViews.clear();
    device->Retire([device, image, view = m_view, memory = m_memory] { device->Free(image, view, memory); });
}

Texture& Texture::operator=(Texture&& other) noexcept {
    if (this == &other) return *this;
    Release();
    m_device = std::exchange(other.m_device, nullptr);
    m_desc = std::exchange(other.m_desc, {});
    m_image = std::exchange(other.m_image, VK_NULL_HANDLE);
    m_view = std::exchange(other.m_view, VK_NULL_HANDLE);
    m_partViews = std::exchange(other.m_partViews, {});
    m_memory = std::exchange(other.m_memory, {});
    m_ownsImage = std::exchange(other.m_ownsImage, true);
    m_isShared = std::exchange(other.m_isShared, false);
    return *this;
}

Texture::~Texture() {
    Release();
}

void Sampler::Release() noexcept {
    if (!m_sampler) return;
    Device* device = m_device;
    device->Retire([device, sampler = m_sampler] {
        device->Vk().vkDestroySampler(device->Handle(), sampler, device->AllocationCallbacks());
    });
}

Sampler& Sampler::operator=(Sampler&& other) noexcept {
    if (this == &other) return *this;
    Release();
    m_device = std::exchange(other.m_device, nullptr);
    m_sampler = std::exchange(other.m_sampler, VK_NULL_HANDLE);
    return *this;
}

Sampler::~Sampler() {
    Release();
}

void MemoryBlock::Release() noexcept {
    if (!m_memory) return;
    Device* device = m_device;
    device->Retire([device, memory = m_memory] { device->Free(VK_NULL_HANDLE, memory); });
}

MemoryBlock& MemoryBlock::operator=(MemoryBlock&& other) noexcept {
    if (this == &other) return *this;
    Release();
    m_device = std::exchange(other.m_device, nullptr);
    m_requirements = std::exchange(other.m_requirements, {});
    m_memory = std::exchange(other.m_memory, {});
    return *this;
}

MemoryBlock::~MemoryBlock() {
    Release();
}

}  // namespace raygraph::rhi
