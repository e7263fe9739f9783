// Reflection of shaders: bindings, interfaces, and what is used.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <spirv_cross.hpp>
#include <string>
#include <vector>

#include "base/error.h"
#include "rhi/reflection.h"
#include "rhi/shader_compiler.h"
#include "rhi/stage_set.h"
#include "shaders/embedded.h"
#include "tests/support/error_of.h"

namespace raygraph::rhi::reflection_test {
namespace {

ShaderReflection ReflectGlsl(StageKind stage, const std::string& text) {
    return Reflect(CompileGlsl({.name = "test", .text = text, .stage = stage}), "test");
}

const Binding& At(const ShaderReflection& reflection, uint32_t set, uint32_t binding) {
    for (const Binding& b : reflection.bindings)
        if (b.set == set && b.binding == binding) return b;
    ADD_FAILURE() << "no binding " << binding << " in set " << set;
    static const Binding kNone;
    return kNone;
}

std::string RefusalOf(StageKind stage, const std::string& text) {
    return testing::ErrorTextOf([&] { ReflectGlsl(stage, text); });
}

constexpr const char* kEveryKind = R"(#version 460
#extension GL_EXT_ray_tracing : require
#extension GL_EXT_nonuniform_qualifier : require
#extension GL_EXT_scalar_block_layout : require
struct Material { vec3 color; uint texture; };
layout(set = 0, binding = 0) uniform accelerationStructureEXT sceneTlas;
layout(set = 0, binding = 1, rgba32f) uniform writeonly image2D radiance;
layout(set = 0, binding = 2, r32ui) uniform uimage2D counts;
layout(set = 0, binding = 3, scalar) readonly buffer Materials { uint count; Material materials[]; };
layout(set = 0, binding = 4, scalar) writeonly buffer Hits { uint data[]; } hits;
layout(set = 0, binding = 5, scalar) buffer Both { uint both[4]; };
layout(set = 0, binding = 6, scalar) uniform Camera { mat4 view; vec3 eye; } camera;
layout(set = 0, binding = 7) uniform sampler2D environment;
layout(set = 0, binding = 8, rgba16f) uniform readonly image2D history;
layout(set = 0, binding = 9) uniform sampler2D pair[2];
layout(set = 0, binding = 10, scalar) readonly buffer Unused { float unused[]; };
layout(set = 1, binding = 0) uniform sampler2D textures[];
layout(push_constant, scalar) uniform Constants { uint seed; vec3 tint; uint frames; } constants;
layout(location = 0) rayPayloadEXT vec4 payload;
void main() {
    ivec2 p = ivec2(gl_LaunchIDEXT.xy);
    traceRayEXT(sceneTlas, 0, 0xff, 0, 1, 0, camera.eye, 0.0, vec3(0, 0, 1), 1e9, 0);
    vec4 c = payload + vec4(materials[constants.seed].color, 1) + texture(environment, vec2(0));
    c += texture(textures[nonuniformEXT(materials[0].texture)], vec2(0)) + imageLoad(history, p);
    c += texture(pair[1], vec2(0));
    imageAtomicAdd(counts, p, 1u);
    hits.data[count] = constants.seed;
    both[0] += 1;
    imageStore(radiance, p, c);
}
)";

TEST(Reflection, EveryKindOfBindingIsFoundByItsGlslName) {
    const ShaderReflection reflection = ReflectGlsl(StageKind::RayGen, kEveryKind);
    EXPECT_EQ(reflection.stage, StageKind::RayGen);
    EXPECT_EQ(reflection.entryPoint, "main");
    ASSERT_EQ(reflection.bindings.size(), 12u);
    struct Expected {
        uint32_t set, binding;
        const char* name;
        BindingKind kind;
        uint32_t count;
    };
    const Expected expected[] = {
        {0, 0, "sceneTlas", BindingKind::AccelerationStructure, 1},
        {0, 1, "radiance", BindingKind::StorageImage, 1},
        {0, 2, "counts", BindingKind::StorageImage, 1},
        {0, 3, "Materials", BindingKind::StorageBuffer, 1},
        {0, 4, "hits", BindingKind::StorageBuffer, 1},
        {0, 5, "Both", BindingKind::StorageBuffer, 1},
        {0, 6, "camera", BindingKind::UniformBuffer, 1},
        {0, 7, "environment", BindingKind::SampledImage, 1},
        {0, 8, "history", BindingKind::StorageImage, 1},
        {0, 9, "pair", BindingKind::SampledImage, 2},
        {0, 10, "Unused", BindingKind::StorageBuffer, 1},
        {1, 0, "textures", BindingKind::SampledImage, 0},
    };
    for (size_t i = 0; i < std::size(expected); ++i) {
        const Binding& binding = reflection.bindings[i];
        EXPECT_EQ(binding.set, expected[i].set) << i;
        EXPECT_EQ(binding.binding, expected[i].binding) << i;
        EXPECT_EQ(binding.name, expected[i].name) << i;
        EXPECT_EQ(binding.kind, expected[i].kind) << binding.name;
        EXPECT_EQ(binding.count, expected[i].count) << binding.name;
    }
}

TEST(Reflection, ReadonlyAndWriteonlyAreKept) {
    const ShaderReflection reflection = ReflectGlsl(StageKind::RayGen, kEveryKind);
    struct Expected {
        uint32_t binding;
        bool isReadable, isWritable;
    };
    for (const Expected& e : {Expected{0, true, false}, Expected{1, false, true}, Expected{2, true, true},
                              Expected{3, true, false}, Expected{4, false, true}, Expected{5, true, true},
                              Expected{6, true, false}, Expected{7, true, false}, Expected{8, true, false}}) {
        EXPECT_EQ(At(reflection, 0, e.binding).isReadable, e.isReadable) << At(reflection, 0, e.binding).name;
        EXPECT_EQ(At(reflection, 0, e.binding).isWritable, e.isWritable) << At(reflection, 0, e.binding).name;
    }
}

TEST(Reflection, OnlyWhatTheEntryPointReachesIsUsed) {
    const ShaderReflection reflection = ReflectGlsl(StageKind::RayGen, kEveryKind);
    for (const Binding& binding : reflection.bindings)
        EXPECT_EQ(binding.isUsed, binding.name != "Unused") << binding.name;
}

// Each member of such a block is a binding, with the flags and sizes of the buffer to which it refers.
TEST(Reflection, BlockOfBufferReferencesIsATableOfAddresses) {
    const ShaderReflection reflection = ReflectGlsl(StageKind::Compute, R"(#version 460
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
layout(local_size_x = 1) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Materials {
    uint head;
    vec3 at[];
};
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Sums { float at[]; };
layout(set = 0, binding = 3, scalar) uniform Tables { Materials materials; Materials unused; Sums sums; };
layout(set = 0, binding = 4, scalar) uniform Mixed { Materials first; uint count; } mixed;
layout(set = 0, binding = 5, scalar) uniform Several { Materials each[2]; } several;
void main() {
    sums.at[0] = materials.at[mixed.count].x + mixed.first.at[0].y + several.each[1].at[0].y;
})");
    ASSERT_EQ(reflection.bindings.size(), 5u) << "a block with anything else is a uniform buffer";
    struct Expected {
        const char* name;
        uint32_t offset;
        bool isUsed, isWritable;
        uint32_t blockBytes, elementBytes;
    };
    const Expected expected[] = {{"materials", 0, true, false, 4, 12},
                                 {"unused", 8, false, false, 4, 12},
                                 {"sums", 16, true, true, 0, 4}};
    for (size_t i = 0; i < std::size(expected); ++i) {
        const Binding& binding = reflection.bindings[i];
        EXPECT_EQ(binding.kind, BindingKind::BufferAddress) << i;
        EXPECT_EQ(binding.binding, 3u) << i;
        EXPECT_EQ(binding.name, expected[i].name);
        EXPECT_EQ(binding.offset, expected[i].offset) << binding.name;
        EXPECT_EQ(binding.isUsed, expected[i].isUsed) << binding.name;
        EXPECT_TRUE(binding.isReadable) << binding.name;
        EXPECT_EQ(binding.isWritable, expected[i].isWritable) << binding.name;
        EXPECT_EQ(binding.blockBytes, expected[i].blockBytes) << binding.name;
        EXPECT_EQ(binding.elementBytes, expected[i].elementBytes) << binding.name;
    }
    EXPECT_EQ(reflection.bindings[3].kind, BindingKind::UniformBuffer);
    EXPECT_EQ(reflection.bindings[4].kind, BindingKind::UniformBuffer);
}

TEST(Reflection, ArrayOfTablesOfAddressesIsRefused) {
    EXPECT_EQ(RefusalOf(StageKind::Compute, R"(#version 460
#extension GL_EXT_buffer_reference : require
layout(local_size_x = 1) in;
layout(buffer_reference, std430) buffer Sums { float at[]; };
layout(set = 0, binding = 3) uniform Tables { Sums sums; } tables[2];
void main() { tables[1].sums.at[0] = 1.0; })"),
              "test: 'tables' is an array of tables of addresses, which cannot be bound");
}

TEST(Reflection, ImageFormatsAndBlockSizesAreKnown) {
    const ShaderReflection reflection = ReflectGlsl(StageKind::RayGen, kEveryKind);
    EXPECT_EQ(At(reflection, 0, 1).imageFormat, Format::Rgba32Float);
    EXPECT_EQ(At(reflection, 0, 2).imageFormat, Format::R32Uint);
    EXPECT_EQ(At(reflection, 0, 8).imageFormat, Format::Rgba16Float);
    EXPECT_EQ(At(reflection, 0, 3).blockBytes, 4u);
    EXPECT_EQ(At(reflection, 0, 3).elementBytes, 16u);
    EXPECT_EQ(At(reflection, 0, 4).blockBytes, 0u);
    EXPECT_EQ(At(reflection, 0, 4).elementBytes, 4u);
    EXPECT_EQ(At(reflection, 0, 5).blockBytes, 16u);
    EXPECT_EQ(At(reflection, 0, 5).elementBytes, 0u);
    EXPECT_EQ(At(reflection, 0, 6).blockBytes, 76u);
    EXPECT_EQ(reflection.pushConstants.name, "constants");
    EXPECT_EQ(reflection.pushConstants.bytes, 20u);
}

TEST(Reflection, SpecializationConstantsHaveTypeNameAndDefault) {
    const ShaderReflection reflection = ReflectGlsl(StageKind::Compute, R"(#version 460
        layout(local_size_x = 8, local_size_y_id = 5) in;
        layout(constant_id = 3) const bool isFast = true;
        layout(constant_id = 1) const int offset = -2;
        layout(constant_id = 2) const uint count = 7;
        layout(constant_id = 4) const float scale = 0.5;
        layout(set = 0, binding = 0) buffer Out { float x; };
        void main() { x = isFast ? scale * float(offset) : float(count); })");
    ASSERT_EQ(reflection.specialization.size(), 5u);
    const auto& s = reflection.specialization;
    EXPECT_EQ(s[0].id, 1u);
    EXPECT_EQ(s[0].name, "offset");
    EXPECT_EQ(s[0].type, ConstantType::Int);
    EXPECT_EQ(static_cast<int32_t>(s[0].defaultValue), -2);
    EXPECT_EQ(s[1].name, "count");
    EXPECT_EQ(s[1].type, ConstantType::Uint);
    EXPECT_EQ(s[1].defaultValue, 7u);
    EXPECT_EQ(s[2].name, "isFast");
    EXPECT_EQ(s[2].type, ConstantType::Bool);
    EXPECT_EQ(s[2].defaultValue, 1u);
    EXPECT_EQ(s[3].type, ConstantType::Float);
    EXPECT_EQ(std::bit_cast<float>(s[3].defaultValue), 0.5f);
    EXPECT_EQ(s[4].id, 5u);
    EXPECT_EQ(reflection.workgroupSize[0], 8u);
    EXPECT_EQ(reflection.workgroupSizeIds[0], -1);
    EXPECT_EQ(reflection.workgroupSizeIds[1], 5);
    EXPECT_EQ(reflection.workgroupSizeIds[2], -1);
}

TEST(Reflection, FixedWorkgroupSizeIsKnown) {
    const ShaderReflection reflection = ReflectGlsl(
        StageKind::Compute,
        "#version 460\nlayout(local_size_x = 8, local_size_y = 4, local_size_z = 2) in;\nvoid main() {}");
    EXPECT_EQ(reflection.workgroupSize, (std::array<uint32_t, 3>{8, 4, 2}));
    EXPECT_TRUE(reflection.bindings.empty());
    EXPECT_EQ(reflection.pushConstants.bytes, 0u);
    EXPECT_TRUE(reflection.pushConstants.name.empty());
}

TEST(Reflection, EveryStageIsRecognised) {
    const std::string version = "#version 460\n#extension GL_EXT_ray_tracing : require\n";
    for (StageKind stage : {StageKind::RayGen, StageKind::Miss, StageKind::ClosestHit, StageKind::AnyHit,
                            StageKind::Intersection, StageKind::Callable, StageKind::Compute,
                            StageKind::Vertex, StageKind::Fragment})
        EXPECT_EQ(ReflectGlsl(stage, version + "void main() {}").stage, stage) << Name(stage);
}

TEST(Reflection, ShaderRecordIsNotABinding) {
    const ShaderReflection reflection = ReflectGlsl(StageKind::Miss, R"(#version 460
        #extension GL_EXT_ray_tracing : require
        layout(shaderRecordEXT) buffer Record { vec4 color; };
        layout(location = 0) rayPayloadInEXT vec4 payload;
        void main() { payload = color; })");
    EXPECT_TRUE(reflection.bindings.empty());
}

TEST(Reflection, ImagesHaveTheShapeThatTheShaderDeclares) {
    const ShaderReflection reflection = ReflectGlsl(StageKind::Compute, R"(#version 460
        layout(set = 0, binding = 0, r32f) uniform writeonly image2D target;
        layout(set = 0, binding = 1) uniform sampler2DArray shadows;
        layout(set = 0, binding = 2) uniform samplerCube sky;
        layout(set = 0, binding = 3, r32f) uniform readonly image2DArray layers;
        void main() {
            imageStore(target, ivec2(0), texture(shadows, vec3(0)) + texture(sky, vec3(0)) +
                                             imageLoad(layers, ivec3(0)));
        })");
    ASSERT_EQ(reflection.bindings.size(), 4u);
    EXPECT_EQ(reflection.bindings[0].shape, ImageShape::Plain);
    EXPECT_EQ(reflection.bindings[1].shape, ImageShape::Array);
    EXPECT_EQ(reflection.bindings[2].shape, ImageShape::Cube);
    EXPECT_EQ(reflection.bindings[3].shape, ImageShape::Array);
}

TEST(Reflection, BindingsThatCannotBeBoundAreRefusedByName) {
    const std::string head =
        "#version 460\n#extension GL_EXT_samplerless_texture_functions : require\nlayout(set = 0, binding = "
        "1) ";
    auto comp = [&](const std::string& declaration, const std::string& use) {
        return RefusalOf(
            StageKind::Compute,
            head + declaration +
                ";\nlayout(set = 0, binding = 0) buffer Out { vec4 x; };\nvoid main() { x = " + use + "; }");
    };
    EXPECT_EQ(comp("uniform texture2D lone", "vec4(textureSize(lone, 0), 0, 0)").substr(0, 33),
              "test: 'lone' is a separate image ");
    for (const auto& [declaration, use] :
         {std::pair("uniform sampler3D volume", "texture(volume, vec3(0))"),
          std::pair("uniform samplerCubeArray volume", "texture(volume, vec4(0))"),
          std::pair("uniform sampler2DMS volume", "texelFetch(volume, ivec2(0), 0)")})
        EXPECT_NE(
            comp(declaration, use)
                .find("'volume' is not a 2D image, an array of them or a cube map, and cannot be bound"),
            std::string::npos)
            << declaration;
    EXPECT_NE(comp("uniform samplerBuffer texels", "texelFetch(texels, 0)")
                  .find("'texels' is a separate image or texel buffer"),
              std::string::npos);
    EXPECT_NE(comp("uniform sampler2D grid[2][2]", "texture(grid[0][0], vec2(0))")
                  .find("'grid' is an array of arrays"),
              std::string::npos);
    EXPECT_NE(
        comp("buffer B { float y; };\nlayout(constant_id = 9) const double d = 1.0", "vec4(float(d) + y)")
            .find("specialization constant 9 'd' is not of a 32-bit type"),
        std::string::npos);
}

TEST(Reflection, WordsThatAreNoModuleAreRefused) {
    const std::vector<uint32_t> nothing;
    EXPECT_THROW(Reflect(nothing), Error);
    const std::vector<uint32_t> noise{1, 2, 3, 4, 5, 6};
    EXPECT_THROW(Reflect(noise), Error);
    std::vector<uint32_t> cut = CompileGlsl({.name = "test",
                                             .text = "#version 460\nvoid main() {}",
                                             .stage = StageKind::Compute,
                                             .includeRoot = {}});
    cut.resize(cut.size() / 2);
    EXPECT_THROW(Reflect(cut, "cut"), Error);
}

TEST(Reflection, VertexShaders_WriteALayerOrNot) {
    const auto writesLayer = [](const std::string& body) {
        return ReflectGlsl(StageKind::Vertex,
                           "#version 460\n#extension GL_ARB_shader_viewport_layer_array : require\n"
                           "void main() { gl_Position = vec4(0.0); " +
                               body + " }")
            .writesLayer;
    };
    EXPECT_FALSE(writesLayer(""));
    EXPECT_TRUE(writesLayer("gl_Layer = gl_InstanceIndex;"));
}

}  // namespace
}  // namespace raygraph::rhi::reflection_test

namespace raygraph::rhi::shader_interface_test {
namespace {

NamedReflection Stage(const std::string& name, const std::string& declarations, const std::string& body) {
    const std::string text =
        "#version 460\n#extension GL_EXT_ray_tracing : require\n"
        "#extension GL_EXT_nonuniform_qualifier : require\n" +
        declarations + "\nvoid main() {" + body + "}";
    return {name, Reflect(CompileGlsl({.name = name, .text = text, .stage = {}}), name)};
}

std::string RefusalOf(const std::vector<NamedReflection>& stages) {
    return testing::ErrorTextOf([&] { MergeInterface(stages); });
}

// Stages of a pipeline share a table; no other kind of binding may have its number.
TEST(ShaderInterface, TablesOfAddressesAreMergedByPlace) {
    const std::string extension = "\n#extension GL_EXT_buffer_reference : require\n";
    const std::string table = extension +
                              "layout(buffer_reference) readonly buffer Data { vec4 at[]; };"
                              "layout(binding = 1) uniform Tables { Data first; Data second; };"
                              "layout(binding = 0, rgba32f) uniform image2D radiance;";
    const NamedReflection reads = Stage("a.rgen", table, "imageStore(radiance, ivec2(0), second.at[0]);");
    const NamedReflection hit = Stage("a.rchit", table, "imageStore(radiance, ivec2(0), first.at[0]);");
    const ShaderInterface merged = MergeInterface(std::vector{reads, hit});
    ASSERT_EQ(merged.bindings.size(), 3u);
    for (const char* name : {"first", "second"}) {
        const BindingInfo* info = merged.Find(name);
        ASSERT_NE(info, nullptr) << name;
        EXPECT_TRUE(info->isUsed) << name;
        EXPECT_EQ(info->offset, name[0] == 'f' ? 0u : 8u);
    }
    const NamedReflection other = Stage("b.rmiss",
                                        "layout(binding = 1) readonly buffer Other { vec4 d[]; };"
                                        "layout(binding = 0, rgba32f) uniform image2D radiance;",
                                        "imageStore(radiance, ivec2(0), d[0]);");
    EXPECT_EQ(RefusalOf({reads, other}),
              "shaders disagree: a.rgen has buffer address 'first' at binding 1, b.rmiss has storage buffer "
              "'Other' at binding 1");
}

TEST(ShaderInterface, BindingsOfAllStagesAreMergedWithTheirStages) {
    const NamedReflection stages[] = {
        Stage("a.rgen",
              "layout(binding = 2) readonly buffer Data { float d[]; };"
              "layout(binding = 1, rgba32f) uniform writeonly image2D radiance;",
              "imageStore(radiance, ivec2(0), vec4(d[0]));"),
        Stage("a.rchit",
              "layout(binding = 2) buffer Data { float d[]; }; layout(binding = 0) uniform U { vec4 u; };",
              "d[0] = u.x;"),
    };
    const ShaderInterface merged = MergeInterface(stages);
    ASSERT_EQ(merged.bindings.size(), 3u);
    EXPECT_EQ(merged.bindings[0].name, "U");
    EXPECT_EQ(merged.bindings[1].name, "radiance");
    EXPECT_EQ(merged.bindings[2].name, "Data");
    EXPECT_EQ(merged.stages,
              VkShaderStageFlags{VK_SHADER_STAGE_RAYGEN_BIT_KHR | VK_SHADER_STAGE_CLOSEST_HIT_BIT_KHR});
    const BindingInfo* data = merged.Find("Data");
    ASSERT_NE(data, nullptr);
    EXPECT_EQ(data->stages, merged.stages);
    EXPECT_TRUE(data->isWritable) << "writable in one stage is writable";
    EXPECT_EQ(data->firstShader, "a.rgen");
    EXPECT_EQ(merged.Find("radiance")->stages, VkShaderStageFlags{VK_SHADER_STAGE_RAYGEN_BIT_KHR});
    EXPECT_EQ(merged.Find("nothing"), nullptr);
    EXPECT_FALSE(merged.usesTextureTable);
}

TEST(ShaderInterface, TwoKindsAtOneBindingNameBothShaders) {
    EXPECT_EQ(
        RefusalOf({Stage("a.rgen", "layout(binding = 3) buffer Data { float d; };", "d = 1;"),
                   Stage("b.rmiss", "layout(binding = 3) uniform sampler2D sky;", "")}),
        "shaders disagree: a.rgen has storage buffer 'Data' at binding 3, b.rmiss has sampled image 'sky' at "
        "binding 3");
}

TEST(ShaderInterface, OneNameAtTwoBindingsNamesBothShaders) {
    EXPECT_EQ(
        RefusalOf({Stage("a.rgen", "layout(binding = 3) uniform sampler2D sky;", ""),
                   Stage("b.rmiss", "layout(binding = 4) uniform sampler2D sky;", "")}),
        "shaders disagree: a.rgen has sampled image 'sky' at binding 3, b.rmiss has sampled image 'sky' at "
        "binding 4");
}

TEST(ShaderInterface, DifferentArraySizesAndImageFormatsAreConflicts) {
    EXPECT_EQ(RefusalOf({Stage("a.rgen", "layout(binding = 0) uniform sampler2D sky[2];", ""),
                         Stage("b.rmiss", "layout(binding = 0) uniform sampler2D sky[3];", "")}),
              "shaders disagree: a.rgen has sampled image 'sky'[2] at binding 0, b.rmiss has sampled image "
              "'sky'[3] at "
              "binding 0");
    EXPECT_EQ(RefusalOf({Stage("a.rgen", "layout(binding = 0, rgba32f) uniform image2D x;", ""),
                         Stage("b.rmiss", "layout(binding = 0, rgba16f) uniform image2D x;", "")}),
              "shaders disagree: a.rgen has storage image 'x' of rgba32f at binding 0, b.rmiss has storage "
              "image 'x' of "
              "rgba16f at binding 0");
}

TEST(ShaderInterface, ElementsOfArrays_AreBindings) {
    const ShaderInterface merged =
        MergeInterface(std::vector{Stage("a.rgen",
                                         "layout(binding = 3) uniform sampler2D sky;"
                                         "layout(binding = 1) uniform sampler2D maps[3];"
                                         "layout(binding = 2) readonly buffer Data { float d[]; } lists[2];",
                                         "textureLod(maps[1], vec2(lists[1].d[0]), 0.0);")});
    const std::vector<std::string> names{"maps[0]", "maps[1]", "maps[2]", "lists[0]", "lists[1]", "sky"};
    ASSERT_EQ(merged.bindings.size(), names.size());
    for (size_t i = 0; i < names.size(); ++i) {
        const BindingInfo& info = merged.bindings[i];
        EXPECT_EQ(info.name, names[i]);
        EXPECT_EQ(info.binding, i < 3 ? 1u : i < 5 ? 2u : 3u) << info.name;
        EXPECT_EQ(info.element, i < 3 ? i : i < 5 ? i - 3 : 0u) << info.name;
        EXPECT_EQ(info.count, i < 3 ? 3u : i < 5 ? 2u : 1u) << info.name;
        EXPECT_EQ(info.isUsed, i < 5) << info.name;
    }
    EXPECT_EQ(merged.Find("maps"), nullptr);
    EXPECT_EQ(RefusalOf({Stage("a.rgen", "layout(binding = 0) uniform sampler2D maps[100000000];", "")}),
              "a.rgen: 'maps' is an array of 100000000 in set 0, at most 4096 are bound");
}

TEST(ShaderInterface, DifferentShapesAreConflicts) {
    EXPECT_EQ(RefusalOf({Stage("a.rgen", "layout(binding = 0) uniform sampler2D sky;", ""),
                         Stage("b.rmiss", "layout(binding = 0) uniform samplerCube sky;", "")}),
              "shaders disagree: a.rgen has sampled image 'sky' at binding 0, b.rmiss has sampled image "
              "'sky' (cube map) at binding 0");
    EXPECT_EQ(RefusalOf({Stage("a.rchit", "layout(set = 1, binding = 0) uniform sampler2DArray textures[];",
                               "texture(textures[gl_LaunchIDEXT.x], vec3(0));")}),
              "a.rchit: set 1 binding 0 is sampled image 'textures'[] (array of 2D images); set 1 is for the "
              "bindless textures, sampler2D[] at binding 0");
}

TEST(ShaderInterface, DifferentTypesOfTexelsAreConflicts) {
    EXPECT_EQ(RefusalOf({Stage("a.rgen", "layout(binding = 0) uniform sampler2D sky;", ""),
                         Stage("b.rmiss", "layout(binding = 0) uniform usampler2D sky;", "")}),
              "shaders disagree: a.rgen has sampled image 'sky' at binding 0, b.rmiss has sampled image "
              "'sky' of uint texels at binding 0");
    EXPECT_EQ(RefusalOf({Stage("a.rchit", "layout(set = 1, binding = 0) uniform isampler2D textures[];",
                               "texture(textures[gl_LaunchIDEXT.x], vec2(0));")}),
              "a.rchit: set 1 binding 0 is sampled image 'textures'[] of int texels; set 1 is for the "
              "bindless textures, sampler2D[] at binding 0");
}

constexpr const char* kTextures = "layout(set = 1, binding = 0) uniform sampler2D textures[];";
constexpr const char* kUseTexture = "texture(textures[gl_LaunchIDEXT.x], vec2(0));";

TEST(ShaderInterface, TextureTableThatIsOnlyDeclaredIsNotUsed) {
    const ShaderInterface merged = MergeInterface(std::vector{Stage("a.rchit", kTextures, "")});
    EXPECT_FALSE(merged.usesTextureTable);
}

TEST(ShaderInterface, SetOneIsForTheBindlessTextures) {
    const ShaderInterface merged = MergeInterface(std::vector{Stage("a.rchit", kTextures, kUseTexture)});
    EXPECT_TRUE(merged.usesTextureTable);
    EXPECT_TRUE(merged.bindings.empty());
    EXPECT_EQ(RefusalOf({Stage("a.rchit", "layout(set = 1, binding = 0) buffer Data { float d; };", "")}),
              "a.rchit: set 1 binding 0 is storage buffer 'Data'; set 1 is for the bindless textures, "
              "sampler2D[] at "
              "binding 0");
    EXPECT_EQ(RefusalOf({Stage("a.rchit", "layout(set = 1, binding = 2) uniform sampler2D textures[];",
                               kUseTexture)}),
              "a.rchit: set 1 binding 2 is sampled image 'textures'[]; set 1 is for the bindless textures, "
              "sampler2D[] at binding 0");
}

TEST(ShaderInterface, SetsAboveOneAndRuntimeArraysInSetZeroAreRefused) {
    EXPECT_EQ(
        RefusalOf({Stage("a.rgen", "layout(set = 2, binding = 0) buffer Data { float d; };", "d = 1;")}),
        "a.rgen: 'Data' is in set 2; there are set 0 (the pass) and set 1 (bindless textures)");
    EXPECT_EQ(RefusalOf({Stage("a.rgen", "layout(set = 0, binding = 0) uniform sampler2D many[];",
                               "texture(many[gl_LaunchIDEXT.x], vec2(0));")}),
              "a.rgen: 'many' is a runtime array in set 0; give it a size");
}

TEST(ShaderInterface, LargestPushConstantBlockWins) {
    const ShaderInterface merged = MergeInterface(
        std::vector{Stage("a.rgen", "layout(push_constant) uniform C { uint x; };", ""),
                    Stage("b.rmiss", "layout(push_constant) uniform C { uint x; uint y; };", ""),
                    Stage("c.rchit", "", "")});
    EXPECT_EQ(merged.pushConstants.bytes, 8u);
    EXPECT_EQ(merged.pushConstantShader, "b.rmiss");
}

TEST(ShaderInterface, SpecializationConstantsOfAllStagesAreListedOnce) {
    const ShaderInterface merged = MergeInterface(std::vector{
        Stage("a.rgen", "layout(constant_id = 4) const uint a = 1; layout(constant_id = 1) const uint b = 1;",
              ""),
        Stage("b.rmiss", "layout(constant_id = 4) const uint a = 1;", "")});
    ASSERT_EQ(merged.specialization.size(), 2u);
    EXPECT_EQ(merged.specialization[0].id, 1u);
    EXPECT_EQ(merged.specialization[1].id, 4u);
}

}  // namespace
}  // namespace raygraph::rhi::shader_interface_test

// Tests which resources entry points use, beyond what SPIRV-Cross reports.
namespace raygraph::rhi::static_use_test {
namespace {

using Resources = spirv_cross::SmallVector<spirv_cross::Resource>;

void ExpectAsSpirvCross(std::span<const uint32_t> words, std::string_view name) {
    const spirv_cross::Compiler compiler(words.data(), words.size());
    const auto active = compiler.get_active_interface_variables();
    const std::unordered_map<uint32_t, UsedVariable> used = StaticUse(words);
    const spirv_cross::ShaderResources all = compiler.get_shader_resources();
    for (const Resources* kind : {&all.storage_images, &all.sampled_images, &all.storage_buffers,
                                  &all.acceleration_structures, &all.push_constant_buffers})
        for (const spirv_cross::Resource& resource : *kind)
            EXPECT_EQ(used.contains(resource.id), active.contains(resource.id))
                << name << ": " << resource.name;
    for (const spirv_cross::Resource& resource : all.uniform_buffers) {
        EXPECT_EQ(used.contains(resource.id), active.contains(resource.id)) << name << ": " << resource.name;
        const auto found = used.find(resource.id);
        if (found == used.end() || found->second.isWhole) continue;
        std::unordered_set<uint32_t> members;
        for (const spirv_cross::BufferRange& range : compiler.get_active_buffer_ranges(resource.id))
            members.insert(range.index);
        EXPECT_EQ(found->second.members, members) << name << ": " << resource.name;
    }
}

// Returns the names of the resources that a compute shader uses; for a block, "name.0" is its first member.
std::vector<std::string> UsedBy(const std::string& text) {
    const std::vector<uint32_t> words = CompileGlsl({.name = "test.comp", .text = text});
    ExpectAsSpirvCross(words, "test.comp");
    const spirv_cross::Compiler compiler(words.data(), words.size());
    std::vector<std::string> names;
    for (const auto& [id, use] : StaticUse(words)) {
        const std::string& name = compiler.get_name(id);
        if (use.isWhole) names.push_back(name);
        for (const uint32_t member : use.members) names.push_back(name + "." + std::to_string(member));
    }
    std::erase_if(names, [](const std::string& name) { return name.starts_with("gl_"); });
    std::ranges::sort(names);
    return names;
}

TEST(StaticUse, OfEachShaderOfTheLibraryIsThatOfSpirvCross) {
    ASSERT_FALSE(EmbeddedShaders().empty());
    for (const EmbeddedShader& shader : EmbeddedShaders()) ExpectAsSpirvCross(shader.Words(), shader.name);
}

TEST(StaticUse, IsWhatCalledFunctionsRead) {
    EXPECT_EQ(UsedBy(R"(#version 460
layout(binding = 0) uniform A { vec4 first; vec4 second; float third[4]; } a;
layout(binding = 1) buffer B { uint sum; uint values[]; } b;
layout(binding = 2, r32ui) uniform uimage2D counts;
layout(binding = 3) uniform sampler2D direct;
layout(binding = 4) uniform sampler2D passed;
layout(binding = 5) uniform sampler2D unused;
layout(binding = 6) buffer Unused { uint nothing[]; } neverRead;
float Leaf(uint i) { return a.third[i] + texture(direct, vec2(0)).x; }
float Middle(uint i) { return Leaf(i) + Leaf(i + 1); }
float Sample(sampler2D map) { return textureLod(map, vec2(0), 0.0).x; }
float NeverCalled() { return texture(unused, vec2(0)).x + float(neverRead.nothing[0]); }
void main() {
    float value = a.second.x;
    if (value > 1.0) value += Middle(1) + Sample(passed);
    imageAtomicAdd(counts, ivec2(0), uint(value));
    b.values[0] = b.values.length();
}
)"),
              (std::vector<std::string>{"a.1", "a.2", "b", "b.1", "counts", "direct", "passed"}))
        << "values.length() names the block as a whole";
}

TEST(StaticUse, IsThatOfAtomicsAndCopies) {
    EXPECT_EQ(UsedBy(R"(#version 460
struct Pair { uint a; uint b; };
layout(binding = 0) buffer Sums { uint sum; } sums;
layout(binding = 1) buffer From { Pair pairs[]; } from;
layout(binding = 2) buffer To { Pair pairs[]; } to;
layout(binding = 3) buffer Indexed { uint value; } indexed[3];
shared uint together;
void main() {
    atomicAdd(sums.sum, 1u);
    to.pairs[0] = from.pairs[1];
    indexed[gl_WorkGroupID.x].value = atomicMax(together, 2u);
}
)"),
              (std::vector<std::string>{"from.0", "indexed", "sums.0", "to.0", "together"}));
}

}  // namespace
}  // namespace raygraph::rhi::static_use_test
