#include "renderer/gpu_scene/device_limits.h"

#include <algorithm>

#include "base/text.h"
#include "renderer/gpu_scene/streaming/scene_content.h"
#include "rhi/texture_table.h"
#include "shaders/shared/scene_records.h"

namespace raygraph {

namespace {

constexpr uint64_t kMaxCustomIndices = uint64_t{1} << 24;

}  // namespace

void RequireBindable(const rhi::Device& device, const std::string& what, uint64_t count,
                     uint64_t recordBytes) {
    const uint64_t limit = device.Info().maxStorageBufferBytes;
    if (count <= limit / recordBytes) return;
    throw MakeError(ErrorKind::OutOfMemory,
                    "GpuScene: {} {} of {} bytes, a shader can read {} on this device ({} bytes)", count,
                    what, recordBytes, limit / recordBytes, limit);
}

void RequireIndex(const char* what, uint32_t index, size_t count) {
    if (index >= count)
        throw MakeError(ErrorKind::Usage, "GpuScene: {} {} does not exist; the scene has {}", what, index,
                        count);
}

uint64_t MaxPlacements(const rhi::Device& device) {
    return std::min(device.Info().maxInstanceCount, kMaxCustomIndices);
}

void RequirePlacements(const rhi::Device& device, uint64_t count) {
    const uint64_t limit = MaxPlacements(device);
    if (count <= limit) return;
    throw MakeError(ErrorKind::Usage,
                    "GpuScene: {} instances of groups of triangles, this device traces at most {}", count,
                    limit);
}

void CheckLimits(const rhi::Device& device, const PreparedContent& content) {
    const scene::SceneData& scene = content.data;
    if (scene.textures.size() > rhi::kMaxTextureTableSlots)
        throw MakeError(ErrorKind::Usage, "GpuScene: {} textures, a shader can read {}",
                        scene.textures.size(), rhi::kMaxTextureTableSlots);
    const uint32_t largest = device.Info().maxTextureExtent;
    for (const scene::ImageData& image : scene.images)
        if (std::max(image.width, image.height) > largest)
            throw MakeError(
                ErrorKind::Usage,
                "GpuScene: image '{}' of {}x{} texels, the device's textures have at most {} a side",
                image.name, image.width, image.height, largest);
    RequireBindable(device, "materials", scene.materials.size(), sizeof(gpu::MaterialRecord));
    uint64_t geometryCount = 0;
    for (const PackedMesh& mesh : content.meshes) geometryCount += mesh.GeometryCount();
    RequireBindable(device, "geometries", geometryCount, sizeof(gpu::GeometryRecord));
    uint64_t placementCount = 0;
    for (const scene::Instance& instance : scene.instances)
        placementCount += content.meshes[instance.mesh].groups.size();
    RequirePlacements(device, placementCount);
    RequireBindable(device, "instances", placementCount, sizeof(gpu::InstanceRecord));
}

}  // namespace raygraph
