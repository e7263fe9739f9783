#include <gtest/gtest.h>

#include "base/error.h"
#include "rhi/reflection.h"
#include "rhi/shader_compiler.h"
#include "tests/support/error_of.h"

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
