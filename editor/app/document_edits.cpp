// Implements edits of a document: their effect on the rest values, and their consequences.
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <utility>

#include "base/overloaded.h"
#include "base/text.h"
#include "editor/app/document.h"
#include "renderer/scene/geometry/flat_transform.h"
#include "renderer/scene/model/check.h"
#include "renderer/scene/model/light_fields.h"
#include "renderer/scene/model/material_fields.h"

namespace raygraph::editor {

namespace {

constexpr float kLargest = 1e18f;  // bound of a transform's numbers, so that their products stay finite

void RequireIndex(const char* what, uint32_t index, size_t count) {
    if (index >= count) throw MakeError(ErrorKind::Usage, "there is no {} {}", what, index);
}

// Copies to `rest` the parts in which `wanted` differs from `shown`.
void CopyChanges(const scene::TextureRef& shown, const scene::TextureRef& wanted, scene::TextureRef& rest) {
    if (wanted.texture != shown.texture) rest.texture = wanted.texture;
    if (wanted.texCoord != shown.texCoord) rest.texCoord = wanted.texCoord;
    scene::ForEachTransformField([&](const auto& field) {
        if (wanted.transform.*field.member != shown.transform.*field.member)
            rest.transform.*field.member = wanted.transform.*field.member;
    });
}
template <typename T>
void CopyChanges(const T& shown, const T& wanted, T& rest) {
    if (wanted != shown) rest = wanted;
}

[[noreturn]] void RejectAnimated() {
    throw Error(ErrorKind::Usage, "an animation changes this: it can be edited in the rest pose");
}

}  // namespace

bool Document::IsAnimated(scene::AnimatedProperty property, uint32_t object) const {
    const auto isIt = [&](const scene::AnimationChannel& channel) {
        return channel.target.property == property && channel.target.object == object;
    };
    return std::ranges::any_of(m_clips, [&](const scene::ClipState& clip) {
        return clip.weight > 0.0f && std::ranges::any_of(m_scene.animations[clip.animation].channels, isIt);
    });
}

Edit Document::ToRestEdit(const TransformEdit& shown) const {
    RequireIndex("node", shown.node, m_scene.nodes.size());
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 3; ++row)
            if (!(std::abs(shown.local[column][row]) < kLargest))
                throw Error(ErrorKind::Usage, "a node's transform has to be made of finite numbers");
    const scene::Node& node = m_scene.nodes[shown.node];
    const bool isTurned = shown.rest == glm::vec3(0.0f) && shown.local[3] == node.LocalTransform()[3];
    const glm::vec3 rest =
        isTurned ? node.translationResidual : shown.rest;  // keep the residual when only the rotation changed
    if (!m_isNodeAnimated[shown.node]) return TransformEdit{shown.node, shown.local, rest};
    const std::optional<scene::TransformParts> wanted = scene::PartsOf(shown.local, node);
    if (!wanted) throw Error(ErrorKind::Usage, "what an animation moves can neither be flat nor sheared");
    const scene::Node& own = m_rest.nodes[shown.node];
    PartsEdit edit{shown.node, {own.translation, own.rotation, own.scale}, own.translationResidual};
    const auto take = [&](scene::AnimatedProperty property, const auto& before, const auto& after, auto& to) {
        if (after == before) return;
        if (IsAnimated(property, shown.node)) RejectAnimated();
        to = after;
    };
    using Property = scene::AnimatedProperty;
    take(Property::Translation, node.translation, wanted->translation, edit.parts.translation);
    take(Property::Translation, node.translationResidual, rest, edit.rest);
    take(Property::Rotation, node.rotation, wanted->rotation, edit.parts.rotation);
    take(Property::Scale, node.scale, wanted->scale, edit.parts.scale);
    return edit;
}

Edit Document::ToRestEdit(const Edit& shown) const {
    return std::visit(Overloaded{[&](const TransformEdit& e) { return ToRestEdit(e); },
                                 [&](const PartsEdit& e) -> Edit { return e; },
                                 [&](const VisibilityEdit& e) -> Edit {
                                     RequireIndex("node", e.node, m_scene.nodes.size());
                                     return e;
                                 },
                                 [&](const MaterialEdit& e) -> Edit {
                                     RequireIndex("material", e.material, m_scene.materials.size());
                                     MaterialEdit edit{e.material, Rest().materials[e.material]};
                                     scene::ForEachMaterialField([&](const auto& field) {
                                         CopyChanges(m_scene.materials[e.material].*field.member,
                                                     e.values.*field.member, edit.values.*field.member);
                                     });
                                     scene::Check(edit.values, Text("material {}", e.material));
                                     return edit;
                                 },
                                 [&](const LightEdit& e) -> Edit {
                                     RequireIndex("light", e.light, m_scene.lights.size());
                                     LightEdit edit{e.light, Rest().lights[e.light]};
                                     scene::ForEachLightField(edit.values, [&](const auto& field) {
                                         CopyChanges(m_scene.lights[e.light].*field.member,
                                                     e.values.*field.member, edit.values.*field.member);
                                     });
                                     scene::Check(edit.values, Text("light {}", e.light));
                                     return edit;
                                 }},
                      shown);
}

Edit Document::Current(const Edit& of) const {
    const scene::SceneData& rest = Rest();
    return std::visit(Overloaded{
                          [&](const TransformEdit& e) -> Edit {
                              const scene::Node& node = rest.nodes.at(e.node);
                              return TransformEdit{e.node, node.LocalTransform(), node.translationResidual};
                          },
                          [&](const PartsEdit& e) -> Edit {
                              const scene::Node& node = rest.nodes.at(e.node);
                              return PartsEdit{e.node,
                                               {node.translation, node.rotation, node.scale},
                                               node.translationResidual};
                          },
                          [&](const VisibilityEdit& e) -> Edit {
                              return VisibilityEdit{e.node, rest.nodes.at(e.node).isVisible};
                          },
                          [&](const MaterialEdit& e) -> Edit {
                              return MaterialEdit{e.material, rest.materials.at(e.material)};
                          },
                          [&](const LightEdit& e) -> Edit {
                              return LightEdit{e.light, rest.lights.at(e.light)};
                          },
                      },
                      of);
}

void Document::Set(const Edit& edit) {
    const auto setIn = [&](scene::SceneData& scene) {
        std::visit(Overloaded{
                       [&](const TransformEdit& e) {
                           scene.nodes[e.node].matrix = e.local;
                           scene.nodes[e.node].translationResidual = e.rest;
                       },
                       [&](const PartsEdit& e) {
                           scene::Node& node = scene.nodes[e.node];
                           node.translation = e.parts.translation;
                           node.translationResidual = e.rest;
                           node.rotation = e.parts.rotation;
                           node.scale = e.parts.scale;
                       },
                       [&](const VisibilityEdit& e) { scene.nodes[e.node].isVisible = e.isVisible; },
                       [&](const MaterialEdit& e) { scene.materials[e.material] = e.values; },
                       [&](const LightEdit& e) {
                           scene::ForEachLightField(e.values, [&](const auto& field) {
                               scene.lights[e.light].*field.member = e.values.*field.member;
                           });
                       },
                   },
                   edit);
    };
    setIn(m_scene);
    if (m_scene.animations.empty()) return;
    setIn(m_rest);
    m_evaluator.ReadRest(m_rest);
}

void Document::Follow(const Edit& edit, GpuScene& gpu) {
    const auto changes = [&](std::initializer_list<uint32_t> nodes) -> const scene::PoseChanges& {
        return m_applier.Apply(m_scene, m_evaluator.Evaluate(m_scene, m_clips), nodes);
    };
    std::visit(Overloaded{
                   [&](const MaterialEdit& e) {
                       scene::PoseChanges all = changes({});
                       all.materials.push_back(e.material);
                       Push(all, gpu);
                   },
                   [&](const LightEdit& e) {
                       scene::PoseChanges all = changes({});
                       all.lights.push_back(e.light);
                       Push(all, gpu);
                   },
                   [&](const auto& e) { Push(changes({e.node}), gpu); },
               },
               edit);
}

void Document::Push(const scene::PoseChanges& changes, GpuScene& gpu) {
    const bool wasBehind = std::exchange(m_isDeviceStale, true);
    if (wasBehind)
        gpu.SetPose(m_scene, m_applier);
    else
        gpu.SetPose(m_scene, m_applier, changes);
    m_isDeviceStale = false;
}

void Document::Put(const Edit& edit, GpuScene& gpu) {
    ++m_changes;
    const Edit before = Current(edit);
    Set(edit);
    try {
        Follow(edit, gpu);
    } catch (...) {
        Set(before);
        Follow(before, gpu);
        throw;
    }
}

void Document::RequireShown(const Edit& edit) const {
    bool isShown = true;
    std::visit(Overloaded{
                   [](const TransformEdit&) {},
                   [](const PartsEdit&) {},
                   [&](const VisibilityEdit& e) { isShown = m_scene.nodes[e.node].isVisible == e.isVisible; },
                   [&](const MaterialEdit& e) {
                       const scene::Material& shown = m_scene.materials[e.material];
                       scene::ForEachMaterialField([&](const auto& field) {
                           isShown &= shown.*field.member == e.values.*field.member;
                       });
                   },
                   [&](const LightEdit& e) {
                       const scene::Light& shown = m_scene.lights[e.light];
                       scene::ForEachLightField(shown, [&](const auto& field) {
                           isShown &= shown.*field.member == e.values.*field.member;
                       });
                   },
               },
               edit);
    if (!isShown) RejectAnimated();
}

void Document::RequireValidPlacement(const TransformEdit& edit) const {
    const scene::PlacedTransform before{WorldTransform(edit.node)};
    const bool hadInverse = scene::CanInvert(before.matrix);
    const bool hadArea = scene::WithThickness(before, {}).has_value();
    const uint32_t parent = m_scene.nodes[edit.node].parent;
    const scene::PlacedTransform local{edit.local, edit.rest};
    const scene::PlacedTransform placed =
        parent == scene::kNone ? local : scene::Compose(m_applier.NodeTransforms()[parent], local);
    const std::string subject = Text("node {}", edit.node);
    for (const uint32_t below : Subtree(edit.node)) {
        if (hadArea && m_placed[below].instanceCount > 0) scene::CheckedPlacement(placed, {}, subject);
        if (hadInverse && m_placed[below].light != scene::kNone) scene::CheckTransform(placed, subject);
    }
}

}  // namespace raygraph::editor
