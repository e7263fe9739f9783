// Probe: one texel of two pictures.
#version 460
#extension GL_EXT_scalar_block_layout : require
layout(local_size_x = 1) in;

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D mean;
layout(set = 0, binding = 1, rgba32f) readonly uniform image2D variance;
layout(set = 0, binding = 2, scalar) writeonly buffer Texels { vec4 mean; vec4 variance; } texels;

layout(push_constant) uniform Constants { ivec2 pixel; } constants;

void main() {
    texels.mean = imageLoad(mean, constants.pixel);
    texels.variance = imageLoad(variance, constants.pixel);
}
