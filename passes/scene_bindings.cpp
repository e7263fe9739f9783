#include "passes/scene_bindings.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/text.h"
#include "renderer/gpu_scene/camera_record.h"
#include "shaders/shared/mix_bits.h"

namespace raygraph::passes {

namespace {

constexpr HitGroupShaders kOpaqueHit{.closestHit = "scene/hit.rchit", .anyHit = {}, .intersection = {}};
constexpr HitGroupShaders kTestedHit{
    .closestHit = "scene/hit.rchit", .anyHit = "scene/hit.rahit", .intersection = {}};
constexpr HitGroupShaders kOpaqueShadow{};
constexpr HitGroupShaders kTestedShadow{.closestHit = {}, .anyHit = "scene/shadow.rahit", .intersection = {}};
constexpr HitGroupShaders kWallShadow{
    .closestHit = {}, .anyHit = "scene/wall_shadow.rahit", .intersection = {}};

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Returns the hit group of round primitives.
HitGroupShaders Capsules(HitGroupShaders shaders) {
    shaders.intersection = "scene/capsule.rint";
    return shaders;
}

// Returns the bounces of all paths of a sample: from roulette.start on, each is survived with the same
// probability. It is a function of seed and sample, like all random numbers.
uint32_t FrameDepth(const TraceSettings& settings) {
    const uint32_t before = std::max(settings.roulette.start, 1u) - 1u;
    if (settings.roulette.survival >= 1.0f) return kNoDepthLimit;
    const double u =
        (gpu::MixBits(settings.seed ^ gpu::MixBits(settings.sampleIndex + 0x9e3779b9u)) + 1.0) / 4294967297.0;
    return before + static_cast<uint32_t>(std::log(u) / std::log(double{settings.roulette.survival}));
}

// Returns the features that settings make no use of.
TraceFeatures Unused(const SceneIds& scene, const TraceSettings& settings) {
    TraceFeatures unused;
    if (!settings.lights.isOn) unused |= FeaturesOfKind(TraceFeatureKind::Lights);
    // No model but glTF's own has lobes
    if (settings.scattering.brdf != BrdfModel::Gltf) unused |= FeaturesOfKind(TraceFeatureKind::Lobes);
    if (settings.biases.textureLod == -kInfinity || !scene.features.Has(kTraceTextures))
        unused |= kTraceTextureLod;
    if (!settings.isEnvironmentHidden) unused |= kTraceShadowCatcher;
    return unused;
}

void SpecializeModels(PassBuilder& pass, const TraceSettings& settings, TraceFeatures features) {
    const auto specialize = [&](const char* name, auto value) {
        pass.Specialize(name, static_cast<uint32_t>(value));
    };
    SpecializeFeatures(pass, features);
    specialize("kSamplerKind", settings.sampler);
    specialize("kBrdf", settings.scattering.brdf);
    specialize("kDistribution", settings.scattering.distribution);
    specialize("kMasking", settings.scattering.masking);
    specialize("kFresnel", settings.scattering.fresnel);
    specialize("kMultiscatterKind", settings.scattering.multiscatter);
    specialize("kLightSampler", settings.lights.sampler);
}

// Returns the camera relative to the scene's origin, as the device has it.
gpu::CameraRecord FromSceneOrigin(gpu::CameraRecord camera, const glm::dvec3& sceneOrigin) {
    camera.origin = EyeOf(camera) - sceneOrigin;
    camera.originResidual = glm::vec3(0.0f);
    return camera;
}

}  // namespace

Region RegionOf(const TraceSettings& settings) {
    const Extent2D& extent = settings.extent;
    const Region& region = settings.region;
    if (region.IsEmpty()) return WholeOf(extent);
    RequireWithin(extent, region);
    return region;
}

Extent2D TracedExtent(const TraceSettings& settings) {
    return settings.pixels.HasPixels() ? settings.pixels.extent : RegionOf(settings).Extent();
}

void RequireFullFrame(const TraceSettings& settings, const char* pass) {
    if (!(RegionOf(settings) == WholeOf(settings.extent)))
        throw MakeError(ErrorKind::Usage, "{}: a part of a picture; it draws whole ones", pass);
}

gpu::TraceParameters ParametersFor(const SceneIds& scene, const TraceSettings& settings) {
    return {
        .camera = FromSceneOrigin(settings.camera, scene.origin),
        .environment = scene.environment,
        .lights = scene.lightSet,
        .pictureSize = {settings.extent.width, settings.extent.height},
        .regionOffset = {settings.region.x, settings.region.y},
        .seed = settings.seed,
        .sampleIndex = settings.sampleIndex,
        .sampleRows = TracedExtent(settings).height,
        .maxDepth = settings.biases.maxDepth,
        .rouletteStart = settings.roulette.start,
        .survival = settings.roulette.survival,
        .frameDepth = FrameDepth(settings),
        .clampIndirect = settings.biases.clampIndirect,
        .regularize = settings.biases.regularize,
        .textureLod = settings.biases.textureLod,
        .sceneOrigin = scene.origin,
        .pixelList = {settings.pixels.AddressLow(), settings.pixels.AddressHigh()},
        .pixelListWidth = settings.pixels.extent.width,
        .pixelListCount = settings.pixels.count,
    };
}

void BindTracing(PassBuilder& pass, const SceneIds& scene, const gpu::TraceParameters& parameters,
                 AlphaTest alphaTest) {
    pass.Miss(RayType::Radiance, "scene/miss.rmiss");
    if (alphaTest == AlphaTest::On)
        BindHits(pass, scene, RayType::Radiance, scene.features.Has(kTraceAnyHit) ? kTestedHit : kOpaqueHit);
    else
        pass.HitGroup(RayType::Radiance, kOpaqueHit);
    pass.Reads("sceneTlas", scene.tlas);
    pass.ReadsByAddress(scene.blases);
    pass.Uniform("parameters", parameters);
}

void BindHits(PassBuilder& pass, const SceneIds& scene, RayType rayType, const HitGroupShaders& shaders,
              uint32_t number) {
    pass.HitGroup(rayType, shaders, HitSetOf(number, kHitSetTriangles));
    if (scene.features.Has(kTraceCapsules))
        pass.HitGroup(rayType, Capsules(shaders), HitSetOf(number, kHitSetCapsules));
}

void BindShadowRays(PassBuilder& pass, const SceneIds& scene) {
    pass.Miss(RayType::Shadow, "scene/shadow.rmiss");
    const HitGroupShaders& tested = scene.features.Has(kTraceThinWalls) ? kWallShadow : kTestedShadow;
    const bool areTested = scene.features.Has(kTraceThinWalls | kTraceAnyHit);
    BindHits(pass, scene, RayType::Shadow, areTested ? tested : kOpaqueShadow);
}

bool UsesSoftwareTraversal(const SceneIds& scene, const TraceSettings& settings) {
    return settings.traversal != Traversal::Driver && scene.wideNodes.IsValid();
}

void BindSoftwareTracing(PassBuilder& pass, const SceneIds& scene, const gpu::TraceParameters& parameters) {
    pass.Reads("wideNodes", scene.wideNodes);
    pass.Reads("wideTriangles", scene.wideTriangles);
    pass.Reads("wideInstances", scene.wideInstances);
    pass.Specialize("kWideLevels", scene.hasOneWideLevel ? 1u : 2u);
    pass.Uniform("parameters", parameters);
}

void BindLoopRays(PassBuilder& pass, const rhi::Device& device, const SceneIds& scene,
                  const TraceSettings& settings) {
    const TraceFeatures features = ProgramFeatures(scene, settings);
    const bool hasOneTrace = device.Info().type == rhi::DeviceType::Cpu &&
                             features.Has(kTraceLightSampling) &&
                             !features.Has(kTraceThinWalls | kTraceMatchedMedia);
    pass.Specialize("kLoopOptions", hasOneTrace ? kLoopOneTrace : 0u);
    if (!hasOneTrace && !UsesSoftwareTraversal(scene, settings)) BindShadowRays(pass, scene);
}

void BindInstances(PassBuilder& pass, const SceneIds& scene) {
    pass.Reads("instances", scene.instances);
    if (scene.deformedStreams.IsValid()) pass.ReadsByAddress(scene.deformedStreams);
}

void BindGeometry(PassBuilder& pass, const SceneIds& scene) {
    BindInstances(pass, scene);
    pass.Reads("geometries", scene.geometries);
}

void BindMaterials(PassBuilder& pass, const SceneIds& scene) {
    pass.Reads("materials", scene.materials);
    pass.Uses(scene.textures);
}

void BindEnvironment(PassBuilder& pass, const SceneIds& scene) {
    pass.Reads("environmentMap", scene.environmentMap, {.addressV = rhi::AddressMode::ClampToEdge});
}

void BindLights(PassBuilder& pass, const SceneIds& scene) {
    pass.Reads("lights", scene.lights);
    pass.Reads("lightNodes", scene.lightNodes);
    pass.Reads("lightAlias", scene.lightAlias);
    pass.Reads("lightMeshes", scene.lightMeshes);
    pass.Reads("lightProfiles", scene.lightProfiles);
    pass.Reads("environmentTable", scene.environmentTable);
}

void SpecializeFeatures(PassBuilder& pass, TraceFeatures features) {
    pass.Specialize("kTraceFeatures0", features.x);
    pass.Specialize("kTraceFeatures1", features.y);
}

void SpecializeDirect(PassBuilder& pass, const SceneIds& scene, const TraceSettings& settings,
                      bool hasTextureLevels) {
    TraceSettings direct;
    direct.scattering = settings.scattering;
    direct.isEnvironmentHidden = settings.isEnvironmentHidden;
    if (hasTextureLevels) direct.biases.textureLod = 0.0f;
    SpecializeModels(pass, settings,
                     ProgramFeatures(scene, direct) & ~FeaturesOfKind(TraceFeatureKind::Media));
}

TraceFeatures ProgramFeatures(const SceneIds& scene, const TraceSettings& settings) {
    TraceFeatures features = scene.features & ~Unused(scene, settings);
    if (settings.biases.shadowTerminator) features |= kTraceShadowTerminator;
    if (settings.isEnvironmentHidden) features |= kTraceHiddenEnvironment;
    if (settings.pixels.HasPixels()) features |= kTracePixelList;
    return features;
}

SceneIds WithFeatures(const SceneIds& scene, TraceFeatures features) {
    SceneIds wide = scene;
    wide.features |= features & ~FeaturesOfKind(TraceFeatureKind::Settings);
    return wide;
}

void SpecializeTrace(PassBuilder& pass, const SceneIds& scene, const TraceSettings& settings) {
    SpecializeModels(pass, settings, ProgramFeatures(scene, settings));
    pass.Specialize("kMis", static_cast<uint32_t>(settings.lights.mis));
    pass.Specialize("kRoulette", static_cast<uint32_t>(settings.roulette.kind));
    if (settings.pixels.HasPixels()) pass.ReadsByAddress(settings.pixels.list);
}

}  // namespace raygraph::passes
