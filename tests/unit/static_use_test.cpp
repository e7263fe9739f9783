// Tests which resources entry points use, beyond what SPIRV-Cross reports.
#include "rhi/stage_set.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <spirv_cross.hpp>
#include <string>
#include <vector>

#include "rhi/shader_compiler.h"
#include "shaders/embedded.h"

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
