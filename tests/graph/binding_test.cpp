// Bindings against the shaders' own words, without a device: shaders are compiled and reflected on the CPU.
#include "renderer/graph/pass_declaration.h"
#include "rhi/shader_compiler.h"
#include "tests/graph/graph_maker.h"
#include "tests/support/error_of.h"

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
    EXPECT_EQ(m_graph.uses[m_pass.bindings[4].use].access, Access::Uniform) << "the shader declares it so";
}

TEST_F(Bindings, UnknownName_ListsWhatTheShaderHas) {
    Bind("radience", BindVerb::Writes, m_radiance);
    EXPECT_EQ(
        Message(),
        R"(pass "Trace" binds "radience": no such binding; test/all.comp has radiance (storage image, write), )"
        "history (storage image, read), environmentMap (sampled image), Materials (storage buffer, read), "
        "camera (uniform buffer), mean (storage image, read+write), unused (sampled image)");
}

TEST_F(Bindings, WrongKind_NamesBoth) {
    Bind("environmentMap", BindVerb::Reads, m_environment);
    EXPECT_EQ(
        Message(),
        R"(pass "Trace" binds "environmentMap" as a storage image; in test/all.comp it is a sampled image)");
    m_pass.bindings.clear();
    Bind("history", BindVerb::Reads, m_materials);
    EXPECT_EQ(Message(),
              R"(pass "Trace" binds "history" as a buffer; in test/all.comp it is a storage image)");
}

TEST_F(Bindings, WritingWhatTheShaderReads) {
    Bind("history", BindVerb::Writes, m_history);
    EXPECT_EQ(
        Message(),
        R"(pass "Trace" writes "history", which test/all.comp declares readonly (storage image, read))");
}

TEST_F(Bindings, ReadingWhatTheShaderWrites) {
    Bind("radiance", BindVerb::Reads, m_history);
    EXPECT_EQ(
        Message(),
        R"(pass "Trace" reads "radiance", which test/all.comp declares writeonly (storage image, write))");
}

TEST_F(Bindings, ReadingWhatTheShaderMayWrite) {
    Bind("mean", BindVerb::Reads, m_mean);
    EXPECT_EQ(Message(),
              R"(pass "Trace" reads "mean", which test/all.comp may write (storage image, read+write): )"
              "declare it readonly there, or write or update it here");
}

TEST_F(Bindings, WritingAUniformBuffer) {
    Bind("camera", BindVerb::Writes, m_camera);
    EXPECT_EQ(Message(), R"(pass "Trace" writes "camera", a uniform buffer in test/all.comp)");
}

TEST_F(Bindings, BufferTooSmallForItsBlock) {
    Bind("Materials", BindVerb::Reads, m_small);
    EXPECT_EQ(Message(),
              R"(pass "Trace" binds "Materials" to "smallBuffer" of 8 B; test/all.comp needs at least 16 B)");
}

TEST_F(Bindings, ImageOfAnotherFormat) {
    TextureId other = m_graph.Imported<ResourceKind::Texture>("other", {.layout = VK_IMAGE_LAYOUT_GENERAL});
    Bind("history", BindVerb::Reads, other);
    EXPECT_EQ(Message(),
              R"(pass "Trace" binds "history" to "other" of format rgba8; test/all.comp declares rgba32f)");
}

TEST_F(Bindings, NameBoundTwice) {
    Bind("history", BindVerb::Reads, m_history);
    Bind("history", BindVerb::Reads, m_history);
    EXPECT_EQ(Message(), R"(pass "Trace" binds "history" twice)");
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
        testing::ErrorTextOf([&] { ResolveBindings(m_graph, m_pass, &m_interface, 128); }),
        R"(pass "Trace" binds "Materials" to "materialBuffer" of 160 B; on this device a shader can bind 128 B)");
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
    ResolveBindings(graph, pass, &interface, 8);
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
