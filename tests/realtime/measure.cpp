// Measures the real-time view: raygraph_measure_real_time SCENE [option=value]...
//   size=WxH        pixels; 320x180
//   env=FILE        an environment map
//   distance=M      from the camera to the axis that it orbits; half of that to the middle of the scene
//   degrees=D       per frame; 0.5
//   clip=N          plays that animation, 60 frames a second, while the camera orbits
//   emission=F      the first emitting material becomes so much brighter in each moving frame, from the frame `from`
//                   (0) to the one before `to` (16)
//   samples=N       of the reference; 1024
//   reference=FILE  where it is kept: read if it exists, else written
//   passes=1        prints GPU times of passes, too, and the memory that the first filtered frame adds
//   stop=1          prints the relMSE of two frames after the stop, and of the mean of three samples
//   hand-over=1     prints the relMSE of the still picture, of the mean of some samples, and of both handed over
//   shaders=FOLDER  of the shaders' sources, to try changes
//   pictures=PREFIX writes PREFIX-raw.png, -real-time.png, -reference.png and -error.png: white where the error
//                   is ten times the mean or more
// The camera orbits for 16 frames and then stands still for 48. Prints a line of a table: the relMSE of the raw sample and
// of the picture after the 16th frame, FLIP, SSIM, energy, flicker of both after 32 still frames, and the time of
// a frame while moving.
#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <deque>
#include <exception>
#include <fstream>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "passes/accumulate.h"
#include "passes/compare.h"
#include "passes/flip.h"
#include "passes/real_time.h"
#include "passes/tonemap.h"
#include "passes/trace.h"
#include "renderer/gpu_scene/camera_record.h"
#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/graph/pass_harness.h"
#include "renderer/graph/readback_values.h"
#include "renderer/image/image.h"
#include "renderer/scene/animation/deform.h"
#include "renderer/scene/animation/pose.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/model/camera_view.h"
#include "rhi/device.h"

using namespace raygraph;  // NOLINT: a program

namespace {

constexpr int kMovingFrames = 16, kStillFrames = 48, kFlickerFrom = 32;

using Picture = std::vector<float>;  // RGBA

double RelativeSquaredError(const Picture& test, const Picture& reference) {
    double sum = 0.0;
    for (size_t i = 0; i < test.size(); ++i) {
        if (i % 4 == 3) continue;
        const double difference = double(test[i]) - reference[i];
        sum += difference * difference / (double(reference[i]) * reference[i] + 0.01);
    }
    return sum / (0.75 * static_cast<double>(test.size()));
}

// Returns the relative squared error of each pixel, as gray values: white for ten times the mean.
std::vector<uint8_t> ShownError(const Picture& test, const Picture& reference) {
    const double most = 10.0 * RelativeSquaredError(test, reference);
    std::vector<uint8_t> shown;
    for (size_t i = 0; i < test.size(); i += 4) {
        const double error =
            RelativeSquaredError({&test[i], &test[i] + 4}, {&reference[i], &reference[i] + 4});
        const auto gray = static_cast<uint8_t>(255.0 * std::sqrt(std::min(error / most, 1.0)));
        shown.insert(shown.end(), {gray, gray, gray, 255});
    }
    return shown;
}

double Energy(const Picture& picture) {
    double sum = 0.0;
    for (size_t i = 0; i < picture.size(); ++i) sum += i % 4 == 3 ? 0.0 : picture[i];
    return sum;
}

// Wang et al. 2004, "Image Quality Assessment", over windows of 8 x 8 of the displayed gray.
double Ssim(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b, Extent2D extent) {
    const auto gray = [&](const std::vector<uint8_t>& p, size_t x, size_t y) {
        const uint8_t* t = &p[4 * (y * extent.width + x)];
        return 0.2126 * t[0] + 0.7152 * t[1] + 0.0722 * t[2];
    };
    double sum = 0.0, count = 0.0;
    for (size_t y = 0; y + 8 <= extent.height; y += 4)
        for (size_t x = 0; x + 8 <= extent.width; x += 4, count += 1.0) {
            double ma = 0, mb = 0, aa = 0, bb = 0, ab = 0;
            for (size_t j = 0; j < 8; ++j)
                for (size_t i = 0; i < 8; ++i) {
                    const double va = gray(a, x + i, y + j), vb = gray(b, x + i, y + j);
                    ma += va / 64, mb += vb / 64, aa += va * va / 64, bb += vb * vb / 64, ab += va * vb / 64;
                }
            const double c1 = 2.55 * 2.55, c2 = 7.65 * 7.65;
            sum += (2 * ma * mb + c1) * (2 * (ab - ma * mb) + c2) /
                   ((ma * ma + mb * mb + c1) * (aa - ma * ma + bb - mb * mb + c2));
        }
    return count > 0.0 ? sum / count : 1.0;
}

// The mean over the pixels of the variance over frames, in relative luminance.
struct Flicker {
    std::vector<double> sums, squares;
    double frames = 0.0;
    void Add(const Picture& picture) {
        sums.resize(picture.size() / 4);
        squares.resize(picture.size() / 4);
        for (size_t i = 0; i < sums.size(); ++i) {
            const double value = picture[4 * i + 1];
            sums[i] += value;
            squares[i] += value * value;
        }
        frames += 1.0;
    }
    double Value() const {
        double sum = 0.0;
        for (size_t i = 0; i < sums.size(); ++i) {
            const double mean = sums[i] / frames;
            sum += std::max(squares[i] / frames - mean * mean, 0.0) / (mean * mean + 0.01);
        }
        return sum / static_cast<double>(sums.size());
    }
};

class Measurement {
  public:
    Measurement(rhi::Device& device, std::string scene, std::map<std::string, std::string> options)
        : m_file(std::move(scene)),
          m_options(std::move(options)),
          m_renderer(device, {.shaderRoot = Option("shaders", "")}),
          m_scene(m_renderer) {
        const std::string size = Option("size", "320x180");
        m_extent = {static_cast<uint32_t>(std::stoul(size)),
                    static_cast<uint32_t>(std::stoul(size.substr(size.find('x') + 1)))};
        scene::SceneData data = scene::LoadGltf(m_file);
        const float aspect = static_cast<float>(m_extent.width) / static_cast<float>(m_extent.height);
        m_view = scene::ChooseView(data, Option("camera", ""), aspect);
        if (m_options.contains("clip")) {
            scene::DeformInstances(data);
            m_posed = scene::PoseOutline(data);
            m_evaluator.emplace(m_posed);
            m_applier.emplace(m_posed);
        }
        for (uint32_t i = 0; m_options.contains("emission") && i < data.materials.size(); ++i)
            if (data.materials[i].emissiveFactor != glm::vec3(0.0f)) {
                m_emitter = {i, data.materials[i]};
                break;
            }
        m_scene.SetScene(std::move(data));
        if (m_options.contains("env"))
            m_scene.SetEnvironmentMap(image::ReadEnvironment(m_options["env"]).image);
        m_scene.SetEnvironment({.radiance = glm::vec3(1.0f), .usesScene = !m_options.contains("env")});
    }

    void Run() {
        const double distance = std::stod(Option("distance", "2"));
        const double step = std::stod(Option("degrees", "0.5")) * 0.017453292519943295;
        Picture raw, filtered, mean, stopped;
        std::vector<uint8_t> rawShown, filteredShown;
        std::vector<double> times;
        Flicker rawFlicker, filteredFlicker;
        passes::TraceSettings moved = passes::FrameSettings(m_extent, m_view, {}, {});
        if (m_options.contains("passes")) {
            for (int i = 0; i < 2; ++i) BytesOfFrame(moved, false);
            const uint64_t before = BytesOfFrame(moved, false);
            std::printf("  %.1f MB\n", static_cast<double>(BytesOfFrame(moved, true) - before) * 1e-6);
            passes::Release(m_renderer, m_history);
        }
        for (int frame = 0; frame < kMovingFrames + kStillFrames; ++frame) {
            const double angle = step * (std::min(frame, kMovingFrames - 1) - kMovingFrames + 1);
            const glm::dvec3 target = m_view.eye + distance * glm::dvec3(m_view.forward);
            const glm::dvec3 arm = m_view.eye - target;
            const glm::dvec3 turned{std::cos(angle) * arm.x + std::sin(angle) * arm.z, arm.y,
                                    std::cos(angle) * arm.z - std::sin(angle) * arm.x};
            scene::CameraView view = scene::CameraView::LookAt(target + turned, target, {0, 1, 0});
            view.yFov = m_view.yFov;
            passes::TraceSettings settings = passes::FrameSettings(m_extent, view, {}, {});
            settings.sampleIndex = static_cast<uint32_t>(frame);
            Pose(frame);
            Brighten(frame);
            const auto begin = std::chrono::steady_clock::now();
            Frame(settings);
            if (frame > 1 && frame < kMovingFrames)
                times.push_back(
                    std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
                        .count());
            AddGpuTimes(frame < kMovingFrames);
            if (frame == kMovingFrames - 1) {
                raw = m_raw, filtered = m_filtered;
                rawShown = m_rawShown, filteredShown = m_filteredShown;
                moved = settings;
            }
            // Half a second after the camera has stopped, on two cores: two frames, or three samples alone
            if (frame >= kMovingFrames && frame < kMovingFrames + 3) {
                mean.resize(m_raw.size());
                for (size_t i = 0; i < mean.size(); ++i) mean[i] += m_raw[i] / 3.0f;
                if (frame < kMovingFrames + 2) stopped = m_filtered;
            }
            if (frame >= kMovingFrames + kFlickerFrom) {
                rawFlicker.Add(m_raw);
                filteredFlicker.Add(m_filtered);
            }
        }
        const Picture still = m_filtered;
        Reference(moved, rawShown, filteredShown);
        std::sort(times.begin(), times.end());
        const double error = RelativeSquaredError(filtered, m_reference);
        std::printf("| %s | %.4f | %.5f | %.1f | %.3f | %.3f | %.3f | %.3f | %.3f | %.3f | %.1f | %.0f |\n",
                    m_file.substr(m_file.rfind('/') + 1).c_str(), RelativeSquaredError(raw, m_reference),
                    error, RelativeSquaredError(raw, m_reference) / error, m_rawFlip, m_flip,
                    Ssim(rawShown, m_referenceShown, m_extent),
                    Ssim(filteredShown, m_referenceShown, m_extent), Energy(filtered) / Energy(m_reference),
                    Energy(still) / Energy(m_reference), rawFlicker.Value() / filteredFlicker.Value(),
                    times[times.size() / 2]);
        if (m_options.contains("stop"))
            std::printf("  2 frames after the stop %.5f, mean of 3 samples %.5f\n",
                        RelativeSquaredError(stopped, m_reference), RelativeSquaredError(mean, m_reference));
        if (m_options.contains("hand-over")) HandOver(moved);
        for (const auto& [name, ms] : m_passMs)
            if (m_options.contains("passes"))
                std::printf("  %-20s %8.3f ms\n", name.c_str(), ms / m_timedFrames);
        Save("-raw.png", rawShown);
        Save("-real-time.png", filteredShown);
        Save("-reference.png", m_referenceShown);
        Save("-error.png", ShownError(filtered, m_reference));
    }

  private:
    std::string Option(const std::string& name, const std::string& otherwise) const {
        const auto found = m_options.find(name);
        return found == m_options.end() ? otherwise : found->second;
    }
    TextureId Shown(TextureId radiance) {
        return passes::Tonemap(m_renderer, radiance,
                               {.exposureEv = std::stof(Option("ev", "0")), .isOpaque = true});
    }
    void Frame(const passes::TraceSettings& settings) {
        m_renderer.BeginFrame();
        m_scene.SetViewpoint(EyeOf(settings.camera));
        const SceneIds ids = m_scene.Declare(m_renderer);
        const TextureId sample = passes::Trace(m_renderer, ids, settings).radiance;
        const TextureId picture =
            passes::RealTime(m_renderer, ids, settings, sample, m_history,
                             {.mostFramesMoving = static_cast<uint32_t>(std::stoul(Option("moving", "8")))});
        const Readback raw = m_renderer.ReadBack(sample), filtered = m_renderer.ReadBack(picture),
                       rawShown = m_renderer.ReadBack(Shown(sample)),
                       filteredShown = m_renderer.ReadBack(Shown(picture));
        m_renderer.Execute();
        m_raw = WaitForValues<float>(raw);
        filtered.Wait();
        m_filtered = testing::DecodeTexels(filtered.Bytes(), filtered.Extent(), filtered.Format()).values;
        m_rawShown = WaitForValues<uint8_t>(rawShown);
        m_filteredShown = WaitForValues<uint8_t>(filteredShown);
    }
    // Moves what the clip moves to where it is in that frame, and tells it as the viewport does.
    void Pose(int frame) {
        if (!m_evaluator) return;
        const scene::ClipState clip{.animation = static_cast<uint32_t>(std::stoul(m_options["clip"])),
                                    .seconds = std::min(frame, kMovingFrames - 1) / 60.0};
        m_scene.SetPose(m_posed, *m_applier,
                        m_applier->Apply(m_posed, m_evaluator->Evaluate(m_posed, {&clip, 1})));
        if (frame < kMovingFrames) m_history.NoteChange();
    }
    void Brighten(int frame) {
        if (!m_emitter || frame < std::stoi(Option("from", "0")) || frame >= std::stoi(Option("to", "16")))
            return;
        m_emitter->second.emissiveStrength *= std::stof(m_options["emission"]);
        m_scene.SetMaterial(m_emitter->first, m_emitter->second);
        m_history.NoteChange();
    }
    void AddGpuTimes(bool counts) {
        for (const FrameTiming& timing : m_renderer.TakeTimings()) {
            if (!counts || timing.frame < 3) continue;
            for (const PassTiming& pass : timing.passes) m_passMs[pass.name] += pass.gpuMs;
            m_timedFrames += 1.0;
        }
    }
    void Accumulate(passes::TraceSettings settings) {
        const auto samples = static_cast<uint32_t>(std::stoul(Option("samples", "1024")));
        passes::Accumulation accumulation("reference");
        settings.seed = 77;
        Readback mean;
        for (settings.sampleIndex = 0; settings.sampleIndex < samples; ++settings.sampleIndex) {
            m_renderer.BeginFrame();
            const SceneIds ids = m_scene.Declare(m_renderer);
            const TextureId sum =
                passes::Accumulate(m_renderer, passes::Trace(m_renderer, ids, settings).radiance,
                                   accumulation)
                    .mean;
            m_renderer.Present(sum);
            if (settings.sampleIndex + 1 == samples) mean = m_renderer.ReadBack(sum);
            m_renderer.Execute();
        }
        m_reference = WaitForValues<float>(mean);
        m_renderer.TakeTimings();
    }
    // Hands the still picture over to samples that accumulate.
    void HandOver(passes::TraceSettings settings) {
        passes::Accumulation accumulation("handed over");
        settings.seed = 78;
        std::printf("  %7s %9s %9s %9s\n", "samples", "picture", "mean", "shown");
        for (settings.sampleIndex = 0; settings.sampleIndex < 256; ++settings.sampleIndex) {
            m_renderer.BeginFrame();
            const SceneIds ids = m_scene.Declare(m_renderer);
            const passes::AccumulatedIds samples = passes::Accumulate(
                m_renderer, passes::Trace(m_renderer, ids, settings).radiance, accumulation, true);
            const TextureId picture = passes::LastRealTime(m_renderer, m_history, m_extent);
            const TextureId shown = passes::HandOver(m_renderer, picture, samples, accumulation.Declared());
            const Readback mean = m_renderer.ReadBack(samples.mean), both = m_renderer.ReadBack(shown),
                           display = m_renderer.ReadBack(Shown(shown));
            m_renderer.Execute();
            const uint32_t count = settings.sampleIndex + 1;
            const Picture means = WaitForValues<float>(mean), pictures = WaitForValues<float>(both);
            if (count < 4 || (count != 11 && !std::has_single_bit(count))) continue;
            std::printf("  %7u %9.5f %9.5f %9.5f\n", count, RelativeSquaredError(m_filtered, m_reference),
                        RelativeSquaredError(means, m_reference),
                        RelativeSquaredError(pictures, m_reference));
            Save(("-hand-over-" + std::to_string(count) + ".png").c_str(), WaitForValues<uint8_t>(display));
        }
    }
    void Reference(const passes::TraceSettings& settings, const std::vector<uint8_t>& rawShown,
                   const std::vector<uint8_t>& shown) {
        const std::string file = Option("reference", "");
        const auto bytes = std::streamsize{16} * m_extent.width * m_extent.height;
        m_reference.resize(static_cast<size_t>(bytes) / sizeof(float));
        if (!std::ifstream(file, std::ios::binary).read(reinterpret_cast<char*>(m_reference.data()), bytes)) {
            Accumulate(settings);
            if (!file.empty())
                std::ofstream(file, std::ios::binary)
                    .write(reinterpret_cast<const char*>(m_reference.data()), bytes);
        }
        m_renderer.BeginFrame();
        const TextureId referenceShown =
            Shown(Uploaded(std::as_bytes(std::span(m_reference)), Format::Rgba32Float));
        const Readback display = m_renderer.ReadBack(referenceShown);
        const auto flipTo = [&](const std::vector<uint8_t>& picture) {
            return m_renderer.ReadBack(passes::ReduceBlocks(
                m_renderer, passes::Flip(m_renderer, referenceShown,
                                         Uploaded(std::as_bytes(std::span(picture)), Format::Rgba8Unorm))));
        };
        const Readback flip = flipTo(shown), rawFlip = flipTo(rawShown);
        m_renderer.Execute();
        m_referenceShown = WaitForValues<uint8_t>(display);
        flip.Wait();
        rawFlip.Wait();
        m_flip = passes::StatisticsOf(flip, m_extent).mean;
        m_rawFlip = passes::StatisticsOf(rawFlip, m_extent).mean;
    }
    TextureId Uploaded(std::span<const std::byte> texels, Format format) {
        Staging& staging = m_staging.emplace_back();
        staging.buffer = m_renderer.Device().CreateBuffer({.name = "picture",
                                                           .size = texels.size(),
                                                           .usage = rhi::BufferUsage::CopySource,
                                                           .memory = rhi::MemoryKind::Upload});
        std::ranges::copy(texels, staging.buffer.Mapped().data());
        TextureId texture = m_renderer.CreateTexture("uploaded", {m_extent, format});
        const BufferId source = m_renderer.Import("picture", staging.buffer, staging.state);
        m_renderer.AddPass(
            "Upload", PassKind::Transfer,
            [&](PassBuilder& pass) {
                pass.CopiesFrom(source);
                texture = pass.CopiesTo(texture);
            },
            [source, texture](CommandList& commands, const PassResources& resources) {
                commands.CopyToTexture(resources.Buffer(source), 0, resources.Texture(texture));
            });
        return texture;
    }
    // Returns the bytes in use after a frame of one sample, which RealTime filters or does not.
    uint64_t BytesOfFrame(const passes::TraceSettings& settings, bool isFiltered) {
        m_renderer.BeginFrame();
        m_scene.SetViewpoint(EyeOf(settings.camera));
        const SceneIds ids = m_scene.Declare(m_renderer);
        const TextureId sample = passes::Trace(m_renderer, ids, settings).radiance;
        m_renderer.Present(isFiltered ? passes::RealTime(m_renderer, ids, settings, sample, m_history)
                                      : sample);
        m_renderer.Execute();
        return m_renderer.Device().Memory().usedBytes;
    }
    void Save(const char* ending, const std::vector<uint8_t>& shown) const {
        if (const std::string prefix = Option("pictures", ""); !prefix.empty())
            image::WritePng(prefix + ending, {m_extent.width, m_extent.height, shown});
    }

    std::string m_file;
    std::map<std::string, std::string> m_options;
    Extent2D m_extent;
    struct Staging {
        rhi::Buffer buffer;
        ResourceState state;
    };
    std::deque<Staging> m_staging;
    Renderer m_renderer;
    GpuScene m_scene;
    scene::SceneData m_posed;  // if a clip is played
    std::optional<scene::PoseEvaluator> m_evaluator;
    std::optional<scene::PoseApplier> m_applier;
    std::optional<std::pair<uint32_t, scene::Material>> m_emitter;
    scene::CameraView m_view;
    passes::RealTimeHistory m_history{"realTime"};
    Picture m_raw, m_filtered, m_reference;
    std::vector<uint8_t> m_rawShown, m_filteredShown, m_referenceShown;
    double m_flip = 0.0, m_rawFlip = 0.0, m_timedFrames = 0.0;
    std::map<std::string, double> m_passMs;
};

}  // namespace

int main(int argc, char** argv) {
    try {
        std::map<std::string, std::string> options;
        for (int i = 2; i < argc; ++i) {
            const std::string argument = argv[i];
            options[argument.substr(0, argument.find('='))] = argument.substr(argument.find('=') + 1);
        }
        if (argc < 2)
            throw Error(ErrorKind::Usage, "usage: raygraph_measure_real_time SCENE [option=value]...");
        const auto device = rhi::Device::Create();
        Measurement(*device, argv[1], options).Run();
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
