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
