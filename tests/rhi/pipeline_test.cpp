#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <filesystem>
#include <fstream>
#include <optional>

#include "base/files.h"
#include "rhi/command_list.h"
#include "rhi/compile_ahead.h"
#include "rhi/device.h"
#include "rhi/device_cache.h"
#include "rhi/pipeline.h"
#include "rhi/shader_compiler.h"
#include "rhi/transfer.h"
#include "tests/rhi/fake_loader.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/vulkan_test.h"

// Tests compute and raster pipelines.
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

// Tests the pipeline cache on disk: it is kept between devices, and never trusted.
namespace raygraph::testing::pipeline_cache_test {
namespace {

using rhi::PipelineCacheFile;
using test::TemporaryFolder;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

using Bytes = std::vector<std::byte>;

VkPhysicalDeviceProperties SomeDevice() {
    VkPhysicalDeviceProperties properties{};
    properties.vendorID = 0x10DE;
    properties.deviceID = 0x2335;
    for (uint32_t i = 0; i < VK_UUID_SIZE; ++i)
        properties.pipelineCacheUUID[i] = static_cast<uint8_t>(i * 17);
    return properties;
}

// Returns data as a driver's: its header, then anything.
Bytes DriverBytes(const VkPhysicalDeviceProperties& device) {
    VkPipelineCacheHeaderVersionOne header{
        sizeof(header), VK_PIPELINE_CACHE_HEADER_VERSION_ONE, device.vendorID, device.deviceID, {}};
    std::memcpy(header.pipelineCacheUUID, device.pipelineCacheUUID, VK_UUID_SIZE);
    Bytes bytes(sizeof(header) + 1000, std::byte{0x5A});
    std::memcpy(bytes.data(), &header, sizeof(header));
    return bytes;
}

void Overwrite(const std::filesystem::path& path, const Bytes& bytes) {
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

struct PipelineCacheFileTest : ::testing::Test {
    TemporaryFolder folder;
    VkPhysicalDeviceProperties device = SomeDevice();
    std::string Problem() { return PipelineCacheFile(folder.Path(), device).Load().problem; }
};

TEST_F(PipelineCacheFileTest, SavedBytesAreLoaded) {
    PipelineCacheFile file(folder / "new", device);
    EXPECT_THAT(file.Load().bytes, IsEmpty()) << "there is no file yet";
    EXPECT_THAT(file.Load().problem, IsEmpty());
    const Bytes bytes = DriverBytes(device);
    EXPECT_EQ(file.Save(bytes), "");
    EXPECT_EQ(PipelineCacheFile(folder / "new", device).Load().bytes, bytes);
    EXPECT_THAT(file.Path().filename().string(),
                AllOf(HasSubstr("000010de"), HasSubstr("00002335"), HasSubstr("0011223344556677")));
}

TEST_F(PipelineCacheFileTest, UnchangedBytesAreNotWrittenAgain) {
    PipelineCacheFile file(folder.Path(), device);
    ASSERT_EQ(file.Save(DriverBytes(device)), "");
    std::filesystem::remove(file.Path());
    EXPECT_EQ(file.Save(DriverBytes(device)), "");
    EXPECT_FALSE(std::filesystem::exists(file.Path()));
}

TEST_F(PipelineCacheFileTest, EveryFlippedByteIsNoticed) {
    PipelineCacheFile file(folder.Path(), device);
    ASSERT_EQ(file.Save(DriverBytes(device)), "");
    const Bytes good = ReadFile(file.Path());
    for (size_t i = 0; i < good.size(); i += i < 80 ? 1 : 97) {
        Bytes bad = good;
        bad[i] ^= std::byte{0x10};
        Overwrite(file.Path(), bad);
        const PipelineCacheFile::Loaded loaded = PipelineCacheFile(folder.Path(), device).Load();
        EXPECT_THAT(loaded.bytes, IsEmpty()) << i;
        EXPECT_THAT(loaded.problem, HasSubstr("is ignored")) << i;
    }
    Overwrite(file.Path(), good);
    EXPECT_EQ(Problem(), "");
}

TEST_F(PipelineCacheFileTest, CutOffFilesAreNoticed) {
    PipelineCacheFile file(folder.Path(), device);
    ASSERT_EQ(file.Save(DriverBytes(device)), "");
    const Bytes good = ReadFile(file.Path());
    for (const size_t size : {size_t{0}, size_t{7}, size_t{24}, size_t{60}, good.size() - 1}) {
        Overwrite(file.Path(), Bytes(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)));
        EXPECT_THAT(Problem(), HasSubstr("is ignored")) << size;
    }
}

TEST_F(PipelineCacheFileTest, EveryNumberOfDeviceAndDriver_NamesAnotherFileAndIsComparedInIt) {
    PipelineCacheFile file(folder.Path(), device);
    const auto expectOther = [&](const VkPhysicalDeviceProperties& other) {
        EXPECT_NE(PipelineCacheFile(folder.Path(), other).Path(), file.Path());
        ASSERT_EQ(file.Save(DriverBytes(other)), "");
        EXPECT_THAT(Problem(), HasSubstr("another device or driver"));
    };
    VkPhysicalDeviceProperties other = device;
    other.vendorID ^= 1;
    expectOther(other);
    other = device;
    other.deviceID ^= 1;
    expectOther(other);
    for (uint32_t i = 0; i < VK_UUID_SIZE; ++i) {
        SCOPED_TRACE(i);
        other = device;
        other.pipelineCacheUUID[i] ^= 1;
        expectOther(other);
    }
    ASSERT_EQ(file.Save(DriverBytes(device)), "");
    EXPECT_EQ(Problem(), "");
}

TEST_F(PipelineCacheFileTest, FolderThatCannotBeMade_IsReported) {
    Overwrite(folder / "file", Bytes(1));
    PipelineCacheFile file(folder / "file" / "cache", device);
    EXPECT_THAT(file.Save(DriverBytes(device)), HasSubstr((folder / "file").string()));
}

TEST(PipelineCacheFolderTest, FollowsTheXdgRules) {
    const auto set = [](const char* name, const char* value) {
        value ? setenv(name, value, 1) : unsetenv(name);
    };
    const auto get = [](const char* name) {
        const char* value = std::getenv(name);
        return value ? std::optional<std::string>(value) : std::nullopt;
    };
    const std::optional<std::string> cache = get("XDG_CACHE_HOME"), home = get("HOME");
    set("XDG_CACHE_HOME", "/caches");
    set("HOME", "/users/someone");
    EXPECT_EQ(rhi::PipelineCacheFolder("/mine"), "/mine");
    EXPECT_EQ(rhi::PipelineCacheFolder(""), "/caches/raygraph");
    set("XDG_CACHE_HOME", "relative");
    EXPECT_EQ(rhi::PipelineCacheFolder(""), "/users/someone/.cache/raygraph");
    set("XDG_CACHE_HOME", nullptr);
    EXPECT_EQ(rhi::PipelineCacheFolder(""), "/users/someone/.cache/raygraph");
    set("HOME", nullptr);
    EXPECT_EQ(rhi::PipelineCacheFolder(""), "");
    set("XDG_CACHE_HOME", cache ? cache->c_str() : nullptr);
    set("HOME", home ? home->c_str() : nullptr);
}

struct DeviceCacheTest : ::testing::Test {
    TemporaryFolder folder;
    MessageLog log;
    std::unique_ptr<rhi::Device> Make() {
        rhi::DeviceDesc desc;
        desc.cacheDirectory = folder.Path();
        desc.log = log.Listener();
        return rhi::Device::Create(desc);
    }
    std::filesystem::path File() {
        for (const auto& entry : std::filesystem::directory_iterator(folder.Path())) return entry.path();
        return {};
    }
};

TEST_F(DeviceCacheTest, IsWrittenWhenTheDeviceIsDestroyedAndReadByTheNext) {
    Make();
    ASSERT_FALSE(File().empty());
    EXPECT_TRUE(Make()->SavePipelineCache());
    EXPECT_EQ(log.Text(), "");
}

TEST_F(DeviceCacheTest, DamagedFile_IsIgnoredWithAMessageAndReplaced) {
    Make();
    const std::filesystem::path file = File();
    Overwrite(file, Bytes(100, std::byte{0x42}));
    Make();
    ASSERT_EQ(log.Count(), 1u);
    EXPECT_THAT(log.All()[0].text, AllOf(HasSubstr(file.string()), HasSubstr("is ignored")));
    EXPECT_EQ(log.All()[0].level, LogLevel::Warning);
    Make();
    EXPECT_EQ(log.Count(), 1u) << "the second one found a good file";
}

TEST_F(DeviceCacheTest, UnwritableFolder_IsAMessageNotAnError) {
    Overwrite(folder / "file", Bytes(1));
    rhi::DeviceDesc desc;
    desc.cacheDirectory = folder / "file" / "cache";
    desc.log = log.Listener();
    rhi::Device::Create(desc);
    EXPECT_THAT(log.Text(), HasSubstr("pipeline cache is not saved"));
}

TEST_F(DeviceCacheTest, SwitchedOff_WritesNothing) {
    rhi::DeviceDesc desc;
    desc.cacheDirectory = folder.Path();
    desc.savePipelineCache = false;
    EXPECT_FALSE(rhi::Device::Create(desc)->SavePipelineCache());
    EXPECT_TRUE(File().empty());
}

}  // namespace
}  // namespace raygraph::testing::pipeline_cache_test

// Tests that a driver which compiles at the first execution has the machine code of pipelines before.
namespace raygraph::rhi::compile_ahead_test {
namespace {

// Sets an environment variable while it lives.
class Environment {
  public:
    Environment(const char* name, const std::string& value) : m_name(name) {
        if (const char* before = std::getenv(name)) m_before = before;
        setenv(name, value.c_str(), 1);
    }
    ~Environment() { m_before ? setenv(m_name, m_before->c_str(), 1) : unsetenv(m_name); }

  private:
    const char* m_name;
    std::optional<std::string> m_before;
};

// Gives Mesa's cache a folder of its own, in which each piece of machine code is a file.
class CompileAheadTest : public ::testing::Test {
  protected:
    RayTracingPipelineDesc Desc(const std::vector<uint32_t>& words) const {
        RayTracingPipelineDesc desc{.name = "ahead"};
        desc.rayGen.stage = {.name = "ahead.rgen", .spirv = words};
        return desc;
    }
    static std::vector<uint32_t> RayGen(const std::string& value) {
        return CompileGlsl({.name = "ahead.rgen",
                            .text = R"(#version 460
                                #extension GL_EXT_ray_tracing : require
                                #extension GL_EXT_buffer_reference_uvec2 : require
                                layout(buffer_reference) buffer Number { uint number; };
                                layout(push_constant) uniform Constants { uvec2 at; } constants;
                                void main() {
                                    if (gl_LaunchIDEXT.x > 99u) Number(constants.at).number = )" +
                                    value + "; }\n"});
    }
    // Call it after the device has ended, which writes the compiled code.
    size_t FileCount() const {
        namespace fs = std::filesystem;
        return static_cast<size_t>(
            std::count_if(fs::recursive_directory_iterator(m_folder.Path()),
                          fs::recursive_directory_iterator(), [](const fs::directory_entry& entry) {
                              return entry.is_regular_file() && entry.path().filename() != "index" &&
                                     entry.path().filename() != "marker";
                          }));
    }
    // Returns how many files the first execution of what `make` makes writes; `launch` records the execution.
    template <typename Make, typename Launch>
    size_t FilesOfFirst(Make&& make, Launch&& launch) {
        size_t before = 0;
        {
            const std::unique_ptr<Device> device = Device::Create({.savePipelineCache = false});
            const auto pipeline = make(*device);
            before = FileCount();
            CommandList commands = device->BeginCommands("first");
            commands.Bind(pipeline);
            const std::array<uint32_t, 2> nowhere{};
            commands.PushConstants(std::as_bytes(std::span(nowhere)));
            launch(commands);
            device->WaitFor(device->Submit(std::move(commands)));
        }
        return FileCount() - before;
    }
    // Returns the files by a ray-tracing pipeline that is made after `skipped` others.
    size_t FilesOfFirstExecution(uint32_t skipped, bool isAhead) {
        const auto make = [&](Device& device) {
            const std::vector<uint32_t> other = RayGen("7u");
            for (uint32_t i = 0; i < skipped; ++i)
                static_cast<void>(CreateRayTracingPipeline(device, Desc(other)));
            const std::vector<uint32_t> words = RayGen(std::to_string(skipped + 10) + "u");
            RayTracingPipelineDesc desc = Desc(words);
            RayTracingPipeline pipeline = CreateRayTracingPipeline(device, desc);
            if (isAhead) CompileAhead(device, desc, pipeline);
            return pipeline;
        };
        return FilesOfFirst(make, [](CommandList& commands) { commands.TraceRays({1, 1}); });
    }
    // Returns the files by a compute pipeline.
    size_t FilesOfFirstDispatch(bool isAhead) {
        const auto make = [&](Device& device) {
            const std::vector<uint32_t> words =
                CompileGlsl({.name = "ahead.comp",
                             .text = R"(#version 460
                                 #extension GL_EXT_buffer_reference_uvec2 : require
                                 layout(buffer_reference) buffer Number { uint number; };
                                 layout(push_constant) uniform Constants { uvec2 at; } constants;
                                 void main() {
                                     if (gl_GlobalInvocationID.x > 99u) Number(constants.at).number = )" +
                                     std::string(isAhead ? "1u" : "2u") + "; }\n"});
            const ComputePipelineDesc desc{.name = "ahead", .shader = {.name = "ahead.comp", .spirv = words}};
            ComputePipeline pipeline = CreateComputePipeline(device, desc);
            if (isAhead) CompileAhead(device, desc, pipeline);
            return pipeline;
        };
        return FilesOfFirst(make, [](CommandList& commands) { commands.Dispatch(1); });
    }

  private:
    test::TemporaryFolder m_folder;
    Environment m_cache{"MESA_SHADER_CACHE_DIR", m_folder.Path().string()};
    Environment m_isOff{"MESA_SHADER_CACHE_DISABLE", "false"};
    Environment m_kind{"MESA_DISK_CACHE_MULTI_FILE", "true"};
};

TEST_F(CompileAheadTest, TheFirstExecutionFindsTheMachineCode) {
    testing::MessageLog log;
    const std::unique_ptr<Device> device =
        Device::Create({.log = log.Listener(LogLevel::Debug), .savePipelineCache = false});
    if (!device->Info()
             .isLavapipe) {  // Other drivers compile when pipelines are made, and nothing is left to do.
        const std::vector<uint32_t> words = RayGen("7u");
        const RayTracingPipelineDesc desc = Desc(words);
        const RayTracingPipeline pipeline = CreateRayTracingPipeline(*device, desc);
        const size_t said = log.Count();
        CompileAhead(*device, desc, pipeline);
        EXPECT_EQ(log.Text(said), "");
        return;
    }
    EXPECT_EQ(FilesOfFirstExecution(0, false), 1u) << "else there is nothing to do ahead";
    // The code contains the groups' indices on the device, whatever was made before
    for (const uint32_t skipped : {1u, 2u, 3u})
        EXPECT_EQ(FilesOfFirstExecution(skipped, true), 0u) << skipped;
    EXPECT_EQ(FilesOfFirstDispatch(false), 1u);
    EXPECT_EQ(FilesOfFirstDispatch(true), 0u);
}

}  // namespace
}  // namespace raygraph::rhi::compile_ahead_test
