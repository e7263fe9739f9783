#include "rhi/texture_table.h"

#include <algorithm>
#include <mutex>
#include <vector>

#include "base/text.h"
#include "rhi/device.h"

namespace raygraph::rhi {

VkDescriptorSetLayout CreateTextureTableLayout(Device& device) {
    VkDescriptorSetLayoutBinding binding{};
    binding.binding = 0;
    binding.descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    binding.descriptorCount = kMaxTextureTableSlots;
    binding.stageFlags = VK_SHADER_STAGE_ALL;
    const VkDescriptorBindingFlags flags =
        VK_DESCRIPTOR_BINDING_UPDATE_AFTER_BIND_BIT | VK_DESCRIPTOR_BINDING_UPDATE_UNUSED_WHILE_PENDING_BIT |
        VK_DESCRIPTOR_BINDING_PARTIALLY_BOUND_BIT | VK_DESCRIPTOR_BINDING_VARIABLE_DESCRIPTOR_COUNT_BIT;
    VkDescriptorSetLayoutBindingFlagsCreateInfo bindingFlags{};
    bindingFlags.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_BINDING_FLAGS_CREATE_INFO;
    bindingFlags.bindingCount = 1;
    bindingFlags.pBindingFlags = &flags;
    VkDescriptorSetLayoutCreateInfo create{};
    create.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO;
    create.pNext = &bindingFlags;
    create.flags = VK_DESCRIPTOR_SET_LAYOUT_CREATE_UPDATE_AFTER_BIND_POOL_BIT;
    create.bindingCount = 1;
    create.pBindings = &binding;
    VkDescriptorSetLayout layout = VK_NULL_HANDLE;
    device.Check(device.Vk().vkCreateDescriptorSetLayout(device.Handle(), &create,
                                                         device.AllocationCallbacks(), &layout),
                 "texture table: vkCreateDescriptorSetLayout");
    device.SetName(VK_OBJECT_TYPE_DESCRIPTOR_SET_LAYOUT, reinterpret_cast<uint64_t>(layout), "texture table");
    return layout;
}

struct TextureTable::State {
    explicit State(Device& owner) : device(owner) {}
    void CreateSet(uint32_t capacity);
    void Write(uint32_t slot, const VkDescriptorImageInfo& image);

    Device& device;
    VkDescriptorPool pool = VK_NULL_HANDLE;
    VkDescriptorSet set = VK_NULL_HANDLE;
    VkDescriptorImageInfo defaultImage{};
    std::mutex mutex;  // guards everything below and writes to the set
    std::vector<bool> isTaken;
    std::vector<uint32_t> free;  // the last one is used next
    uint32_t count = 0;
    bool isClosed = false;  // the table is destroyed, and pending removals no longer write to the set
};

void TextureTable::State::CreateSet(uint32_t capacity) {
    const DeviceFunctions& vk = device.Vk();
    const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, capacity};
    VkDescriptorPoolCreateInfo create{};
    create.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO;
    create.flags = VK_DESCRIPTOR_POOL_CREATE_UPDATE_AFTER_BIND_BIT;
    create.maxSets = 1;
    create.poolSizeCount = 1;
    create.pPoolSizes = &size;
    VkDescriptorPool created = VK_NULL_HANDLE;
    device.Check(vk.vkCreateDescriptorPool(device.Handle(), &create, device.AllocationCallbacks(), &created),
                 "texture table: vkCreateDescriptorPool");
    pool = created;

    VkDescriptorSetVariableDescriptorCountAllocateInfo variable{};
    variable.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_VARIABLE_DESCRIPTOR_COUNT_ALLOCATE_INFO;
    variable.descriptorSetCount = 1;
    variable.pDescriptorCounts = &capacity;
    const VkDescriptorSetLayout layout = device.TextureTableLayout();
    VkDescriptorSetAllocateInfo allocate{};
    allocate.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO;
    allocate.pNext = &variable;
    allocate.descriptorPool = pool;
    allocate.descriptorSetCount = 1;
    allocate.pSetLayouts = &layout;
    device.Check(vk.vkAllocateDescriptorSets(device.Handle(), &allocate, &set),
                 "texture table: vkAllocateDescriptorSets");
    device.SetName(VK_OBJECT_TYPE_DESCRIPTOR_SET, reinterpret_cast<uint64_t>(set), "texture table");
}

void TextureTable::State::Write(uint32_t slot, const VkDescriptorImageInfo& image) {
    VkWriteDescriptorSet write{};
    write.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
    write.dstSet = set;
    write.dstArrayElement = slot;
    write.descriptorCount = 1;
    write.descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    write.pImageInfo = &image;
    device.Vk().vkUpdateDescriptorSets(device.Handle(), 1, &write, 0, nullptr);
}

TextureTable::TextureTable(Device& device, uint32_t capacity, const Texture& defaultTexture,
                           const Sampler& defaultSampler)
    : m_state(std::make_shared<State>(device)) {
    if (!defaultTexture || !defaultSampler)
        throw Error(ErrorKind::Usage, "texture table: has no default texture");
    m_state->defaultImage = {defaultSampler.Handle(), defaultTexture.View(),
                             VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    Create(capacity);
}

void TextureTable::Create(uint32_t capacity) {
    if (capacity == 0 || capacity > kMaxTextureTableSlots)
        throw MakeError(ErrorKind::Usage, "texture table: capacity is {}, 1 to {} are possible", capacity,
                        kMaxTextureTableSlots);
    State& state = *m_state;
    state.isTaken.assign(capacity, false);
    for (uint32_t slot = capacity; slot-- > 0;) state.free.push_back(slot);
    try {
        state.CreateSet(capacity);
    } catch (...) {
        state.device.Vk().vkDestroyDescriptorPool(state.device.Handle(), state.pool,
                                                  state.device.AllocationCallbacks());
        throw;
    }
    for (uint32_t slot = 0; slot < capacity; ++slot) state.Write(slot, state.defaultImage);
}

TextureTable::TextureTable(Device& device, uint32_t capacity, const TextureTable& smaller)
    : m_state(std::make_shared<State>(device)) {
    State& from = *smaller.m_state;
    const std::lock_guard lock(from.mutex);
    if (capacity < from.isTaken.size())
        throw MakeError(ErrorKind::Usage, "texture table: capacity is {}, that to be enlarged has {}",
                        capacity, from.isTaken.size());
    m_state->defaultImage = from.defaultImage;
    Create(capacity);
    State& state = *m_state;
    std::copy(from.isTaken.begin(), from.isTaken.end(), state.isTaken.begin());
    std::erase_if(state.free, [&](uint32_t slot) { return state.isTaken[slot]; });
    state.count = from.count;
    for (uint32_t slot = 0; slot < from.isTaken.size(); ++slot) {
        if (!from.isTaken[slot]) continue;
        VkCopyDescriptorSet copy{};
        copy.sType = VK_STRUCTURE_TYPE_COPY_DESCRIPTOR_SET;
        copy.srcSet = from.set;
        copy.srcArrayElement = slot;
        copy.dstSet = state.set;
        copy.dstArrayElement = slot;
        copy.descriptorCount = 1;
        device.Vk().vkUpdateDescriptorSets(device.Handle(), 0, nullptr, 1, &copy);
    }
}

TextureTable::~TextureTable() {
    {
        const std::lock_guard lock(m_state->mutex);
        m_state->isClosed = true;
    }
    m_state->device.Retire([&device = m_state->device, pool = m_state->pool] {
        device.Vk().vkDestroyDescriptorPool(device.Handle(), pool, device.AllocationCallbacks());
    });
}

uint32_t TextureTable::Add(const Texture& texture, const Sampler& sampler) {
    if (!texture || !sampler) throw Error(ErrorKind::Usage, "texture table: texture or sampler is empty");
    if (texture.Desc().layers != 1)
        throw MakeError(ErrorKind::Usage, "texture table: '{}' has {} layers, its shaders see one",
                        texture.Desc().name, texture.Desc().layers);
    State& state = *m_state;
    const std::lock_guard lock(state.mutex);
    if (state.free.empty())
        throw MakeError(ErrorKind::Usage, "texture table: all {} slots are taken, no room for '{}'",
                        state.isTaken.size(), texture.Desc().name);
    const uint32_t slot = state.free.back();
    state.free.pop_back();
    state.isTaken[slot] = true;
    ++state.count;
    state.Write(slot, {sampler.Handle(), texture.View(), VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL});
    return slot;
}

void TextureTable::Remove(uint32_t slot) {
    {
        const std::lock_guard lock(m_state->mutex);
        if (slot >= m_state->isTaken.size() || !m_state->isTaken[slot])
            throw MakeError(ErrorKind::Usage, "texture table: slot {} holds no texture", slot);
        m_state->isTaken[slot] = false;
        --m_state->count;
    }
    m_state->device.Retire([state = m_state, slot] {
        const std::lock_guard lock(state->mutex);
        if (state->isClosed) return;
        state->Write(slot, state->defaultImage);
        state->free.push_back(slot);
    });
}

VkDescriptorSet TextureTable::Set() const {
    return m_state->set;
}

uint32_t TextureTable::Capacity() const {
    return static_cast<uint32_t>(m_state->isTaken.size());
}

uint32_t TextureTable::FreeCount() const {
    const std::lock_guard lock(m_state->mutex);
    return static_cast<uint32_t>(m_state->free.size());
}

uint32_t TextureTable::Count() const {
    const std::lock_guard lock(m_state->mutex);
    return m_state->count;
}

}  // namespace raygraph::rhi
