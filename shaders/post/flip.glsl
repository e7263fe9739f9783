// The color spaces and constants of FLIP (Andersson et al. 2020, "FLIP: A Difference Evaluator for
// Alternating Images", version 1 for low dynamic range). Numbers in parentheses are sections there.
#ifndef RAYGRAPH_POST_FLIP_GLSL
#define RAYGRAPH_POST_FLIP_GLSL

#include "core/color.glsl"

// Converts linear Rec. 709 to XYZ over the white point's XYZ.
vec3 FlipToWhiteRelative(vec3 c) {
    return vec3(10135552.0f * c.x + 8788810.0f * c.y + 4435075.0f * c.z,
                2613072.0f * c.x + 8788810.0f * c.y + 887015.0f * c.z,
                1425312.0f * c.x + 8788810.0f * c.y + 70074185.0f * c.z) /
           vec3(23359437.0f, 12288897.0f, 80288307.0f);
}

vec3 FlipFromWhiteRelative(vec3 v) {
    // This is the inverse of the matrix above
    return vec3(3.08034199f * v.x - 1.53739897f * v.y - 0.54294302f * v.z,
                -0.92117840f * v.x + 1.87592998f * v.y + 0.04524841f * v.z,
                0.05288129f * v.x - 0.20401121f * v.y + 1.15112991f * v.z);
}

// Converts to linearized CIELab (3.1.1).
vec3 FlipToOpponent(vec3 linear) {
    vec3 v = FlipToWhiteRelative(linear);
    return vec3(116.0f * v.y - 16.0f, 500.0f * (v.x - v.y), 200.0f * (v.y - v.z));
}

vec3 FlipFromOpponent(vec3 c) {
    float y = (c.x + 16.0f) / 116.0f;
    return FlipFromWhiteRelative(vec3(y + c.y / 500.0f, y, y - c.z / 200.0f));
}

float FlipLabCurve(float t) {
    const float delta = 6.0f / 29.0f;
    return t > delta * delta * delta ? pow(t, 1.0f / 3.0f) : t / (3.0f * delta * delta) + 4.0f / 29.0f;
}

// Converts to CIELab with chroma scaled by the lightness: Hunt's effect (3.1.2).
vec3 FlipToHuntLab(vec3 linear) {
    vec3 v = FlipToWhiteRelative(linear);
    float y = FlipLabCurve(v.y);
    float lightness = 116.0f * y - 16.0f;
    return vec3(lightness, 0.01f * lightness * 500.0f * (FlipLabCurve(v.x) - y),
                0.01f * lightness * 200.0f * (y - FlipLabCurve(v.z)));
}

float FlipHyAb(vec3 a, vec3 b) { return abs(a.x - b.x) + length(a.yz - b.yz); }

// Converts a distance of colors to an error in [0, 1] (3.1.3). Powers of 0 are undefined in GLSL.
float FlipColorError(vec3 reference, vec3 test) {
    const float exponent = 0.7f, share = 0.4f, at = 0.95f;
    // This is the maximum distance within the gamut: between green and blue
    float maximum = pow(FlipHyAb(FlipToHuntLab(vec3(0, 1, 0)), FlipToHuntLab(vec3(0, 0, 1))), exponent);
    float distance = FlipHyAb(reference, test);
    float error = distance > 0.0f ? pow(distance, exponent) : 0.0f;
    if (error < share * maximum) return error * at / (share * maximum);
    return min(1.0f, at + (error - share * maximum) / (maximum - share * maximum) * (1.0f - at));
}

// Differences in edges and points (3.2). Each is a length.
float FlipFeatureError(vec2 reference, vec2 test) {
    vec2 difference = abs(reference - test);
    return sqrt(clamp(max(difference.x, difference.y) * 0.70710678f, 0.0f, 1.0f));
}

#endif
