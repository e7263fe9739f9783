// Hand-made frame graphs for tests of the pure part: no device anywhere.
#pragma once

#include <gtest/gtest.h>

#include <initializer_list>
#include <string>
#include <string_view>

#include "base/error.h"
#include "renderer/graph/compile.h"
#include "renderer/graph/frame_graph.h"
#include "renderer/graph/plan_text.h"

namespace raygraph {

struct GraphMaker : FrameGraph {
    GraphMaker() { Begin(1); }

    // A transient of `mebibytes`; 0 leaves it out of aliasing.
    TextureId Texture(std::string_view name, uint64_t mebibytes = 0, uint32_t memoryTypeBits = 1) {
        return Add<ResourceKind::Texture>({.name = std::string(name),
                                           .extent = {64, 64},
                                           .format = rhi::Format::Rgba32Float,
                                           .memory = Memory(mebibytes, memoryTypeBits)});
    }
    // One of several levels and layers.
    TextureId Chain(std::string_view name, uint32_t levels, uint32_t layers = 1, uint64_t mebibytes = 0,
                    Origin origin = Origin::Transient, const ResourceState& state = {}) {
        return Add<ResourceKind::Texture>({.name = std::string(name),
                                           .origin = origin,
                                           .extent = {64, 64},
                                           .format = rhi::Format::Rgba32Float,
                                           .levels = levels,
                                           .layers = layers,
                                           .memory = Memory(mebibytes, 1),
                                           .state = state});
    }
    BufferId Buffer(std::string_view name, uint64_t mebibytes = 0) {
        return Add<ResourceKind::Buffer>(
            {.name = std::string(name), .bytes = mebibytes << 20, .memory = Memory(mebibytes, 1)});
    }
    TextureId Persistent(std::string_view name, const ResourceState& state = {},
                         Persistence persistence = Persistence::OnDemand) {
        return Add<ResourceKind::Texture>({.name = std::string(name),
                                           .origin = Origin::Persistent,
                                           .persistence = persistence,
                                           .extent = {64, 64},
                                           .format = rhi::Format::Rgba32Float,
                                           .state = state});
    }
    template <ResourceKind Kind>
    ResourceId<Kind> Imported(std::string_view name, const ResourceState& state = {}) {
        return Add<Kind>({.name = std::string(name),
                          .origin = Origin::Imported,
                          .extent = {64, 64},
                          .format = rhi::Format::Rgba8Unorm,
                          .state = state});
    }

    // A pass that reads textures and writes one, all as storage images.
    TextureId Pass(std::string_view name, std::initializer_list<TextureId> reads, TextureId target,
                   PassKind kind = PassKind::Compute) {
        AddPass(name, kind);
        for (const TextureId id : reads) Use(id, Access::StorageRead);
        return Use(target, Access::StorageWrite);
    }
    // One that reads a part of a texture and writes another part of it.
    TextureId Step(std::string_view name, TextureId texture, const Subresources& from, const Subresources& to,
                   Access read = Access::StorageRead) {
        AddPass(name, PassKind::Compute);
        Use(texture, read, from);
        return Use(texture, Access::StorageWrite, to);
    }
    // One that writes a part.
    TextureId Fill(std::string_view name, TextureId texture, const Subresources& part = {}) {
        AddPass(name, PassKind::Compute);
        return Use(texture, Access::StorageWrite, part);
    }
    // One that reads a part and is kept.
    void Look(std::string_view name, TextureId texture, const Subresources& part = {},
              Access access = Access::Sampled) {
        AddPass(name, PassKind::Compute);
        passes.back().keepAlive = true;
        Use(texture, access, part);
    }

    std::string Text() const { return DescribePlan(*this, Compile(*this)); }
    // The names of the executed passes, in order.
    std::string Order() const {
        std::string names;
        for (const PlannedPass& planned : Compile(*this).passes)
            names += (names.empty() ? "" : " ") + passes[planned.pass].name;
        return names;
    }

  private:
    static rhi::MemoryRequirements Memory(uint64_t mebibytes, uint32_t memoryTypeBits) {
        return {.size = mebibytes << 20, .alignment = 4096, .memoryTypeBits = memoryTypeBits};
    }
};

}  // namespace raygraph
