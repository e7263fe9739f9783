// An option: a number that the host sets when a pipeline is created (a specialization constant kName), so
// that branches on it fold. Compiled as C++, by the tests, it is a variable of the thread.
//
//   OPTION(Choice, Name, id, value)   one of a choice (shared/choice.h): ActiveName(); threadChoice in C++
//   OPTION_BITS(Name, Has, id, value) a set of bits: Has(bit); threadName in C++
//   OPTION_FEATURES(Name, HasAny, id, secondId, value) a set of TraceFeatures (shared/trace_options.h), in
//       constants kName0 and kName1: HasAny(features); threadName in C++
//
// `value` is the default. Each id is used once in all of shaders/; glslang refuses a second use of one in the
// same shader. The raster passes have 32 of their own (raster/rasterize.glsl).
#ifndef RAYGRAPH_CORE_OPTION_H
#define RAYGRAPH_CORE_OPTION_H

#include "core/glue.h"

#ifdef __cplusplus

#define OPTION(Choice, Name, id, value)                        \
    inline thread_local Choice thread##Choice = Choice::value; \
    inline uint Active##Name() {                               \
        return uint(thread##Choice);                           \
    }
#define OPTION_BITS(Name, Has, id, value)          \
    inline thread_local uint thread##Name = value; \
    inline bool Has(uint bit) {                    \
        return (thread##Name & bit) != 0u;         \
    }
#define OPTION_FEATURES(Name, HasAny, id, secondId, value)  \
    inline thread_local TraceFeatures thread##Name = value; \
    inline bool HasAny(TraceFeatures any) {                 \
        return thread##Name.Has(any);                       \
    }

#else

#define OPTION(Choice, Name, id, value)   layout(constant_id = id) const uint k##Name = k##Name##value;
#define OPTION_BITS(Name, Has, id, value) layout(constant_id = id) const uint k##Name = value;
#define OPTION_FEATURES(Name, HasAny, id, secondId, value)      \
    layout(constant_id = id) const uint k##Name##0 = (value).x; \
    layout(constant_id = secondId) const uint k##Name##1 = (value).y;
// These are macros, which no macro can define, so a new option gets its line here. The reason is that glslang
// makes a constant of operators on specialization constants but not of a call. rhi/shader_specializer.h
// starts from constants. clang-format off
#define ActiveBrdf()             kBrdf
#define ActiveDistribution()     kDistribution
#define ActiveFresnel()          kFresnel
#define ActiveLightSampler()     kLightSampler
#define ActiveMasking()          kMasking
#define ActiveMis()              kMis
#define ActiveMultiscatterKind() kMultiscatterKind
#define ActiveRoulette()         kRoulette
#define ActiveSamplerKind()      kSamplerKind
#define HasLoopOption(bit)       ((kLoopOptions & (bit)) != 0u)
#define HasTraceFeature(any)     (((kTraceFeatures0 & (any).x) | (kTraceFeatures1 & (any).y)) != 0u)
// clang-format on

#endif

#endif
