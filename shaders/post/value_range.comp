// ValueRange: minimum and maximum of the first channel over all pixels that have an alpha. Values are not
// negative, so their bits have the same order.
#version 460
#extension GL_EXT_scalar_block_layout : require

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0, rgba32f) readonly uniform image2D values;
// Both values start at 0.
layout(set = 0, binding = 1, scalar) buffer Range { uint notMinimum; uint maximum; } range;

shared uint sharedNotMinimum;
shared uint sharedMaximum;

void main() {
    if (gl_LocalInvocationIndex == 0u) {
        sharedNotMinimum = 0u;
        sharedMaximum = 0u;
    }
    barrier();
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(pixel, imageSize(values)))) {
        vec4 value = imageLoad(values, pixel);
        if (value.w > 0.0f) {
            uint bits = floatBitsToUint(max(value.x, 0.0f));
            atomicMax(sharedNotMinimum, ~bits);
            atomicMax(sharedMaximum, bits);
        }
    }
    barrier();
    if (gl_LocalInvocationIndex != 0u) return;
    atomicMax(range.notMinimum, sharedNotMinimum);
    atomicMax(range.maximum, sharedMaximum);
}
