#include "rhi/blas_geometry.h"

#include "base/text.h"
#include "rhi/device.h"

namespace raygraph::rhi {
namespace {

// The count that every device supports: maxPrimitiveCount is at least this.
constexpr uint64_t kMaxPrimitives = (uint64_t{1} << 29) - 1;

template <typename... Values>
[[noreturn]] void Fail(const BlasDesc& desc, fmt::format_string<Values...> format, Values&&... values) {
    throw MakeError(ErrorKind::Usage, "BLAS '{}': {}", desc.name,
                    Text(format, std::forward<Values>(values)...));
}

std::string At(const char* list, size_t index) {
    return Text("{}[{}]", list, index);
}

void CheckSame(const BlasDesc& desc, const std::string& what, uint64_t built, uint64_t next) {
    if (built == next) return;
    Fail(desc, "update changes {} from {} to {}", what, built, next);
}

void CheckAddress(const BlasDesc& desc, const std::string& what, VkDeviceAddress address,
                  uint64_t alignment) {
    if (address == 0) Fail(desc, "{} is null", what);
    if (address % alignment != 0) Fail(desc, "{} is not a multiple of {}", what, alignment);
}

VkGeometryFlagsKHR FlagsOf(bool isOpaque, bool noDuplicateAnyHit) {
    VkGeometryFlagsKHR flags = 0;
    if (isOpaque) flags |= VK_GEOMETRY_OPAQUE_BIT_KHR;
    if (noDuplicateAnyHit) flags |= VK_GEOMETRY_NO_DUPLICATE_ANY_HIT_INVOCATION_BIT_KHR;
    return flags;
}

}  // namespace

void CheckBuildable(const BlasDesc& desc) {
    if (desc.triangles.empty() == desc.aabbs.empty())
        Fail(desc, "{}", desc.triangles.empty() ? "has no geometry" : "has both triangles and AABBs");
    uint64_t primitiveCount = 0;
    for (size_t i = 0; i < desc.triangles.size(); ++i) {
        const TriangleGeometry& g = desc.triangles[i];
        const std::string name = At("triangles", i);
        if (g.triangleCount == 0 || g.vertexCount == 0) Fail(desc, "{} is empty", name);
        CheckAddress(desc, name + ".vertices", g.vertices, sizeof(float));
        CheckAddress(desc, name + ".indices", g.indices, sizeof(uint32_t));
        if (g.vertexStride % sizeof(float) != 0 || g.vertexStride < 3 * sizeof(float))
            Fail(desc, "{}.vertexStride is {}, not a multiple of 4 from 12 up", name, g.vertexStride);
        primitiveCount += g.triangleCount;
    }
    for (size_t i = 0; i < desc.aabbs.size(); ++i) {
        const std::string name = At("aabbs", i);
        if (desc.aabbs[i].boxCount == 0) Fail(desc, "{} is empty", name);
        CheckAddress(desc, name + ".boxes", desc.aabbs[i].boxes, 8);
        primitiveCount += desc.aabbs[i].boxCount;
    }
    if (primitiveCount > kMaxPrimitives)
        Fail(desc, "has {} primitives, at most {} can be built", primitiveCount, kMaxPrimitives);
}

void CheckUpdatable(const BlasDesc& built, const BlasDesc& next) {
    CheckBuildable(next);
    if (built.kind != BlasKind::Deforming || next.kind != BlasKind::Deforming)
        Fail(built, "update of a Static one; only a Deforming one can be updated");
    CheckSame(built, "triangles.size()", built.triangles.size(), next.triangles.size());
    CheckSame(built, "aabbs.size()", built.aabbs.size(), next.aabbs.size());
    for (size_t i = 0; i < built.triangles.size(); ++i) {
        const TriangleGeometry& a = built.triangles[i];
        const TriangleGeometry& b = next.triangles[i];
        const std::string name = At("triangles", i);
        CheckSame(built, name + ".triangleCount", a.triangleCount, b.triangleCount);
        CheckSame(built, name + ".vertexCount", a.vertexCount, b.vertexCount);
        CheckSame(built, name + ".isOpaque", a.isOpaque, b.isOpaque);
        CheckSame(built, name + ".noDuplicateAnyHit", a.noDuplicateAnyHit, b.noDuplicateAnyHit);
    }
    for (size_t i = 0; i < built.aabbs.size(); ++i) {
        const std::string name = At("aabbs", i);
        CheckSame(built, name + ".boxCount", built.aabbs[i].boxCount, next.aabbs[i].boxCount);
        CheckSame(built, name + ".isOpaque", built.aabbs[i].isOpaque, next.aabbs[i].isOpaque);
        CheckSame(built, name + ".noDuplicateAnyHit", built.aabbs[i].noDuplicateAnyHit,
                  next.aabbs[i].noDuplicateAnyHit);
    }
}

BlasGeometry::BlasGeometry(const BlasDesc& desc, VkBuildAccelerationStructureFlagsKHR flags) {
    for (const TriangleGeometry& source : desc.triangles) {
        VkAccelerationStructureGeometryKHR geometry{};
        geometry.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR;
        geometry.geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR;
        geometry.flags = FlagsOf(source.isOpaque, source.noDuplicateAnyHit);
        auto& triangles = geometry.geometry.triangles;
        triangles.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR;
        triangles.vertexFormat = VK_FORMAT_R32G32B32_SFLOAT;
        triangles.vertexData.deviceAddress = source.vertices;
        triangles.vertexStride = source.vertexStride;
        triangles.maxVertex = source.vertexCount - 1;
        triangles.indexType = VK_INDEX_TYPE_UINT32;
        triangles.indexData.deviceAddress = source.indices;
        m_geometries.push_back(geometry);
        m_ranges.push_back({source.triangleCount, 0, 0, 0});
    }
    for (const AabbGeometry& source : desc.aabbs) {
        VkAccelerationStructureGeometryKHR geometry{};
        geometry.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR;
        geometry.geometryType = VK_GEOMETRY_TYPE_AABBS_KHR;
        geometry.flags = FlagsOf(source.isOpaque, source.noDuplicateAnyHit);
        auto& aabbs = geometry.geometry.aabbs;
        aabbs.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_AABBS_DATA_KHR;
        aabbs.data.deviceAddress = source.boxes;
        aabbs.stride = sizeof(VkAabbPositionsKHR);
        m_geometries.push_back(geometry);
        m_ranges.push_back({source.boxCount, 0, 0, 0});
    }
    m_info.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR;
    m_info.type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR;
    m_info.flags = flags;
    m_info.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
    m_info.geometryCount = static_cast<uint32_t>(m_geometries.size());
    m_info.pGeometries = m_geometries.data();
}

VkAccelerationStructureBuildSizesInfoKHR BlasGeometry::Sizes(Device& device) const {
    std::vector<uint32_t> primitiveCounts;
    for (const auto& range : m_ranges) primitiveCounts.push_back(range.primitiveCount);
    VkAccelerationStructureBuildSizesInfoKHR sizes{};
    sizes.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR;
    device.Vk().vkGetAccelerationStructureBuildSizesKHR(device.Handle(),
                                                        VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR,
                                                        &m_info, primitiveCounts.data(), &sizes);
    return sizes;
}

}  // namespace raygraph::rhi
