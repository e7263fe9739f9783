// Tests pictures that several devices render together, and renders that consist of several runs. It needs a
// device, which is opened several times.
#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <thread>

#include "editor/session/file/render_file_parts.h"
#include "editor/session/file/sum_residuals.h"
#include "editor/session/group/block_queue.h"
#include "editor/session/session.h"
#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::session::session_devices_test {

namespace {

class SessionDevicesTest : public testing::VulkanTest {
  protected:
    // Returns the device of the tests, opened `count` times.
    static std::vector<rhi::Device*> Devices(size_t count) {
        static std::vector<std::unique_ptr<rhi::Device>> more;
        while (more.size() + 1 < count) more.push_back(rhi::Device::Create({.savePipelineCache = false}));
        std::vector<rhi::Device*> devices{&Device()};
        for (size_t i = 1; i < count; ++i) devices.push_back(more[i - 1].get());
        return devices;
    }
    // Describes a picture with everything that several devices can share, biases included.
    static SessionDesc Everything() {
        SessionDesc desc;
        desc.settings.size = {24, 16};
        desc.settings.paths.biases.maxDepth = 3;
        desc.settings.paths.biases.clampIndirect = 1.0f;
        desc.settings.lightGroups = {{"lamp", {"*"}}};
        for (const Aov aov : kAovs) desc.aovs.Set(aov, CanHave(aov, desc.settings) && aov != Aov::Denoising);
        return desc;
    }
    static SceneInput Cornell() { return LoadInput(test::SceneFile("cornell.gltf")); }
    static void ExpectSameBits(const RenderFile& a, const RenderFile& b) {
        EXPECT_EQ(a.samples, b.samples);
        EXPECT_EQ(a.measuredError, b.measuredError);
        EXPECT_EQ(a.radiance, b.radiance);
        EXPECT_EQ(a.variance, b.variance);
        EXPECT_EQ(a.removedSamples, b.removedSamples);
        EXPECT_EQ(AovsOf(a), AovsOf(b));
        for (const Aov aov : kAovs) {
            const Texels* mean = MeanOf(a, aov);
            if (mean == nullptr) continue;
            EXPECT_TRUE(*mean == *MeanOf(b, aov)) << Name(aov);
        }
        EXPECT_EQ(a.removedVariance, b.removedVariance);
        EXPECT_EQ(a.lightGroups, b.lightGroups);
        EXPECT_EQ(a.depth, b.depth);
        EXPECT_EQ(a.instance, b.instance);
        EXPECT_EQ(a.material, b.material);
        EXPECT_EQ(a.motion, b.motion);
        RenderFile left = a, right = b;
        const auto ofLeft = AllOf(left.sums), ofRight = AllOf(right.sums);
        ASSERT_EQ(ofLeft.size(), ofRight.size());
        for (size_t i = 0; i < ofLeft.size(); ++i) EXPECT_TRUE(*ofLeft[i] == *ofRight[i]) << "sums " << i;
    }
};

// Acts as the second of two processes up to where it has agreed with the first one on what is rendered; then
// it throws Ended.
class SecondProcess : public ProcessGroup {
  public:
    struct Ended {};
    // `said` holds what the first process broadcasts; with `isFirst`, this is the first one and fills it.
    explicit SecondProcess(std::vector<std::byte>* said, bool isFirst = false)
        : m_said(*said), m_isFirst(isFirst) {}

    uint32_t Rank() const override { return m_isFirst ? 0 : 1; }
    uint32_t Size() const override { return 2; }
    uint32_t LocalRank() const override { return Rank(); }
    uint32_t LocalSize() const override { return 2; }
    void Broadcast(std::span<std::byte> bytes) override {
        if (m_isFirst) {
            m_said.assign(bytes.begin(), bytes.end());
            throw Ended();
        }
        if (m_hasAgreed) throw Ended();
        ASSERT_EQ(bytes.size(), m_said.size());
        std::ranges::copy(m_said, bytes.begin());
        m_hasAgreed = true;
    }
    uint64_t Sum(uint64_t) override { throw Ended(); }
    uint64_t Minimum(uint64_t) override { throw Ended(); }
    void AddAtRoot(passes::ExactSums&) override { throw Ended(); }
    void Deal(BlockDealer*, BlockQueue&, const Tick&) override { throw Ended(); }

  private:
    std::vector<std::byte>& m_said;
    bool m_isFirst, m_hasAgreed = false;
};

}  // namespace

TEST_F(SessionDevicesTest, AProcessWithAnotherSceneOrEnvironment_IsRefused) {
    const auto lit = [](float radiance, const char* name = "sky") {
        SceneInput input = Cornell();
        SetEnvironment(input, {.width = 1, .height = 1, .rgba = {radiance, 1, 1, 1}}, name);
        return input;
    };
    std::vector<std::byte> said;
    const auto begin = [&](SceneInput&& input, bool isFirst) {
        SecondProcess group(&said, isFirst);
        SessionDesc desc = Everything();
        desc.settings.light = DefaultLight::None;  // the processes need not agree on a light
        desc.group = &group;
        const Session session(Device(), std::move(input), desc);
    };
    EXPECT_THROW(begin(lit(1.0f), true), SecondProcess::Ended);
    EXPECT_THROW(begin(lit(1.0f), false), SecondProcess::Ended) << "it goes on with what comes next";
    EXPECT_THROW(begin(lit(1.0f, "elsewhere"), false), SecondProcess::Ended) << "wherever the file is";
    const auto expectRefused = [&](SceneInput input) {
        test::ExpectError(
            ErrorKind::BadInput, [&] { begin(std::move(input), false); }, "process 1 has another scene");
    };
    expectRefused(lit(2.0f));
    expectRefused(Cornell());
    SceneInput other = LoadInput(test::SceneFile("furnace_sphere.gltf"));
    SetEnvironment(other, lit(1.0f).environment, "sky");
    expectRefused(std::move(other));
}

TEST_F(SessionDevicesTest, AnyNumberOfDevicesGivesTheBitsOfOne) {
    Session alone(Device(), Cornell(), Everything());
    alone.Run({.samples = 21});
    for (const size_t count : {2u, 3u}) {
        SCOPED_TRACE(count);
        const auto devices = Devices(count);
        Session together(devices, Cornell(), Everything());
        together.Run({.samples = 9});  // in two runs
        together.Run({.samples = 21});
        ExpectSameBits(together.Result().render, alone.Result().render);
        EXPECT_EQ(together.Result().render.device, alone.Result().render.device);
        EXPECT_EQ(together.Display().rgba, alone.Display().rgba);
        EXPECT_EQ(together.SampleCount(), 21u);
        EXPECT_EQ(together.Result().removed.size(), 2u);
    }
}

// There are more devices than samples.
TEST_F(SessionDevicesTest, DevicesWithoutASampleAddNothing) {
    Session alone(Device(), Cornell(), Everything());
    alone.Run({.samples = 1});
    const auto devices = Devices(3);
    Session together(devices, Cornell(), Everything());
    together.Run({.samples = 1});
    ExpectSameBits(together.Result().render, alone.Result().render);
    EXPECT_EQ(together.Display().rgba, alone.Display().rgba);
}

TEST_F(SessionDevicesTest, ResumedRenderGoesOnOnSeveralDevices) {
    Session alone(Device(), Cornell(), Everything());
    alone.Run({.samples = 5});
    const ResumedRender before{"a.exr", alone.Result().render};
    alone.Run({.samples = 16});
    const auto devices = Devices(2);
    Session together(devices, Cornell(), Resuming(before));
    EXPECT_EQ(together.SampleCount(), 5u);
    together.Run({.samples = 16});
    ExpectSameBits(together.Result().render, alone.Result().render);
}

TEST_F(SessionDevicesTest, ViewsOfSurfacesHaveTheSameBits) {
    for (const View view : {View::Albedo, View::Depth}) {
        SCOPED_TRACE(Name(view));
        SessionDesc desc;
        desc.settings.size = {24, 16};
        desc.settings.view = view;
        Session alone(Device(), Cornell(), desc);
        alone.Run({.samples = 4});
        const auto devices = Devices(2);
        Session together(devices, Cornell(), desc);
        together.Run({.samples = 4});
        EXPECT_EQ(together.Result().render.radiance, alone.Result().render.radiance);
        EXPECT_EQ(together.Display().rgba, alone.Display().rgba);
    }
}

TEST_F(SessionDevicesTest, ProgressCountsUpToAllSamples) {
    const auto devices = Devices(2);
    SessionDesc desc;
    desc.settings.size = {32, 32};
    Session session(devices, Cornell(), desc);
    uint32_t last = 0;
    bool hasSpeed = false;
    const std::thread::id thisThread = std::this_thread::get_id();
    session.Run({.samples = 400}, [&](const ProgressState& state) {
        EXPECT_TRUE(std::this_thread::get_id() == thisThread);
        EXPECT_GE(state.samplesDone, last);
        EXPECT_LE(state.samplesDone, 400u);
        last = state.samplesDone;
        hasSpeed |= state.samplesPerSecond > 0.0;
    });
    EXPECT_TRUE(hasSpeed);
    EXPECT_GT(last, 100u);
    // The next run continues from there
    session.Run({.samples = 420}, [](const ProgressState& state) {
        EXPECT_GE(state.samplesDone, 400u);
        EXPECT_LE(state.samplesDone, 420u);
    });
}

TEST_F(SessionDevicesTest, RunEndsWhenItIsAskedTo) {
    const auto devices = Devices(2);
    SessionDesc desc;
    desc.settings.size = {16, 16};
    Session session(devices, Cornell(), desc);
    const RunSummary stopped = session.Run({.samples = 1u << 30, .isStopRequested = [] { return true; }});
    EXPECT_TRUE(stopped.wasStopped);
    const uint32_t count = session.SampleCount();
    EXPECT_GE(count, 1u);
    EXPECT_EQ(session.Result().render.samples, (SampleRanges{{0, count}}));
    session.Run({.samples = 1u << 30, .seconds = 0.1});
    EXPECT_GT(session.SampleCount(), count);
    EXPECT_LT(session.SampleCount(), 1u << 20);
}

// This holds however a render is divided into runs and devices: the error is measured at the same samples.
TEST_F(SessionDevicesTest, RunsToAnErrorEndAtTheSameSample) {
    SessionDesc desc;
    desc.settings.size = {12, 12};
    const StopRule rule{.samples = 4000, .relativeError = 0.35};
    Session once(Device(), Cornell(), desc);
    once.Run(rule);
    const uint32_t wanted = once.SampleCount();
    ASSERT_GT(wanted, 65u);
    ASSERT_LT(wanted, 4000u);
    ASSERT_TRUE(once.Result().render.measuredError);
    EXPECT_FALSE(std::has_single_bit(wanted)) << "foretold, not only met";

    const auto devices = Devices(2);
    Session together(devices, Cornell(), desc);
    together.Run(rule);
    ExpectSameBits(together.Result().render, once.Result().render);

    // Stops between a measurement and the end that it predicted, and resumes from the file
    Session cut(Device(), Cornell(), desc);
    StopRule fewer = rule;
    fewer.samples = wanted - 1;
    cut.Run(fewer);
    ASSERT_EQ(cut.SampleCount(), wanted - 1);
    const ResumedRender before{"a.exr", cut.Result().render};
    Session resumed(Device(), Cornell(), Resuming(before));
    resumed.Run(rule);
    ExpectSameBits(resumed.Result().render, once.Result().render);
    cut.Run(rule);
    ExpectSameBits(cut.Result().render, once.Result().render);

    // Stops with the last sample, so that nothing is left to do
    Session late(Device(), Cornell(), desc);
    StopRule stopped = rule;
    stopped.isStopRequested = [&] { return late.SampleCount() >= wanted; };
    EXPECT_FALSE(late.Run(stopped).wasStopped);
    ExpectSameBits(late.Result().render, once.Result().render);
}

// A session renders one camera after another, each as a session of its own would.
TEST_F(SessionDevicesTest, NextPictureMayHaveAnotherCamera) {
    const std::string above = "0 1 3.2 0 1 0 0 1 0 30";
    SessionDesc desc;
    desc.settings.size = {16, 12};
    desc.aovs = {Aov::Depth};
    Session session(Device(), Cornell(), desc);
    session.Run({.samples = 3});
    const RenderFile first = session.Result().render;
    session.StartPicture({.camera = above});
    EXPECT_FALSE(session.HasResult());
    EXPECT_EQ(session.SampleCount(), 0u);
    session.Run({.samples = 3});
    const RenderFile second = session.Result().render;
    EXPECT_NE(second.radiance, first.radiance);
    SessionDesc other = desc;
    other.settings.camera = above;
    Session fresh(Device(), Cornell(), other);
    fresh.Run({.samples = 3});
    ExpectSameBits(second, fresh.Result().render);
    EXPECT_EQ(FirstMismatch(second, fresh.Result().render), "");

    // A missing camera changes nothing
    EXPECT_THROW(session.StartPicture({.camera = "top"}), SettingError);
    EXPECT_EQ(session.SampleCount(), 3u);
    session.StartPicture({.camera = ""});
    session.Run({.samples = 3});
    ExpectSameBits(session.Result().render, first);
}

// The next picture may resume a file.
TEST_F(SessionDevicesTest, NextPictureMayBeResumed) {
    SessionDesc desc;
    desc.settings.size = {16, 12};
    Session session(Device(), Cornell(), desc);
    session.Run({.samples = 2});
    const ResumedRender before{"a.exr", session.Result().render};
    session.Run({.samples = 6});
    const RenderFile whole = session.Result().render;
    session.StartPicture({.resumed = &before});
    EXPECT_EQ(session.SampleCount(), 2u);
    session.Run({.samples = 6});
    ExpectSameBits(session.Result().render, whole);
    ResumedRender foreign = before;
    foreign.render.settings["seed"] = "7";
    EXPECT_THROW(session.StartPicture({.resumed = &foreign}), Error);
}

}  // namespace raygraph::session::session_devices_test

// Tests which samples are dealt to which worker.
namespace raygraph::session::block_dealer_test {

namespace {

// Simulates workers of these speeds until everything is dealt; returns the time at which each ends.
std::vector<double> Simulate(SampleRange samples, const std::vector<double>& speeds, double blockSeconds,
                             std::vector<SampleRange>& blocks) {
    BlockDealer dealer(samples, static_cast<uint32_t>(speeds.size()), blockSeconds);
    std::vector<double> busyUntil(speeds.size(), 0.0);
    std::vector<bool> isMeasured(speeds.size(), false), isOver(speeds.size(), false);
    while (true) {
        size_t next = speeds.size();
        for (size_t i = 0; i < speeds.size(); ++i)
            if (!isOver[i] && (next == speeds.size() || busyUntil[i] < busyUntil[next])) next = i;
        if (next == speeds.size()) return busyUntil;
        const auto block = dealer.Next(static_cast<uint32_t>(next), isMeasured[next] ? speeds[next] : 0.0);
        isMeasured[next] = true;
        if (!block) {
            isOver[next] = true;
            continue;
        }
        blocks.push_back(*block);
        busyUntil[next] += block->count / speeds[next];
    }
}

}  // namespace

TEST(BlockDealer, BlocksAreAlignedAndCoverTheSamplesOnce) {
    for (const SampleRange samples : {SampleRange{0, 1000}, {37, 555}, {0xFFFFFF00u, 256}, {5, 1}}) {
        std::vector<SampleRange> blocks;
        Simulate(samples, {90.0, 10.0, 33.0}, 1.0, blocks);
        uint64_t next = samples.first;
        for (const SampleRange& block : blocks) {
            EXPECT_EQ(block.first, next) << "dealt in order";
            EXPECT_TRUE(std::has_single_bit(block.count));
            EXPECT_EQ(block.first % block.count, 0u);
            next = block.End();
        }
        EXPECT_EQ(next, samples.End());
    }
}

// One worker would need a hundred seconds. One that is ten times as fast gets ten times as much, and none
// waits for long.
TEST(BlockDealer, WorkersOfAnySpeedEndTogether) {
    std::vector<SampleRange> blocks;
    const std::vector<double> ends = Simulate({0, 11100}, {100.0, 10.0, 1.0}, 1.0, blocks);
    for (const double end : ends) EXPECT_NEAR(end, 100.0, 2.0);
    EXPECT_LT(blocks.size(), 1200u) << "of 11100 samples";
}

TEST(BlockDealer, LoneWorkerGetsSampleBySample) {
    BlockDealer dealer({8, 3}, 1, 1e9);
    for (uint32_t i = 0; i < 3; ++i) EXPECT_EQ(dealer.Next(0, 1e6), (SampleRange{8 + i, 1}));
    EXPECT_FALSE(dealer.Next(0, 1e6));
}

TEST(BlockDealer, BlocksHaveTheSamplesThatADeviceRendersAtOnce) {
    for (const uint32_t workers : {1u, 3u}) {
        BlockDealer dealer({0, 100}, workers, 1.0, 8);
        std::vector<uint32_t> counts;
        while (const auto block = dealer.Next(0, counts.empty() ? 0.0 : 10.0)) counts.push_back(block->count);
        EXPECT_EQ(counts, (std::vector<uint32_t>{1, 1, 2, 4, 8, 8, 8, 8, 8, 8, 8, 8, 8, 8, 8, 4})) << workers;
    }
}

// Otherwise a request to stop would wait for minutes.
TEST(BlockDealer, SlowWorkersGetFewerSamplesThanADeviceRendersAtOnce) {
    for (const uint32_t workers : {1u, 2u}) {
        BlockDealer dealer({0, 1000}, workers, 1.0, 64);
        EXPECT_EQ(dealer.Next(0, 0.5)->count, 1u);
        EXPECT_EQ(dealer.Next(0, 3.0)->count, 1u) << "aligned";
        EXPECT_EQ(dealer.Next(0, 3.0)->count, 2u);
        EXPECT_EQ(dealer.Next(0, 5.0)->count, 4u);
    }
}

TEST(BlockDealer, StoppedOneDealsTheFirstBlockAndNoMore) {
    BlockDealer dealer({0, 100}, 2, 1.0);
    dealer.Stop();
    EXPECT_TRUE(dealer.Next(0, 0.0));
    EXPECT_FALSE(dealer.Next(1, 0.0));
    EXPECT_EQ(dealer.DealtCount(), 1u);
}

TEST(BlockDealer, CountsAsDoneWhatItsWorkerHasAskedAfter) {
    BlockDealer dealer({0, 100}, 2, 1.0);
    dealer.Next(0, 0.0);
    dealer.Next(1, 0.0);
    EXPECT_EQ(dealer.DealtCount(), 2u);
    EXPECT_EQ(dealer.DoneCount(), 0u);
    const auto block = dealer.Next(0, 16.0);
    ASSERT_TRUE(block);
    EXPECT_EQ(dealer.DoneCount(), 1u);
    EXPECT_EQ(dealer.DealtCount(), 2u + block->count);
}

TEST(BlockQueue, AnswersEveryDeviceAndRethrowsTheErrorOfOne) {
    BlockQueue queue(2);
    std::vector<SampleRange> got;
    std::jthread works([&] {
        while (const auto block = queue.Next(0, 1.0)) got.push_back(*block);
    });
    std::jthread fails([&] { queue.Fail(1, std::make_exception_ptr(std::runtime_error("lost"))); });
    uint32_t answered = 0;
    while (!queue.IsOver()) {
        const auto request = queue.TakeRequest(std::chrono::milliseconds(10));
        if (!request) continue;
        EXPECT_EQ(request->device, 0u);
        if (answered < 3)
            queue.Answer(0, SampleRange{answered++, 1});
        else
            queue.Answer(0, std::nullopt);
    }
    works.join();
    EXPECT_EQ(got, (std::vector<SampleRange>{{0, 1}, {1, 1}, {2, 1}}));
    EXPECT_TRUE(queue.HasFailed());
    EXPECT_THROW(queue.RethrowError(), std::runtime_error);
}

TEST(BlockQueue, ClosedOneLetsWaitingDevicesGo) {
    BlockQueue queue(1);
    std::optional<SampleRange> answer{SampleRange{1, 1}};
    std::jthread waits([&] { answer = queue.Next(0, 1.0); });
    ASSERT_TRUE(queue.TakeRequest(std::chrono::seconds(10)));  // it waits now
    queue.Close();
    waits.join();
    EXPECT_FALSE(answer);
    EXPECT_TRUE(queue.IsOver());
}

}  // namespace raygraph::session::block_dealer_test

namespace raygraph::session::sum_residuals_test {
namespace {

constexpr uint32_t kWidth = 7;

PredictedSums Back(const SumResiduals& residuals, size_t channels, uint32_t width,
                   const SumPrediction& prediction) {
    std::array<std::span<const uint32_t>, kSumWordCount> words;
    for (size_t i = 0; i < kSumWordCount; ++i) words[i] = residuals.words[i];
    return SumsOf(words, channels, width, prediction, 5);
}

// Returns the sums of samples of which some are dark, some bright, some negative.
passes::ExactSums SumsOfSamples(size_t pixels, uint32_t count) {
    std::mt19937 random(count);
    passes::ExactSums sums = passes::MakeExactSums(pixels, true);
    for (uint32_t n = 0; n < count; ++n) {
        Texels sample(4 * pixels);
        for (float& value : sample)
            value = std::ldexp(static_cast<float>(random()) / 4294967296.0f - 0.2f,
                               static_cast<int>(random() % 12) - 6);
        passes::AddSample(sums, sample);
    }
    return sums;
}

size_t WordsOf(const SumResiduals& residuals, bool ofSquares, bool onlyNonZero) {
    size_t words = 0;
    for (size_t i = 0; i < kSumWordCount; ++i) {
        const LargeArray<uint32_t>& of = residuals.words[i];
        const bool isAnything = std::ranges::any_of(of, [](uint32_t word) { return word != 0; });
        if (kSumWords[i].isSquareSum == ofSquares && !of.empty() && (isAnything || !onlyNonZero))
            words = std::max(words, kSumWords[i].word + 1);
    }
    return words;
}

TEST(SumResiduals, OfOneSampleThereAreNone) {
    const passes::ExactSums sums = SumsOfSamples(3 * kWidth, 1);
    const Texels mean = passes::MeanOf(sums, 1), variance = passes::VarianceOf(sums, 1);
    const std::vector<uint32_t> counts{1};
    const SumResiduals residuals = ResidualsOf(sums, 4, kWidth, {mean, variance, counts}, 5);
    EXPECT_EQ(WordsOf(residuals, false, true), 0u);
    EXPECT_EQ(WordsOf(residuals, true, true), 0u);
    // The lowest words tell that there are sums
    EXPECT_EQ(WordsOf(residuals, false, false), 1u);
    EXPECT_EQ(WordsOf(residuals, true, false), 1u);
    EXPECT_EQ(Back(residuals, 4, kWidth, {mean, variance, counts}).sums, sums);
}

TEST(SumResiduals, TakeTwoWordsWhereSumsTakeFour) {
    constexpr uint32_t kCount = 512;
    const passes::ExactSums sums = SumsOfSamples(3 * kWidth, kCount);
    const Texels mean = passes::MeanOf(sums, kCount), variance = passes::VarianceOf(sums, kCount);
    const std::vector<uint32_t> counts{kCount};
    const SumResiduals residuals = ResidualsOf(sums, 4, kWidth, {mean, variance, counts}, 5);
    EXPECT_EQ(WordsOf(residuals, false, true), 2u);
    EXPECT_EQ(WordsOf(residuals, true, true), 2u);
    const PredictedSums back = Back(residuals, 4, kWidth, {mean, variance, counts});
    EXPECT_EQ(back.sums, sums);
    EXPECT_EQ(back.digest, residuals.digest);
}

// Programs may have stored anything as mean and variance.
TEST(SumResiduals, GiveSumsBackWhateverIsPredicted) {
    constexpr size_t kPixels = 300 * kWidth;
    std::mt19937 generator(1);
    const auto random = [&] { return static_cast<uint32_t>(generator()); };
    passes::ExactSums sums = passes::MakeExactSums(kPixels, true);
    for (auto* planes : {&sums.sums, &sums.squares})
        for (passes::ExactSums::Plane& plane : *planes)
            for (uint32_t& word : plane) word = random() % 3 == 0 ? 0xFFFFFFFFu : random() % 2 * random();
    for (size_t i = 0; i < kPixels; ++i) sums.squares[3][4 * i + 3] = 0;  // unused
    Texels mean(4 * kPixels), variance(4 * kPixels);
    for (Texels* texels : {&mean, &variance})
        for (float& value : *texels) value = std::bit_cast<float>(random());
    mean[0] = variance[0] = std::numeric_limits<float>::quiet_NaN();
    mean[1] = variance[1] = std::numeric_limits<float>::infinity();
    mean[2] = variance[2] = -std::numeric_limits<float>::max();
    mean[4] = variance[4] = std::numeric_limits<float>::denorm_min();
    std::vector<uint32_t> counts(kPixels);
    for (uint32_t& count : counts) count = random() % 4 == 0 ? random() % 2 : random();
    counts[0] = counts[1] = 0xFFFFFFFFu;
    const SumPrediction prediction{mean, variance, counts};
    const PredictedSums back = Back(ResidualsOf(sums, 4, kWidth, prediction, 5), 4, kWidth, prediction);
    for (size_t k = 0; k < passes::ExactSums::kPlanes; ++k) {
        EXPECT_EQ(back.sums.sums[k], sums.sums[k]) << k;
        EXPECT_EQ(back.sums.squares[k], sums.squares[k]) << k;
    }
}

// Large pictures are processed by several threads.
TEST(SumResiduals, OfLargePicturesAreThoseOfTheirRows) {
    constexpr uint32_t kLargeWidth = 1000, kHeight = 300;
    const passes::ExactSums sums = SumsOfSamples(size_t{kLargeWidth} * kHeight, 3);
    const Texels mean = passes::MeanOf(sums, 3), variance = passes::VarianceOf(sums, 3);
    const std::vector<uint32_t> counts{3};
    const SumResiduals residuals = ResidualsOf(sums, 4, kLargeWidth, {mean, variance, counts}, 5);
    const PredictedSums back = Back(residuals, 4, kLargeWidth, {mean, variance, counts});
    EXPECT_TRUE(back.sums == sums);
    EXPECT_EQ(back.digest, residuals.digest);
    const auto rowOf = [&](const passes::ExactSums::Plane& plane, size_t y) {
        return passes::ExactSums::Plane(plane.begin() + 4 * y * kLargeWidth,
                                        plane.begin() + 4 * (y + 1) * kLargeWidth);
    };
    for (const size_t y : {size_t{0}, size_t{149}, size_t{150}, size_t{kHeight - 1}}) {
        passes::ExactSums row;
        for (size_t k = 0; k < passes::ExactSums::kPlanes; ++k) {
            row.sums[k] = rowOf(sums.sums[k], y);
            row.squares[k] = rowOf(sums.squares[k], y);
        }
        const size_t first = 4 * y * kLargeWidth, size = 4 * kLargeWidth;
        const SumResiduals ofRow = ResidualsOf(
            row, 4, kLargeWidth,
            {std::span(mean).subspan(first, size), std::span(variance).subspan(first, size), counts}, 5);
        for (size_t i = 0; i < kSumWordCount; ++i) {
            if (ofRow.words[i].empty()) continue;
            const auto inPicture = std::span(residuals.words[i]).subspan(y * kLargeWidth, kLargeWidth);
            EXPECT_TRUE(std::ranges::equal(ofRow.words[i], inPicture)) << "row " << y << ", word " << i;
        }
    }
}

TEST(SumResiduals, OtherSumsHaveOtherDigests) {
    passes::ExactSums sums = SumsOfSamples(3 * kWidth, 4);
    const Texels mean = passes::MeanOf(sums, 4);
    const std::vector<uint32_t> counts{4};
    const auto digest = [&](size_t channels, uint64_t seed) {
        return ResidualsOf(sums, channels, kWidth, {mean, {}, counts}, seed).digest;
    };
    const uint64_t first = digest(4, 5);
    EXPECT_EQ(digest(4, 5), first);
    EXPECT_NE(digest(3, 5), first);
    EXPECT_NE(digest(4, 6), first);
    sums.sums[0][11] ^= 1u;
    EXPECT_NE(digest(4, 5), first);
}

}  // namespace
}  // namespace raygraph::session::sum_residuals_test
