// Pixels of a picture, and the samples that a pixel has while tiles of the next sample are rendered.
#ifndef RAYGRAPH_POST_PIXELS_GLSL
#define RAYGRAPH_POST_PIXELS_GLSL

bool IsInside(ivec2 pixel, ivec2 size) {
    return all(greaterThanEqual(pixel, ivec2(0))) && all(lessThan(pixel, size));
}

// An entry that is infinite or NaN counts as 0.
vec3 FiniteOr0(vec3 value) {
    bvec3 isFinite = lessThanEqual(abs(value), vec3(3.4e38f));  // false for NaN
    return mix(vec3(0.0f), value, isFinite);
}

// Returns the samples of a pixel: one more than `sampleCount` where tiles of the next one have reached it.
uint SamplesAt(uvec2 pixel, uint sampleCount, uint doneRows, uint doneColumns, uint bandHeight) {
    bool isAhead = pixel.y < doneRows || (pixel.y < doneRows + bandHeight && pixel.x < doneColumns);
    return sampleCount + (isAhead ? 1u : 0u);
}

#endif
