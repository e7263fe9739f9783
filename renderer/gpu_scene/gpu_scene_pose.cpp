// Poses of a GpuScene: applies everything that an animation has changed, as the setters of gpu_scene.cpp do.
#include <numeric>

#include "base/counted.h"
#include "base/out_of_memory.h"
#include "base/text.h"
#include "renderer/gpu_scene/gpu_scene_impl.h"
#include "renderer/scene/animation/deform.h"
#include "renderer/scene/animation/pose_applier.h"

namespace raygraph {

void GpuScene::SetJointMatrices(uint32_t skin, std::span<const glm::mat4x3> matrices) {
    m_impl->RequireNoFrame("SetJointMatrices");
    m_impl->scene->RequireMatrices("SetJointMatrices", skin, matrices.size());
    if (m_impl->scene->deform->SetJointMatrices(skin, matrices)) ++m_impl->context.revisions.shapes;
}

void GpuScene::SetMorphWeights(uint32_t instance, std::span<const float> weights) {
    m_impl->RequireNoFrame("SetMorphWeights");
    m_impl->scene->RequireWeights("SetMorphWeights", instance, weights.size());
    if (m_impl->scene->deform->SetMorphWeights(instance, weights)) ++m_impl->context.revisions.shapes;
}

void GpuScene::SetPose(const scene::SceneData& posed, const scene::PoseApplier& applier,
                       const scene::PoseChanges& changes) {
    m_impl->RequireNoFrame("SetPose");
    const auto require = [](const char* what, size_t given, size_t there) {
        if (given != there)
            throw MakeError(ErrorKind::Usage, "GpuScene: SetPose: {} {}, the scene has {}", given, what,
                            there);
    };
    require("instances", posed.instances.size(), m_impl->scene->setInstances);
    require("materials", posed.materials.size(), m_impl->scene->setMaterials);
    require("lights", posed.lights.size(), m_impl->scene->setLights);
    const DeformResources* const deform = m_impl->scene->geometry->deform.get();
    if (!changes.skins.empty()) require("skins", posed.skins.size(), deform ? deform->skins.size() : 0);
    for (const uint32_t i : changes.skins)
        m_impl->scene->RequireMatrices("SetPose", i, applier.JointMatricesOf(i).size());
    // A mesh may have weights without targets, which then move nothing
    const auto isMorphed = [&](uint32_t i) { return scene::HasTargets(posed, posed.instances[i]); };
    for (const uint32_t i : changes.reweighted)
        if (isMorphed(i))
            m_impl->scene->RequireWeights("SetPose", i,
                                          scene::MorphWeights(posed, posed.instances[i]).size());

    const auto isOwnedByScene = [](const Owners& owners, uint32_t i) {
        return owners.Of(i) == kOwnedByScene;
    };
    std::vector<uint32_t> moved, shown, hidden;
    std::vector<scene::PlacedTransform> places;
    WithMemoryErrors("SetPose", [&] {
        for (const uint32_t i : changes.instances) {
            if (!isOwnedByScene(m_impl->scene->owners.instances, i)) continue;
            moved.push_back(i);
            places.push_back({posed.instances[i].objectToWorld, posed.instances[i].translationResidual});
        }
        for (const uint32_t i : changes.shown)
            if (isOwnedByScene(m_impl->scene->owners.instances, i))
                (applier.IsVisible(i) ? shown : hidden).push_back(i);
    });
    SetTransforms(moved, places);
    SetVisible(shown, true);
    SetVisible(hidden, false);
    for (const uint32_t i : changes.materials)
        if (isOwnedByScene(m_impl->scene->owners.materials, i)) SetMaterial(i, posed.materials[i]);
    for (const uint32_t i : changes.lights)
        WithMemoryErrors("SetPose", [&] {
            if (!isOwnedByScene(m_impl->scene->owners.lights, i) ||
                m_impl->scene->lights.Punctual(i) == posed.lights[i])
                return;
            m_impl->scene->lights.SetPunctual(i, posed.lights[i], LightOwner::OfNode);
            ++m_impl->context.revisions.lights;
        });
    for (const uint32_t i : changes.lightsShown)
        if (isOwnedByScene(m_impl->scene->owners.lights, i)) SetLightVisible(i, applier.IsLightVisible(i));
    for (const uint32_t i : changes.skins)
        if (m_impl->scene->deform->FollowJoints(i, applier.JointMatricesOf(i)))
            ++m_impl->context.revisions.shapes;
    for (const uint32_t i : changes.reweighted)
        if (isMorphed(i)) SetMorphWeights(i, scene::MorphWeights(posed, posed.instances[i]));
}

void GpuScene::SetPose(const scene::SceneData& posed, const scene::PoseApplier& applier) {
    const auto numbers = [](size_t count) {
        std::vector<uint32_t> all(count);
        std::iota(all.begin(), all.end(), 0u);
        return all;
    };
    scene::PoseChanges all;
    WithMemoryErrors("SetPose", [&] {
        all.instances = all.shown = numbers(posed.instances.size());
        all.materials = numbers(posed.materials.size());
        all.lights = all.lightsShown = numbers(posed.lights.size());
        for (uint32_t i = 0; i < posed.skins.size(); ++i)
            if (!applier.JointMatricesOf(i).empty()) all.skins.push_back(i);
        for (uint32_t i = 0; i < posed.instances.size(); ++i)
            if (posed.instances[i].isDeformed) all.reweighted.push_back(i);
    });
    SetPose(posed, applier, all);
    m_impl->scene->RestartOrigin();
}

}  // namespace raygraph
