// Tests the threading contract of the public headers. The counts that are asserted here prove little; `./dev
// tsan` runs these tests under ThreadSanitizer, which finds the races.
#include <gtest/gtest.h>

#include <atomic>
#include <deque>
#include <mutex>
#include <set>
#include <thread>

#include "base/error.h"
#include "base/files.h"
#include "editor/viewport/viewport.h"
#include "passes/tonemap.h"
#include "renderer/graph/pass_harness.h"
#include "renderer/image/exr.h"
#include "renderer/image/image.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "rhi/command_list.h"
#include "rhi/shader_compiler.h"
#include "rhi/texture_table.h"
#include "rhi/transfer.h"
#include "shaders/embedded.h"
#include "tests/support/source_file.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::threads_test {
namespace {

class Threads : public VulkanTest {};

std::string SceneFile(const std::string& name) {
    return (test::SourceFile("scenes") / name).string();
}

// Hands scenes from the thread that loads them to the one that renders.
class Loaded {
  public:
    void Put(scene::SceneData&& data) {
        const std::lock_guard lock(m_mutex);
        m_scenes.push_back(std::move(data));
    }
    std::optional<scene::SceneData> Take() {
        const std::lock_guard lock(m_mutex);
        if (m_scenes.empty()) return std::nullopt;
        std::optional<scene::SceneData> data(std::move(m_scenes.front()));
        m_scenes.pop_front();
        return data;
    }

  private:
    std::mutex m_mutex;
    std::deque<scene::SceneData> m_scenes;
};

// Tone-maps a picture by a Renderer of its own, and reads it back.
void ToneMapOnce(PassHarness& harness, float exposure) {
    const Texels texels = harness.Run([&](PassHarness& h) {
        const TextureId radiance =
            h.Texture("radiance", {4, 4}, Format::Rgba32Float, {0.5f, 0.5f, 0.5f, 1.0f});
        return passes::Tonemap(h.Graph(), radiance, {.exposureEv = exposure});
    });
    EXPECT_GT(texels.At(3, 3)[0], 0.0f);
}

TEST_F(Threads, ScenesAreLoaded_BesideTheThreadThatRenders) {
    const std::vector<std::string> files{"cornell.gltf", "texture_orientation.gltf", "missing.gltf",
                                         "small_light.gltf", "cornell.gltf"};
    Loaded loaded;
    std::atomic<uint32_t> refused = 0;
    std::atomic<float> progress = 0.0f;
    std::atomic<bool> isDone = false;
    std::thread loader([&] {
        for (const std::string& file : files) try {
                scene::LoadOptions options;
                options.progress = [&](std::string_view, float fraction) { progress = fraction; };
                loaded.Put(scene::LoadGltf(SceneFile(file), options));
            } catch (const Error& error) {
                EXPECT_EQ(error.Kind(), ErrorKind::Io);
                ++refused;
            }
        isDone = true;
    });

    Renderer renderer(Device());
    GpuScene scene(renderer);
    viewport::Viewport viewport(renderer, scene, {.size = {8, 8}});
    viewport::PathSettings paths;
    paths.scattering.brdf = BrdfModel::Lambert;
    viewport.SetPaths(paths);
    size_t shown = 0;
    for (bool wasDone = false; !wasDone;) {
        wasDone = isDone;  // before the last look
        while (std::optional<scene::SceneData> data = loaded.Take()) {
            viewport.SetCamera(scene::ChooseView(*data, "", 1.0f));
            scene.SetScene(std::move(*data));
            ++shown;
            viewport.RenderFrame();
        }
        viewport.RenderFrame();
        EXPECT_LE(progress, 1.0f);
    }
    loader.join();
    EXPECT_EQ(shown, files.size() - 1);
    EXPECT_EQ(refused, 1u);
    EXPECT_GT(viewport.Progress().pathTracedSamples, 0u);
}

// The callback is the host's: all of these threads call it, as its lock requires.
TEST_F(Threads, MessagesComeFromEveryThreadThatDoesTheWork) {
    std::mutex mutex;
    std::set<std::thread::id> speakers;
    std::atomic<uint32_t> count = 0;
    const auto note = [&](const LogMessage&) {
        ++count;
        const std::lock_guard lock(mutex);
        speakers.insert(std::this_thread::get_id());
    };
    const raygraph::Log log(note, LogLevel::Debug);
    const std::unique_ptr<rhi::Device> device =
        rhi::Device::Create({.name = "told", .log = log, .savePipelineCache = false});
    const auto load = [&] {
        scene::LoadOptions options;
        options.log = log;
        for (int i = 0; i < 4; ++i) scene::LoadGltf(SceneFile("small_light.gltf"), options);
    };
    const auto render = [&] {
        PassHarness harness(*device);
        ToneMapOnce(harness, 1.0f);
    };
    std::vector<std::thread> others;
    for (int i = 0; i < 2; ++i) others.emplace_back(load);
    others.emplace_back(render);
    render();
    for (std::thread& other : others) other.join();
    EXPECT_EQ(speakers.size(), 4u) << "this thread, two that load and one that renders";
    EXPECT_GE(count, 8u + 2u + 1u);
}

TEST_F(Threads, RenderersOfOneDevice_RunAtOnce) {
    const auto run = [&] {
        PassHarness harness(Device());
        for (int frame = 0; frame < 12; ++frame) ToneMapOnce(harness, 0.1f * float(frame));
    };
    std::thread other(run);
    run();
    other.join();
}

// A thread polls each readback of the rendering thread, reads it and releases it, whether its frame ran or
// was dropped.
TEST_F(Threads, ReadbacksArePolled_BesideTheThreadThatRenders) {
    constexpr uint32_t kFrames = 24;
    std::mutex mutex;
    std::deque<std::pair<Readback, uint32_t>> queue;
    std::atomic<bool> isDone = false;
    std::atomic<uint32_t> readCount = 0;
    std::thread reader([&] {
        std::deque<std::pair<Readback, uint32_t>> polled;
        for (bool wasDone = false; !wasDone || !polled.empty();) {
            wasDone = isDone;
            {
                const std::lock_guard lock(mutex);
                polled.insert(polled.end(), queue.begin(), queue.end());
                queue.clear();
            }
            std::erase_if(polled, [&](const auto& entry) {
                if (!entry.first.IsReady()) return wasDone;
                EXPECT_EQ(As<uint32_t>(entry.first.Bytes()), std::vector<uint32_t>(16, entry.second));
                ++readCount;
                return true;
            });
        }
    });
    Renderer renderer(Device());
    for (uint32_t frame = 0; frame < kFrames; ++frame) {
        renderer.BeginFrame();
        BufferId buffer = renderer.CreateBuffer("values", {.size = 64});
        renderer.AddPass(
            "Fill", PassKind::Transfer, [&](PassBuilder& pass) { buffer = pass.CopiesTo(buffer); },
            [buffer, frame](CommandList& commands, const PassResources& resources) {
                commands.Fill(resources.Buffer(buffer), frame);
            });
        const Readback readback = renderer.ReadBack(buffer);
        {
            const std::lock_guard lock(mutex);
            queue.emplace_back(readback, frame);
        }
        if (frame % 4 == 3)
            renderer.DropFrame();
        else
            renderer.Execute();
    }
    Device().WaitIdle();
    isDone = true;
    reader.join();
    EXPECT_EQ(readCount, kFrames - kFrames / 4);
}

TEST_F(Threads, ObjectsComeAndGo_BesideFrames) {
    std::atomic<bool> isDone = false;
    const rhi::Texture gray =
        Device().CreateTexture({.name = "gray",
                                .extent = {1, 1},
                                .usage = rhi::TextureUsage::Sampled | rhi::TextureUsage::CopyDestination});
    const rhi::Sampler sampler = Device().CreateSampler({});
    {
        rhi::Uploader uploader(Device());
        uploader.UploadTexture(gray, BytesOf(std::vector<uint8_t>(4, 128)));
        Device().WaitFor(uploader.Flush());
    }
    rhi::TextureTable table(Device(), 4096, gray, sampler);
    std::thread maker([&] {
        while (!isDone) {
            const rhi::Buffer buffer = Device().CreateBuffer(
                {.name = "short-lived", .size = 256, .usage = rhi::BufferUsage::CopyDestination});
            rhi::CommandList commands = Device().BeginCommands("fill");
            commands.Fill(buffer, 7);
            const rhi::Submission filled = Device().Submit(std::move(commands));
            table.Remove(table.Add(gray, sampler));
            Device().WaitFor(filled);
            EXPECT_GE(Device().CompletedValue(), filled.value);
        }
    });
    std::thread uploads([&] {
        const rhi::Buffer buffer = Device().CreateBuffer(
            {.name = "uploaded",
             .size = 4096,
             .usage = rhi::BufferUsage::CopyDestination | rhi::BufferUsage::CopySource});
        rhi::Uploader uploader(Device());
        for (uint32_t value = 1; !isDone; ++value) {
            const std::vector<uint32_t> words(1024, value);
            uploader.UploadBuffer(buffer, 0, BytesOf(words));
            Device().WaitFor(uploader.Flush());
            EXPECT_EQ(As<uint32_t>(rhi::ReadBuffer(Device(), buffer)), words);
        }
    });
    PassHarness harness(Device());
    for (int frame = 0; frame < 12; ++frame) ToneMapOnce(harness, 0.0f);
    isDone = true;
    maker.join();
    uploads.join();
    Device().WaitIdle();
    EXPECT_EQ(table.Count(), 0u);
}

TEST(ThreadsWithoutADevice, ShadersCompileAtOnce) {
    const auto run = [] {
        const auto words = rhi::CompileGlsl(
            {.name = "a.comp",
             .text =
                 "#version 460\nlayout(local_size_x = 4) in;\nlayout(binding = 0) buffer B { uint b[]; };\n"
                 "void main() { b[gl_GlobalInvocationID.x] = 1; }\n"});
        EXPECT_EQ(rhi::Reflect(words).bindings.size(), 1u);
        for (const EmbeddedShader& shader : EmbeddedShaders().first(8))
            EXPECT_NO_THROW(rhi::Reflect(shader.Words(), shader.name));
        EXPECT_FALSE(rhi::Requirements().extensions.empty());
    };
    std::vector<std::thread> threads;
    for (int i = 0; i < 3; ++i) threads.emplace_back(run);
    for (std::thread& thread : threads) thread.join();
}

TEST(ThreadsWithoutADevice, PicturesAndScenesAreReadAtOnce) {
    const test::TemporaryFolder folder;
    const image::ImageF picture{.width = 32, .height = 8, .rgba = std::vector<float>(32 * 8 * 4, 0.5f)};
    image::WriteHdr(folder / "picture.hdr", picture);
    const auto run = [&](int index) {
        const std::filesystem::path own = folder / ("own" + std::to_string(index) + ".png");
        image::WritePng(own, {.width = 3, .height = 5, .rgba = std::vector<uint8_t>(3 * 5 * 4, 9)});
        EXPECT_EQ(image::DecodeImage8(ReadFile(own), "own").height, 5u);
        const std::filesystem::path exr = folder / ("own" + std::to_string(index) + ".exr");
        image::WriteExr(exr, picture.width, picture.height,
                        std::vector<image::ExrPlane>{{"R", std::span<const float>(picture.rgba), 4}});
        EXPECT_EQ(image::ReadExr(exr).width, picture.width);
        EXPECT_EQ(image::ReadEnvironment(folder / "picture.hdr").image.height, 8u);
        EXPECT_EQ(scene::LoadGltf(SceneFile("texture_orientation.gltf")).images.empty(), false);
    };
    std::vector<std::thread> threads;
    for (int i = 0; i < 3; ++i) threads.emplace_back(run, i);
    for (std::thread& thread : threads) thread.join();
}

}  // namespace
}  // namespace raygraph::testing::threads_test
