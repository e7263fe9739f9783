// Tests compute and raster pipelines.
#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <deque>

#include "rhi/command_list.h"
#include "rhi/compute_pipeline.h"
#include "rhi/device.h"
#include "rhi/pipeline_statistics.h"
#include "rhi/raster_pipeline.h"
#include "rhi/readback.h"
#include "rhi/shader_compiler.h"
#include "tests/rhi/fake_loader.h"
#include "tests/support/error_of.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::rhi::pipeline_test {
namespace {

class PipelineTest : public testing::VulkanTest {
  protected:
    ShaderStage Compile(const std::string& name, const std::string& body) {
        m_words.push_back(CompileGlsl({.name = name, .text = "#version 460\n" + body, .stage = {}}));
        return {name, m_words.back()};
    }

    std::deque<std::vector<uint32_t>> m_words;
};

using ComputePipelineTest = PipelineTest;

TEST_F(ComputePipelineTest, StatisticsAreThoseOfThePrograms_WhereTheyAreCaptured) {
    const ShaderStage shader = Compile("empty.comp", "void main() {}");
    testing::FakeLoader fake;
    fake.Tell().hasStatistics = true;
    for (const bool captures : {true, false}) {
        const std::unique_ptr<rhi::Device> device =
            rhi::Device::Create({.savePipelineCache = false,
                                 .capturesStatistics = captures,
                                 .getInstanceProcAddr = fake.Entry()});
        ASSERT_TRUE(device->Info().optional.pipelineStatistics);
        const ComputePipeline pipeline = CreateComputePipeline(*device, {.name = "empty", .shader = shader});
        const std::vector<ProgramStatistics> told = StatisticsOf(*device, pipeline);
        EXPECT_TRUE(StatisticsOf(*device, ComputePipeline()).empty());
        ASSERT_EQ(told.size(), captures ? 2u : 0u);
        if (!captures) continue;
        EXPECT_EQ(told[0].name, "main");
        EXPECT_EQ(told[0].subgroupSize, 8u);
        ASSERT_EQ(told[0].statistics.size(), 2u);
        EXPECT_EQ(told[0].statistics[0].name, "Register Count");
        EXPECT_EQ(told[0].statistics[0].description, "How many registers an invocation has.");
        EXPECT_EQ(told[0].statistics[0].value, 40.0);
        EXPECT_EQ(told[0].statistics[1].value, 1.0);
        EXPECT_EQ(told[1].name, "other");
        EXPECT_TRUE(told[1].statistics.empty());
    }
}

TEST_F(ComputePipelineTest, SpecializationSetsConstantsAndWorkgroupSize) {
    const ShaderStage shader = Compile("sum.comp", R"(
        layout(local_size_x_id = 0, local_size_y = 2) in;
        layout(constant_id = 1) const uint kBase = 5;
        layout(constant_id = 2) const bool kDoubles = false;
        layout(constant_id = 3) const float kScale = 1.0;
        layout(binding = 0) buffer Out { uint count; uint base; uint scaled; };
        void main() {
            atomicAdd(count, 1);
            base = kDoubles ? kBase * 2 : kBase;
            scaled = uint(10.0 * kScale);
        })");
    auto run = [&](std::vector<SpecializationValue> specialization, std::array<uint32_t, 3> size) {
        const ComputePipeline pipeline = CreateComputePipeline(
            Device(), {.name = "sum", .shader = shader, .specialization = specialization});
        EXPECT_EQ(pipeline.WorkgroupSize(), size);
        const Buffer out = Device().CreateBuffer(
            {.name = "out",
             .size = 12,
             .usage = BufferUsage::Storage | BufferUsage::CopySource | BufferUsage::CopyDestination});
        CommandList commands = Device().BeginCommands("sum");
        commands.Fill(out, 0);
        commands.FullBarrier();
        commands.Bind(pipeline);
        const BoundResource resource{.binding = 0, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, .buffer = &out};
        commands.BindResources({&resource, 1});
        commands.Dispatch(3);
        Device().WaitFor(Device().Submit(std::move(commands)));
        return testing::As<uint32_t>(ReadBuffer(Device(), out));
    };
    EXPECT_EQ(run({}, {1, 2, 1}), (std::vector<uint32_t>{6, 5, 10}));
    EXPECT_EQ(run({{0, 16}, {1, 7}, {2, 1}, {3, std::bit_cast<uint32_t>(2.5f)}}, {16, 2, 1}),
              (std::vector<uint32_t>{96, 14, 25}));
}

TEST_F(ComputePipelineTest, WhatCannotBeIsRefusedByName) {
    auto error = [&](const ShaderStage& shader, std::vector<SpecializationValue> specialization = {}) {
        return testing::ErrorTextOf([&] {
            (void)CreateComputePipeline(Device(),
                                        {.name = "p", .shader = shader, .specialization = specialization});
        });
    };
    EXPECT_EQ(error({}), "p: has no compute shader");
    EXPECT_EQ(error(Compile("a.vert", "void main() {}")),
              "p: a.vert is a vertex shader, given as compute shader");
    EXPECT_EQ(
        error(Compile("a.comp",
                      "layout(constant_id = 4) const uint a = 1; layout(constant_id = 7) const uint b = 1;"
                      "layout(binding = 0) buffer O { uint o; }; void main() { o = a + b; }"),
              {{5, 1}}),
        "p: specialization constant 5 is in none of its shaders, which have 4 7");
    EXPECT_EQ(
        error(Compile("a.comp", "layout(set = 3, binding = 0) buffer O { uint o; }; void main() { o = 1; }")),
        "p: a.comp: 'O' is in set 3; there are set 0 (the pass) and set 1 (bindless textures)");
    const std::string many = std::to_string(Device().Info().maxPushDescriptors + 1);
    EXPECT_EQ(
        error(Compile("a.comp", "layout(binding = 0) uniform sampler2D s[" + many + "]; void main() {}")),
        "p: binds " + many + " descriptors in set 0, maxPushDescriptors is " +
            std::to_string(Device().Info().maxPushDescriptors));
    const uint32_t words = Device().Info().maxPushConstantBytes / 4 + 1;
    EXPECT_EQ(error(Compile("a.comp", "layout(push_constant) uniform C { uint c[" + std::to_string(words) +
                                          "]; }; void main() {}")),
              "p: a.comp has " + std::to_string(words * 4) +
                  " bytes of push constants, maxPushConstantsSize is " + std::to_string(words * 4 - 4));
    EXPECT_EQ(error(Compile("a.comp", "void main() {}")), "accepted");
}

// Draws rectangles by vertex pulling into a 4 x 4 picture.
class RasterPipelineTest : public PipelineTest {
  protected:
    struct Rectangle {
        float x0, y0, x1, y1;  // in clip space; x0 > x1 turns the winding around
        float depth;
        float color[4];
    };

    RasterPipelineDesc Desc() {
        RasterPipelineDesc desc;
        desc.name = "rectangles";
        desc.vertex = Compile("rectangle.vert", R"(
            #extension GL_EXT_scalar_block_layout : require
            struct Rectangle { vec4 corners; float depth; vec4 color; };
            layout(binding = 0, scalar) readonly buffer Rectangles { Rectangle rectangles[]; };
            layout(location = 0) out vec4 color;
            void main() {
                Rectangle r = rectangles[gl_InstanceIndex];
                const vec2 at[6] =
                    vec2[](vec2(0, 0), vec2(1, 0), vec2(1, 1), vec2(0, 0), vec2(1, 1), vec2(0, 1));
                gl_Position = vec4(mix(r.corners.xy, r.corners.zw, at[gl_VertexIndex]), r.depth, 1);
                color = r.color;
            })");
        desc.fragment = Compile("flat.frag", R"(
            layout(location = 0) in vec4 color;
            layout(location = 0) out vec4 target;
            void main() { target = color; })");
        desc.colorFormats = {Format::Rgba8Unorm};
        desc.depthFormat = Format::D32Float;
        return desc;
    }

    // The texel at (x, y) from the top left after drawing the rectangles in order over transparent black.
    std::array<int, 4> Draw(const RasterPipelineDesc& desc, const std::vector<Rectangle>& rectangles,
                            uint32_t x = 1, uint32_t y = 1) {
        const RasterPipeline pipeline = CreateRasterPipeline(Device(), desc);
        const Extent2D extent{4, 4};
        const Texture color =
            Device().CreateTexture({.name = "color",
                                    .extent = extent,
                                    .format = Format::Rgba8Unorm,
                                    .usage = TextureUsage::ColorTarget | TextureUsage::CopySource});
        const Texture depth = Device().CreateTexture({.name = "depth",
                                                      .extent = extent,
                                                      .format = Format::D32Float,
                                                      .usage = TextureUsage::DepthTarget});
        const Buffer buffer = Device().CreateBuffer({.name = "rectangles",
                                                     .size = rectangles.size() * sizeof(Rectangle),
                                                     .usage = BufferUsage::Storage,
                                                     .memory = MemoryKind::Upload});
        std::memcpy(buffer.Mapped().data(), rectangles.data(), buffer.Size());

        CommandList commands = Device().BeginCommands("draw");
        commands.Transition(color, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
        commands.Transition(depth, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL);
        const ColorTarget colorTarget{.texture = &color};
        const DepthTarget depthTarget{.texture = &depth};
        commands.BeginRendering(extent, {&colorTarget, 1}, &depthTarget);
        commands.Bind(pipeline);
        const BoundResource resource{
            .binding = 0, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, .buffer = &buffer};
        commands.BindResources({&resource, 1});
        commands.Draw(6, static_cast<uint32_t>(rectangles.size()));
        commands.EndRendering();
        commands.Transition(color, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_GENERAL);
        Device().WaitFor(Device().Submit(std::move(commands)));
        const std::vector<std::byte> bytes = ReadTexture(Device(), color, VK_IMAGE_LAYOUT_GENERAL);
        std::array<int, 4> texel{};
        for (size_t c = 0; c < 4; ++c) texel[c] = static_cast<int>(bytes[(y * extent.width + x) * 4 + c]);
        return texel;
    }

    static constexpr std::array<int, 4> kRed{255, 0, 0, 255};
    static constexpr std::array<int, 4> kGreen{0, 255, 0, 255};
    static constexpr std::array<int, 4> kNothing{0, 0, 0, 0};
};

TEST_F(RasterPipelineTest, DepthCompareDecidesWhichSurfaceIsSeen) {
    const std::vector<Rectangle> rectangles{{-1, -1, 1, 1, 0.25f, {1, 0, 0, 1}},
                                            {-1, -1, 1, 1, 0.75f, {0, 1, 0, 1}}};
    RasterPipelineDesc desc = Desc();
    EXPECT_EQ(Draw(desc, rectangles), kRed);
    desc.depthCompare = DepthCompare::Always;
    EXPECT_EQ(Draw(desc, rectangles), kGreen);
    desc.depthCompare = DepthCompare::Greater;  // nothing is greater than the cleared 1
    EXPECT_EQ(Draw(desc, rectangles), kNothing);
    desc.depthCompare = DepthCompare::LessOrEqual;
    desc.writesDepth = false;
    EXPECT_EQ(Draw(desc, rectangles), kGreen);
}

TEST_F(RasterPipelineTest, CullingFollowsTheWindingInTheFramebuffer) {
    // In the framebuffer y points down: (-1,-1) (1,-1) (1,1) turn clockwise.
    const std::vector<Rectangle> clockwise{{-1, -1, 1, 1, 0.5f, {1, 0, 0, 1}}};
    const std::vector<Rectangle> counterClockwise{{1, -1, -1, 1, 0.5f, {1, 0, 0, 1}}};
    RasterPipelineDesc desc = Desc();
    EXPECT_EQ(Draw(desc, clockwise), kRed);
    desc.cull = CullMode::Back;
    EXPECT_EQ(Draw(desc, clockwise), kNothing);
    EXPECT_EQ(Draw(desc, counterClockwise), kRed);
    desc.isFrontClockwise = true;
    EXPECT_EQ(Draw(desc, clockwise), kRed);
    desc.cull = CullMode::Front;
    EXPECT_EQ(Draw(desc, clockwise), kNothing);
}

TEST_F(RasterPipelineTest, BlendingFollowsTheMode) {
    const std::vector<Rectangle> rectangles{{-1, -1, 1, 1, 0.5f, {0, 0, 1, 1}},
                                            {-1, -1, 1, 1, 0.5f, {0.6f, 0, 0, 0.2f}}};
    RasterPipelineDesc desc = Desc();
    EXPECT_EQ(Draw(desc, rectangles), (std::array<int, 4>{153, 0, 0, 51}));
    desc.blend = BlendMode::Alpha;  // 0.6 * 0.2, 1 - 0.2
    EXPECT_EQ(Draw(desc, rectangles), (std::array<int, 4>{31, 0, 204, 255}));
    desc.blend = BlendMode::Premultiplied;
    EXPECT_EQ(Draw(desc, rectangles), (std::array<int, 4>{153, 0, 204, 255}));
    desc.blend = BlendMode::Additive;
    EXPECT_EQ(Draw(desc, rectangles), (std::array<int, 4>{153, 0, 255, 255}));
}

TEST_F(RasterPipelineTest, WireframeLeavesTheInsideOut) {
    if (!Device().Info().optional.wireframe) GTEST_SKIP() << "the device lacks fillModeNonSolid";
    const std::vector<Rectangle> rectangles{{-0.75f, -0.75f, 0.75f, 0.75f, 0.5f, {1, 0, 0, 1}}};
    RasterPipelineDesc desc = Desc();
    EXPECT_EQ(Draw(desc, rectangles, 2, 1), kRed);
    desc.isWireframe = true;
    EXPECT_EQ(Draw(desc, rectangles, 2, 1), kNothing) << "off the edges and the diagonal";
    EXPECT_EQ(Draw(desc, rectangles, 0, 2), kRed) << "on an edge";
}

TEST_F(RasterPipelineTest, WhatCannotBeIsRefusedByName) {
    auto error = [&](const std::function<void(RasterPipelineDesc&)>& change) {
        RasterPipelineDesc desc = Desc();
        change(desc);
        return testing::ErrorTextOf([&] { (void)CreateRasterPipeline(Device(), desc); });
    };
    EXPECT_EQ(error([](auto&) {}), "accepted");
    EXPECT_EQ(error([](auto& d) { d.fragment = {}; }), "accepted") << "depth alone";
    EXPECT_EQ(error([](auto& d) { d.vertex = {}; }), "rectangles: has no vertex shader");
    EXPECT_EQ(error([](auto& d) { d.vertex = d.fragment; }),
              "rectangles: flat.frag is a fragment shader, given as vertex shader");
    EXPECT_EQ(error([](auto& d) {
                  d.colorFormats.clear();
                  d.depthFormat = Format::Undefined;
              }),
              "rectangles: has neither color nor depth target");
    EXPECT_EQ(error([](auto& d) { d.colorFormats = {Format::D32Float}; }),
              "rectangles: has a color target of d32f");
    EXPECT_EQ(error([](auto& d) { d.depthFormat = Format::R32Float; }),
              "rectangles: has a depth target of r32f");
}

}  // namespace
}  // namespace raygraph::rhi::pipeline_test
