#version 460
// One direction of a separable Gaussian blur; `sigma` is in texels.
layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 0) const int RADIUS = 12;
layout(binding = 0, rgba32f) uniform readonly image2D source;
layout(binding = 1, rgba32f) uniform writeonly image2D target;
layout(push_constant) uniform Push {
    ivec2 direction;
    float sigma;
};

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(target);
    if (any(greaterThanEqual(texel, size))) return;
    vec4 sum = vec4(0.0);
    float weights = 0.0;
    for (int i = -RADIUS; i <= RADIUS; ++i) {
        float weight = exp(-0.5 * float(i * i) / (sigma * sigma));
        sum += weight * imageLoad(source, clamp(texel + i * direction, ivec2(0), size - 1));
        weights += weight;
    }
    imageStore(target, texel, sum / weights);
}
