// Color is linear, with Rec. 709 / sRGB primaries and white D65, everywhere except in displayed images.
#ifndef RAYGRAPH_CORE_COLOR_GLSL
#define RAYGRAPH_CORE_COLOR_GLSL

#include "core/glue.h"

SHADING_BEGIN

// Returns the relative luminance Y of Rec. 709 primaries (ITU-R BT.709).
INLINE float Luminance(vec3 c) { return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z; }

// These are the transfer functions of IEC 61966-2-1, for values in [0, 1].
INLINE float SrgbEncode(float linear) {
    return linear <= 0.0031308f ? 12.92f * linear : 1.055f * pow(linear, 1.0f / 2.4f) - 0.055f;
}

INLINE float SrgbDecode(float encoded) {
    return encoded <= 0.04045f ? encoded / 12.92f : pow((encoded + 0.055f) / 1.055f, 2.4f);
}

INLINE vec3 SrgbEncode(vec3 linear) {
    return vec3(SrgbEncode(linear.x), SrgbEncode(linear.y), SrgbEncode(linear.z));
}

INLINE vec3 SrgbDecode(vec3 encoded) {
    return vec3(SrgbDecode(encoded.x), SrgbDecode(encoded.y), SrgbDecode(encoded.z));
}

SHADING_END

#endif
