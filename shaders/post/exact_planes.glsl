// The textures that hold the exact sums of an accumulated picture (passes/accumulate.h). Word k of the sum of
// channel c is component c of plane k. Word k of the sum of squares of a color channel is there too, in the
// planes of squares; its highest word, which seldom changes, is component w of plane c.
#ifndef RAYGRAPH_POST_EXACT_PLANES_GLSL
#define RAYGRAPH_POST_EXACT_PLANES_GLSL

#include "shared/exact_sums.h"

#ifndef PLANE_ACCESS
#define PLANE_ACCESS
#endif

layout(set = 0, binding = 4, rgba32ui) PLANE_ACCESS uniform uimage2D sum0;
layout(set = 0, binding = 5, rgba32ui) PLANE_ACCESS uniform uimage2D sum1;
layout(set = 0, binding = 6, rgba32ui) PLANE_ACCESS uniform uimage2D sum2;
layout(set = 0, binding = 7, rgba32ui) PLANE_ACCESS uniform uimage2D sum3;
#ifdef WITH_VARIANCE
layout(set = 0, binding = 8, rgba32ui) PLANE_ACCESS uniform uimage2D squares0;
layout(set = 0, binding = 9, rgba32ui) PLANE_ACCESS uniform uimage2D squares1;
layout(set = 0, binding = 10, rgba32ui) PLANE_ACCESS uniform uimage2D squares2;
layout(set = 0, binding = 11, rgba32ui) PLANE_ACCESS uniform uimage2D squares3;
#endif

#endif
