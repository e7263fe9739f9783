// The Vulkan structures of a BlasDesc, and the checks of builds and updates. For rhi/ alone.
#pragma once

#include <string>
#include <vector>

#include "rhi/acceleration_structure.h"

namespace raygraph::rhi {

class Device;

// Throws Error{Usage} naming the BLAS for what BlasBuilder::Add refuses.
void CheckBuildable(const BlasDesc& desc);
// Throws Error{Usage} naming the BLAS unless `next` is a legal update of `built`.
void CheckUpdatable(const BlasDesc& built, const BlasDesc& next);

// Geometries and ranges of one build; the Vulkan structures point into this object.
class BlasGeometry {
  public:
    BlasGeometry(const BlasDesc& desc, VkBuildAccelerationStructureFlagsKHR flags);
    BlasGeometry(const BlasGeometry&) = delete;
    BlasGeometry& operator=(const BlasGeometry&) = delete;

    VkAccelerationStructureBuildSizesInfoKHR Sizes(Device& device) const;
    // The caller completes it: mode, source, destination and scratch.
    VkAccelerationStructureBuildGeometryInfoKHR& Info() { return m_info; }
    const VkAccelerationStructureBuildRangeInfoKHR* Ranges() const { return m_ranges.data(); }

  private:
    std::vector<VkAccelerationStructureGeometryKHR> m_geometries;
    std::vector<VkAccelerationStructureBuildRangeInfoKHR> m_ranges;
    VkAccelerationStructureBuildGeometryInfoKHR m_info{};
};

}  // namespace raygraph::rhi
