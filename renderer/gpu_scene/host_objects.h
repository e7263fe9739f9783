// Meshes and textures that a host has on the device already, as parts of a GpuScene: nothing is copied.
// Threads: plain values.
//
// The host owns the buffers and the image. It writes them before the frame that shows them, on the device's
// queue or with a semaphore for which this frame waits, and does not change them while a frame that shows
// them may be in flight. After it has changed vertices, it calls GpuScene::MarkChanged.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "renderer/scene/model/scene_data.h"
#include "rhi/acceleration_structure.h"
#include "rhi/resources.h"

namespace raygraph {

// Describes a range of a buffer: contiguous elements at an offset that is a multiple of 4 bytes. The buffer
// is one of rhi::Device::WrapBuffer whose VkBuffer has VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT, or one that
// was created by rhi::Device.
struct HostStream {
    const rhi::Buffer* buffer = nullptr;  // null: there is no such stream. The buffer outlives the mesh
    uint64_t offset = 0;                  // bytes

    explicit operator bool() const { return buffer != nullptr; }
};

// Describes one list of triangles with one material.
struct HostMesh {
    std::string name;
    uint32_t vertexCount = 0;
    uint32_t triangleCount = 0;
    // positions and indices also need BufferUsage::BuildInput, unless the BLAS is the host's own.
    HostStream positions{};  // vec3 float
    HostStream indices{};    // uint32, three a triangle, counter-clockwise seen from the front
    HostStream normals{};    // vec3 float, unit length
    // vec4 float as in scene::Primitive::tangents; all maps of materials with tangents are read along these
    HostStream tangents{};
    HostStream uv0{};     // vec2 float
    HostStream uv1{};     // vec2 float
    HostStream colors{};  // vec4 float, linear
    // Index in the scene. Paths find an emissive mesh of a host by hitting it, not by light sampling.
    uint32_t material = 0;
    scene::Bounds bounds{};  // of the positions, in object space
    // The smallest alpha of `colors`, if it is known. With 1, rays need no alpha test for them.
    float lowestAlpha = 0.0f;
    // The host's own BLAS of these triangles, as one geometry in this order, which outlives the mesh; 0: one
    // is built. The geometry must be opaque exactly if the material needs no any-hit test, which is so for an
    // opaque alpha mode and no smooth thin wall.
    VkDeviceAddress blas = 0;
    // The BLAS that is built can be updated quickly after MarkChanged, and is not compacted. Not for a BLAS
    // of the host.
    bool isDeforming = false;
};

// Describes an image in SHADER_READ_ONLY_OPTIMAL, of one layer, with any levels.
struct HostTexture {
    std::shared_ptr<const rhi::Texture> texture;  // from rhi::Device::WrapTexture, or created by rhi::Device
    scene::Sampler sampler;
    // The smallest alpha of all texels, if it is known. With 1, base colors from this texture need no alpha
    // test.
    float lowestAlpha = 0.0f;
};

}  // namespace raygraph
