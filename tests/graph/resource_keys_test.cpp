// Frames share resources by description: these tests show that a difference in any field gives another
// resource.
#include <algorithm>
#include <memory>
#include <tuple>

#include "renderer/graph/persistent_store.h"
#include "renderer/graph/transient_pool.h"
#include "tests/graph/graph_test.h"
#include "tests/rhi/fake_loader.h"
#include "tests/support/option_rows.h"

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
};

const Row<BufferDesc> kOfBuffers[] = {
    {"name", [](BufferDesc& d) { d.name = "other"; }},
    {"size", [](BufferDesc& d) { d.size = 128; }},
    {"usage", [](BufferDesc& d) { d.usage = d.usage | BufferUsage::Index; }},
    {"upload", [](BufferDesc& d) { d.memory = rhi::MemoryKind::Upload; }},
    {"readback", [](BufferDesc& d) { d.memory = rhi::MemoryKind::Readback; }},
    {"own memory", [](BufferDesc& d) { d.hasOwnMemory = true; }},
};

// One other value stands for all formats or usages, because they are compared as numbers.
template <typename Enum>
uint64_t Number(Enum value) {
    return static_cast<uint64_t>(value);
}
auto FieldsOf(TextureDesc& s) {
    auto& [name, extent, format, usage, mipLevels, layers] = s;
    return std::tuple(name, extent, Number(format), Number(usage), mipLevels, layers);
}
auto FieldsOf(BufferDesc& s) {
    auto& [name, size, usage, memory, hasOwnMemory] = s;
    return std::tuple(name, size, Number(usage), memory, hasOwnMemory);
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
    const rhi::Texture* texture = &pool.Place(kTexture, 0, frame);
    const rhi::Buffer* buffer = &pool.Place(kBuffer, 0, frame);
    EXPECT_EQ(&pool.Place(kTexture, 0, ++frame), texture);
    EXPECT_EQ(&pool.Place(kBuffer, 0, frame), buffer);
    ForEachChange(
        kTexture, kOfTextures, [](TextureDesc& s) { return FieldsOf(s); },
        [&](const TextureDesc& changed) { EXPECT_NE(&pool.Place(changed, 0, ++frame), texture); });
    ForEachChange(
        kBuffer, kOfBuffers, [](BufferDesc& s) { return FieldsOf(s); },
        [&](const BufferDesc& changed) {
            if (changed.memory != kBuffer.memory) return;  // it is not placed in the block
            EXPECT_NE(&pool.Place(changed, 0, ++frame), buffer);
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
