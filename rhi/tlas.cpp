#include "rhi/tlas.h"

#include <algorithm>
#include <cstring>

#include "base/check.h"
#include "base/text.h"
#include "rhi/blas_build.h"
#include "rhi/command_list.h"
#include "rhi/device.h"

namespace raygraph::rhi {
namespace {

static_assert(sizeof(VkAccelerationStructureInstanceKHR) == kTlasInstanceBytes);
constexpr uint32_t kMax24Bits = (1u << 24) - 1;
constexpr uint64_t kInstanceAlignment = 16;

VkAccelerationStructureGeometryKHR InstanceGeometry(VkDeviceAddress instances) {
    VkAccelerationStructureGeometryKHR geometry{};
    geometry.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR;
    geometry.geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR;
    geometry.geometry.instances.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR;
    geometry.geometry.instances.data.deviceAddress = instances;
    return geometry;
}

// `geometry` must outlive the result.
VkAccelerationStructureBuildGeometryInfoKHR BuildInfo(const TlasDesc& desc,
                                                      const VkAccelerationStructureGeometryKHR& geometry) {
    VkAccelerationStructureBuildGeometryInfoKHR info{};
    info.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR;
    info.type = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR;
    info.flags = VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR;
    if (desc.allowsUpdate) info.flags |= VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR;
    info.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
    info.geometryCount = 1;
    info.pGeometries = &geometry;
    return info;
}

}  // namespace

void WriteInstances(std::span<const TlasInstance> instances, std::span<std::byte> target) {
    if (target.size() < instances.size() * kTlasInstanceBytes)
        throw MakeError(ErrorKind::Usage, "{} TLAS instances do not fit {} bytes", instances.size(),
                        target.size());
    for (size_t i = 0; i < instances.size(); ++i) {
        const TlasInstance& source = instances[i];
        if (source.customIndex > kMax24Bits || source.hitRecord > kMax24Bits)
            throw MakeError(ErrorKind::Usage,
                            "TLAS instance {}: customIndex {} or hitRecord {} exceeds 24 bits", i,
                            source.customIndex, source.hitRecord);
        VkAccelerationStructureInstanceKHR native{};
        static_assert(sizeof(native.transform) == sizeof(source.objectToWorld));
        std::memcpy(&native.transform, source.objectToWorld.data(), sizeof(native.transform));
        native.instanceCustomIndex = source.customIndex & kMax24Bits;
        native.mask = source.mask;
        native.instanceShaderBindingTableRecordOffset = source.hitRecord & kMax24Bits;
        VkGeometryInstanceFlagsKHR flags = 0;
        if (source.isFacingFlipped) flags |= VK_GEOMETRY_INSTANCE_TRIANGLE_FLIP_FACING_BIT_KHR;
        if (source.isCullingDisabled) flags |= VK_GEOMETRY_INSTANCE_TRIANGLE_FACING_CULL_DISABLE_BIT_KHR;
        native.flags = flags & 0xffu;
        native.accelerationStructureReference = source.blas;
        std::memcpy(target.data() + i * kTlasInstanceBytes, &native, sizeof(native));
    }
}

Tlas::Tlas(Device& device, const TlasDesc& desc) : m_device(&device), m_desc(desc) {
    if (desc.capacity > device.Info().maxInstanceCount)
        throw MakeError(ErrorKind::Usage, "TLAS '{}': capacity {} exceeds maxInstanceCount {}", desc.name,
                        desc.capacity, device.Info().maxInstanceCount);
    const VkAccelerationStructureGeometryKHR geometry = InstanceGeometry(0);
    const VkAccelerationStructureBuildGeometryInfoKHR info = BuildInfo(desc, geometry);
    VkAccelerationStructureBuildSizesInfoKHR sizes{};
    sizes.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR;
    device.Vk().vkGetAccelerationStructureBuildSizesKHR(
        device.Handle(), VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, &info, &desc.capacity, &sizes);
    m_structure = AccelerationStructure(device, desc.name, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR,
                                        sizes.accelerationStructureSize);
    m_scratch = BuildScratch(device, desc.name, std::max(sizes.buildScratchSize, sizes.updateScratchSize));
    m_built = std::make_shared<Built>();
}

Tlas Device::WrapTlas(const std::string& name, VkAccelerationStructureKHR structure) {
    if (!structure) throw MakeError(ErrorKind::Usage, "TLAS '{}': the host's structure is null", name);
    Tlas wrapped;
    wrapped.m_device = this;
    wrapped.m_desc.name = name;
    wrapped.m_structure = AccelerationStructure::Wrap(*this, structure);
    return wrapped;
}

void Tlas::Build(CommandList& commands, const Buffer& instances, uint32_t count) {
    Record(commands, instances, count, false);
}

void Tlas::Update(CommandList& commands, const Buffer& instances, uint32_t count) {
    const std::string name = "TLAS '" + m_desc.name + "': ";
    if (!m_desc.allowsUpdate)
        throw MakeError(ErrorKind::Usage, "{}update, but it was made without allowsUpdate", name);
    if (!m_built || !m_built->isBuilt)
        throw MakeError(ErrorKind::Usage, "{}update before its first build", name);
    if (count != m_built->count)
        throw MakeError(ErrorKind::Usage, "{}update with {} instances, built with {}", name, count,
                        m_built->count);
    Record(commands, instances, count, true);
}

void Tlas::Record(CommandList& commands, const Buffer& instances, uint32_t count, bool isUpdate) {
    const std::string name = "TLAS '" + m_desc.name + "': ";
    if (!m_structure.IsOwned()) throw MakeError(ErrorKind::Usage, "{}it is the host's to build", name);
    if (count > m_desc.capacity)
        throw MakeError(ErrorKind::Usage, "{}{} instances exceed its capacity of {}", name, count,
                        m_desc.capacity);
    if (count * kTlasInstanceBytes > instances.Size())
        throw MakeError(ErrorKind::Usage, "{}{} instances exceed buffer '{}' of {} bytes", name, count,
                        instances.Desc().name, instances.Size());
    RG_CHECK_EQ(instances.Address() % kInstanceAlignment, 0u);

    const VkAccelerationStructureGeometryKHR geometry = InstanceGeometry(instances.Address());
    VkAccelerationStructureBuildGeometryInfoKHR info = BuildInfo(m_desc, geometry);
    if (isUpdate) {
        info.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
        info.srcAccelerationStructure = m_structure.Handle();
    }
    info.dstAccelerationStructure = m_structure.Handle();
    info.scratchData.deviceAddress = m_scratch.Address();
    const VkAccelerationStructureBuildRangeInfoKHR range{count, 0, 0, 0};
    const VkAccelerationStructureBuildRangeInfoKHR* ranges = &range;
    BarrierBetweenBuilds(commands);  // waits for BLASes, and for builds that used the same scratch
    m_device->Vk().vkCmdBuildAccelerationStructuresKHR(commands.Handle(), 1, &info, &ranges);
    commands.OnDropped([built = m_built, before = *m_built] { *built = before; });
    *m_built = {true, count};
}

}  // namespace raygraph::rhi
