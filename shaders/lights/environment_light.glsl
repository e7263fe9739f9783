// Directions to the environment, by a table over the cells of its equirectangular map: a row, a cell of the
// row, then uniform in solid angle within the cell. A cell's probability comes from the interpolated map,
// less half of its mean: where the map is dim there is no density, and BSDF sampling finds it alone.
//
// The bridge: EnvironmentEntry EnvironmentEntryAt(uint), LightSetRecord LightSet().
#ifndef RAYGRAPH_LIGHTS_ENVIRONMENT_LIGHT_GLSL
#define RAYGRAPH_LIGHTS_ENVIRONMENT_LIGHT_GLSL

#include "core/equirect.glsl"
#include "lights/light_types.glsl"

SHADING_BEGIN

// Returns the solid angle of a cell in a row: dphi (cos theta0 - cos theta1), without the cancellation.
INLINE float EnvironmentCellSolidAngle(LightSetRecord lights, uint row) {
    float height = float(lights.environmentHeight);
    float middle = CosSinTurn((float(row) + 0.5f) * 0.5f / height).y;
    float halfStep = CosSinTurn(0.25f / height).y;
    return 2.0f * kTwoPi / float(lights.environmentWidth) * middle * halfStep;
}

struct EnvironmentSample {
    vec3 wi;
    float pdf;  // per solid angle
};

// Returns the entry that u chooses of `count` from `first`; the rest of u is uniform in it, as `fine` fills
// up its digits.
INLINE uint InvertEnvironmentTable(uint first, uint count, float fine, INOUT(float) u) {
    uint slot = min(uint(u * float(count)), count - 1u);
    uint low = EnvironmentEntryAt(first + slot).guide;
    uint high = slot + 1u < count ? EnvironmentEntryAt(first + slot + 1u).guide : count - 1u;
    while (low < high) {
        uint middle = (low + high) >> 1u;
        if (u < EnvironmentEntryAt(first + middle).end)
            high = middle;
        else
            low = middle + 1u;
    }
    float begin = low > 0u ? EnvironmentEntryAt(first + low - 1u).end : 0.0f;
    float size = EnvironmentEntryAt(first + low).end - begin;
    u = clamp((u - begin + fine / float(kEnvironmentSteps)) / size, 0.0f, kOneMinusEpsilon);
    return low;
}

// u selects the cell and the position in it; `fine` is uniform, too, and decides no more than the digits that
// u has not.
INLINE EnvironmentSample SampleEnvironmentLight(LightSetRecord lights, float fine, vec2 u) {
    uint row = InvertEnvironmentTable(0u, lights.environmentHeight, fine, u.y);
    uint firstCell = lights.environmentHeight + row * lights.environmentWidth;
    uint column = InvertEnvironmentTable(firstCell, lights.environmentWidth, fract(fine * 4096.0f), u.x);
    float probability = EnvironmentEntryAt(firstCell + column).probability;

    // The position is uniform in cos theta = 1 - 2 s, with s counted from the nearer pole: near it s is tiny
    // and 1 - 2 s is not
    float height = float(lights.environmentHeight);
    bool isUpper = 2u * row < lights.environmentHeight;
    float near = isUpper ? float(row) : float(lights.environmentHeight - row - 1u);
    float s0 = Sqr(CosSinTurn(0.25f * near / height).y);
    float s1 = Sqr(CosSinTurn(0.25f * (near + 1.0f) / height).y);
    float s = mix(s0, s1, isUpper ? u.y : 1.0f - u.y);
    float sinTheta = 2.0f * SafeSqrt(s * (1.0f - s));
    float cosTheta = isUpper ? 1.0f - 2.0f * s : 2.0f * s - 1.0f;
    float turn =
        (float(column) + u.x) / float(lights.environmentWidth) - 0.5f - lights.environmentRotation * kInv2Pi;
    vec2 azimuth = CosSinTurn(fract(turn));
    EnvironmentSample result;
    result.wi = vec3(sinTheta * azimuth.x, cosTheta, sinTheta * azimuth.y);
    result.pdf = probability / EnvironmentCellSolidAngle(lights, row);
    return result;
}

// Returns the density of a direction in SampleEnvironmentLight.
INLINE float EnvironmentLightPDF(LightSetRecord lights, vec3 wi) {
    vec2 uv = EquirectFromDirection(wi, lights.environmentRotation);
    uint column = min(uint(uv.x * float(lights.environmentWidth)), lights.environmentWidth - 1u);
    uint row = min(uint(uv.y * float(lights.environmentHeight)), lights.environmentHeight - 1u);
    uint cell = lights.environmentHeight + row * lights.environmentWidth + column;
    return EnvironmentEntryAt(cell).probability / EnvironmentCellSolidAngle(lights, row);
}

SHADING_END

#endif
