#include "passes/trace.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <span>
#include <string>

#include "base/check.h"
#include "base/text.h"
#include "passes/add_compute.h"
#include "passes/scene_bindings.h"
#include "passes/wavefront.h"
#include "renderer/gpu_scene/camera_record.h"
#include "renderer/gpu_scene/materials/texture_set.h"
#include "shaders/shared/path_record.h"

namespace raygraph::passes {

namespace {

constexpr auto kPathPartNames = Texts(PathPart{});

std::string LoopOf(const TraceOutputs& outputs, const char* stage) {
    return std::string("pathtrace/pathtrace") + (outputs.parts ? "_parts" : "") +
           (outputs.lightGroups ? "_groups" : "") + (outputs.rayCounts ? "_counted" : "") +
           (outputs.record ? "_recorded" : "") + stage;
}

// More invocations than any device runs at once.
constexpr uint32_t kMaxInvocations = 1u << 18;

// Returns the invocations for a picture of that size: see pathtrace/pathtrace_main.glsl.
Extent2D InvocationsFor(Extent2D extent) {
    const uint64_t pixels = uint64_t{extent.width} * extent.height;
    return {static_cast<uint32_t>(std::min<uint64_t>(pixels, kMaxInvocations)), 1};
}

BufferId ZeroedBuffer(Renderer& renderer, const char* name, const char* pass, uint64_t size) {
    BufferId buffer = renderer.CreateBuffer(name, {.size = size});
    renderer.AddPass(
        pass, PassKind::Transfer, [&](PassBuilder& builder) { buffer = builder.CopiesTo(buffer); },
        [buffer](CommandList& commands, const PassResources& resources) {
            commands.Fill(resources.Buffer(buffer), 0);
        });
    return buffer;
}

}  // namespace

IntegratorForm DefaultForm(const rhi::Device& device) {
    return device.Info().type == rhi::DeviceType::Cpu ? IntegratorForm::Loop : IntegratorForm::Wavefront;
}

bool IsTracePass(std::string_view pass) {
    return pass == "Trace" || pass.starts_with("Wave");
}

Extent2D LightGroupTiles(uint32_t groupCount) {
    uint32_t columns = 1;
    while (columns * columns < groupCount) ++columns;
    return {columns, (groupCount + columns - 1) / columns};
}

uint32_t PreferredBatchSize(const rhi::Device& device, const TraceSettings& settings, uint32_t tileRows) {
    constexpr uint64_t kPaths = uint64_t{1} << 24, kBytesOfPath = 512;
    if (device.Info().type == rhi::DeviceType::Cpu || settings.roulette.kind == Roulette::Frame) return 1;
    const Region region = RegionOf(settings);
    const uint64_t inMemory = DefaultTextureBudget(device) / 4 / kBytesOfPath;
    const uint64_t rows = uint64_t{tileRows} * region.height;
    const uint64_t most = std::min({std::min(kPaths, inMemory) / region.PixelCount(),
                                    device.Info().maxTextureExtent / rows, uint64_t{64}});
    return std::bit_floor(std::max(static_cast<uint32_t>(most), 1u));
}

uint64_t PathCount(const TraceSettings& settings) {
    const uint64_t pixels =
        settings.pixels.HasPixels() ? settings.pixels.count : RegionOf(settings).PixelCount();
    return pixels * settings.sampleCount;
}

TraceIds Trace(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
               TraceOutputs outputs) {
    if (int{outputs.rayCounts} + outputs.record + (outputs.parts || outputs.lightGroups) > 1)
        throw Error(ErrorKind::Usage,
                    "Trace: two of ray counts, a record, and parts were asked for; it gives one of them");
    if (outputs.record && PathCount(settings) != 1)
        throw MakeError(ErrorKind::Usage, "Trace: a record of {} paths was asked for; it is of one",
                        PathCount(settings));
    if (const float survival = settings.roulette.survival; !(survival > 0.0f && survival <= 1.0f))
        throw MakeError(ErrorKind::Usage, "Trace: roulette.survival is {}, must be above 0 and at most 1",
                        survival);
    if (settings.sampleCount == 0 || (settings.sampleCount > 1 && settings.roulette.kind == Roulette::Frame))
        throw MakeError(ErrorKind::Usage, "Trace: sampleCount is {}, must be {}", settings.sampleCount,
                        settings.sampleCount == 0 ? "at least 1" : "1 with Roulette::Frame");
    if (settings.pixels.HasPixels() && settings.roulette.kind == Roulette::Frame)
        throw Error(ErrorKind::Usage,
                    "Trace: pixels have samples of their own, and Roulette::Frame one length of all paths");
    Extent2D traced = TracedExtent(settings);
    traced.height *= settings.sampleCount;
    TraceIds ids{.radiance = renderer.CreateTexture("radiance", {traced, Format::Rgba32Float})};
    if (outputs.rayCounts) {
        ids.rayCounts = renderer.CreateTexture("rayCounts", {traced, Format::R32Float});
        ids.bounces = renderer.CreateTexture("bounces", {traced, Format::R32Float});
    }
    for (size_t i = 0; outputs.parts && i < kPathPartCount; ++i)
        ids.parts[i] = renderer.CreateTexture(kPathPartNames[i], {traced, Format::Rgba32Float});
    if (outputs.lightGroups) {
        const Extent2D tiles = LightGroupTiles(scene.lightGroupCount);
        const Extent2D extent{tiles.width * traced.width, tiles.height * traced.height};
        ids.lightGroups = renderer.CreateTexture("lightGroups", {extent, Format::Rgba32Float});
    }
    const bool isSoftware = UsesSoftwareTraversal(scene, settings);
    ids.counts = ZeroedBuffer(renderer, "pixelQueue", "PixelQueue", sizeof(TraceCounts));
    if (outputs.record)
        ids.record =
            ZeroedBuffer(renderer, "pathRecords", "PathRecords",
                         sizeof(uint32_t) + gpu::kMaxRecordedVertices * sizeof(gpu::PathVertexRecord));
    const IntegratorForm form =
        settings.form == IntegratorForm::Auto ? DefaultForm(renderer.Device()) : settings.form;
    if (form == IntegratorForm::Wavefront && !outputs.rayCounts && !outputs.record)
        return TraceWavefront(renderer, scene, settings, outputs, ids);
    renderer.AddPass(
        "Trace", isSoftware ? PassKind::Compute : PassKind::RayTracing,
        [&](PassBuilder& pass) {
            if (isSoftware)
                pass.Compute(LoopOf(outputs, ".comp"));
            else
                pass.RayGen(LoopOf(outputs, ".rgen"));
            SpecializeTrace(pass, scene, settings);
            if (isSoftware)
                BindSoftwareTracing(pass, scene, ParametersFor(scene, settings));
            else
                BindTracing(pass, scene, ParametersFor(scene, settings), AlphaTest::On);
            BindLoopRays(pass, renderer.Device(), scene, settings);
            BindGeometry(pass, scene);
            BindMaterials(pass, scene);
            BindEnvironment(pass, scene);
            BindLights(pass, scene);
            pass.Reads("energyTables", scene.energyTables);
            ids.counts = pass.Updates("pixelQueue", ids.counts);
            ids.radiance = pass.Writes("radiance", ids.radiance);
            if (outputs.rayCounts) {
                ids.rayCounts = pass.Writes("rayCounts", ids.rayCounts);
                ids.bounces = pass.Writes("bounceCounts", ids.bounces);
            }
            if (outputs.record) ids.record = pass.Updates("pathRecords", ids.record);
            for (size_t i = 0; outputs.parts && i < kPathPartCount; ++i)
                ids.parts[i] = pass.Writes(kPathPartNames[i], ids.parts[i]);
            if (outputs.lightGroups) ids.lightGroups = pass.Writes("lightGroups", ids.lightGroups);
        },
        [extent = InvocationsFor(traced), isSoftware](CommandList& commands) {
            if (isSoftware)
                commands.DispatchOver(extent);
            else
                commands.TraceRays(extent);
        });
    return ids;
}

std::vector<gpu::PathVertexRecord> PathOf(const Readback& record) {
    record.Wait();
    const std::span<const std::byte> bytes = record.Bytes();
    uint32_t count = 0;
    std::memcpy(&count, bytes.data(), sizeof(count));
    RG_CHECK(count <= gpu::kMaxRecordedVertices);
    std::vector<gpu::PathVertexRecord> vertices(count);
    std::memcpy(vertices.data(), bytes.data() + sizeof(count), count * sizeof(gpu::PathVertexRecord));
    return vertices;
}

glm::vec3 ValueOf(std::span<const gpu::PathVertexRecord> path) {
    glm::vec3 sum(0.0f);
    for (const gpu::PathVertexRecord& vertex : path) {
        sum += vertex.emitted;
        sum += vertex.lit;
    }
    const bool isFinite = std::isfinite(sum.x) && std::isfinite(sum.y) && std::isfinite(sum.z);
    return isFinite ? sum : glm::vec3(0.0f);
}

PrimaryHitIds PrimaryHits(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                          FilmPosition film) {
    const Extent2D traced = RegionOf(settings).Extent();
    PrimaryHitIds hits{
        .albedo = renderer.CreateTexture("albedo", {traced, Format::Rgba32Float}),
        .normal = renderer.CreateTexture("normal", {traced, Format::Rgba32Float}),
        .position = renderer.CreateTexture("position", {traced, Format::Rgba32Float}),
        .ids = renderer.CreateTexture("ids", {traced, Format::Rgba32Uint}),
    };
    renderer.AddPass(
        "PrimaryHits", PassKind::RayTracing,
        [&](PassBuilder& pass) {
            pass.RayGen("pathtrace/primary_hits.rgen");
            pass.Specialize("kSamplerKind", static_cast<uint32_t>(settings.sampler));
            BindTracing(pass, scene, ParametersFor(scene, settings), AlphaTest::On);
            BindGeometry(pass, scene);
            BindMaterials(pass, scene);
            pass.Constants<uint32_t>(film == FilmPosition::Jittered ? 1u : 0u);
            hits.albedo = pass.Writes("albedo", hits.albedo);
            hits.normal = pass.Writes("normal", hits.normal);
            hits.position = pass.Writes("position", hits.position);
            hits.ids = pass.Writes("ids", hits.ids);
        },
        [traced](CommandList& commands) { commands.TraceRays(traced); });
    return hits;
}

GuideIds TraceGuides(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings, TextureId mean,
                     TextureId variance) {
    constexpr uint32_t kLeast = 16, kFurther = 192;
    const bool hasSeen = settings.sampleCount <= kMostSeenSamples && !scene.features.Has(kTraceProbeMedia);
    const uint32_t own = hasSeen ? settings.sampleCount : 0;
    struct {
        uint32_t leastCount, ownCount, mostCount, firstRow;
    } constants{kLeast, own, own > 0 ? own + kFurther : kLeast, 0};
    const Extent2D traced = RegionOf(settings).Extent();
    const auto texture = [&](const char* name) {
        return renderer.CreateTexture(name, {traced, Format::Rgba32Float});
    };
    GuideIds guides{
        .albedo = texture("guides.albedo"),
        .normal = texture("guides.normal"),
        .seen = texture("guides.seen"),
        .seenByAll = texture("guides.seenByAll"),
        .seenSquares = texture("guides.seenSquares"),
    };
    TraceSettings unlit = settings;
    unlit.lights.isOn = false;  // no light sampling
    renderer.AddPass(
        "TraceGuides", PassKind::RayTracing,
        [&](PassBuilder& pass) {
            pass.RayGen("pathtrace/guides.rgen");
            SpecializeTrace(pass, scene, unlit);
            BindTracing(pass, scene, ParametersFor(scene, settings), AlphaTest::On);
            BindGeometry(pass, scene);
            BindMaterials(pass, scene);
            BindEnvironment(pass, scene);
            BindLights(pass, scene);
            pass.Reads("energyTables", scene.energyTables);
            pass.Reads("mean", mean);
            pass.Reads("variance", variance);
            pass.Constants(constants);
            guides.albedo = pass.Writes("albedo", guides.albedo);
            guides.normal = pass.Writes("normal", guides.normal);
            guides.seen = pass.Writes("seen", guides.seen);
            guides.seenByAll = pass.Writes("seenByAll", guides.seenByAll);
            guides.seenSquares = pass.Writes("seenSquares", guides.seenSquares);
            pass.Dividable();
        },
        [traced, constants](CommandList& commands) mutable {
            const rhi::Portion rows = commands.PortionOf(traced.height);
            constants.firstRow = rows.first;
            commands.PushConstants(std::as_bytes(std::span(&constants, 1)));
            commands.TraceRays({traced.width, rows.end - rows.first});
        });
    return guides;
}

TextureId Preview(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings, float gain) {
    const PrimaryHitIds hits = PrimaryHits(renderer, scene, settings, FilmPosition::Center);
    const Extent2D extent = renderer.Desc(hits.albedo).extent;
    TextureId preview = renderer.CreateTexture("preview", {extent, Format::Rgba32Float});
    AddCompute(renderer, "Preview", "post/preview.comp", extent, [&](PassBuilder& pass) {
        pass.Reads("albedo", hits.albedo);
        pass.Reads("normal", hits.normal);
        pass.Constants(glm::vec4(settings.camera.forward, gain));
        preview = pass.Writes("preview", preview);
    });
    return preview;
}

TraceSettings FrameSettings(Extent2D extent, const scene::CameraView& camera, const LensSettings& lens,
                            const PathSettings& paths) {
    scene::CameraView view = camera;
    view.aspect = static_cast<float>(extent.width) / static_cast<float>(extent.height);
    TraceSettings settings;
    static_cast<PathSettings&>(settings) = paths;
    settings.extent = extent;
    settings.camera = ToRecord(view);
    settings.camera.lensRadius = lens.radius;
    settings.camera.focusDistance = lens.focusDistance;
    return settings;
}

}  // namespace raygraph::passes
