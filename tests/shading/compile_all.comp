// Every text of the GLSL and C++ subset in one shader: what the CPU tests compile, glslang compiles too.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_scalar_block_layout : require

#include "bxdf/conductor.glsl"
#include "bxdf/dielectric.glsl"
#include "bxdf/diffuse.glsl"
#include "bxdf/lafortune.glsl"
#include "core/color.glsl"
#include "core/equirect.glsl"
#include "core/frame.glsl"
#include "core/ramp.glsl"
#include "core/ray_offset.glsl"
#include "core/rng.glsl"
#include "core/tonemap.glsl"
#include "core/warp.glsl"
#include "lights/light_types.glsl"
#include "shared/ray_types.h"

layout(local_size_x = 64) in;
layout(set = 0, binding = 0, scalar) writeonly buffer Output { vec3 texels[]; };
layout(push_constant, scalar) uniform Constants {
    uint width;
    uint seed;
    float exposureEv;
    uint op;
};

// The bridge of lights/lights.glsl
layout(set = 0, binding = 1, scalar) readonly buffer Lights { LightRecord lights[]; };
layout(set = 0, binding = 2, scalar) readonly buffer LightNodes { LightNode lightNodes[]; };
layout(set = 0, binding = 3, scalar) readonly buffer LightAlias { AliasEntry lightAlias[]; };
layout(set = 0, binding = 4, scalar) readonly buffer EnvironmentAlias { AliasEntry environmentAlias[]; };
layout(set = 0, binding = 5, scalar) uniform Set { LightSetRecord lightSet; };
LightSetRecord LightSet() { return lightSet; }
LightRecord LightAt(uint light) { return lights[light]; }
LightNode LightNodeAt(uint node) { return lightNodes[node]; }
AliasEntry LightAliasAt(uint slot) { return lightAlias[slot]; }
AliasEntry EnvironmentAliasAt(uint slot) { return environmentAlias[slot]; }
vec3 EnvironmentRadiance(vec3 direction) { return abs(direction); }
vec3 TriangleEmission(LightRecord light, vec2 barycentrics, vec3 toViewer) {
    return vec3(barycentrics, light.e1.x) * toViewer;
}
#include "lights/lights.glsl"

// The bridge of bxdf/energy.glsl
layout(set = 0, binding = 6, std430) readonly buffer EnergyTables { uvec4 at[]; } energyTables;
uvec4 EnergyEntryAt(uint index) { return energyTables.at[index]; }
#include "bxdf/gltf.glsl"

vec3 GltfMaterial(vec3 wo, float uc, vec2 u) {
    GltfBxDF lobe;
    lobe.baseColor = vec3(u, uc);
    lobe.metallic = uc;
    lobe.transmission = u.x;
    lobe.alpha = u;
    lobe.specular = u.y;
    lobe.specularColor = wo;
    lobe.eta = 1.0f + uc;
    lobe.isThin = u.x < 0.5f ? 1u : 0u;
    lobe.seed = seed;
    BSDFSample s = Sample_f(lobe, wo, uc, u);
    PreparedGltf prepared = Prepare(lobe, wo);
    float pdf = 0.0f;
    vec3 value = Evaluate(prepared, s.wi, pdf) + f(prepared, s.wi) + f(lobe, wo, s.wi);
    value += Sample_f(prepared, uc, u).f;
    return value * (PDF(prepared, s.wi) + PDF(lobe, wo, s.wi) + pdf + float(Flags(lobe)));
}

vec3 MicrofacetLobes(vec3 wo, float uc, vec2 u) {
    ConductorBxDF metal;
    metal.distribution = MakeMicrofacetDistribution(u);
    metal.fresnel = uc < 0.5f ? ConductorFromColor(wo, vec3(1.0f)) : ConductorFromIndices(wo, wo);
    DielectricBxDF glass;
    glass.distribution = metal.distribution;
    glass.eta = 1.0f + uc;
    glass.isThin = u.x < 0.5f;
    LafortuneBxDF phong;
    phong.diffuse = vec3(u, uc);
    phong.specular = vec3(uc, u);
    phong.exponent = LafortuneExponent(u.x);
    BSDFSample a = Sample_f(metal, wo, uc, u);
    BSDFSample b = Sample_f(glass, wo, uc, u);
    BSDFSample c = Sample_f(phong, wo, uc, u);
    float pdf = PDF(metal, wo, a.wi) + PDF(glass, wo, b.wi) + PDF(phong, wo, c.wi);
    uint flags = Flags(metal) | Flags(glass) | Flags(phong);
    float masking = G(glass.distribution, wo, b.wi, a.wi) * Lambda(glass.distribution, wo) *
                    G1(glass.distribution, wo);
    return f(metal, wo, a.wi) + f(glass, wo, b.wi) + f(phong, wo, c.wi) + vec3(pdf, float(flags), masking);
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    Sampler rng = StartPixelSample(uvec2(i % width, i / width), 0u, seed);
    Frame frame = FrameFromZ(SampleUniformSphere(Get2D(rng)));

    DiffuseBxDF lobe;
    lobe.albedo = vec3(Get1D(rng), 0.5f, 0.5f);
    vec3 wo = SampleUniformHemisphere(Get2D(rng));
    BSDFSample s = Sample_f(lobe, wo, Get1D(rng), Get2D(rng));
    float ratio = s.pdf > 0.0f ? PDF(lobe, wo, s.wi) / s.pdf : 0.0f;
    vec3 difference = f(lobe, wo, s.wi) - s.f;
    difference += MicrofacetLobes(wo, Get1D(rng), Get2D(rng));
    difference += GltfMaterial(wo, Get1D(rng), Get2D(rng));

    vec3 direction = FromLocal(frame, s.wi);
    vec2 uv = EquirectFromDirection(direction, 0.5f);
    vec3 back = ToLocal(frame, DirectionFromEquirect(uv, 0.5f)) + SampleUniformTriangle(uv);
    vec3 color = ratio * OffsetRayOrigin(back, frame.z, RayClearance(mat3(frame.x, frame.y, frame.z), uv.xxy, back, uv.xyy, uv.yyx, back)) + difference;
    color = SrgbDecode(color) * Luminance(color) * float(kRayTypeShadow * kRayTypeCount);

    LightContext context;
    context.position = back;
    context.normal = frame.z;
    LightSample light = SampleLight(context, Get1D(rng), Get2D(rng));
    color += light.radiance * light.pdf * LightPDF(context, light.light, light.wi, light.distance) *
             LightPDF(context, LightSet().lightCount, light.wi, light.distance);
    texels[i] = Tonemap(color, exposureEv, op) * EquirectSolidAnglePDF(1.0f, uv.y);
}
