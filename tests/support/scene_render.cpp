#include "tests/support/scene_render.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/gtc/constants.hpp>
#include <utility>

#include "passes/scene_bindings.h"
#include "renderer/scene/geometry/round_primitives.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing {

namespace {

// Renderers that no test has at the moment.
struct Idle {
    Idle() {
        VulkanTest::OnDeviceDestroy([this] { renderers.clear(); });
    }
    std::vector<std::unique_ptr<Renderer>> renderers;
};

std::vector<std::unique_ptr<Renderer>>& IdleRenderers() {
    static Idle idle;
    return idle.renderers;
}

}  // namespace

RendererLease::RendererLease(rhi::Device& device) : m_isShared(&device == &VulkanTest::Device()) {
    if (m_isShared && !IdleRenderers().empty()) {
        m_renderer = std::move(IdleRenderers().back());
        IdleRenderers().pop_back();
        m_renderer->TakeTimings();
    } else {
        m_renderer = std::make_unique<Renderer>(device);
    }
}

RendererLease::~RendererLease() {
    if (!m_isShared) return;
    m_renderer->DropFrame();
    IdleRenderers().push_back(std::move(m_renderer));
}

glm::dvec3 FloatImage::Mean() const {
    glm::dvec3 sum(0.0);
    for (const glm::vec4& value : values) sum += glm::dvec3(value);
    return sum / double(values.size());
}

glm::dvec3 RenderedImage::StandardErrorOfMean() const {
    const double pixels = double(variance.values.size());
    return glm::sqrt(variance.Mean() / (pixels * sampleCount));
}

FloatImage ToFloatImage(const Readback& readback) {
    readback.Wait();
    FloatImage texels{.extent = readback.Extent(), .values = {}};
    texels.values.resize(readback.Bytes().size() / sizeof(glm::vec4));
    std::memcpy(texels.values.data(), readback.Bytes().data(), readback.Bytes().size());
    return texels;
}

SceneIds SceneRender::Declare() {
    return passes::WithFeatures(scene.Declare(renderer), more);
}

uint32_t SamplesOfAFrame(passes::TraceSettings settings, uint32_t remaining) {
    constexpr uint64_t kPaths = 16384;
    settings.sampleCount = 1;
    if (settings.roulette.kind == Roulette::Frame) return 1;
    const uint64_t samples = std::clamp<uint64_t>(kPaths / passes::PathCount(settings), 1, 64);
    return std::min(remaining, static_cast<uint32_t>(samples));
}

RenderedImage SceneRender::Render(passes::TraceSettings settings, uint32_t sampleCount) {
    passes::Accumulation accumulation("test");
    RenderedImage image;
    for (const uint32_t end = settings.sampleIndex + sampleCount; settings.sampleIndex < end;
         settings.sampleIndex += settings.sampleCount) {
        settings.sampleCount = SamplesOfAFrame(settings, end - settings.sampleIndex);
        renderer.BeginFrame();
        const SceneIds ids = Declare();
        const TextureId samples = passes::Trace(renderer, ids, settings).radiance;
        const Extent2D stacked = renderer.Desc(samples).extent;
        const Extent2D extent{stacked.width, stacked.height / settings.sampleCount};
        const TextureId mean =
            passes::Accumulate(renderer, samples, {settings.sampleCount, extent.height}, accumulation, true)
                .mean;
        if (settings.sampleIndex + settings.sampleCount < end) {
            renderer.Present(mean);
            renderer.Execute();
            continue;
        }
        const passes::AccumulatedIds all = passes::Resolve(renderer, accumulation, extent, true);
        const Readback meanTexels = renderer.ReadBack(all.mean);
        const Readback variance = renderer.ReadBack(all.variance);
        renderer.Execute();
        image = {ToFloatImage(meanTexels), ToFloatImage(variance), accumulation.SampleCount()};
    }
    return image;
}

FloatImage SceneRender::TraceOnce(const passes::TraceSettings& settings) {
    renderer.BeginFrame();
    const SceneIds ids = Declare();
    const Readback radiance = renderer.ReadBack(passes::Trace(renderer, ids, settings).radiance);
    renderer.Execute();
    return ToFloatImage(radiance);
}

SceneRender::Hits SceneRender::PrimaryHits(const passes::TraceSettings& settings) {
    renderer.BeginFrame();
    const SceneIds ids = scene.Declare(renderer);
    return ReadHits(passes::PrimaryHits(renderer, ids, settings, passes::FilmPosition::Center));
}

SceneRender::Hits SceneRender::ReadHits(const passes::PrimaryHitIds& hits) {
    const Readback albedo = renderer.ReadBack(hits.albedo);
    const Readback normal = renderer.ReadBack(hits.normal);
    const Readback position = renderer.ReadBack(hits.position);
    const Readback idTexels = renderer.ReadBack(hits.ids);
    renderer.Execute();
    Hits result{ToFloatImage(albedo), ToFloatImage(normal), ToFloatImage(position), {}};
    idTexels.Wait();
    result.ids.resize(idTexels.Bytes().size() / sizeof(glm::uvec4));
    std::memcpy(result.ids.data(), idTexels.Bytes().data(), idTexels.Bytes().size());
    return result;
}

namespace {

scene::Mesh MeshOf(scene::Primitive primitive, uint32_t material) {
    primitive.material = material;
    primitive.bounds = scene::BoundsOf(primitive.positions);
    scene::Mesh mesh;
    mesh.primitives.push_back(std::move(primitive));
    return mesh;
}

// Appends a quad center + {-u-v, u-v, u+v, -u+v} with normal cross(u, v).
void AppendQuad(scene::Primitive& primitive, const glm::vec3& center, const glm::vec3& u,
                const glm::vec3& v) {
    const auto first = static_cast<uint32_t>(primitive.positions.size());
    const glm::vec3 normal = glm::normalize(glm::cross(u, v));
    for (const glm::vec2 corner : {glm::vec2(-1, -1), glm::vec2(1, -1), glm::vec2(1, 1), glm::vec2(-1, 1)}) {
        primitive.positions.push_back(center + corner.x * u + corner.y * v);
        primitive.normals.push_back(normal);
    }
    for (const uint32_t index : {0u, 1u, 2u, 0u, 2u, 3u}) primitive.indices.push_back(first + index);
}

}  // namespace

scene::Mesh QuadMesh(float halfSize, uint32_t material) {
    scene::Primitive primitive;
    AppendQuad(primitive, glm::vec3(0.0f), {halfSize, 0, 0}, {0, halfSize, 0});
    return MeshOf(std::move(primitive), material);
}

scene::Mesh BoxMesh(float halfSize, uint32_t material) {
    scene::Primitive primitive;
    for (int axis = 0; axis < 3; ++axis)
        for (const float side : {-1.0f, 1.0f}) {
            glm::vec3 n(0.0f), u(0.0f), v(0.0f);
            n[axis] = side * halfSize;
            u[(axis + 1) % 3] = halfSize;
            v[(axis + 2) % 3] = side * halfSize;
            AppendQuad(primitive, n, u, v);
        }
    return MeshOf(std::move(primitive), material);
}

scene::Mesh SphereMesh(float radius, uint32_t rings, uint32_t material) {
    scene::Primitive primitive;
    const uint32_t segments = 2 * rings;
    for (uint32_t ring = 0; ring <= rings; ++ring)
        for (uint32_t segment = 0; segment <= segments; ++segment) {
            const float theta = glm::pi<float>() * float(ring) / float(rings);
            const float phi = glm::two_pi<float>() * float(segment) / float(segments);
            const glm::vec3 n(std::sin(theta) * std::cos(phi), std::cos(theta),
                              -std::sin(theta) * std::sin(phi));
            primitive.normals.push_back(n);
            primitive.positions.push_back(radius * n);
        }
    for (uint32_t ring = 0; ring < rings; ++ring)
        for (uint32_t segment = 0; segment < segments; ++segment) {
            const uint32_t a = ring * (segments + 1) + segment;
            const uint32_t b = a + segments + 1;
            if (ring > 0) primitive.indices.insert(primitive.indices.end(), {a, b, a + 1});
            if (ring + 1 < rings) primitive.indices.insert(primitive.indices.end(), {a + 1, b, b + 1});
        }
    return MeshOf(std::move(primitive), material);
}

scene::Material Lambert(const glm::vec3& albedo, const glm::vec3& emission) {
    scene::Material material;
    material.baseColorFactor = glm::vec4(albedo, 1.0f);
    material.emissiveFactor = emission;
    material.isDoubleSided = true;
    return material;
}

glm::mat4x3 Translation(const glm::vec3& offset) {
    glm::mat4x3 result(1.0f);
    result[3] = offset;
    return result;
}

scene::SceneData SceneOf(std::vector<scene::Mesh> meshes, std::vector<scene::Material> materials,
                         std::vector<glm::mat4x3> transforms) {
    scene::SceneData scene;
    transforms.resize(meshes.size(), glm::mat4x3(1.0f));
    for (uint32_t i = 0; i < meshes.size(); ++i) {
        scene.instances.push_back({.mesh = i, .objectToWorld = transforms[i]});
        for (const scene::Primitive& primitive : meshes[i].primitives)
            scene.bounds.Extend(primitive.bounds.Transformed(transforms[i]));
    }
    scene.meshes = std::move(meshes);
    scene.materials = std::move(materials);
    return scene;
}

scene::Mesh RoundMesh(std::vector<glm::vec3> positions, std::vector<uint32_t> indices,
                      std::vector<float> radii, uint32_t material) {
    scene::Mesh mesh;
    scene::Primitive& primitive = mesh.primitives.emplace_back();
    primitive.positions = std::move(positions);
    primitive.indices = std::move(indices);
    primitive.radii = std::move(radii);
    primitive.material = material;
    primitive.bounds = scene::RoundBounds(primitive);
    return mesh;
}

scene::Mesh RoundSphere(float radius, uint32_t material, const glm::vec3& at) {
    return RoundMesh({at}, {0, 0}, {radius}, material);
}

passes::TraceSettings LookAt(const glm::vec3& eye, const glm::vec3& target, float yFov, uint32_t size) {
    scene::CameraView view = scene::CameraView::LookAt(eye, target, glm::vec3(0, 1, 0));
    view.yFov = yFov;
    passes::TraceSettings settings;
    settings.extent = {size, size};
    settings.camera = ToRecord(view);
    settings.scattering.brdf = BrdfModel::Lambert;
    return settings;
}

}  // namespace raygraph::testing
