// BlurMap: an equirectangular map, blurred alike in all directions, with weights exp(-a^2 / 2s^2) of the
// angle a.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "core/math.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0) uniform sampler2D map;
layout(set = 0, binding = 1, rgba32f) writeonly uniform image2D blurred;

layout(push_constant, scalar) uniform Constants {
    float deviation;  // s, in radians
} constants;

const float kReach = 3.0f;  // deviations; beyond them the weight is below 0.012

float PolarAngle(int row, int height) { return kPi * (float(row) + 0.5f) / float(height); }

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(blurred);
    if (any(greaterThanEqual(texel, size))) return;
    float theta = PolarAngle(texel.y, size.y), reach = kReach * constants.deviation;
    // Within reach of a pole, all columns are; else the farthest is where a circle touches a meridian
    bool hasPole = reach >= min(theta, kPi - theta);
    float span = hasPole ? kPi : asin(sin(reach) / sin(theta));
    int across = int(ceil(span / kTwoPi * float(size.x)));
    int left = min(across, size.x / 2), right = min(across, (size.x - 1) / 2);  // no column counts twice
    float rowStep = kPi / float(size.y);
    int first = max(int(ceil((theta - reach) / rowStep - 0.5f)), 0);
    int last = min(int(floor((theta + reach) / rowStep - 0.5f)), size.y - 1);
    vec3 sum = vec3(0.0f);
    float weights = 0.0f;
    for (int row = first; row <= last; ++row) {
        float rowTheta = PolarAngle(row, size.y);
        for (int dx = -left; dx <= right; ++dx) {
            float cosine = cos(theta) * cos(rowTheta) +
                           sin(theta) * sin(rowTheta) * cos(kTwoPi * float(dx) / float(size.x));
            float angle = acos(clamp(cosine, -1.0f, 1.0f));
            if (angle > reach) continue;
            float weight = sin(rowTheta) * exp(-0.5f * Sqr(angle / constants.deviation));
            weights += weight;
            sum += weight * texelFetch(map, ivec2((texel.x + dx + size.x) % size.x, row), 0).xyz;
        }
    }
    imageStore(blurred, texel, vec4(sum / weights, 1.0f));
}
