// Tests pictures that several devices render together, and renders that consist of several runs. It needs a
// device, which is opened several times.
#include "editor/session/file/render_file_impl.h"
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
    // Describes a picture with everything that it can have, biases included.
    static SessionDesc Everything() {
        SessionDesc desc;
        desc.settings.size = {24, 16};
        desc.settings.paths.biases.maxDepth = 3;
        desc.settings.paths.biases.clampIndirect = 1.0f;
        desc.settings.lightGroups = {{"lamp", {"*"}}};
        for (const Aov aov : kAovs) desc.aovs.Set(aov, CanHave(aov, desc.settings));
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
    uint64_t Least(uint64_t) override { throw Ended(); }
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
