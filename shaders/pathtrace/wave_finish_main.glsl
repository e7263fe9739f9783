// The last kernel of a wavefront: samples that are infinite or NaN become black.
#version 460
#extension GL_GOOGLE_include_directive : require
#define NO_TLAS
#define OUTPUTS_ARE_READ
#include "scene/extensions.glsl"

#include "scene/camera.glsl"
#include "scene/environment.glsl"
#include "scene/light_bridge.glsl"
#include "scene/surface.glsl"

#include "pathtrace/outputs.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(radiance)))) return;
    PathState path;
    path.radiance = imageLoad(radiance, texel).xyz;
    if (IsFinite(path.radiance)) return;
    LoadOutputs(texel, path);
    BlackenIfNotFinite(path);
    StoreOutputs(texel, path);
}
