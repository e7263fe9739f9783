#include "rhi/acceleration_structure.h"

#include <utility>

#include "rhi/device.h"

namespace raygraph::rhi {

AccelerationStructure::AccelerationStructure(Device& device, const std::string& name,
                                             VkAccelerationStructureTypeKHR type, uint64_t bytes)
    : m_device(&device), m_bytes(bytes) {
    m_storage = device.CreateBuffer({.name = name,
                                     .size = bytes,
                                     .usage = BufferUsage::AccelerationStructure,
                                     .memory = MemoryKind::Device});
    VkAccelerationStructureCreateInfoKHR create{};
    create.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR;
    create.buffer = m_storage.Handle();
    create.size = bytes;
    create.type = type;
    const DeviceFunctions& vk = device.Vk();
    device.Check(vk.vkCreateAccelerationStructureKHR(device.Handle(), &create, device.AllocationCallbacks(),
                                                     &m_structure),
                 name + ": vkCreateAccelerationStructureKHR");
    device.SetName(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, reinterpret_cast<uint64_t>(m_structure), name);
    RequestAddress();
}

AccelerationStructure AccelerationStructure::Wrap(Device& device, VkAccelerationStructureKHR structure) {
    AccelerationStructure wrapped;
    wrapped.m_device = &device;
    wrapped.m_structure = structure;
    wrapped.m_isOwned = false;
    wrapped.RequestAddress();
    return wrapped;
}

void AccelerationStructure::RequestAddress() {
    VkAccelerationStructureDeviceAddressInfoKHR ask{};
    ask.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR;
    ask.accelerationStructure = m_structure;
    m_address = m_device->Vk().vkGetAccelerationStructureDeviceAddressKHR(m_device->Handle(), &ask);
}

AccelerationStructure& AccelerationStructure::operator=(AccelerationStructure&& other) noexcept {
    if (this == &other) return *this;
    Release();
    m_device = std::exchange(other.m_device, nullptr);
    m_storage = std::move(other.m_storage);
    m_isOwned = std::exchange(other.m_isOwned, true);
    m_structure = std::exchange(other.m_structure, VK_NULL_HANDLE);
    m_address = std::exchange(other.m_address, 0);
    m_bytes = std::exchange(other.m_bytes, 0);
    return *this;
}

AccelerationStructure::~AccelerationStructure() {
    Release();
}

// The structure is destroyed before its storage: retired objects are destroyed in order.
void AccelerationStructure::Release() noexcept {
    if (m_structure && m_isOwned) {
        m_device->Retire([device = m_device, structure = m_structure] {
            device->Vk().vkDestroyAccelerationStructureKHR(device->Handle(), structure,
                                                           device->AllocationCallbacks());
        });
    }
    m_structure = VK_NULL_HANDLE;
    m_storage = {};
}

}  // namespace raygraph::rhi
