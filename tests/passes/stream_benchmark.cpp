// Measures what a frame waits for while a scene is loaded beside the one that is shown. Prints, for each
// way of loading it, the host's milliseconds: of the one call, and the longest of any frame of making the frame
// ready (GpuScene::Declare), of all that the frame's thread does, and of BeginFrame, which waits while the
// device is behind; of all frames the median; and the device's longest frame.
//
//   raygraph_stream_benchmark [MESHES [TRIANGLES [TEXTURES [PIXELS]]]]
//
// Default: 120 meshes of 100,000 triangles, 20 textures of 2048x2048 texels, 1280 pixels. Scenes are made in
// memory; the device is the default one.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <numeric>
#include <string>
#include <vector>

#include "base/os.h"
#include "base/stopwatch.h"
#include "passes/trace.h"
#include "renderer/gpu_scene/camera_record.h"
#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/gpu_scene/streaming/prepared_scene.h"
#include "renderer/graph/renderer.h"
#include "renderer/scene/model/camera_view.h"
#include "rhi/device.h"

namespace raygraph {
namespace {

struct Sizes {
    uint32_t meshes = 120, triangles = 100'000, textures = 20, pixels = 1280;
};

// Hills over a square of one meter.
scene::Mesh Hills(uint32_t triangles, uint32_t seed, uint32_t material) {
    const auto side = static_cast<uint32_t>(std::sqrt(0.5 * triangles));
    scene::Mesh mesh;
    scene::Primitive& primitive = mesh.primitives.emplace_back();
    primitive.material = material;
    for (uint32_t y = 0; y <= side; ++y)
        for (uint32_t x = 0; x <= side; ++x) {
            const glm::vec2 at = glm::vec2(x, y) / float(side);
            const float height = 0.05f * std::sin(40.0f * at.x + float(seed)) * std::sin(31.0f * at.y);
            primitive.positions.emplace_back(at.x - 0.5f, height, at.y - 0.5f);
            primitive.normals.emplace_back(0.0f, 1.0f, 0.0f);
            primitive.uv0.push_back(at);
            primitive.bounds.Extend(primitive.positions.back());
        }
    for (uint32_t y = 0; y < side; ++y)
        for (uint32_t x = 0; x < side; ++x) {
            const uint32_t i = y * (side + 1) + x, above = i + side + 1;
            primitive.indices.insert(primitive.indices.end(), {i, above, i + 1, i + 1, above, above + 1});
        }
    return mesh;
}

scene::SceneData Field(const Sizes& sizes) {
    scene::SceneData scene;
    const uint32_t materials = std::max(1u, sizes.textures);
    const auto side = static_cast<uint32_t>(std::ceil(std::sqrt(double(sizes.meshes))));
    for (uint32_t i = 0; i < sizes.textures; ++i) {
        constexpr uint32_t kTexels = 2048;
        scene::ImageData& image = scene.images.emplace_back();
        image.width = image.height = kTexels;
        image.rgba.assign(size_t{4} * kTexels * kTexels, uint8_t(80 + 5 * i));
        scene::Texture& texture = scene.textures.emplace_back();
        texture.image = i;
        texture.colorSpace = scene::ColorSpace::Srgb;
    }
    for (uint32_t i = 0; i < materials; ++i)
        scene.materials.emplace_back().baseColorTexture.texture = sizes.textures > 0 ? int32_t(i) : -1;
    for (uint32_t i = 0; i < sizes.meshes; ++i) {
        scene.meshes.push_back(Hills(sizes.triangles, i, i % materials));
        glm::mat4x3 place(1.0f);
        place[3] = glm::vec3(i % side, 0.0f, i / side);
        scene.instances.push_back({.mesh = i, .objectToWorld = place});
    }
    return scene;
}

class Frames {
  public:
    Frames(rhi::Device& device, const Sizes& sizes)
        : m_renderer(device), m_scene(m_renderer, {.textureLevels = true}) {
        const auto side = static_cast<float>(std::ceil(std::sqrt(double(sizes.meshes))));
        scene::CameraView view =
            scene::CameraView::LookAt(glm::vec3(0.5f * side, 0.7f * side, -0.5f * side),
                                      glm::vec3(0.5f * side, 0.0f, 0.4f * side), glm::vec3(0.0f, 1.0f, 0.0f));
        m_settings.extent = {sizes.pixels, sizes.pixels * 9 / 16};
        m_settings.camera = ToRecord(view);
        m_settings.biases.maxDepth = 2;
        m_scene.SetScene(Field({.meshes = 4, .triangles = 1000, .textures = 0}));
        m_scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
        for (int frame = 0; frame < 20; ++frame) Show();  // pipelines, compaction
        m_declare.clear(), m_all.clear(), m_wait.clear(), m_device.clear();
    }

    void Show() {
        const Stopwatch wait;
        m_renderer.BeginFrame();
        m_wait.push_back(wait.Milliseconds());
        const Stopwatch all;
        const SceneIds ids = m_scene.Declare(m_renderer);
        m_declare.push_back(all.Milliseconds());
        m_renderer.Present(passes::Trace(m_renderer, ids, m_settings).radiance);
        m_renderer.Execute();
        m_all.push_back(all.Milliseconds());
        double gpu = 0.0;
        for (const PassTiming& pass : m_renderer.Timing().passes) gpu += pass.gpuMs;
        m_device.push_back(gpu);
    }

    void Report(const char* name, double callMs) {
        const auto longest = [](const std::vector<double>& values) {
            return *std::ranges::max_element(values);
        };
        std::vector<double> sorted = m_all;
        std::ranges::sort(sorted);
        std::printf("%-8s %8.2f %8zu %9.2f %9.2f %9.2f %9.2f %9.2f\n", name, callMs, m_all.size(),
                    longest(m_declare), longest(m_all), longest(m_wait), sorted[sorted.size() / 2],
                    longest(m_device));
        // Which frames these were: the first ones take memory that later ones use again
        std::printf("         longest to make ready:");
        std::vector<size_t> order(m_declare.size());
        std::iota(order.begin(), order.end(), size_t{0});
        std::ranges::sort(order, std::greater{}, [&](size_t i) { return m_declare[i]; });
        for (size_t i = 0; i < std::min<size_t>(8, order.size()); ++i)
            std::printf(" %.2f (%zu)", m_declare[order[i]], order[i]);
        std::printf("\n");
    }

    GpuScene& Scene() { return m_scene; }

  private:
    Renderer m_renderer;
    GpuScene m_scene;
    passes::TraceSettings m_settings;
    std::vector<double> m_declare, m_all, m_wait, m_device;
};

void Run(rhi::Device& device, const Sizes& sizes) {
    std::printf("%-8s %8s %8s %9s %9s %9s %9s %9s\n", "", "call", "frames", "declare", "frame", "wait",
                "median", "device");
    for (const bool isStreamed : {false, true}) {
        Frames frames(device, sizes);
        const Stopwatch preparing;
        PreparedScene prepared(Field(sizes), {.maxTriangles = 1u << 18});
        const double prepareMs = preparing.Milliseconds();
        const Stopwatch call;
        std::shared_ptr<const AddedPart> part;
        if (isStreamed)
            part = frames.Scene().Stream(std::move(prepared));
        else
            part = std::make_shared<AddedPart>(frames.Scene().Add(std::move(prepared)));
        const double callMs = call.Milliseconds();
        do frames.Show();
        while (!part->isComplete);
        for (int frame = 0; frame < 60; ++frame) frames.Show();
        frames.Report(isStreamed ? "stream" : "add", callMs);
        std::printf("         %llu triangles, prepared in %.0f ms on other threads\n",
                    static_cast<unsigned long long>(frames.Scene().Statistics().trianglesPlaced), prepareMs);
    }
}

}  // namespace
}  // namespace raygraph

int main(int argc, char** argv) {
    raygraph::os::MapLargeBlocks();
    raygraph::Sizes sizes;
    uint32_t* const values[] = {&sizes.meshes, &sizes.triangles, &sizes.textures, &sizes.pixels};
    for (int i = 1; i < argc && i <= 4; ++i)
        *values[i - 1] = static_cast<uint32_t>(std::strtoul(argv[i], nullptr, 10));
    try {
        raygraph::Run(*raygraph::rhi::Device::Create(), sizes);
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
