// A viewport on a small scene, for tests.
#pragma once

#include <cstdlib>
#include <cstring>
#include <vector>

#include "editor/viewport/viewport.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing {

using viewport::View;
using viewport::Viewport;

// Returns the mean over the bytes of two displays of one size.
inline double MeanDifference(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b) {
    double sum = 0.0;
    for (size_t i = 0; i < a.size(); ++i) sum += std::abs(int{a[i]} - int{b[i]});
    return sum / static_cast<double>(a.size());
}

// A lit box in a box, with a point light: paths of every length, and something of every kind to edit.
inline scene::SceneData Boxes() {
    scene::SceneData data = SceneOf({BoxMesh(1.0f), BoxMesh(0.4f, 1)},
                                    {Lambert(glm::vec3(0.6f), glm::vec3(0.3f)), Lambert(glm::vec3(0.8f))},
                                    {glm::mat4x3(1.0f), Translation({0.4f, -0.5f, 0.1f})});
    scene::Light light;
    light.intensity = 0.2f;
    light.lightToWorld = Translation({-0.3f, 0.7f, 0.2f});
    data.lights.push_back(light);
    return data;
}

inline scene::CameraView InsideBoxes() {
    scene::CameraView camera =
        scene::CameraView::LookAt({-0.8f, 0.1f, 0.3f}, {1.0f, -0.5f, 0.0f}, glm::vec3(0, 1, 0));
    camera.yFov = 1.2f;
    return camera;
}

// Without what takes long to compile.
inline passes::RasterSettings PlainRaster() {
    return {.shadows = passes::RasterShadows::Off, .hasOcclusion = false, .hasTransmission = false};
}

// Renderer, scene and viewport; surfaces are Lambert's.
class ViewedScene {
  public:
    explicit ViewedScene(rhi::Device& device, Extent2D size = {24, 16}, scene::SceneData data = Boxes())
        : m_lent(device), renderer(*m_lent), scene(renderer), viewport(renderer, scene, {.size = size}) {
        scene.SetScene(std::move(data));
        viewport.SetCamera(InsideBoxes());
        viewport::PathSettings paths;
        paths.scattering.brdf = BrdfModel::Lambert;
        viewport.SetPaths(paths);
        viewport.SetRaster(PlainRaster());
    }

    void RenderFrames(uint32_t count) {
        for (uint32_t i = 0; i < count; ++i) viewport.RenderFrame();
    }
    // A frame, and what it shows.
    std::vector<uint8_t> Picture() {
        renderer.BeginFrame();
        const Readback readback = renderer.ReadBack(viewport.Declare());
        renderer.Execute();
        readback.Wait();
        std::vector<uint8_t> bytes(readback.Bytes().size());
        std::memcpy(bytes.data(), readback.Bytes().data(), bytes.size());
        return bytes;
    }
    uint32_t Samples() const { return viewport.Progress().pathTracedSamples; }
    uint32_t AllResets() const {
        uint32_t count = 0;
        for (uint32_t i = 0; i < static_cast<uint32_t>(passes::ResetCause::Count); ++i)
            count += viewport.ResetCount(static_cast<passes::ResetCause>(i));
        return count;
    }

  private:
    RendererLease m_lent;

  public:
    Renderer& renderer;
    GpuScene scene;
    Viewport viewport;
};

}  // namespace raygraph::testing
