// The box around the scene, see shared/shadow_records.h.
#ifndef RAYGRAPH_RASTER_SCENE_BOUNDS_GLSL
#define RAYGRAPH_RASTER_SCENE_BOUNDS_GLSL

#include "shared/shadow_records.h"

// Returns unsigned numbers in the order of the floats; none is 0.
uint OrderedBits(float value) {
    uint bits = floatBitsToUint(value);
    return (bits & 0x80000000u) != 0u ? ~bits : bits | 0x80000000u;
}

float FloatOfOrdered(uint bits) {
    return uintBitsToFloat((bits & 0x80000000u) != 0u ? bits & 0x7FFFFFFFu : ~bits);
}

struct SceneBox {
    vec3 low;
    vec3 high;
};

// Returns the box of the scene; a point if the scene is empty.
SceneBox SceneBoxOf(SceneBoundsRecord bounds) {
    SceneBox box;
    box.low = vec3(0.0f);
    box.high = vec3(0.0f);
    if (bounds.max[0] == 0u) return box;
    box.low = -vec3(FloatOfOrdered(bounds.negatedMin[0]), FloatOfOrdered(bounds.negatedMin[1]),
                    FloatOfOrdered(bounds.negatedMin[2]));
    box.high =
        vec3(FloatOfOrdered(bounds.max[0]), FloatOfOrdered(bounds.max[1]), FloatOfOrdered(bounds.max[2]));
    return box;
}

// Returns corner 0 to 7 of a box.
vec3 BoxCorner(vec3 low, vec3 high, uint corner) {
    return vec3((corner & 1u) != 0u ? high.x : low.x, (corner & 2u) != 0u ? high.y : low.y,
                (corner & 4u) != 0u ? high.z : low.z);
}

#endif
