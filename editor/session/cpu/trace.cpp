#include "editor/session/cpu/trace.h"

#include <algorithm>

#include "editor/session/cpu/bindings.h"
#include "passes/scene_bindings.h"

// The program is that of pathtrace/pathtrace_main.glsl with a recorder, by software traversal.
#define RECORDS_PATHS
#define SOFTWARE_TRAVERSAL
#define TRACES_SHADOW_RAYS

#include "pathtrace/path_recorder.glsl"

#include "scene/camera.glsl"
#include "scene/environment.glsl"
#include "scene/light_bridge.glsl"
#include "scene/surface.glsl"

namespace raygraph::shading {

static inline bool IsAccepted(WideHit hit, bool isBack, bool isAny);

}  // namespace raygraph::shading

#include "scene/wide_bvh.glsl"

namespace raygraph::shading {

// Does for a capsule what scene/capsule.rint and the any-hit shaders do. Returns whether `hit` is set.
static bool MeetsCapsule(const session::CopiedCapsules& group, uint primitive, vec3 origin, vec3 direction,
                         float tMax, bool isAny, WideHit& hit) {
    const CapsuleRecord& capsule = group.capsules[primitive];
    const CapsuleHit ends = IntersectCapsule(capsule, origin, direction);
    const auto report = [&](float t, bool isBack) {
        if (!(t >= 0.0f && t <= tMax)) return false;
        const WideHit met{.t = t,
                          .instance = group.instance,
                          .primitive = primitive,
                          .barycentrics = CapsulePlaceOf(capsule, origin + t * direction)};
        if ((group.flags & kWideTested) != 0u && !IsAccepted(met, isBack, isAny)) return false;
        hit = met;
        return true;
    };
    if (report(ends.enter, false)) return true;
    const InstanceRecord instance = InstanceAt(group.instance);
    const GeometryRecord& geometry = geometries.at[GeometryIndex(instance, primitive)];
    return (materials.at[geometry.material].flags & kMaterialTwoSided) != 0u && report(ends.leave, true);
}

static bool MeetsBox(const Box& box, vec3 origin, vec3 inverse, float tMax) {
    const vec3 a = (box.min - origin) * inverse, b = (box.max - origin) * inverse;
    const vec3 low = min(a, b), high = max(a, b);
    constexpr float kMargin = 1.0f + 1e-5f;  // more than the roundings
    const float near = max(max(low.x, low.y), max(low.z, 0.0f));
    return near <= min(min(high.x, high.y), high.z) * kMargin && near <= tMax;
}

static WideHit HitOrCapsule(vec3 origin, vec3 direction, float tMax, bool isAny, WideHit hit) {
    if (hit.t >= 0.0f) {
        if (isAny) return hit;
        tMax = hit.t;
    }
    std::vector<uint> nodes;
    for (const session::CopiedCapsules& group : copiedScene->capsules) {
        const vec3 from = group.toObject * vec4(origin, 1.0f), along = mat3(group.toObject) * direction;
        const vec3 inverse(1.0f / AwayFromZero(along.x), 1.0f / AwayFromZero(along.y),
                           1.0f / AwayFromZero(along.z));
        nodes.assign(group.tree.nodes.empty() ? 0 : 1, 0u);
        while (!nodes.empty()) {
            const BinaryNode& node = group.tree.nodes[nodes.back()];
            nodes.pop_back();
            if (!MeetsBox(node.box, from, inverse, tMax)) continue;
            if (!node.IsLeaf()) {
                nodes.push_back(node.left);
                nodes.push_back(node.right);
            } else if (MeetsCapsule(group, group.tree.order[node.left], from, along, tMax, isAny, hit)) {
                if (isAny) return hit;
                tMax = hit.t;
            }
        }
    }
    return hit;
}

}  // namespace raygraph::shading

#include "scene/trace_rays.glsl"

#include "integrator/camera_media.glsl"
#include "integrator/extend_path.glsl"
#include "pathtrace/start.glsl"

namespace raygraph::session {

namespace {

// Sets the options of the shaders, which are the thread's, as SpecializeTrace does.
void SetOptions(const SceneIds& ids, const passes::TraceSettings& settings) {
    using namespace shading;
    threadTraceFeatures = passes::ProgramFeatures(ids, settings);
    threadSamplerKind = settings.sampler;
    threadBrdfModel = settings.scattering.brdf;
    threadMicrofacetModel = settings.scattering.distribution;
    threadMaskingModel = settings.scattering.masking;
    threadFresnelModel = settings.scattering.fresnel;
    threadMultiscatterKind = settings.scattering.multiscatter;
    threadLightSampler = settings.lights.sampler;
    threadMisHeuristic = settings.lights.mis;
    threadRoulette = settings.roulette.kind;
}

}  // namespace

CpuPath TraceOnCpu(const SceneCopy& scene, const passes::TraceSettings& settings, const glm::uvec2& pixel) {
    using namespace shading;
    passes::TraceSettings ofPixel = settings;
    ofPixel.region = {pixel.x, pixel.y, 1, 1};
    SetOptions(scene.ids, ofPixel);
    copiedScene = &scene;
    parameters.value = passes::ParametersFor(scene.ids, ofPixel);
    pathRecords.count = 0;
    pathRecords.at.Clear();
    const shading::PathSettings limits = SettingsOf(parameters.value);
    PathState path = shading::PathOf(uvec2(0u));
    if (HasTraceFeature(kTraceProbeMedia)) path.media = MediaAround(path.ray.origin);
    while (ExtendPath(path, limits)) {
    }
    if (IsCaught(path)) FinishCaught(path);
    copiedScene = nullptr;
    return {IsFinite(path.radiance) ? path.radiance : vec3(0.0f), pathRecords.at.Take(pathRecords.count)};
}

}  // namespace raygraph::session
