// Meshes and textures that a host has on the device, as parts of a GpuScene: nothing is copied. Threads:
// plain values.
//
// The buffers and the image stay the host's. It has written them before the frame that shows them, on the
// device's queue or with a semaphore that this frame waits for, and leaves them as they are while a frame
// that shows them may be in flight: after it has changed vertices it calls GpuScene::MarkChanged.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "renderer/scene/model/scene_data.h"
#include "rhi/acceleration_structure.h"
#include "rhi/resources.h"

namespace raygraph {

// A part of a buffer: elements side by side, without gaps, from a multiple of 4 bytes on. A buffer of
// rhi::Device::WrapBuffer whose VkBuffer has VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT, or one of our own.
struct HostStream {
    const rhi::Buffer* buffer = nullptr;  // null: there is no such stream. It outlives the mesh.
    uint64_t offset = 0;                  // bytes

    explicit operator bool() const { return buffer != nullptr; }
};

// One list of triangles with one material.
struct HostMesh {
    std::string name;
    uint32_t vertexCount = 0;
    uint32_t triangleCount = 0;
    // positions and indices also need BufferUsage::BuildInput, unless the BLAS is the host's own.
    HostStream positions{};  // vec3 float
    HostStream indices{};    // uint32, three a triangle, counter-clockwise seen from the front
    HostStream normals{};    // vec3 float, unit length
    // vec4 float, as scene::Primitive::tangents; materials that need them read all their maps along these
    HostStream tangents{};
    HostStream uv0{};        // vec2 float
    HostStream uv1{};        // vec2 float
    HostStream colors{};     // vec4 float, linear
    uint32_t material = 0;   // of the scene. If it emits, paths find it by hitting it, not by light sampling
    scene::Bounds bounds{};  // of the positions, object space
    // The smallest alpha of `colors`, if it is known: of 1, rays need no alpha test for them.
    float lowestAlpha = 0.0f;
    // The host's own BLAS of these triangles, as one geometry in this order; 0: one is built. Its geometry is
    // opaque exactly if the material needs no any-hit test: an opaque alpha mode and no smooth thin wall. It
    // outlives the mesh.
    VkDeviceAddress blas = 0;
    // Its BLAS can be updated quickly after MarkChanged, and is not compacted. Not of a host's own.
    bool isDeforming = false;
};

// An image in SHADER_READ_ONLY_OPTIMAL, of one layer, with any levels.
struct HostTexture {
    std::shared_ptr<const rhi::Texture> texture;  // of rhi::Device::WrapTexture, or one of our own
    scene::Sampler sampler;
    // The smallest alpha of all texels, if it is known: of 1, base colors of it need no alpha test.
    float lowestAlpha = 0.0f;
};

}  // namespace raygraph
