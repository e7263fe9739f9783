// PlaceShadowViews: assigns the tiles of the shadow atlas to lights, and computes the view of each tile. One
// workgroup; one invocation a view.
//
// Cascades: the camera's view is split at depths between uniform and logarithmic ones (Zhang, Sun, Xu and Lun
// 2006, "Parallel-Split Shadow Maps for Large-Scale Virtual Environments"). Each part lies in a sphere, so
// that turning the camera does not change its size, and the sphere's center moves in whole texels, so that
// edges do not crawl when the camera moves (Valient 2008, "Stable Rendering of Cascaded Shadow Maps",
// ShaderX6). Depths are rounded to powers of sqrt(2) for the same reason.
#version 460
#extension GL_GOOGLE_include_directive : require
#define NO_TLAS
#include "scene/extensions.glsl"

#include "core/frame.glsl"
#include "raster/scene_bounds.glsl"
#include "scene/bindings.glsl"

layout(local_size_x = 64) in;  // kMaxShadowViews
layout(set = 0, binding = 16, scalar) readonly buffer Bounds { SceneBoundsRecord value; } bounds;
layout(set = 0, binding = 17, scalar) writeonly buffer ShadowViews { ShadowView at[]; } shadowViews;
layout(set = 0, binding = 18, scalar) writeonly buffer ShadowLights { ShadowLight at[]; } shadowLights;
layout(push_constant, scalar) uniform Constants {
    uint punctualLights;
    uint viewSlots;
    uint tileSize;  // texels
} constants;

const float kMinSpotCosine = 0.5f;      // cosine of the half angle; wider ones are seen as point lights are
const float kSplitByFactor = 0.8f;   // 1: cascades grow by a factor; 0: evenly
const float kNearShare = 1e-4f;  // fraction of the scene's size: nearer to a light, nothing casts a shadow
const float kMinDepthShare = 2e-3f;  // fraction of the farthest depth: cascades do not begin nearer

shared uint lightOfView[kMaxShadowViews];
shared uint indexOfView[kMaxShadowViews];

LightRecord Light(uint ordinal) {
    return lights.at[parameters.value.lights.lightCount - constants.punctualLights + ordinal];
}

float SpotCosine(LightRecord light) {
    return clamp(-light.spotOffsetOrClearance / light.spotScale, -1.0f, 1.0f);
}

uint ShadowViewCount(LightRecord light) {
    if (dot(light.e2, vec3(1.0f)) <= 0.0f) return 0u;
    if (light.kind == kLightDirectional) return kShadowCascades;
    return light.kind == kLightSpot && SpotCosine(light) >= kMinSpotCosine ? 1u : kShadowFaces;
}

void AllocateTiles() {
    uint next = 0u;
    for (uint i = 0u; i < constants.punctualLights; ++i) {
        uint needed = ShadowViewCount(Light(i));
        if (next + needed > constants.viewSlots) needed = 0u;
        shadowLights.at[i].firstView = next;
        shadowLights.at[i].viewCount = needed;
        for (uint k = 0u; k < needed; ++k) {
            lightOfView[next + k] = i;
            indexOfView[next + k] = k;
        }
        next += needed;
    }
    for (; next < constants.viewSlots; ++next) lightOfView[next] = kNoLight;
}

// Returns a view that shows `halfWidth` to each side (perspective: at distance 1), and the margin around it.
ShadowView MakeView(vec3 origin, Frame frame, float halfWidth) {
    ShadowView view;
    view.texel = 2.0f * halfWidth / float(constants.tileSize - 2u * kShadowMargin);
    float film = 0.5f * view.texel * float(constants.tileSize);
    view.camera.origin = origin;
    view.camera.orthographic = 0u;
    view.camera.right = film * frame.y;  // to the right of up, as a camera's: faces keep their sides
    view.camera.up = film * frame.x;
    view.camera.forward = frame.z;
    view.camera.lensRadius = 0.0f;
    view.camera.focusDistance = 1.0f;
    view.camera.zNear = 1.0f;
    view.camera.zFar = 1.0f;
    view.camera.originResidual = vec3(0.0f);
    return view;
}

Frame FaceFrame(uint face) {
    float side = (face & 1u) == 0u ? 1.0f : -1.0f;
    uint axis = face >> 1u;
    return FrameFromZ(side * vec3(axis == 0u, axis == 1u, axis == 2u));
}

struct Sphere {
    vec3 center;
    float radius;
};

// Returns a sphere around what the camera sees between two depths.
Sphere SliceSphere(CameraRecord camera, float from, float to) {
    float square = dot(camera.right, camera.right) + dot(camera.up, camera.up);
    Sphere sphere;
    float depth = 0.5f * (from + to);
    if (camera.orthographic != 0u) {
        sphere.radius = sqrt(0.25f * (to - from) * (to - from) + square);
    } else {
        depth = min(depth * (1.0f + square), to);  // equally far from the corners near and far, if inside
        sphere.radius = sqrt((to - depth) * (to - depth) + to * to * square);
    }
    sphere.center = camera.origin + depth * camera.forward;
    return sphere;
}

// Returns the depth of a split between two depths.
float CascadeSplitDepth(float from, float to, float share) {
    return mix(mix(from, to, share), from * pow(to / from, share), kSplitByFactor);
}

ShadowView CascadeView(vec3 towards, uint cascade, SceneBox box) {
    CameraRecord camera = parameters.value.camera;
    Sphere scene;
    scene.center = 0.5f * (box.low + box.high);
    scene.radius = 0.5f * length(box.high - box.low);
    float nearest = 3.0e38f;
    float farthest = 0.0f;
    float first = 3.0e38f;
    float last = -3.0e38f;
    for (uint corner = 0u; corner < 8u; ++corner) {
        vec3 at = BoxCorner(box.low, box.high, corner);
        float depth = dot(at - camera.origin, camera.forward);
        nearest = min(nearest, depth);
        farthest = max(farthest, depth);
        first = min(first, dot(at, towards));
        last = max(last, dot(at, towards));
    }
    farthest = exp2(0.5f * ceil(2.0f * log2(max(farthest, 1e-6f))));
    nearest = exp2(0.5f * floor(2.0f * log2(max(nearest, kMinDepthShare * farthest))));
    float count = float(kShadowCascades);
    Sphere part =
        SliceSphere(camera, CascadeSplitDepth(nearest, farthest, float(cascade) / count),
                    CascadeSplitDepth(nearest, farthest, float(cascade + 1u) / count));
    if (part.radius > scene.radius) part = scene;
    Frame frame = FrameFromZ(towards);
    ShadowView view = MakeView(vec3(0.0f), frame, max(part.radius, 1e-6f));
    float margin = 1e-3f * (last - first) + view.texel;
    vec2 snapped = round(vec2(dot(part.center, frame.x), dot(part.center, frame.y)) / view.texel);
    view.camera.orthographic = 1u;
    view.camera.origin =
        view.texel * (snapped.x * frame.x + snapped.y * frame.y) + (first - margin) * frame.z;
    view.camera.zFar = last - first + 2.0f * margin;
    return view;
}

ShadowView ViewOf(LightRecord light, uint index) {
    SceneBox box = SceneBoxOf(bounds.value);
    if (light.kind == kLightDirectional) return CascadeView(light.e1, index, box);
    ShadowView view;
    float cosine = SpotCosine(light);
    if (light.kind == kLightSpot && cosine >= kMinSpotCosine)
        view = MakeView(light.p0, FrameFromZ(light.e1), sqrt(1.0f - cosine * cosine) / cosine);
    else
        view = MakeView(light.p0, FaceFrame(index), 1.0f);
    view.camera.zNear = max(kNearShare * length(box.high - box.low), 1e-6f);
    return view;
}

void main() {
    uint slot = gl_LocalInvocationIndex;
    if (slot == 0u) AllocateTiles();
    barrier();
    if (slot >= constants.viewSlots) return;
    uint light = lightOfView[slot];
    if (light == kNoLight) {
        shadowViews.at[slot].light = kNoLight;
        return;
    }
    ShadowView view = ViewOf(Light(light), indexOfView[slot]);
    view.light = light;
    shadowViews.at[slot] = view;
}
