// Every text of the GLSL and C++ subset in one shader: what the CPU tests compile, glslang compiles too.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_scalar_block_layout : require

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
layout(set = 0, binding = 4, scalar) readonly buffer EnvironmentTable { EnvironmentEntry environmentTable[]; };
layout(set = 0, binding = 8, scalar) readonly buffer LightMeshes { LightMeshRecord lightMeshes[]; };
layout(set = 0, binding = 9, scalar) readonly buffer Placements { mat4x3 placements[]; };
layout(set = 0, binding = 5, scalar) uniform Set { LightSetRecord lightSet; };
LightSetRecord LightSet() { return lightSet; }
LightRecord LightAt(uint light) { return lights[light]; }
LightNode LightNodeAt(uint node) { return lightNodes[node]; }
LightMeshRecord LightMeshAt(uint mesh) { return lightMeshes[mesh]; }
mat4x3 LightPlacement(uint instance) { return placements[instance]; }
AliasEntry LightAliasAt(uint slot) { return lightAlias[slot]; }
layout(set = 0, binding = 7, scalar) readonly buffer LightProfiles { float lightProfiles[]; };
float LightProfileAt(uint word) { return lightProfiles[word]; }
EnvironmentEntry EnvironmentEntryAt(uint slot) { return environmentTable[slot]; }
vec3 EnvironmentRadiance(vec3 direction) { return abs(direction); }
vec3 TriangleEmission(LightRecord light, vec2 barycentrics, vec3 toViewer) {
    return vec3(barycentrics, light.e1.x) * toViewer;
}
#include "lights/lights.glsl"

// The bridge of bxdf/energy.glsl
layout(set = 0, binding = 6, std430) readonly buffer EnergyTables { uvec4 at[]; } energyTables;
uvec4 EnergyEntryAt(uint index) { return energyTables.at[index]; }
#include "bxdf/gltf.glsl"

SurfaceMaterial MaterialOf(vec3 wo, float uc, vec2 u) {
    SurfaceMaterial material;
    material.baseColor = vec3(u, uc);
    material.metallic = uc;
    material.roughness = u.y;
    material.anisotropy = u.x;
    material.transmission = u.x;
    material.specular = u.y;
    material.specularColor = wo;
    material.ior = 1.5f;
    material.iridescenceThickness = 1e3f * u.y;
#define RAYGRAPH_MATERIAL_FACTOR(type, name, object, key, channels, space, feature, quantity) \
    material.name = type(u.y);
#define RAYGRAPH_MATERIAL_NUMBER(type, name, field, object, key, feature, quantity) material.name = type(u.x);
#include "shared/material_list.h"
    material.flags = 0u;
    material.id = 0u;
    return material;
}

SurfaceSetting SettingOf(SurfaceMaterial material, float uc, vec2 u) {
    SurfaceSetting setting = SettingOf(material, 1.0f + uc, 0.01f, seed);
    setting.isThin = u.x < 0.5f;
    return setting;
}

vec3 GltfMaterial(vec3 wo, float uc, vec2 u) {
    SurfaceMaterial material = MaterialOf(wo, uc, u);
    GltfBSDF g = Prepare(material, SettingOf(material, uc, u), wo);
    BSDFSample s = Sample_f(g, uc, u);
    float pdf = 0.0f;
    vec3 value = Evaluate(g, s.wi, pdf) + f(g, s.wi);
    float chance = PassThroughProbability(g);
    value += PassThroughWeight(g) + f(WithoutPassThrough(g, chance), s.wi) + 
             PassThroughWeight(material, SettingOf(material, uc, u), wo);
    return value * (PDF(g, s.wi) + pdf + float(g.flags));
}

// Every word of every lobe.
vec3 LobesAlone(vec3 wo, float uc, vec2 u) {
    SurfaceMaterial material = MaterialOf(wo, uc, u);
    SurfaceSetting setting = SettingOf(material, uc, u);
    FacetView view = ViewOf(material, setting, wo);
    float share = 1.0f;
    vec3 sum = vec3(0.0f);
#define ADD(Lobe, name, feature)                                                       \
    Lobe name;                                                                         \
    InitLobe(name, material, setting, view, share);                                   \
    BSDFSample name##Sample = Sample_f(name, view, uc, u);                             \
    sum += f(name, view, name##Sample.wi) * PDF(name, view, name##Sample.wi);          \
    sum += Reflected(name, view).albedo + Transmitted(name, view).albedo;              \
    sum += vec3(Weight(name, view), float(Flags(name, view)),                          \
                NormalizedTransmittance(name, view, PairOf(view, name##Sample.wi, false)));           \
    sum += WalkOf(name, view).reflect * float(IsWalked(name));                         \
    sum += PassThroughWeight(WithoutPassThrough(name), view) * PassThroughProbability(name, view);
    GLTF_LOBES(ADD)
#undef ADD
    return sum;
}

vec3 PhongLobe(vec3 wo, float uc, vec2 u) {
    LafortuneBxDF phong;
    phong.diffuse = vec3(u, uc);
    phong.specular = vec3(uc, u);
    phong.exponent = LafortuneExponent(u.x);
    BSDFSample s = Sample_f(phong, wo, uc, u);
    MicrofacetDistribution facets = MakeMicrofacetDistribution(u);
    float masking = G(facets, wo, s.wi, wo) * Lambda(facets, wo) * G1(facets, wo);
    return f(phong, wo, s.wi) + vec3(PDF(phong, wo, s.wi), float(Flags(phong)), masking);
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
    difference += LobesAlone(wo, Get1D(rng), Get2D(rng)) + PhongLobe(wo, Get1D(rng), Get2D(rng));
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
    color += light.radiance * light.pdf * LightPDF(context, light.light, light.triangle, light.wi, light.distance) *
             LightPDF(context, LightSet().lightCount, 0u, light.wi, light.distance);
    texels[i] = Tonemap(color, exposureEv, op) * EquirectSolidAnglePDF(1.0f, uv.y);
}
