// Tables on the device of which few, many or all records change: always what the host has.
#include "renderer/gpu_scene/record_table.h"

#include <algorithm>
#include <cstring>
#include <numeric>

#include "renderer/graph/readback_values.h"
#include "tests/rhi/gate.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::record_table_test {
namespace {

constexpr uint32_t kCount = 1000;
using Record = std::array<uint32_t, 6>;

// A table of items with two records each, in another order than theirs, and what should be in it.
class RecordTableTest : public VulkanTest {
  protected:
    RecordTableTest() : records(kCount), places(kCount) {
        table.SetCount(kCount);
        for (uint32_t i = 0; i < kCount; ++i) {
            places[i] = i * 37 % kCount;
            Change(i);
        }
    }
    void Change(uint32_t record) {
        for (uint32_t word = 0; word < 6; ++word) records[record][word] = 0x01000193u * ++m_last + word;
        if (std::ranges::count(changed, record / 2) > 0) return;
        changed.push_back(record / 2);
    }
    // So many items.
    void ChangeSome(uint32_t count) {
        for (uint32_t i = 0; i < count; ++i)
            for (uint32_t k = 0; k < 2; ++k) Change(2 * ((i * 611 + 7) % (kCount / 2)) + k);
    }
    BufferId Declare() {
        return table.DeclareUpload(renderer, table.Import(renderer),
                                   {.prepare = [this] { ++prepared; },
                                    .changed = 2 * changed.size(),
                                    .write =
                                        [this](bool areAll, RecordTable::Writer& writer) {
                                            for (uint32_t i = 0; areAll && i < kCount / 2; ++i)
                                                Write(i, writer);
                                            for (size_t i = 0; !areAll && i < changed.size(); ++i)
                                                Write(changed[i], writer);
                                        },
                                    .done = [this] { changed.clear(); }});
    }
    void Write(uint32_t item, RecordTable::Writer& writer) {
        for (const uint32_t record : {2 * item, 2 * item + 1}) {
            ++written;
            const std::span<std::byte> target = writer.At(places[record]);
            ASSERT_EQ(target.size(), sizeof(Record));
            std::memcpy(target.data(), &records[record], sizeof(Record));
        }
    }
    // What the device has after a frame, by record.
    std::vector<Record> Frame() {
        prepared = written = 0;
        renderer.BeginFrame();
        const Readback readback = renderer.ReadBack(Declare());
        renderer.Execute();
        const auto inPlace = WaitForValues<Record>(readback);
        std::vector<Record> values(kCount);
        for (uint32_t i = 0; i < kCount; ++i) values[i] = inPlace.at(places[i]);
        return values;
    }
    bool IsScattered() const { return renderer.DescribePlan().find("scattered") != std::string::npos; }

    RendererLease lent{Device()};
    Renderer& renderer = *lent;
    RecordTable table{Device(),
                      {.name = "records",
                       .passName = "UploadRecords",
                       .recordBytes = sizeof(Record),
                       .capacity = kCount,
                       .usage = rhi::BufferUsage::CopySource}};
    std::vector<Record> records;
    std::vector<uint32_t> places;
    std::vector<uint32_t> changed;  // items
    uint32_t prepared = 0, written = 0;

  private:
    uint32_t m_last = 0;
};

}  // namespace

TEST_F(RecordTableTest, FewManyAndAllAreWhatTheHostHas) {
    EXPECT_EQ(Frame(), records) << "all at first";
    EXPECT_EQ(written, kCount);
    for (const uint32_t count : {1u, 5u, 16u, 17u, 63u, 64u, 65u, 200u, 250u, 251u, 499u, 500u}) {
        SCOPED_TRACE(count);
        ChangeSome(count);
        EXPECT_EQ(Frame(), records);
        EXPECT_EQ(prepared, 1u);
        EXPECT_EQ(written, count > 250 ? kCount : 2 * count);
        EXPECT_EQ(IsScattered(), count > 16 && count <= 250);
    }
    EXPECT_EQ(Frame(), records);
    EXPECT_EQ(prepared, 0u) << "nothing has changed";
}

TEST_F(RecordTableTest, WhatIsChangedTwiceIsWrittenOnce) {
    Frame();
    for (int i = 0; i < 3; ++i) ChangeSome(40);
    EXPECT_EQ(Frame(), records);
    EXPECT_EQ(written, 80u);
}

TEST_F(RecordTableTest, DroppedAndCulledChangesStayDue) {
    Frame();
    for (const uint32_t count : {3u, 100u, 400u}) {
        SCOPED_TRACE(count);
        ChangeSome(count);
        renderer.BeginFrame();
        (void)Declare();
        renderer.DropFrame();
        renderer.BeginFrame();
        (void)Declare();
        renderer.Execute();  // leads to no root
        EXPECT_FALSE(changed.empty());
        Change(500);
        EXPECT_EQ(Frame(), records);
        EXPECT_TRUE(changed.empty());
    }
}

// More workgroups than every device dispatches at once.
TEST_F(RecordTableTest, MoreThanOneDispatchScattersAreCopied) {
    constexpr uint32_t kMany = 65'536 * 128;
    RecordTable large(Device(), {.name = "words",
                                 .passName = "UploadWords",
                                 .recordBytes = 4,
                                 .capacity = 2 * kMany,
                                 .usage = rhi::BufferUsage::CopySource});
    large.SetCount(2 * kMany);
    for (const uint32_t due : {0u, kMany}) {
        renderer.BeginFrame();
        const BufferId words =
            large.DeclareUpload(renderer, large.Import(renderer),
                                {.changed = due, .write = [&](bool areAll, RecordTable::Writer& writer) {
                                     for (uint32_t i = 0; i < (areAll ? 2 * kMany : kMany); ++i) {
                                         const uint32_t value = i + due;
                                         std::memcpy(writer.At(i).data(), &value, 4);
                                     }
                                 }});
        const Readback readback = renderer.ReadBack(words);
        renderer.Execute();
        const auto values = WaitForValues<uint32_t>(readback);
        EXPECT_EQ(values.front(), due);
        EXPECT_EQ(values[kMany - 1], kMany - 1 + due);
    }
}

// Without layers, as what waits for a gate.
TEST(FrameStagingTest, MemoryIsUsedAgainOnceTheDeviceHasReadIt) {
    const std::unique_ptr<rhi::Device> device = rhi::Device::Create({.savePipelineCache = false});
    FrameStaging staging(*device, "staging");
    const std::byte* const first = staging.Take(1000).Mapped().data();
    EXPECT_EQ(staging.Take(500).Mapped().data(), first) << "its frame was dropped";
    Gate gate(*device);
    const rhi::SemaphoreUse wait = gate.At(1);
    const uint64_t busy = device->Submit(device->BeginCommands("reads it"), {&wait, 1});
    staging.MarkSubmitted();
    const std::byte* const second = staging.Take(1000).Mapped().data();
    EXPECT_NE(second, first);
    EXPECT_EQ(staging.Take(1000).Mapped().data(), second);
    gate.Open();
    device->WaitFor(busy);
    EXPECT_EQ(staging.Take(1000).Mapped().data(), first);
    EXPECT_GE(staging.Take(5000).Size(), 5000u);
}

}  // namespace raygraph::testing::record_table_test
