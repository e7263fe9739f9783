// The values of a vertex of an explained path, one row each, from which the records (path_record.h), their
// clearing and what is printed as JSON follow. Positions are relative to the scene's origin on the device.
// A value that a vertex does not have is 0; such an index is kNoRecord.
//
// To include this, define RAYGRAPH_PATH_VALUE(type, name) for the values of a vertex, or
// RAYGRAPH_CANDIDATE_VALUE(type, name) for those of a candidate for its light sample; `type` is float, uint,
// vec2, vec3, or PathIndex, a uint that is kNoRecord until it is known.
#ifndef RAYGRAPH_PATH_VALUE
#define RAYGRAPH_PATH_VALUE(type, name)
#endif
#ifndef RAYGRAPH_CANDIDATE_VALUE
#define RAYGRAPH_CANDIDATE_VALUE(type, name)
#endif

// The ray that arrives, and what it meets.
RAYGRAPH_PATH_VALUE(uint, ray)    // number within the path, shadow rays included; the camera's is 1
RAYGRAPH_PATH_VALUE(uint, depth)  // bounces before it
RAYGRAPH_PATH_VALUE(vec3, origin)
RAYGRAPH_PATH_VALUE(vec3, direction)
RAYGRAPH_PATH_VALUE(uint, event)          // kPathEvent*
RAYGRAPH_PATH_VALUE(float, distance)      // along the ray; negative: it met no surface
RAYGRAPH_PATH_VALUE(PathIndex, instance)  // of the scene
RAYGRAPH_PATH_VALUE(PathIndex, material)
RAYGRAPH_PATH_VALUE(PathIndex, primitive)  // triangle or capsule, in the order of the file
RAYGRAPH_PATH_VALUE(vec2, uv0)
RAYGRAPH_PATH_VALUE(vec2, uv1)
RAYGRAPH_PATH_VALUE(vec3, position)  // of the surface; where a medium scatters, that point
RAYGRAPH_PATH_VALUE(vec3, geometricNormal)
RAYGRAPH_PATH_VALUE(vec3, shadingNormal)
RAYGRAPH_PATH_VALUE(uint, isFront)
RAYGRAPH_PATH_VALUE(vec3, baseColor)  // this and the next three: textures included
RAYGRAPH_PATH_VALUE(float, metallic)
RAYGRAPH_PATH_VALUE(float, roughness)
RAYGRAPH_PATH_VALUE(float, transmission)

// The medium that the ray crosses.
RAYGRAPH_PATH_VALUE(PathIndex, medium)    // the material whose inside it is; kNoRecord: vacuum
RAYGRAPH_PATH_VALUE(float, mediumLength)  // meters
RAYGRAPH_PATH_VALUE(vec3, mediumWeight)   // factor on the throughput
RAYGRAPH_PATH_VALUE(float, wavelength)    // nm; 0: all colors

// The emission that the ray finds.
RAYGRAPH_PATH_VALUE(vec3, arriving)    // throughput there
RAYGRAPH_PATH_VALUE(vec3, emission)    // radiance
RAYGRAPH_PATH_VALUE(PathIndex, light)  // number of the light that it is
RAYGRAPH_PATH_VALUE(PathIndex, lightTriangle)
RAYGRAPH_PATH_VALUE(float, scatterPDF)      // density of the ray's direction; 0: no light sample finds this
RAYGRAPH_PATH_VALUE(float, lightPDF)        // density with which light sampling would have found it
RAYGRAPH_PATH_VALUE(float, emissionWeight)  // weight of multiple importance sampling
RAYGRAPH_PATH_VALUE(vec3, emitted)          // contribution to the sample

// The choice of the next direction.
RAYGRAPH_PATH_VALUE(float, passProbability)  // of going straight on: thin walls and matched boundaries
RAYGRAPH_PATH_VALUE(uint, lobe)              // kPathLobe*
RAYGRAPH_PATH_VALUE(float, lobeProbability)
RAYGRAPH_PATH_VALUE(uint, scatterFlags)  // kBxDF* (bxdf_flags.h) of the sample
RAYGRAPH_PATH_VALUE(vec3, scattered)     // the direction
RAYGRAPH_PATH_VALUE(vec3, bsdf)          // value of the BSDF or of the phase function
RAYGRAPH_PATH_VALUE(float, pdf)
RAYGRAPH_PATH_VALUE(float, cosine)
RAYGRAPH_PATH_VALUE(float, survival)  // probability of Russian roulette; 0: it was not played
RAYGRAPH_PATH_VALUE(float, rouletteNumber)

// The light sample: candidates, the shadow ray to the chosen one, and what comes along it.
RAYGRAPH_PATH_VALUE(uint, candidateCount)
RAYGRAPH_PATH_VALUE(PathIndex, chosen)  // candidate; kNoRecord: none brings light
RAYGRAPH_PATH_VALUE(vec3, shadowOrigin)
RAYGRAPH_PATH_VALUE(vec3, shadowDirection)
RAYGRAPH_PATH_VALUE(float, shadowDistance)
RAYGRAPH_PATH_VALUE(vec3, unoccluded)  // contribution if nothing is in the way
RAYGRAPH_PATH_VALUE(vec3, visibility)  // share that comes through
RAYGRAPH_PATH_VALUE(vec3, lit)         // contribution to the sample

// After the vertex.
RAYGRAPH_PATH_VALUE(uint, end)         // kPathEnd*
RAYGRAPH_PATH_VALUE(vec3, throughput)  // of the next ray
RAYGRAPH_PATH_VALUE(vec3, radiance)    // of the sample so far

RAYGRAPH_CANDIDATE_VALUE(PathIndex, light)     // number; kNoRecord: none was found
RAYGRAPH_CANDIDATE_VALUE(PathIndex, triangle)  // of a mesh that is one light
RAYGRAPH_CANDIDATE_VALUE(uint, kind)           // kPathLight*
RAYGRAPH_CANDIDATE_VALUE(PathIndex, instance)  // of the scene, if it is a surface
RAYGRAPH_CANDIDATE_VALUE(PathIndex, material)
RAYGRAPH_CANDIDATE_VALUE(float, probability)  // with which the light was chosen
RAYGRAPH_CANDIDATE_VALUE(float, pdf)          // with the direction, per solid angle; delta lights: the former
RAYGRAPH_CANDIDATE_VALUE(vec3, direction)
RAYGRAPH_CANDIDATE_VALUE(float, distance)
RAYGRAPH_CANDIDATE_VALUE(vec3, radiance)
RAYGRAPH_CANDIDATE_VALUE(vec3, bsdf)
RAYGRAPH_CANDIDATE_VALUE(float, scatterPDF)  // with which the BSDF would have drawn the direction
RAYGRAPH_CANDIDATE_VALUE(float, weight)      // of multiple importance sampling
RAYGRAPH_CANDIDATE_VALUE(float, share)       // weight by which resampling chooses among the candidates

#undef RAYGRAPH_PATH_VALUE
#undef RAYGRAPH_CANDIDATE_VALUE
