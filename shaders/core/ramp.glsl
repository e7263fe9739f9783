// False colors: a ramp for quantities, and a palette for ids.
#ifndef RAYGRAPH_CORE_RAMP_GLSL
#define RAYGRAPH_CORE_RAMP_GLSL

#include "core/color.glsl"
#include "core/math.glsl"

SHADING_BEGIN

// Converts OKLab to linear Rec. 709. B. Ottosson 2020, "A perceptual color space for image processing".
INLINE vec3 LinearFromOklab(vec3 lab) {
    float l = lab.x + 0.3963377774f * lab.y + 0.2158037573f * lab.z;
    float m = lab.x - 0.1055613458f * lab.y - 0.0638541728f * lab.z;
    float s = lab.x - 0.0894841775f * lab.y - 1.2914855480f * lab.z;
    l = l * l * l;
    m = m * m * m;
    s = s * s * s;
    return vec3(4.0767416621f * l - 3.3077115913f * m + 0.2309699292f * s,
                -1.2684380046f * l + 2.6097574011f * m - 0.3413193965f * s,
                -0.0041960863f * l - 0.7034186147f * m + 1.7076147010f * s);
}

// Returns a ramp over t in [0, 1], from dark blue over violet and red to light yellow, linear Rec. 709.
// OKLab's lightness grows evenly from 0.18 to 0.93, so that equal steps of t look equal, in gray too.
INLINE vec3 HeatColor(float t) {
    float x = clamp(t, 0.0f, 1.0f);
    float hue = 4.65f + 3.45f * x;  // radians, from blue upwards
    float chroma = 0.07f + 0.36f * x * (1.0f - x);
    vec3 color =
        LinearFromOklab(vec3(0.18f + 0.75f * x, chroma * cos(hue), chroma * sin(hue)));
    return clamp(color, vec3(0.0f), vec3(1.0f));
}

// Returns a distinct color for each id, display-encoded (not linear): neighbors get hues that are far apart,
// by steps of the golden ratio, and two levels of brightness.
INLINE vec3 IdColor(uint id) {
    float hue = float((id * 2654435769u) >> 8u) * 5.9604644775390625e-8f;
    float value = (id & 1u) == 0u ? 0.95f : 0.7f;
    vec3 turns = fract(vec3(hue) + vec3(0.0f, 1.0f / 3.0f, 2.0f / 3.0f));
    vec3 ramp = clamp(abs(turns * 6.0f - vec3(3.0f)) - vec3(1.0f), vec3(0.0f), vec3(1.0f));
    return value * (vec3(0.25f) + 0.75f * ramp);
}

SHADING_END

#endif
