// Operators from scene-linear radiance to display values. Pure functions of one color; exposure is in stops.
// All but Linear end in the sRGB transfer function.
//
// Linear: clamp to [0, 1], not encoded. Code values are proportional to radiance, for measuring.
//
// Srgb: clamp to [0, 1].
//
// Reinhard: c / (1 + c) per channel. Reinhard et al. 2002, "Photographic Tone Reproduction", eq. 3.
//
// Aces: S. Hill's fit (2016) of the ACES reference rendering and sRGB output transforms.
//
// AgX: T. Sobotka's AgX base look (2022). Inset matrix, log2 over 16.5 stops about middle gray, the
// sigmoid of the configuration's generator in closed form, outset; the 2.2 power of its display encoding
// is then inverted.
//
// Neutral: Khronos PBR Neutral (2024). The identity minus the 4 % of Fresnel reflection, compressed from 0.8.
#ifndef RAYGRAPH_CORE_TONEMAP_GLSL
#define RAYGRAPH_CORE_TONEMAP_GLSL

#include "core/color.glsl"
#include "core/math.glsl"
#include "shared/choice.h"

SHADING_BEGIN

// All operators are white far below this; it keeps infinity out of their quotients.
CONST float kTonemapInputLimit = 1.0e6f;

// NaN and negative values become 0, infinity the limit.
INLINE float TonemapInput(float x) { return x > 0.0f ? min(x, kTonemapInputLimit) : 0.0f; }

INLINE vec3 TonemapReinhard(vec3 c) { return c / (vec3(1.0f) + c); }

// Returns the tone curve of Hill's fit, on a color in its working space.
INLINE vec3 AcesFitCurve(vec3 v) {
    vec3 numerator = v * (v + vec3(0.0245786f)) - vec3(0.000090537f);
    vec3 denominator = v * (0.983729f * v + vec3(0.4329510f)) + vec3(0.238081f);
    return numerator / denominator;
}

INLINE vec3 TonemapAces(vec3 c) {
    // The matrices are given by columns, into the transform's working space with its desaturation of the
    // input, and back to sRGB with that of the output.
    mat3 toRrt = mat3(vec3(0.59719f, 0.07600f, 0.02840f), vec3(0.35458f, 0.90834f, 0.13383f),
                      vec3(0.04823f, 0.01566f, 0.83777f));
    mat3 fromOdt = mat3(vec3(1.60475f, -0.10208f, -0.00327f), vec3(-0.53108f, 1.10813f, -0.07276f),
                        vec3(-0.07367f, -0.00605f, 1.07602f));
    return fromOdt * AcesFitCurve(toRrt * c);
}

// Returns the sigmoid of AgX on log-encoded [0, 1]: slope 2 at the pivot (10 of 16.5 stops, value 0.5), power
// 3 below it and 3.25 above, scaled to pass through (0, 0) and (1, 1).
INLINE float AgXSigmoid(float x) {
    float d = x - 10.0f / 16.5f;
    float scale = d < 0.0f ? 59.507875f : 69.862789f;
    float power = d < 0.0f ? 3.0f : 3.25f;
    return 0.5f + 2.0f * d * pow(1.0f + scale * pow(abs(d), power), -1.0f / power);
}

INLINE float AgXChannel(float x) {
    // 16.5 stops: from 10 below to 6.5 above middle gray, 0.18 = 2^-2.47393.
    float stops = log2(max(x, 1.0e-10f)) + 12.4739312f;
    return AgXSigmoid(clamp(stops / 16.5f, 0.0f, 1.0f));
}

INLINE vec3 TonemapAgX(vec3 c) {
    mat3 inset =
        mat3(vec3(0.842479062f, 0.042328242f, 0.042375655f), vec3(0.078433600f, 0.878468636f, 0.078433600f),
             vec3(0.079223745f, 0.079166127f, 0.879142974f));
    mat3 outset = mat3(vec3(1.196879005f, -0.052896852f, -0.052971636f),
                       vec3(-0.098020881f, 1.151903130f, -0.098043450f),
                       vec3(-0.099029744f, -0.098961177f, 1.151073673f));
    vec3 v = inset * c;
    v = outset * vec3(AgXChannel(v.x), AgXChannel(v.y), AgXChannel(v.z));
    v = clamp(v, vec3(0.0f), vec3(1.0f));
    return vec3(pow(v.x, 2.2f), pow(v.y, 2.2f), pow(v.z, 2.2f));
}

INLINE vec3 TonemapNeutral(vec3 c) {
    float startCompression = 0.8f - 0.04f;
    float desaturation = 0.15f;
    float least = min(c.x, min(c.y, c.z));
    float offset = least < 0.08f ? least - 6.25f * least * least : 0.04f;
    c = c - vec3(offset);
    float peak = MaxComponent(c);
    if (peak < startCompression) return c;
    float range = 1.0f - startCompression;
    float newPeak = 1.0f - range * range / (peak + range - startCompression);
    float white = 1.0f - 1.0f / (desaturation * (peak - newPeak) + 1.0f);
    return mix(c * (newPeak / peak), vec3(newPeak), white);
}

// Maps scene-linear to display-linear, both Rec. 709; the result is in [0, 1]. `op` is one of kTonemap*.
INLINE vec3 TonemapLinearLight(vec3 c, uint op) {
    c = vec3(TonemapInput(c.x), TonemapInput(c.y), TonemapInput(c.z));
    if (op == kTonemapReinhard)
        c = TonemapReinhard(c);
    else if (op == kTonemapAces)
        c = TonemapAces(c);
    else if (op == kTonemapAgX)
        c = TonemapAgX(c);
    else if (op == kTonemapNeutral)
        c = TonemapNeutral(c);
    return clamp(c, vec3(0.0f), vec3(1.0f));
}

// Returns the value for an 8-bit image: scene-linear radiance times 2^exposureEv, through `op`, encoded.
INLINE vec3 Tonemap(vec3 radiance, float exposureEv, uint op) {
    vec3 c = TonemapLinearLight(radiance * exp2(exposureEv), op);
    if (op == kTonemapLinear) return c;
    return SrgbEncode(c);
}

SHADING_END

#endif
