// Typed, versioned ids of the render graph's resources.
//
// An id names one version of one resource of one frame. A write returns a new id; the old one still names
// the contents before the write, and using it after a later write is a Usage error ("stale id"), as is an
// id of an earlier frame. Threads: plain values, for any thread; functions that take them have the rule of
// the Renderer.
#pragma once

#include <cstdint>

namespace raygraph {

enum class ResourceKind : uint8_t { Texture, Buffer, Tlas, BlasSet, TextureSet };

template <ResourceKind Kind>
struct ResourceId {
    static constexpr uint32_t kInvalid = 0x1fff;
    static constexpr uint32_t kMaxVersion = 0x7ff;
    static constexpr uint32_t kFrameMask = 0xff;

    uint32_t resource : 13 = kInvalid;  // index into the frame's resources
    uint32_t version : 11 = 0;          // number of writes so far
    uint32_t frame : 8 = 0;             // frame number modulo 256

    bool IsValid() const { return resource != kInvalid; }
    bool operator==(const ResourceId&) const = default;
};

using TextureId = ResourceId<ResourceKind::Texture>;
using BufferId = ResourceId<ResourceKind::Buffer>;
using TlasId = ResourceId<ResourceKind::Tlas>;
// All bottom-level structures of a scene: one resource for the graph, any number of Vulkan objects.
using BlasSetId = ResourceId<ResourceKind::BlasSet>;
// The bindless textures of a scene (set 1).
using TextureSetId = ResourceId<ResourceKind::TextureSet>;

static_assert(sizeof(TextureId) == 4);

// Describes a pass of the frame, in order of declaration.
struct PassId {
    uint32_t index = ~0u;
};

}  // namespace raygraph
