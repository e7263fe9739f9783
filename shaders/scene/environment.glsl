// Radiance that arrives from infinity.
#ifndef RAYGRAPH_SCENE_ENVIRONMENT_GLSL
#define RAYGRAPH_SCENE_ENVIRONMENT_GLSL

#include "core/equirect.glsl"
#include "scene/bindings.glsl"

SHADING_BEGIN

INLINE vec3 EnvironmentRadiance(vec3 direction) {
    EnvironmentRecord environment = parameters.value.environment;
    vec3 radiance = environment.radiance;
    if (environment.hasMap != 0u)
        radiance *=
            vec3(textureLod(environmentMap, EquirectFromDirection(direction, environment.rotation), 0.0f));
    return radiance;
}

SHADING_END

#endif
