// Tests of the graph on a device: a Renderer of their own and shaders written in the test.
#pragma once

#include <gtest/gtest.h>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "renderer/graph/compile.h"
#include "renderer/graph/frame_graph.h"
#include "renderer/graph/pass_harness.h"
#include "renderer/graph/plan_text.h"
#include "renderer/graph/renderer.h"
#include "rhi/shader_compiler.h"
#include "tests/support/vulkan_test.h"

namespace raygraph {

inline std::vector<uint32_t> CompileText(std::string_view name, std::string_view text) {
    rhi::GlslSource source;
    source.name = name;
    source.text = "#version 460\n#extension GL_EXT_scalar_block_layout : require\n" + std::string(text);
    return rhi::CompileGlsl(source);
}

// Adds, multiplies and copies single-channel textures: enough to see in the texels which passes ran, and in
// what order.
inline constexpr std::string_view kFillShader = R"(
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, r32f) uniform writeonly image2D target;
layout(push_constant, std430) uniform Constants { float value; } constants;
void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(target)))) return;
    imageStore(target, texel, vec4(constants.value + float(texel.x) + 100.0 * float(texel.y)));
})";
inline constexpr std::string_view kScaleShader = R"(
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, r32f) uniform readonly image2D source;
layout(binding = 1, r32f) uniform writeonly image2D target;
layout(push_constant, std430) uniform Constants { float factor; } constants;
void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(target)))) return;
    imageStore(target, texel, constants.factor * imageLoad(source, texel));
})";
inline constexpr std::string_view kAddShader = R"(
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, r32f) uniform readonly image2D source;
layout(binding = 1, r32f) uniform image2D sum;
layout(push_constant, std430) uniform Constants { uint isFirst; } constants;
void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(sum)))) return;
    vec4 before = constants.isFirst != 0 ? vec4(0.0) : imageLoad(sum, texel);
    imageStore(sum, texel, before + imageLoad(source, texel));
})";

class GraphTest : public testing::VulkanTest {
  protected:
    GraphTest() : m_renderer(Device()) { AddTestShaders(m_renderer); }

    static void AddTestShaders(Renderer& renderer) {
        renderer.AddShader("test/fill.comp", CompileText("test/fill.comp", kFillShader));
        renderer.AddShader("test/scale.comp", CompileText("test/scale.comp", kScaleShader));
        renderer.AddShader("test/add.comp", CompileText("test/add.comp", kAddShader));
    }

    // target(x, y) = value + x + 100 y
    static TextureId Fill(Renderer& renderer, std::string_view name, Extent2D extent, float value) {
        TextureId target = renderer.CreateTexture(name, {.extent = extent, .format = Format::R32Float});
        return FillInto(renderer, "Fill " + std::string(name), target, value);
    }
    static TextureId FillInto(Renderer& renderer, std::string_view pass, TextureId target, float value) {
        const Extent2D extent = renderer.Desc(target).extent;
        renderer.AddPass(
            pass, PassKind::Compute,
            [&](PassBuilder& builder) {
                builder.Compute("test/fill.comp");
                target = builder.Writes("target", target);
                builder.Constants(value);
            },
            [extent](CommandList& commands) { commands.DispatchOver(extent); });
        return target;
    }
    static TextureId Scale(Renderer& renderer, std::string_view name, TextureId source, float factor) {
        const GraphTextureDesc desc = renderer.Desc(source);
        TextureId target = renderer.CreateTexture(name, desc);
        renderer.AddPass(
            "Scale " + std::string(name), PassKind::Compute,
            [&](PassBuilder& pass) {
                pass.Compute("test/scale.comp");
                pass.Reads("source", source);
                target = pass.Writes("target", target);
                pass.Constants(factor);
            },
            [extent = desc.extent](CommandList& commands) { commands.DispatchOver(extent); });
        return target;
    }
    // Adds to a persistent texture, which starts at zero.
    static TextureId AddTo(Renderer& renderer, std::string_view name, TextureId source) {
        const GraphTextureDesc desc = renderer.Desc(source);
        TextureId sum = renderer.Persist(name, desc);
        const uint32_t isFirst = renderer.IsFresh(sum) ? 1 : 0;
        renderer.AddPass(
            "Add to " + std::string(name), PassKind::Compute,
            [&](PassBuilder& pass) {
                pass.Compute("test/add.comp");
                pass.Reads("source", source);
                sum = pass.Updates("sum", sum);
                pass.Constants(isFirst);
            },
            [extent = desc.extent](CommandList& commands) { commands.DispatchOver(extent); });
        return sum;
    }

    static testing::Texels Read(const Readback& readback) {
        readback.Wait();
        return testing::DecodeTexels(readback.Bytes(), readback.Extent(), readback.Format());
    }
    // True if every texel is scale * (value + x + 100 y); says what is wrong otherwise.
    static ::testing::AssertionResult IsRamp(const testing::Texels& texels, float value, float scale = 1.0f) {
        for (uint32_t y = 0; y < texels.extent.height; ++y)
            for (uint32_t x = 0; x < texels.extent.width; ++x) {
                const float expected =
                    scale * (value + static_cast<float>(x) + 100.0f * static_cast<float>(y));
                if (texels.At(x, y)[0] != expected)
                    return ::testing::AssertionFailure() << "texel " << x << ", " << y << " is "
                                                         << texels.At(x, y)[0] << ", expected " << expected;
            }
        return ::testing::AssertionSuccess();
    }

    Renderer m_renderer;
};

}  // namespace raygraph

// Hand-made frame graphs for tests of the pure part: no device anywhere.
namespace raygraph {

struct GraphMaker : FrameGraph {
    GraphMaker() { Begin(1); }

    // A transient of `mebibytes`; 0 leaves it out of aliasing.
    TextureId Texture(std::string_view name, uint64_t mebibytes = 0, uint32_t memoryTypeBits = 1) {
        return Add<ResourceKind::Texture>({.name = name,
                                           .extent = {64, 64},
                                           .format = rhi::Format::Rgba32Float,
                                           .memory = Memory(mebibytes, memoryTypeBits)});
    }
    // One of several levels and layers.
    TextureId Chain(std::string_view name, uint32_t levels, uint32_t layers = 1, uint64_t mebibytes = 0,
                    Origin origin = Origin::Transient, const ResourceState& state = {}) {
        return Add<ResourceKind::Texture>({.name = name,
                                           .origin = origin,
                                           .isShared = origin != Origin::Imported,
                                           .extent = {64, 64},
                                           .format = rhi::Format::Rgba32Float,
                                           .levels = levels,
                                           .layers = layers,
                                           .memory = Memory(mebibytes, 1),
                                           .state = state});
    }
    BufferId Buffer(std::string_view name, uint64_t mebibytes = 0) {
        return Add<ResourceKind::Buffer>(
            {.name = name, .bytes = mebibytes << 20, .memory = Memory(mebibytes, 1)});
    }
    TextureId Persistent(std::string_view name, const ResourceState& state = {},
                         Persistence persistence = Persistence::OnDemand) {
        return Add<ResourceKind::Texture>({.name = name,
                                           .origin = Origin::Persistent,
                                           .persistence = persistence,
                                           .extent = {64, 64},
                                           .format = rhi::Format::Rgba32Float,
                                           .state = state});
    }
    template <ResourceKind Kind>
    ResourceId<Kind> Imported(std::string_view name, const ResourceState& state = {}) {
        return Add<Kind>({.name = name,
                          .origin = Origin::Imported,
                          .isShared = false,
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
            names.append(names.empty() ? "" : " ").append(passes[planned.pass].name);
        return names;
    }

  private:
    static rhi::MemoryRequirements Memory(uint64_t mebibytes, uint32_t memoryTypeBits) {
        return {.size = mebibytes << 20, .alignment = 4096, .memoryTypeBits = memoryTypeBits};
    }
};

}  // namespace raygraph
