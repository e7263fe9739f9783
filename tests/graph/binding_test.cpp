#include <gmock/gmock.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <memory>
#include <tuple>

#include "base/text.h"
#include "renderer/graph/pass_declaration.h"
#include "renderer/graph/resource_pool.h"
#include "rhi/shader_compiler.h"
#include "tests/graph/graph_test.h"
#include "tests/rhi/fake_loader.h"
#include "tests/support/error_of.h"
#include "tests/support/option_rows.h"

// Bindings against the shaders' own words, without a device: shaders are compiled and reflected on the CPU.
namespace raygraph::binding_test {
namespace {

rhi::ShaderInterface InterfaceOf(const std::string& name, const std::string& text) {
    rhi::GlslSource source;
    source.name = name;
    source.text =
        "#version 460\n#extension GL_EXT_ray_tracing : enable\n#extension GL_EXT_scalar_block_layout : "
        "enable\n" +
        text;
    const std::vector<uint32_t> words = rhi::CompileGlsl(source);
    const rhi::NamedReflection stage{name, rhi::Reflect(words, name)};
    return rhi::MergeInterface(std::span(&stage, 1));
}

// A compute pass with one of each kind of binding.
class Bindings : public ::testing::Test {
  protected:
    Bindings()
        : m_interface(InterfaceOf("test/all.comp", R"(
layout(local_size_x = 8) in;
layout(binding = 0, rgba32f) uniform writeonly image2D radiance;
layout(binding = 1, rgba32f) uniform readonly image2D history;
layout(binding = 2) uniform sampler2D environmentMap;
layout(binding = 3, std430) readonly buffer Materials { vec4 head; vec4 materials[]; };
layout(binding = 4, std140) uniform Camera { mat4 view; } camera;
layout(binding = 5, rgba32f) uniform image2D mean;
layout(binding = 6) uniform sampler2D unused;
layout(push_constant, std430) uniform Constants { vec3 origin; uint seed; uvec2 tail; } constants;
void main() {
    vec4 sum = imageLoad(history, ivec2(0)) + texture(environmentMap, vec2(0.0)) + materials[0] + camera.view[0];
    imageStore(mean, ivec2(0), imageLoad(mean, ivec2(0)) + sum + vec4(constants.origin, constants.tail.x));
    imageStore(radiance, ivec2(0), sum);
})")) {
        m_radiance = m_graph.Texture("radianceTexture");
        m_history = m_graph.Persistent("historyTexture");
        m_mean = m_graph.Persistent("meanTexture");
        m_environment = m_graph.Persistent("environmentTexture");
        m_materials = m_graph.Add<ResourceKind::Buffer>(
            {.name = "materialBuffer", .origin = Origin::Imported, .bytes = 160});
        m_small = m_graph.Add<ResourceKind::Buffer>(
            {.name = "smallBuffer", .origin = Origin::Imported, .bytes = 8});
        m_camera = m_graph.Add<ResourceKind::Buffer>(
            {.name = "cameraBuffer", .origin = Origin::Imported, .bytes = 64});
        m_graph.AddPass("Trace", PassKind::Compute);
    }

    template <ResourceKind Kind>
    DeclaredBinding& Bind(const char* name, BindVerb verb, ResourceId<Kind> id,
                          const rhi::Sampler* sampler = nullptr) {
        const Access access = sampler                    ? Access::Sampled
                              : verb == BindVerb::Reads  ? Access::StorageRead
                              : verb == BindVerb::Writes ? Access::StorageWrite
                                                         : Access::StorageUpdate;
        AddBinding(m_graph, m_pass, name, id, verb, access, sampler);
        return m_pass.bindings.back();
    }
    void BindEverything() {
        Bind("radiance", BindVerb::Writes, m_radiance);
        Bind("history", BindVerb::Reads, m_history);
        Bind("environmentMap", BindVerb::Reads, m_environment, &m_sampler);
        Bind("Materials", BindVerb::Reads, m_materials);
        Bind("camera", BindVerb::Reads, m_camera);
        Bind("mean", BindVerb::Updates, m_mean);
        GiveConstants(24);
    }
    void GiveConstants(size_t bytes, size_t alignment = 4) {
        m_pass.hasConstants = true;
        m_pass.constantAlignment = alignment;
        m_pass.constants.resize(bytes);
    }
    void Resolve() { ResolveBindings(m_graph, m_pass, &m_interface); }
    std::string Message() {
        return testing::ErrorTextOf([&] { Resolve(); });
    }

    rhi::ShaderInterface m_interface;
    GraphMaker m_graph;
    PassDeclaration m_pass;
    rhi::Sampler m_sampler;
    TextureId m_radiance, m_history, m_mean, m_environment;
    BufferId m_materials, m_small, m_camera;
};

TEST_F(Bindings, WholePass_FindsNumbersAndTypes) {
    BindEverything();
    Resolve();
    EXPECT_EQ(m_pass.bindings[2].binding, 2u);
    EXPECT_EQ(m_pass.bindings[2].type, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER);
    EXPECT_EQ(m_pass.bindings[3].type, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER);
    EXPECT_EQ(m_pass.bindings[4].type, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER);
    EXPECT_EQ(m_pass.bindings[4].uniformBytes, 64u) << "the block's, whatever the buffer has";
    EXPECT_EQ(m_graph.uses[m_pass.bindings[4].use].access, Access::Uniform) << "the shader declares it so";
}

// Each of these is refused when it is bound alone.
TEST_F(Bindings, EachMistake_NamesThePassTheBindingAndBothSides) {
    const TextureId other =
        m_graph.Imported<ResourceKind::Texture>("other", {.layout = VK_IMAGE_LAYOUT_GENERAL});
    const struct {
        std::function<void()> bind;
        const char* expected;
    } rows[] = {
        {[&] { Bind("radience", BindVerb::Writes, m_radiance); },
         R"(binds "radience": no such binding; test/all.comp has radiance (storage image, write), history (storage image, read), environmentMap (sampled image), Materials (storage buffer, read), camera (uniform buffer), mean (storage image, read+write), unused (sampled image))"},
        {[&] { Bind("environmentMap", BindVerb::Reads, m_environment); },
         R"(binds "environmentMap" as a storage image; in test/all.comp it is a sampled image)"},
        {[&] { Bind("history", BindVerb::Reads, m_materials); },
         R"(binds "history" as a buffer; in test/all.comp it is a storage image)"},
        {[&] { Bind("radiance", BindVerb::Reads, m_history); },
         R"(reads "radiance", which test/all.comp declares writeonly (storage image, write))"},
        {[&] { Bind("mean", BindVerb::Reads, m_mean); },
         R"(reads "mean", which test/all.comp may write (storage image, read+write): declare it readonly there, or write or update it here)"},
        {[&] { Bind("camera", BindVerb::Writes, m_camera); },
         R"(writes "camera", a uniform buffer in test/all.comp)"},
        {[&] { Bind("Materials", BindVerb::Reads, m_small); },
         R"(binds "Materials" to "smallBuffer" of 8 B; test/all.comp needs at least 16 B)"},
        {[&] { Bind("history", BindVerb::Reads, other); },
         R"(binds "history" to "other" of format rgba8; test/all.comp declares rgba32f)"},
        {[&] {
             Bind("history", BindVerb::Reads, m_history);
             Bind("history", BindVerb::Reads, m_history);
         },
         R"(binds "history" twice)"},
        {[&] { Bind("history", BindVerb::Writes, m_history); },
         R"(writes "history", which test/all.comp declares readonly (storage image, read))"}};
    for (const auto& row : rows) {
        m_pass.bindings.clear();
        m_graph.AddPass("Trace", PassKind::Compute);
        row.bind();
        EXPECT_EQ(Message(), std::string(R"(pass "Trace" )") + row.expected);
    }
}

// A mistake is reported as soon as those before it are corrected.
TEST_F(Bindings, SeveralMistakesInOnePass_AreReportedInTurn) {
    using ::testing::HasSubstr;
    BindEverything();
    GiveConstants(20);
    m_pass.bindings.erase(m_pass.bindings.begin() + 3);
    Bind("radience", BindVerb::Reads, m_materials);
    Bind("unused", BindVerb::Reads, m_history);
    Bind("camera", BindVerb::Reads, m_camera);
    for (const char* expected : {"binds \"radience\": no such binding", "binds \"unused\" as a storage image",
                                 "binds \"camera\" twice"}) {
        EXPECT_THAT(Message(), HasSubstr(expected));
        m_pass.bindings.erase(m_pass.bindings.begin() + 5);
    }
    EXPECT_THAT(Message(), HasSubstr("does not bind what its shaders use: Materials"));
    Bind("Materials", BindVerb::Reads, m_materials);
    EXPECT_THAT(Message(), HasSubstr("gives 20 bytes of constants"));
    GiveConstants(24);
    EXPECT_EQ(Message(), "accepted");
}

TEST_F(Bindings, WhatTheShaderUsesButNobodyBinds) {
    BindEverything();
    m_pass.bindings.erase(m_pass.bindings.begin() + 3, m_pass.bindings.begin() + 5);
    EXPECT_EQ(Message(),
              R"(pass "Trace" does not bind what its shaders use: Materials (storage buffer, read, in )"
              "test/all.comp), camera (uniform buffer, in test/all.comp)");
}

TEST_F(Bindings, ConstantsOfAnotherSize) {
    BindEverything();
    m_pass.hasConstants = false;
    EXPECT_EQ(Message(), R"(pass "Trace" gives no constants; test/all.comp has 24 bytes of push constants)");
    GiveConstants(20);
    EXPECT_EQ(Message(),
              R"(pass "Trace" gives 20 bytes of constants; test/all.comp has 24 bytes of push constants)");
    GiveConstants(32);
    EXPECT_EQ(Message(),
              R"(pass "Trace" gives 32 bytes of constants; test/all.comp has 24 bytes of push constants)");
    GiveConstants(32, 16);
    EXPECT_NO_THROW(Resolve()) << "padding at the end of an aligned struct";
}

TEST_F(Bindings, UniformDataOfAnotherSize) {
    DeclaredBinding& bound = m_pass.bindings.emplace_back();
    bound.name = "camera";
    bound.verb = BindVerb::Uniform;
    bound.uniformBytes = 48;
    EXPECT_EQ(Message(), R"(pass "Trace" gives 48 bytes for "camera", which has 64 in test/all.comp)");
}

TEST_F(Bindings, BufferLargerThanTheDeviceBinds) {
    Bind("Materials", BindVerb::Reads, m_materials);
    EXPECT_EQ(
        testing::ErrorTextOf([&] { ResolveBindings(m_graph, m_pass, &m_interface, {.storageBuffer = 128}); }),
        R"(pass "Trace" binds "Materials" to "materialBuffer" of 160 B; on this device a shader can bind 128 B)");
}

TEST_F(Bindings, BlockLargerThanTheDeviceBinds) {
    const BindingLimits limits{.uniformBlock = 63};
    const auto message = [&] {
        return testing::ErrorTextOf([&] { ResolveBindings(m_graph, m_pass, &m_interface, limits); });
    };
    const std::string expected =
        R"(pass "Trace" binds "camera" of 64 B in test/all.comp; on this device a uniform block has at most 63 B)";
    Bind("camera", BindVerb::Reads, m_camera);
    EXPECT_EQ(message(), expected);
    m_pass.bindings.clear();
    DeclaredBinding& data = m_pass.bindings.emplace_back();
    data.name = "camera";
    data.verb = BindVerb::Uniform;
    data.uniformBytes = 64;
    EXPECT_EQ(message(), expected);
}

// Texels of another type than the shader's have undefined values.
TEST(BindingTexels, TypesOfTheShaderAndTheTextureAgree) {
    const rhi::ShaderInterface interface = InterfaceOf("test/types.comp", R"(
#extension GL_EXT_shader_image_load_formatted : enable
layout(local_size_x = 1) in;
layout(binding = 0) uniform sampler2D floats;
layout(binding = 1) uniform usampler2D uints;
layout(binding = 2) uniform isampler2D ints;
layout(binding = 3) uniform writeonly uimage2D storage;
void main() {
    imageStore(storage, ivec2(0), uvec4(texelFetch(floats, ivec2(0), 0)) + texelFetch(uints, ivec2(0), 0) +
                                      uvec4(texelFetch(ints, ivec2(0), 0)));
})");
    const rhi::Sampler sampler;
    const auto messageOf = [&](const char* name, Format format) {
        GraphMaker graph;
        const TextureId texture =
            graph.Add<ResourceKind::Texture>({.name = "texture",
                                              .origin = Origin::Imported,
                                              .extent = {4, 4},
                                              .format = format,
                                              .state = {.layout = VK_IMAGE_LAYOUT_GENERAL}});
        graph.AddPass("Read", PassKind::Compute);
        PassDeclaration pass;
        const bool isSampled = std::string_view(name) != "storage";
        AddBinding(graph, pass, name, texture, isSampled ? BindVerb::Reads : BindVerb::Writes,
                   isSampled ? Access::Sampled : Access::StorageWrite, isSampled ? &sampler : nullptr);
        return testing::ErrorTextOf([&] { ResolveBindings(graph, pass, &interface); });
    };
    const auto refusal = [](const char* name, const char* format, const char* has, const char* reads) {
        return Text(
            R"(pass "Read" binds "{}" to "texture" of format {}, of {} texels; in test/types.comp they )"
            "are {}",
            name, format, has, reads);
    };
    EXPECT_EQ(messageOf("floats", Format::R32Uint), refusal("floats", "r32ui", "uint", "float"));
    EXPECT_EQ(messageOf("uints", Format::Rgba8Unorm), refusal("uints", "rgba8", "float", "uint"));
    EXPECT_EQ(messageOf("ints", Format::Rg32Uint), refusal("ints", "rg32ui", "uint", "int"));
    EXPECT_EQ(messageOf("storage", Format::R32Float), refusal("storage", "r32f", "float", "uint"));
    for (const auto& [name, format] : {std::pair("floats", Format::D32Float),
                                       {"floats", Format::Rgba8Srgb},
                                       {"uints", Format::R32Uint},
                                       {"storage", Format::Rgba32Uint}})
        EXPECT_THAT(messageOf(name, format), ::testing::HasSubstr("does not bind"))
            << "but the others: " << name;
}

TEST_F(Bindings, PassWithoutShaders_BindsNothing) {
    Bind("history", BindVerb::Reads, m_history);
    m_graph.passes.back().kind = PassKind::Transfer;
    EXPECT_EQ(testing::ErrorTextOf([&] { ResolveBindings(m_graph, m_pass, nullptr); }),
              R"(pass "Trace" is of kind transfer and has no shaders: it cannot bind "history")");
}

TEST_F(Bindings, ShadersOfAnotherKind) {
    Shader shader{.name = "test/all.comp"};
    shader.reflection.stage = rhi::StageKind::Compute;
    const auto message = [&](PassKind kind, bool hasShader) {
        GraphPass pass{.name = "Trace", .kind = kind};
        ProgramRequest request;
        request.compute = hasShader ? &shader : nullptr;
        return testing::ErrorTextOf([&] { CheckShaders(pass, request); });
    };
    EXPECT_EQ(message(PassKind::Compute, false),
              R"(pass "Trace" is of kind compute and names no compute shader (Compute))");
    EXPECT_EQ(message(PassKind::RayTracing, false),
              R"(pass "Trace" is of kind ray tracing and names no ray-generation shader (RayGen))");
    EXPECT_EQ(message(PassKind::Transfer, true),
              R"(pass "Trace" is of kind transfer and cannot run test/all.comp, a compute shader)");
}

TEST(AddressTable, HasThePlacesOfItsBuffers) {
    const rhi::ShaderInterface interface = InterfaceOf("test/table.comp", R"(
#extension GL_EXT_buffer_reference : enable
layout(local_size_x = 1) in;
layout(buffer_reference, scalar) readonly buffer Source { float at[]; };
layout(buffer_reference, scalar) buffer Sum { float at[]; };
layout(binding = 5, scalar) uniform Tables { Source source; Source other; Sum sum; };
void main() { sum.at[0] = source.at[1]; })");
    GraphMaker graph;
    const auto buffer = [&](const char* name) {
        return graph.Add<ResourceKind::Buffer>({.name = name, .origin = Origin::Imported, .bytes = 16});
    };
    const BufferId source = buffer("sourceBuffer"), sum = buffer("sumBuffer");
    graph.AddPass("Add", PassKind::Compute);
    PassDeclaration pass;
    AddBinding(graph, pass, "source", source, BindVerb::Reads, Access::StorageRead);
    EXPECT_EQ(testing::ErrorTextOf([&] { ResolveBindings(graph, pass, &interface); }),
              R"(pass "Add" does not bind what its shaders use: sum (buffer address, read+write, in )"
              "test/table.comp)");
    AddBinding(graph, pass, "sum", sum, BindVerb::Updates, Access::StorageUpdate);
    // However many bytes can be bound: by its address a buffer may be larger
    ResolveBindings(graph, pass, &interface, {.storageBuffer = 8});
    ASSERT_EQ(pass.addressTables.size(), 1u);
    EXPECT_EQ(pass.addressTables[0].binding, 5u);
    EXPECT_EQ(pass.addressTables[0].bytes, 24u);
    EXPECT_TRUE(pass.bindings[0].isAddress);
    EXPECT_EQ(pass.bindings[0].addressOffset, 0u);
    EXPECT_EQ(pass.bindings[1].addressOffset, 16u);
    pass.bindings[0].verb = BindVerb::Writes;
    EXPECT_EQ(
        testing::ErrorTextOf([&] { ResolveBindings(graph, pass, &interface); }),
        R"(pass "Add" writes "source", which test/table.comp declares readonly (buffer address, read))");
}

TEST(BindlessTextures, MissingSet_IsNamed) {
    const rhi::ShaderInterface interface = InterfaceOf("test/bindless.comp", R"(
#extension GL_EXT_nonuniform_qualifier : enable
layout(local_size_x = 1) in;
layout(set = 1, binding = 0) uniform sampler2D textures[];
layout(binding = 0, rgba32f) uniform writeonly image2D target;
void main() { imageStore(target, ivec2(0), texture(textures[3], vec2(0.5))); })");
    GraphMaker graph;
    const TextureId target = graph.Texture("target");
    graph.AddPass("Show", PassKind::Compute);
    PassDeclaration pass;
    AddBinding(graph, pass, "target", target, BindVerb::Writes, Access::StorageWrite);
    EXPECT_EQ(testing::ErrorTextOf([&] { ResolveBindings(graph, pass, &interface); }),
              R"(pass "Show" uses no texture set, but its shaders read the bindless textures of set 1)");
}

}  // namespace
}  // namespace raygraph::binding_test

// Frames share resources by description: these tests show that a difference in any field gives another
// resource.
namespace raygraph::resource_keys_test {
namespace {

template <typename Desc>
struct Row {
    const char* name;
    void (*change)(Desc&);
};

// Calls `see` with each changed description, and requires that the rows change every field.
template <typename Desc, size_t N, typename Fields, typename See>
void ForEachChange(const Desc& plain, const Row<Desc> (&table)[N], Fields fields, See see) {
    auto rows = testing::OptionRowsOf<Desc>(fields);
    for (const Row<Desc>& row : table) {
        SCOPED_TRACE(row.name);
        Desc changed = plain;
        row.change(changed);
        rows.Add(row.name, plain, changed);
        see(changed);
    }
    rows.ExpectComplete();
}

using rhi::BufferDesc;
using rhi::BufferUsage;
using rhi::TextureDesc;
using rhi::TextureUsage;

const Row<TextureDesc> kOfTextures[] = {
    {"name", [](TextureDesc& d) { d.name = "other"; }},
    {"width", [](TextureDesc& d) { d.extent.width = 8; }},
    {"height", [](TextureDesc& d) { d.extent.height = 8; }},
    {"format", [](TextureDesc& d) { d.format = Format::Rgba32Float; }},
    {"usage", [](TextureDesc& d) { d.usage = d.usage | TextureUsage::CopySource; }},
    {"levels", [](TextureDesc& d) { d.mipLevels = 2; }},
    {"layers", [](TextureDesc& d) { d.layers = 2; }},
    {"shared by all queues", [](TextureDesc& d) { d.isShared = true; }},
};

const Row<BufferDesc> kOfBuffers[] = {
    {"name", [](BufferDesc& d) { d.name = "other"; }},
    {"size", [](BufferDesc& d) { d.size = 128; }},
    {"usage", [](BufferDesc& d) { d.usage = d.usage | BufferUsage::Index; }},
    {"upload", [](BufferDesc& d) { d.memory = rhi::MemoryKind::Upload; }},
    {"readback", [](BufferDesc& d) { d.memory = rhi::MemoryKind::Readback; }},
    {"own memory", [](BufferDesc& d) { d.hasOwnMemory = true; }},
    {"shared by all queues", [](BufferDesc& d) { d.isShared = true; }},
};

// One other value stands for all formats or usages, because they are compared as numbers.
template <typename Enum>
uint64_t Number(Enum value) {
    return static_cast<uint64_t>(value);
}
auto FieldsOf(TextureDesc& s) {
    auto& [name, extent, format, usage, mipLevels, layers, isShared] = s;
    return std::tuple(name, extent, Number(format), Number(usage), mipLevels, layers, isShared);
}
auto FieldsOf(BufferDesc& s) {
    auto& [name, size, usage, memory, hasOwnMemory, isShared] = s;
    return std::tuple(name, size, Number(usage), memory, hasOwnMemory, isShared);
}

const TextureDesc kTexture{.name = "plain", .extent = {16, 16}, .usage = TextureUsage::Sampled};
const BufferDesc kBuffer{.name = "plain", .size = 64};

class TransientKeys : public testing::VulkanTest {
  protected:
    // Reserves a block in which any resource of the tables fits.
    void Reserve(uint64_t frame) {
        rhi::MemoryRequirements block{.size = 1u << 20, .alignment = 1, .memoryTypeBits = ~0u};
        const auto fit = [&](const auto& desc) {
            const rhi::MemoryRequirements needed = Device().RequirementsOf(desc);
            block.alignment = std::max(block.alignment, needed.alignment);
            block.memoryTypeBits &= needed.memoryTypeBits;
        };
        fit(kTexture);
        fit(kBuffer);
        pool.Reserve({&block, 1}, frame);
    }

    TransientPool pool{Device()};
};

class SamplerKeys : public ::testing::Test {
  protected:
    // Returns the number of samplers after frames that read a texture with each of `descs`, one after
    // another.
    uint32_t SamplersAfter(const std::vector<rhi::SamplerDesc>& descs) {
        Renderer renderer(*m_device);
        renderer.AddShader("test/sample.comp", CompileText("test/sample.comp", R"(
layout(local_size_x = 1) in;
layout(binding = 0) uniform sampler2D source;
layout(binding = 1, scalar) buffer Result { vec4 result; };
void main() { result = textureLod(source, vec2(0.5), 0.0); })"));
        const uint32_t before = m_loader.Tell().samplers;
        for (const rhi::SamplerDesc& desc : descs) {
            renderer.BeginFrame();
            const TextureId texture = renderer.Persist("texture", {.extent = {4, 4}});
            BufferId result = renderer.PersistBuffer("result", {.size = 16});
            renderer.AddPass(
                "Sample", PassKind::Compute,
                [&](PassBuilder& pass) {
                    pass.Compute("test/sample.comp");
                    pass.Reads("source", texture, desc);
                    result = pass.Writes("Result", result);
                },
                [](CommandList& commands) { commands.Dispatch(1); });
            renderer.DropFrame();
        }
        return m_loader.Tell().samplers - before;
    }

  private:
    testing::FakeLoader m_loader;
    std::unique_ptr<rhi::Device> m_device =
        rhi::Device::Create({.savePipelineCache = false, .getInstanceProcAddr = m_loader.Entry()});
};

const Row<rhi::SamplerDesc> kOfSamplers[] = {
    {"magnified", [](rhi::SamplerDesc& d) { d.magFilter = rhi::Filter::Nearest; }},
    {"minified", [](rhi::SamplerDesc& d) { d.minFilter = rhi::Filter::Nearest; }},
    {"between levels", [](rhi::SamplerDesc& d) { d.mipFilter = rhi::Filter::Nearest; }},
    {"mirrored u", [](rhi::SamplerDesc& d) { d.addressU = rhi::AddressMode::MirroredRepeat; }},
    {"clamped u", [](rhi::SamplerDesc& d) { d.addressU = rhi::AddressMode::ClampToEdge; }},
    {"mirrored v", [](rhi::SamplerDesc& d) { d.addressV = rhi::AddressMode::MirroredRepeat; }},
    {"clamped v", [](rhi::SamplerDesc& d) { d.addressV = rhi::AddressMode::ClampToEdge; }},
    {"anisotropy", [](rhi::SamplerDesc& d) { d.maxAnisotropy = 2.0f; }},
};

const Row<GraphTextureDesc> kOfPersistentTextures[] = {
    {"width", [](GraphTextureDesc& d) { d.extent.width = 8; }},
    {"height", [](GraphTextureDesc& d) { d.extent.height = 8; }},
    {"format", [](GraphTextureDesc& d) { d.format = Format::Rgba8Unorm; }},
    {"levels", [](GraphTextureDesc& d) { d.levels = 2; }},
    {"layers", [](GraphTextureDesc& d) { d.layers = 2; }},
};

const Row<GraphBufferDesc> kOfPersistentBuffers[] = {
    {"size", [](GraphBufferDesc& d) { d.size = 128; }},
    {"memory", [](GraphBufferDesc& d) { d.memory = rhi::MemoryKind::Upload; }},
};

template <typename Desc>
void ExpectAnew(PersistentStore& store, const Desc& changed) {
    constexpr GraphTextureDesc kPlainTexture{.extent = {16, 16}};
    constexpr GraphBufferDesc kPlainBuffer{.size = 64};
    const Desc& plain = [&]() -> const Desc& {
        if constexpr (std::is_same_v<Desc, GraphTextureDesc>)
            return kPlainTexture;
        else
            return kPlainBuffer;
    }();
    store.Find("a", plain).lastFrame = 7;
    store.CommitReplacements();
    EXPECT_EQ(store.Find("a", plain).lastFrame, 7u);
    EXPECT_NE(store.Find("a", changed).lastFrame, 7u);
    store.DropReplacements();
}

}  // namespace

// If a field were not compared, two textures at one place in memory that differ in it would be one object.
TEST_F(TransientKeys, ADescriptionThatDiffersInAnyPart_IsOfAnotherObject) {
    uint64_t frame = 1;
    Reserve(frame);
    const rhi::Texture* texture = &pool.Place(kTexture, 0, frame).object;
    const rhi::Buffer* buffer = &pool.Place(kBuffer, 0, frame).object;
    EXPECT_EQ(&pool.Place(kTexture, 0, ++frame).object, texture);
    EXPECT_EQ(&pool.Place(kBuffer, 0, frame).object, buffer);
    ForEachChange(
        kTexture, kOfTextures, [](TextureDesc& s) { return FieldsOf(s); },
        [&](const TextureDesc& changed) { EXPECT_NE(&pool.Place(changed, 0, ++frame).object, texture); });
    ForEachChange(
        kBuffer, kOfBuffers, [](BufferDesc& s) { return FieldsOf(s); },
        [&](const BufferDesc& changed) {
            if (changed.memory != kBuffer.memory) return;  // it is not placed in the block
            EXPECT_NE(&pool.Place(changed, 0, ++frame).object, buffer);
        });
}

TEST_F(TransientKeys, ABufferThatTheHostWrites_IsUsedAgainByItsDescription) {
    const BufferDesc plain{.name = "plain", .size = 64, .memory = rhi::MemoryKind::Upload};
    uint64_t frame = 1;
    const auto take = [&](const BufferDesc& desc) {
        return &pool.TakeUpload(desc, frame += Device().FramesInFlight());
    };
    const rhi::Buffer* buffer = take(plain);
    EXPECT_EQ(take(plain), buffer);
    for (const Row<BufferDesc>& row : kOfBuffers) {
        BufferDesc changed = plain;
        row.change(changed);
        const bool isPlain = changed.memory == plain.memory && row.name == std::string_view("upload");
        EXPECT_EQ(take(changed) == buffer, isPlain) << row.name;
    }
}

TEST_F(TransientKeys, WhatTheDriverNeedsIsKnownOfEachDescription) {
    const auto expect = [&](const auto& desc) {
        for (int time = 0; time < 2; ++time) {
            const rhi::MemoryRequirements known = pool.RequirementsOf(desc),
                                          asked = Device().RequirementsOf(desc);
            EXPECT_EQ(known.size, asked.size);
            EXPECT_EQ(known.memoryTypeBits, asked.memoryTypeBits);
        }
    };
    expect(kTexture);
    expect(kBuffer);
    ForEachChange(
        kTexture, kOfTextures, [](TextureDesc& s) { return FieldsOf(s); }, expect);
    ForEachChange(
        kBuffer, kOfBuffers, [](BufferDesc& s) { return FieldsOf(s); }, expect);
}

TEST(PersistentKeys, ADescriptionThatDiffersInAnyPart_StartsAnew) {
    PersistentStore store;
    ForEachChange(
        GraphTextureDesc{.extent = {16, 16}}, kOfPersistentTextures,
        [](GraphTextureDesc& s) {
            auto& [extent, format, levels, layers] = s;
            return std::tuple(extent, Number(format), levels, layers);
        },
        [&](const GraphTextureDesc& changed) { ExpectAnew(store, changed); });
    store.Find("a", GraphBufferDesc{.size = 64}).lastFrame = 8;
    EXPECT_NE(store.Find("a", GraphTextureDesc{.extent = {16, 16}}).lastFrame, 8u) << "of another kind";
    ForEachChange(
        GraphBufferDesc{.size = 64}, kOfPersistentBuffers,
        [](GraphBufferDesc& s) {
            auto& [size, memory] = s;
            return std::tuple(size, Number(memory));
        },
        [&](const GraphBufferDesc& changed) { ExpectAnew(store, changed); });
}

TEST_F(SamplerKeys, ADescriptionThatDiffersInAnyPartButItsName_IsOfAnotherSampler) {
    const rhi::SamplerDesc plain;
    rhi::SamplerDesc renamed = plain;
    renamed.name = "other";
    EXPECT_EQ(SamplersAfter({plain, plain, renamed}), 1u);
    ForEachChange(
        plain, kOfSamplers,
        [](rhi::SamplerDesc& s) {
            auto& [name, magFilter, minFilter, mipFilter, addressU, addressV, maxAnisotropy] = s;
            return std::tie(magFilter, minFilter, mipFilter, addressU, addressV, maxAnisotropy);
        },
        [&](const rhi::SamplerDesc& changed) {
            EXPECT_EQ(SamplersAfter({plain, changed}), 2u);
        });
}

}  // namespace raygraph::resource_keys_test

// Arrays of resources in set 0, executed: each element is bound by its name in GLSL, in any order.
namespace raygraph::array_test {
namespace {

constexpr Extent2D kExtent{8, 8};

struct Block {
    float value[4];
};

class Arrays : public GraphTest {
  protected:
    Arrays() {
        m_renderer.AddShader("test/arrays.comp", CompileText("test/arrays.comp", R"(
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 5) uniform sampler2D maps[3];
layout(binding = 1, r32f) uniform writeonly image2D targets[2];
layout(binding = 3, scalar) readonly buffer List { float at[]; } lists[2];
layout(binding = 2, std140) uniform Factors { vec4 value; } factors[2];
void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    float sum = 0.0;
    for (int i = 0; i < 3; ++i) sum = 1000.0 * sum + texelFetch(maps[i], ivec2(0), 0).x;  // exact: 3 digits each
    for (int i = 0; i < 2; ++i)
        imageStore(targets[i], texel, vec4(factors[i].value.x * float(i == 0 ? sum : lists[0].at[0] - lists[1].at[0])));
})"));
    }

    // Fills all elements but one, which is bound under another name; empty leaves it out.
    TextureId Run(std::string_view instead, Readback* second = nullptr) {
        m_renderer.BeginFrame();
        const TextureId maps[] = {Fill(m_renderer, "first", kExtent, 1.0f),
                                  Fill(m_renderer, "second", kExtent, 2.0f),
                                  Fill(m_renderer, "third", kExtent, 3.0f)};
        std::vector<BufferId> lists;
        for (const float value : {7.0f, 4.0f}) {
            BufferId list = m_renderer.CreateBuffer(Text("list {}", value),
                                                    {.size = 4, .memory = rhi::MemoryKind::Upload});
            m_renderer.AddPass(
                "Write", PassKind::Transfer, [&](PassBuilder& pass) { list = pass.CopiesTo(list); },
                [list, value](CommandList&, const PassResources& resources) {
                    std::memcpy(resources.Buffer(list).Mapped().data(), &value, sizeof value);
                });
            lists.push_back(list);
        }
        TextureId targets[] = {
            m_renderer.CreateTexture("target 0", {.extent = kExtent, .format = Format::R32Float}),
            m_renderer.CreateTexture("target 1", {.extent = kExtent, .format = Format::R32Float})};
        m_renderer.AddPass(
            "Arrays", PassKind::Compute,
            [&](PassBuilder& pass) {
                pass.Compute("test/arrays.comp");
                pass.Reads("lists[1]", lists[1]);
                pass.Reads("maps[2]", maps[2], rhi::SamplerDesc{});
                pass.Reads("maps[0]", maps[0], rhi::SamplerDesc{});
                if (!instead.empty()) pass.Reads(instead, maps[1], rhi::SamplerDesc{});
                targets[1] = pass.Writes("targets[1]", targets[1]);
                pass.Reads("lists[0]", lists[0]);
                targets[0] = pass.Writes("targets[0]", targets[0]);
                pass.Uniform("factors[1]", Block{{-1.0f}});
                pass.Uniform("factors[0]", Block{{0.5f}});
            },
            [](CommandList& commands) { commands.DispatchOver(kExtent); });
        if (second) *second = m_renderer.ReadBack(targets[1]);
        return targets[0];
    }
};

TEST_F(Arrays, Elements_AreBoundByName) {
    Readback second;
    const Readback first = m_renderer.ReadBack(Run("maps[1]", &second));
    m_renderer.Execute();
    EXPECT_THAT(Read(first).values, ::testing::Each(0.5f * 1'002'003.0f));
    EXPECT_THAT(Read(second).values, ::testing::Each(-3.0f));
}

TEST_F(Arrays, ElementsThatAreMissing_AreNamed) {
    const auto refusal = [&](std::string_view instead) {
        const std::string text = testing::ErrorTextOf([&] { Run(instead); });
        m_renderer.DropFrame();
        return text;
    };
    EXPECT_EQ(
        refusal(""),
        R"(pass "Arrays" does not bind what its shaders use: maps[1] (sampled image, in test/arrays.comp))");
    for (const char* name : {"maps", "maps[3]", "maps[01]"})
        EXPECT_THAT(refusal(name), ::testing::StartsWith(Text(
                                       R"(pass "Arrays" binds "{}": no such binding; test/arrays.comp has )"
                                       R"(targets[0] (storage image, write), targets[1])",
                                       name)));
    EXPECT_EQ(refusal("maps[2]"), R"(pass "Arrays" binds "maps[2]" twice)");
}

}  // namespace
}  // namespace raygraph::array_test
