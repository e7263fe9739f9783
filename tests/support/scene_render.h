// Renders small scenes through the real passes, for tests that look at the numbers.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "passes/accumulate.h"
#include "passes/trace.h"
#include "renderer/gpu_scene/camera_record.h"
#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/graph/renderer.h"
#include "renderer/scene/model/camera_view.h"

namespace raygraph::testing {

// rgba float texels, rows from the top.
struct FloatImage {
    Extent2D extent;
    std::vector<glm::vec4> values;

    const glm::vec4& At(uint32_t x, uint32_t y) const { return values[size_t{y} * extent.width + x]; }
    glm::dvec3 Mean() const;
};

struct RenderedImage {
    FloatImage mean;
    FloatImage variance;  // variance of one sample
    uint32_t sampleCount = 0;

    // Standard error of the mean over all pixels, per channel.
    glm::dvec3 StandardErrorOfMean() const;
};

// Exclusive use of a Renderer of the tests' shared device. The next test of the process gets it with the
// pipelines that it has created, which take a second or more each on a CPU, and with the persistent resources
// that an earlier test left behind. For another device: a Renderer of its own.
class RendererLease {
  public:
    explicit RendererLease(rhi::Device& device);
    ~RendererLease();
    RendererLease(const RendererLease&) = delete;
    RendererLease& operator=(const RendererLease&) = delete;

    Renderer& operator*() const { return *m_renderer; }

  private:
    std::unique_ptr<Renderer> m_renderer;
    bool m_isShared;
};

// How many of the remaining samples to trace in one frame, which costs as much as thousands of paths. The bits
// do not depend on it.
uint32_t SamplesOfAFrame(passes::TraceSettings settings, uint32_t remaining);

// A device-side scene with its renderer; the settings are those of Trace.
class SceneRender {
  public:
    explicit SceneRender(rhi::Device& device, const GpuSceneDesc& desc = {})
        : m_lent(device), renderer(*m_lent), scene(renderer, desc) {}

    // Declares the scene, with `more`.
    SceneIds Declare();
    // Renders samples settings.sampleIndex ... + sampleCount - 1.
    RenderedImage Render(passes::TraceSettings settings, uint32_t sampleCount);
    // One sample's radiance, straight from Trace.
    FloatImage TraceOnce(const passes::TraceSettings& settings);
    // The textures of PrimaryHits through pixel centers.
    struct Hits {
        FloatImage albedo, normal, position;
        std::vector<glm::uvec4> ids;
    };
    Hits PrimaryHits(const passes::TraceSettings& settings);
    // Executes the open frame and reads these textures of it.
    Hits ReadHits(const passes::PrimaryHitIds& hits);

  private:
    RendererLease m_lent;

  public:
    Renderer& renderer;
    GpuScene scene;
    // Features of Trace's programs beside those of the scene, so that one program serves scenes with and
    // without them: a program takes Mesa's CPU driver one second or more to compile.
    TraceFeatures more = kLightsAndTextures;
    static constexpr TraceFeatures kLightsAndTextures =
        FeaturesOfKind(TraceFeatureKind::Lights) | kTraceMeshLights | kTraceTextures | kTraceVertexColors;
    static constexpr TraceFeatures kPlainLobes = kTraceOpaque | kTraceMetals | kTraceGlass | kTraceSmooth;
};

FloatImage ToFloatImage(const Readback& readback);

// Meshes for scenes made in a test. Counter-clockwise seen from outside or from +z.
scene::Mesh QuadMesh(float halfSize, uint32_t material = 0);                  // in the xy plane, facing +z
scene::Mesh BoxMesh(float halfSize, uint32_t material = 0);                   // axis-aligned cube
scene::Mesh SphereMesh(float radius, uint32_t rings, uint32_t material = 0);  // smooth normals
// Capsules, two indices each.
scene::Mesh RoundMesh(std::vector<glm::vec3> positions, std::vector<uint32_t> indices,
                      std::vector<float> radii, uint32_t material = 0);
scene::Mesh RoundSphere(float radius, uint32_t material = 0, const glm::vec3& at = glm::vec3(0.0f));
// Makes a material that reflects and emits on both sides.
scene::Material Lambert(const glm::vec3& albedo, const glm::vec3& emission = glm::vec3(0.0f));
glm::mat4x3 Translation(const glm::vec3& offset);
// One instance of each mesh, untransformed, unless transforms are given.
scene::SceneData SceneOf(std::vector<scene::Mesh> meshes, std::vector<scene::Material> materials,
                         std::vector<glm::mat4x3> transforms = {});

// A perspective camera's settings over a square picture. Surfaces are Lambert's: closed forms know no gloss.
passes::TraceSettings LookAt(const glm::vec3& eye, const glm::vec3& target, float yFov, uint32_t size);

}  // namespace raygraph::testing
