// GpuScene: a scene on the device, refreshed every frame by passes it declares itself.
//
//   GpuScene scene(renderer);
//   scene.SetScene(scene::LoadGltf("box.gltf"));       // once: uploads geometry, textures, materials
//   ...every frame...
//   scene.SetTransform(3, objectToWorld);              // cheap: notes it
//   SceneIds ids = scene.Declare(renderer);            // passes: BuildBlas, UploadInstances, RefreshTlas,
//   ...
//
// The TLAS is refreshed every frame: no work when nothing moved, an update when instances were moved, shown
// or hidden, a rebuild when BLASes changed or updates have decayed it (tlas_quality.h); Statistics() says
// which. The host's work for instances is in proportion to those that changed, but in frames with a rebuild.
// Compaction is polled and never waited for. Objects come and go by Add, Stream and Remove, while all others
// keep their indices and stay as they are. An empty scene is legal: every ray misses. Edits come before
// Declare or after Execute; between the two they are refused with Error{Usage} (Renderer::DropFrame drops
// such a frame). The work of a frame counts when it has been submitted: after a dropped frame it is still
// due. Threads: that of the Renderer.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "base/api.h"
#include "renderer/bvh/traversal.h"
#include "renderer/gpu_scene/lights/light_groups.h"
#include "renderer/gpu_scene/lights/own_light.h"
#include "renderer/gpu_scene/scene_ids.h"
#include "renderer/gpu_scene/scene_statistics.h"
#include "renderer/gpu_scene/streaming/prepared_scene.h"
#include "renderer/gpu_scene/streaming/scene_upload.h"
#include "renderer/graph/renderer.h"
#include "renderer/image/image.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph {

namespace scene {
class PoseApplier;
struct PoseChanges;
}  // namespace scene
struct HostMesh;
struct HostTexture;

// Light from infinity: a constant, times an equirectangular map if there is one.
struct EnvironmentSettings {
    glm::vec3 radiance{0.0f};  // constant radiance, or the factor on the map
    float rotation = 0.0f;     // radians about +y
    // If SetEnvironmentMap has set no map, the scene's map (SceneData::environment) or the studio is used;
    // without either the environment is black.
    bool usesScene = false;
    DefaultLight defaultLight = DefaultLight::Auto;  // for usesScene

    bool operator==(const EnvironmentSettings&) const = default;
};

// Where the things of a part of the scene are: by their index in the part, their index in the scene.
// scene::kNone: not there yet, of a part that streams.
struct AddedPart {
    std::vector<uint32_t> textures, materials, meshes, instances, lights;
    uint32_t owner = 0;  // by which the scene knows what is still the part's
    bool isComplete = false;
};

// Of all parts that stream.
struct StreamProgress {
    uint64_t bytes = 0;  // that are on the device
    uint64_t of = 0;     // 0: nothing streams

    bool IsDone() const { return bytes == of; }
};

// When the light tree is rebuilt, where an update would do (docs/lights.md). Always: pictures depend on the
// scene as it is alone, not on what was shown before; own trees are then those of the scene as it was set,
// and only their boxes follow what moves.
enum class LightRule : uint8_t { Decay, Always };

struct GpuSceneDesc {
    uint64_t scratchBudget = 64ull << 20;     // bytes of build scratch at a time
    uint64_t compactionBudget = 64ull << 20;  // bytes of compacted structures made in one frame
    // Gives textures mip levels, made on the device when a scene is set; of those whose samplers filter
    // without levels, one stays. False: they cost nothing.
    bool textureLevels = false;
    // Samples along the longer axis of a footprint that raster views read of a texture with levels, at most;
    // 1: none, as if footprints were round. Beyond what the device has, that.
    float maxAnisotropy = 8.0f;
    // Bytes of all textures of a scene; 0: half of what the process may use of the largest heap of device
    // memory and by rhi::Device::LimitMemory, and no more than is left of it when the scene is set. Where
    // they take more, levels are dropped, of the largest textures first, and a warning says so.
    uint64_t textureBudget = 0;
    // Bytes of vertices and texels that Stream copies in one frame, 64 KiB at least; a mesh or a texture that
    // is larger takes several frames.
    uint64_t streamBudget = 8ull << 20;
    // Own: keeps trees of triangles beside the device's acceleration structures, which Trace then takes
    // (docs/performance.md). They need as much memory on the host as on the device. There are none while the
    // scene places round primitives, meshes that deform or are the host's, or more than a shader can bind:
    // then Trace takes the driver's structures. Auto: where own traversal is faster on the device.
    //
    // A scene begins with one tree over the triangles of all instances, if there are at most
    // kMaxLevelTriangles; else there are two levels, a tree over the instances above those of meshes. In
    // frames after instances have moved, the boxes of the tree follow; where that has made it worse by a
    // third, it is built again on another thread. In frames after instances have come, gone, been shown or
    // hidden, the host builds it again, of one level only up to kMaxRebuiltTriangles: once there are more,
    // there are two levels from then on.
    Traversal traversal = Traversal::Auto;
    // PrepareSettings::measuresLight of scenes and parts that come as SceneData. It does not follow the
    // environment, so that DefaultLight::Auto is the same whenever that is set. False saves the measurement
    // for a host that never shows the studio.
    bool measuresLight = true;
    LightRule lightRule = LightRule::Decay;
};

class RAYGRAPH_API GpuScene {
  public:
    explicit GpuScene(Renderer& renderer, const GpuSceneDesc& desc = {});
    ~GpuScene();
    GpuScene(const GpuScene&) = delete;
    GpuScene& operator=(const GpuScene&) = delete;

    // Replaces everything but the environment that was set. Consumes the data: host copies are freed as they
    // are uploaded. On an Error the old scene stays, and is drawn as before: everything that the new one
    // needs on the device, its acceleration structures included, is allocated before the old one is
    // destroyed, so either both fit or nothing changes. SetScene({}) waits for the device, so that the old
    // scene's memory is free when it returns. Error{Usage} for data that scene::Check refuses, for more
    // textures or instances than the device or GpuSceneDesc allow; Error{OutOfMemory} if it does not fit the
    // host or the device. An Error after the upload has begun leaves the data consumed: it has no meshes any
    // more, and is refused if it has instances.
    void SetScene(scene::SceneData&& scene);
    // The same of one that was prepared, on another thread for example: what is left is copying.
    void SetScene(PreparedScene&& scene);
    // The same in two steps. Upload begins, and the frames to come, of the scene that is shown, copy and
    // build as those of Stream do, until the upload IsReady: then SetScene has little left to do, in
    // proportion to the numbers of instances and lights. Before, it does the rest at once. Errors of an
    // upload are thrown by SetScene.
    std::shared_ptr<SceneUpload> Upload(PreparedScene&& scene);
    void SetScene(SceneUpload& upload);

    // --- What comes and goes. Everything else stays as it is, and keeps its index; the index of what has
    // gone may be used again. On an Error nothing has changed. The next frame builds the new BLASes and
    // rebuilds the TLAS; the host's work is in proportion to what comes or goes, but for tables of one record
    // a mesh's group of triangles, and for the light tables, which are made again where lights come.
    //
    // Adds a part with its own textures, materials, meshes, instances and lights, whose indices are within
    // the part. Of its variants that is shown which SceneData::variant names, for good; its environment,
    // cameras and animations count for nothing. Textures take what is left of the budget. Consumes the data.
    // Errors are those of SetScene; Error{Usage} also for deformed instances, which only SetScene takes.
    AddedPart Add(PreparedScene&& part);
    AddedPart Add(scene::SceneData&& part);
    // The same over the frames to come: each copies GpuSceneDesc::streamBudget, and none waits for the
    // device. An instance appears as soon as its mesh and materials are there. What is returned is filled by
    // Declare, and by nothing once the scene has been replaced. An Error in a frame drops that frame and
    // removes the part.
    std::shared_ptr<const AddedPart> Stream(PreparedScene&& part);
    StreamProgress Streaming() const;
    // Removes its instances and lights, then meshes, materials and textures, but for those that are used by
    // something else, which stay; what has gone already, and what has its index now, does not count. A part
    // that streams stops.
    void Remove(const AddedPart& part);

    // A mesh of one part may be placed by others, and materials and textures be shared: indices are those of
    // the scene. Error{Usage} for what does not exist, and for the numbers that scene::Check refuses.
    uint32_t AddInstance(uint32_t mesh, const scene::PlacedTransform& objectToWorld, bool isVisible = true);
    // As far as light sampling goes, the mean of the materials' emissive textures over each triangle is 1.
    uint32_t AddMesh(scene::Mesh&& mesh);
    uint32_t AddMaterial(const scene::Material& material);
    uint32_t AddLight(const scene::Light& light, bool isVisible = true);
    // What the device has already, of the host's own (host_objects.h).
    uint32_t AddMesh(const HostMesh& mesh);
    uint32_t AddTexture(const HostTexture& texture);
    // The vertices of a host's mesh have changed: its BLAS is built again in the next frame, or is the host's
    // own and has been. `bounds` are the new ones, finite and not empty.
    void MarkChanged(uint32_t mesh, const scene::Bounds& bounds);

    // Error{Usage} for what does not exist, and for what is used: a mesh by an instance, a material by a
    // mesh, a texture by a material, all of them by a part that streams and has brought them. Deformed
    // instances and their meshes go with the scene alone.
    void RemoveInstance(uint32_t instance);
    void RemoveMesh(uint32_t mesh);
    void RemoveMaterial(uint32_t material);
    void RemoveTexture(uint32_t texture);
    void RemoveLight(uint32_t light);

    // Tells whether the traversal is Own, by GpuSceneDesc or by measurement
    // (PrepareSettings::buildsWideBvhs).
    bool UsesWideBvhs() const;

    // The position from which the scene is viewed, in world space: the origin of the device's coordinates,
    // which are floats, is near there or at the scene's nearest place (docs/scenes.md). Costs
    // nothing while that is within 128 m of the origin. Beyond, the origin moves: the TLAS is rebuilt and
    // lights are placed again, and Revisions stay. Up to 1024 m that takes eight such calls in a row, so that
    // alternating viewpoints leave it as it is; the first call for a scene needs no others. Without a
    // viewpoint, the origin is the scene's place that is nearest to the world's origin.
    void SetViewpoint(const glm::dvec3& eye);

    // Instance indices are those of SceneData::instances. The translation is PlacedTransform::Place, added in
    // double; a plain matrix has no rest. A flat transform is given a thickness (flat_transform.h). Throws
    // Error{Usage} for an index out of range, and for a transform that is not finite or scales to nothing or
    // to a line.
    void SetTransform(uint32_t instance, const scene::PlacedTransform& objectToWorld) {
        SetTransforms({&instance, 1}, {&objectToWorld, 1});
    }
    void SetTransform(uint32_t instance, const glm::mat4x3& objectToWorld) {
        SetTransform(instance, scene::PlacedTransform{objectToWorld});
    }
    // The same for many, which costs less than one by one: of each of these instances; of one that is listed
    // twice the last. Error{Usage} also for lists of different lengths; Error{OutOfMemory}. On an Error
    // nothing has changed.
    void SetTransforms(std::span<const uint32_t> instances,
                       std::span<const scene::PlacedTransform> objectToWorld);
    bool HasInstance(uint32_t instance) const;  // not of one that was removed
    // The current transform, with its thickness if a flat one was set: setting it again changes nothing.
    const scene::PlacedTransform& Transform(uint32_t instance) const;
    // --- Instances with Instance::isDeformed. Those that agree in mesh, skin and, with morph targets, node
    // share one deformed copy of the mesh. SetScene shows the pose that the scene has, in its nodes; from
    // then on a host moves it by SetPose, or by the two calls below it. A copy whose instances are all
    // invisible follows in the frame in which one is shown.
    //
    // Everything that a PoseApplier has changed: transforms and visibility of instances, materials, lights,
    // joint matrices and morph weights. SetScene consumes its data, so a host that animates keeps an outline
    // of the scene, a copy without vertices and images, and gives that to the evaluator, to the applier and
    // to this call:
    //
    //     scene::DeformInstances(data);
    //     scene::SceneData posed = scene::PoseOutline(data);
    //     scene::PoseEvaluator evaluator(posed);
    //     scene::PoseApplier applier(posed);
    //     gpuScene.SetScene(std::move(data));
    //     ...every frame...
    //     gpuScene.SetPose(posed, applier, applier.Apply(posed, evaluator.Evaluate(posed, clips)));
    //
    // A joint whose matrix is beyond the numbers has the identity: the applier hides what it moves. Of what
    // has been removed nothing changes. Error{Usage}, before anything has changed, for a scene with other
    // numbers of instances, skins, materials, lights, joints or weights than the one that was set. Else the
    // errors of the setters: what they had been given before has then changed.
    void SetPose(const scene::SceneData& posed, const scene::PoseApplier& applier,
                 const scene::PoseChanges& changes);
    // The same of all that an applier may change, changed or not: after an Error, or PoseApplier::Refresh.
    void SetPose(const scene::SceneData& posed, const scene::PoseApplier& applier);
    // For a host that animates by itself: one matrix a joint of the skin, from the mesh's object space to
    // that of the instances with the skin (scene::JointMatrices). The next frame deforms their vertices and
    // refits their BLASes. Error{Usage} for a skin that does not exist, another count, none of a skin that
    // no deformed instance has, and for numbers that are not finite.
    void SetJointMatrices(uint32_t skin, std::span<const glm::mat4x3> matrices);
    // The weights of the morph targets of an instance, and of all that share its copy. Errors as above.
    void SetMorphWeights(uint32_t instance, std::span<const float> weights);

    // No ray hits an invisible instance, and no view draws it. SetScene makes those of invisible nodes
    // invisible. A change updates the TLAS, as SetTransform does.
    void SetVisible(uint32_t instance, bool isVisible) { SetVisible({&instance, 1}, isVisible); }
    // The same for many, which costs less than one by one. On an Error nothing has changed.
    void SetVisible(std::span<const uint32_t> instances, bool isVisible);
    bool IsVisible(uint32_t instance) const;
    // Changes factors; textures stay. Where rays treat the surface differently after that (culling, alpha,
    // straight transmission), the next frame rebuilds the BLASes that contain it, whose memory is allocated
    // when this returns. A material that did not emit when the scene was set, and has no emissive texture,
    // does not become a sampled light when it emits: it is found by BSDF sampling only. On an Error nothing
    // changes: Error{Usage} out of range, and for numbers that scene::Check refuses; Error{OutOfMemory}.
    void SetMaterial(uint32_t material, const scene::Material& values);

    // Shows a variant of the scene, an index into SceneData::variants; scene::kNone: none. SetScene shows
    // SceneData::variant. What is seen is the picture of a scene that was set with it (scene::SetVariant);
    // materials keep what SetMaterial made of them. Rebuilds the light tables if what emits has changed, and
    // BLASes like SetMaterial. On an Error nothing changes: Error{Usage} out of range; Error{OutOfMemory}.
    void SetVariant(uint32_t variant);
    uint32_t Variant() const;

    // A punctual light; indices are those of SceneData::lights. Updates the light tables, and nothing else.
    // Error{Usage} out of range, and for values that no file can have: numbers that are not finite, a
    // negative color or intensity, cone angles that are not 0 <= inner < outer <= pi / 2, a profile that the
    // scene does not have.
    void SetLight(uint32_t light, const scene::Light& values);
    const scene::Light& Light(uint32_t light) const;
    // An invisible light does not shine. A change updates the light tables. Error{Usage} out of range.
    void SetLightVisible(uint32_t light, bool isVisible);
    bool IsLightVisible(uint32_t light) const;

    // The groups of lights that Trace renders separately. For the current scene: SetScene removes
    // them. Error{Usage} for lists that are neither empty nor of the scene's sizes, or a group that is
    // out of range.
    void SetLightGroups(LightGroups groups);

    // Before the first call, and again for {.radiance = glm::vec3(1.0f), .usesScene = true}, the environment
    // is what the scene brings along, or the studio. Error{Usage} for values that are not finite, or negative
    // radiance.
    //
    // DefaultLight::Auto depends on what SetScene, Add and Stream load (see own_light.h), on lights of
    // AddLight, and on instances of AddMesh meshes that emit when the instance is added. Later edits of
    // these, and poses, never switch the studio on or off.
    void SetEnvironment(const EnvironmentSettings& settings);
    const EnvironmentSettings& Environment() const;
    // Environment() with its defaultLight resolved to what is shown now: it is never Auto, and Studio only
    // while the studio is the environment.
    EnvironmentSettings ShownEnvironment() const;
    // Finite, non-negative texels, rows from the zenith down. Error{Usage} otherwise, or if it is empty.
    // Stays when the scene is replaced, and counts instead of what a scene brings along.
    void SetEnvironmentMap(const image::ImageF& equirectangular);
    void RemoveEnvironmentMap();

    // Declares this frame's upkeep and returns the ids to trace against. Once a frame, before the passes that
    // use them.
    SceneIds Declare(Renderer& renderer);

    const GpuSceneStatistics& Statistics() const;
    // Counts edits when they are made, even before a frame applies them.
    const SceneRevisions& Revisions() const;
    // True when structures and deformed vertices are up to date: a frame like the last one, without another
    // edit, builds, compacts, deforms and refits nothing. The device's structures do not count where that
    // frame traced by own trees alone.
    bool IsSettled() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

}  // namespace raygraph
