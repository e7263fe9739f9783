// The specialization of a path tracing pipeline (shared/trace_options.h).
#ifndef RAYGRAPH_CORE_TRACE_OPTIONS_GLSL
#define RAYGRAPH_CORE_TRACE_OPTIONS_GLSL

#include "core/option.h"
#include "shared/trace_options.h"

SHADING_BEGIN

OPTION(BrdfModel, Brdf, 5, Gltf)
OPTION(MisHeuristic, Mis, 7, Power)
OPTION(Roulette, Roulette, 8, Throughput)
// The default is all features, without biases, and a camera that sees all.
OPTION_FEATURES(TraceFeatures, HasTraceFeature, 9, 12,
                ~(kTraceShadowTerminator | kTraceTextureLod | kTraceHiddenEnvironment))

// These options are for the integrator's loop only.
OPTION_BITS(LoopOptions, HasLoopOption, 10, 0u)

SHADING_END

#endif
