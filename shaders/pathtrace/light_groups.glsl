// The light of a path by groups of lights: before integrator/path_state.glsl, which adds to it. Nothing
// unless LIGHT_GROUPS is defined.
#ifndef RAYGRAPH_PATHTRACE_LIGHT_GROUPS_GLSL
#define RAYGRAPH_PATHTRACE_LIGHT_GROUPS_GLSL

#ifdef LIGHT_GROUPS
vec3 groupSums[kMaxLightGroups];

// Returns the group of a light, and of its triangle if it is a mesh: FirstLightGroup of
// renderer/gpu_scene/lights/light_groups.h.
uint GroupOf(uint light, uint triangle) {
    LightRecord record = LightAt(light);
    uint group = record.flags >> kLightGroupShift;
    if (!HasTraceFeature(kTraceMeshLights) || record.kind != kLightMesh) return group;
    uint other = LightAt(LightMeshAt(record.primitive).firstLight + triangle).flags >> kLightGroupShift;
    return group == kLightGroupRest || other == kLightGroupRest ? max(group, other) : min(group, other);
}

void AddToGroup(vec3 value, uint light, uint triangle) {
    uint group = kLightGroupRest;
    if (light == LightSet().lightCount)
        group = kLightGroupEnvironment;
    else if (light != kNoLight)
        group = GroupOf(light, triangle);
    groupSums[min(group, kMaxLightGroups - 1u)] += value;
}

void ClearGroups() {
    for (uint i = 0u; i < kMaxLightGroups; ++i) groupSums[i] = vec3(0.0f);
}
#else
void ClearGroups() {}
#endif

#endif
