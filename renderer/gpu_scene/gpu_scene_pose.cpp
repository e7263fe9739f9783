// Poses of a GpuScene: what the setters of gpu_scene.cpp do, for all that an animation has changed.
#include "base/out_of_memory.h"
#include "base/text.h"
#include "renderer/gpu_scene/gpu_scene_impl.h"
#include "renderer/scene/deform.h"
#include "renderer/scene/pose_applier.h"

namespace raygraph {

void GpuScene::SetJointMatrices(uint32_t skin, std::span<const glm::mat4x3> matrices) {
    m_impl->RequireNoFrame("SetJointMatrices");
    const DeformResources* const deform = m_impl->resources->deform.get();
    RequireIndex("skin", skin, deform ? deform->skins.size() : 0);
    if (m_impl->deform->SetJointMatrices(skin, matrices)) ++m_impl->revisions.shapes;
}

void GpuScene::SetMorphWeights(uint32_t instance, std::span<const float> weights) {
    m_impl->RequireNoFrame("SetMorphWeights");
    RequireIndex("instance", instance, m_impl->instances->Count());
    if (!m_impl->deform)
        throw MakeError(ErrorKind::Usage, "GpuScene: SetMorphWeights: instance {} is not deformed", instance);
    if (m_impl->deform->SetMorphWeights(instance, weights)) ++m_impl->revisions.shapes;
}

void GpuScene::SetPose(const scene::SceneData& posed, const scene::PoseApplier& applier,
                       const scene::PoseChanges& changes) {
    m_impl->RequireNoFrame("SetPose");
    const auto require = [](const char* what, size_t given, size_t there) {
        if (given != there)
            throw MakeError(ErrorKind::Usage, "GpuScene: SetPose: {} {}, the scene has {}", given, what,
                            there);
    };
    const DeformResources* const deform = m_impl->resources->deform.get();
    require("instances", posed.instances.size(), m_impl->instances->Count());
    require("materials", posed.materials.size(), m_impl->resources->materialRecords.size());
    require("lights", posed.lights.size(), m_impl->lights->PunctualCount());
    if (!changes.skins.empty()) require("skins", posed.skins.size(), deform ? deform->skins.size() : 0);
    for (const uint32_t i : changes.instances)
        SetTransform(i, {posed.instances[i].objectToWorld, posed.instances[i].translationRest});
    for (const uint32_t i : changes.shown) SetVisible(i, applier.IsVisible(i));
    for (const uint32_t i : changes.materials) SetMaterial(i, posed.materials[i]);
    for (const uint32_t i : changes.lights)
        WithMemoryErrors("SetPose", [&] {
            if (m_impl->lights->Punctual(i) == posed.lights[i]) return;
            m_impl->lights->SetPunctual(i, posed.lights[i], LightPlace::OfNode);
            ++m_impl->revisions.lights;
        });
    for (const uint32_t i : changes.lightsShown) SetLightVisible(i, applier.IsLightVisible(i));
    for (const uint32_t i : changes.skins) SetJointMatrices(i, applier.JointMatricesOf(i));
    for (const uint32_t i : changes.reweighted)
        SetMorphWeights(i, scene::MorphWeights(posed, posed.instances[i]));
}

}  // namespace raygraph
