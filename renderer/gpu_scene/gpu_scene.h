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
// which. The host's work is in proportion to the instances that changed, except in frames with a rebuild.
// Compaction is polled and never waited for. Objects are added and removed by Add, Stream and Remove, while
// all others keep their indices. An empty scene is legal: every ray misses. Edits are legal before Declare or
// after Execute; between the two they throw Error{Usage} (Renderer::DropFrame drops such a frame). The work
// of a frame is done when it has been submitted: after a dropped frame it is still pending. Threads: that of
// the Renderer.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "base/api.h"
#include "renderer/bvh/traversal.h"
#include "renderer/gpu_scene/lights/light_groups.h"
#include "renderer/gpu_scene/lights/own_light.h"
#include "renderer/gpu_scene/scene_ids.h"
#include "renderer/gpu_scene/scene_memory.h"
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
    // If SetEnvironmentMap has set no map, the scene's map (SceneData::environment) or the studio is used.
    // Without either, the environment is black.
    bool usesScene = false;
    DefaultLight defaultLight = DefaultLight::Auto;  // for usesScene

    bool operator==(const EnvironmentSettings&) const = default;
};

// Where the scene has the objects of a part: by index in the part, the index in the scene. scene::kNone: the
// object of a part that streams is not in the scene yet.
struct AddedPart {
    std::vector<uint32_t> textures, materials, meshes, instances, lights;
    uint32_t owner = 0;  // the number under which the scene lists what the part owns
    bool isComplete = false;
};

// Holds the progress of all parts that stream, together.
struct StreamProgress {
    uint64_t bytes = 0;  // bytes on the device so far
    uint64_t of = 0;     // bytes in all; 0: nothing streams

    bool IsDone() const { return bytes == of; }
};

// When the light tree is rebuilt although an update would do (docs/sampling.md). With Always, pictures
// depend on the current scene alone, not on what was shown before. Raygraph's own BVHs then keep the topology
// of the scene as it was set, and only their boxes follow what moves.
enum class LightRule : uint8_t { Decay, Always };

struct GpuSceneDesc {
    uint64_t scratchBudget = 64ull << 20;     // bytes of build scratch at a time
    uint64_t compactionBudget = 64ull << 20;  // bytes of compacted structures per frame
    // Gives textures mip levels, which the device makes when a scene is set. A texture whose samplers filter
    // without levels has one level. False: levels take no time and no memory.
    bool textureLevels = false;
    // The maximum number of samples along the longer axis of a footprint when raster views read a texture
    // with levels; 1 treats footprints as round. It is clamped to what the device supports.
    float maxAnisotropy = 8.0f;
    // Bytes of all textures of a scene; 0: half of what the process may use of the largest heap of device
    // memory and by rhi::Device::LimitMemory, and no more than is left of it when the scene is set. If the
    // textures take more, levels are dropped, those of the largest textures first, and a warning says so.
    uint64_t textureBudget = 0;
    // Bytes of vertices and texels that Stream copies in one frame, at least 64 KiB. A larger mesh or texture
    // takes several frames.
    uint64_t streamBudget = 8ull << 20;
    // Own: keeps trees of triangles beside the device's acceleration structures, which Trace then takes
    // (docs/performance.md). They need as much memory on the host as on the device. There are none while the
    // scene places round primitives, meshes that deform or are the host's, or more than a shader can bind:
    // then Trace takes the driver's structures. Auto: where software traversal is faster on the device.
    //
    // A scene begins with one tree over the triangles of all instances, if there are at most
    // kMaxLevelTriangles; else there are two levels, a tree over the instances above those of meshes. In
    // frames after instances have moved, the boxes of the tree follow; where that has made it worse by a
    // third, it is built again on another thread. In frames after instances have come, gone, been shown or
    // hidden, the host builds it again, of one level only up to kMaxRebuiltTriangles: once there are more,
    // there are two levels from then on.
    Traversal traversal = Traversal::Auto;
    // PrepareSettings::measuresLight for scenes and parts that are set as SceneData. Changes of the
    // environment do not change it, so that DefaultLight::Auto gives the same whenever the environment is
    // set. False saves the measurement for a host that never shows the studio.
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
    // scene's memory is free when it returns. Throws Error{Usage} for data that scene::Check refuses, and for
    // more textures or instances than the device or GpuSceneDesc allow; Error{OutOfMemory} if it does not fit
    // the host or the device. After an Error once the upload has begun, the data is consumed: it has no
    // meshes any more, and is refused if it has instances.
    void SetScene(scene::SceneData&& scene);
    // Replaces the scene by one that was prepared, on another thread for example, and only has to be copied.
    void SetScene(PreparedScene&& scene);
    // Replaces the scene in two steps. This call begins the upload, and the following frames of the scene
    // that is shown copy and build as those of Stream do, until the upload IsReady. Then SetScene has little
    // left to do, in proportion to the numbers of instances and lights. If it is called earlier, it does the
    // rest at once. Errors of an upload are thrown by SetScene.
    std::shared_ptr<SceneUpload> Upload(PreparedScene&& scene);
    void SetScene(SceneUpload& upload);

    // --- Adding and removing. All other objects stay as they are and keep their indices; the index of a
    // removed object may be used again. On an Error nothing has changed. The next frame builds the new BLASes
    // and rebuilds the TLAS. The host's work is in proportion to what is added or removed, except for tables
    // with one record per mesh's group of triangles, and for the light tables, which are rebuilt where lights
    // are added.
    //
    // Adds a part with its own textures, materials, meshes, instances and lights, whose indices are within
    // the part. The variant that SceneData::variant names is shown permanently; environment, cameras and
    // animations of the part are ignored. Its textures get what is left of the budget. Consumes the data.
    // Errors are those of SetScene; Error{Usage} also for deformed instances, which only SetScene takes.
    AddedPart Add(PreparedScene&& part);
    AddedPart Add(scene::SceneData&& part);
    // Adds a part over the following frames: each copies GpuSceneDesc::streamBudget bytes, and none waits for
    // the device. An instance appears as soon as its mesh and materials are on the device. Declare fills the
    // returned part, until the scene is replaced. An Error in a frame drops that frame and removes the part.
    std::shared_ptr<const AddedPart> Stream(PreparedScene&& part);
    StreamProgress Streaming() const;
    // Removes its instances and lights, then its meshes, materials and textures, except those that something
    // else uses. Objects that have been removed already are ignored, even if their index is in use again. A
    // part that streams stops.
    void Remove(const AddedPart& part);

    // Puts a ground under these bounds (scene::GroundUnder), or moves it there; empty ones remove it, and
    // so does SetScene. Views that draw leave it out. It is an instance beyond those of SetScene and Extend.
    // Costs nothing while the bounds stay. Errors are those of Add.
    void SetGround(const scene::Bounds& bounds);

    // An instance may place a mesh of any part, and parts may share materials and textures: indices are those
    // of the scene. Throws Error{Usage} for what does not exist, and for the numbers that scene::Check
    // refuses.
    uint32_t AddInstance(uint32_t mesh, const scene::PlacedTransform& objectToWorld, bool isVisible = true);
    // For light sampling, the mean of a material's emissive texture over each triangle is taken as 1.
    uint32_t AddMesh(scene::Mesh&& mesh);
    uint32_t AddMaterial(const scene::Material& material);
    uint32_t AddLight(const scene::Light& light, bool isVisible = true);
    // Adds a mesh or texture that the host has on the device already (host_objects.h).
    uint32_t AddMesh(const HostMesh& mesh);
    uint32_t AddTexture(const HostTexture& texture);
    // The vertices of a host's mesh have changed. Its BLAS is rebuilt in the next frame, or is the host's own
    // and the host has rebuilt it. `bounds` are the new ones, finite and not empty.
    void MarkChanged(uint32_t mesh, const scene::Bounds& bounds);

    // Throws Error{Usage} for what does not exist, and for what is in use: a mesh by an instance, a material
    // by a mesh, a texture by a material, and all of them by a part that streams and has added them. Deformed
    // instances and their meshes can only be removed with the scene.
    void RemoveInstance(uint32_t instance);
    void RemoveMesh(uint32_t mesh);
    void RemoveMaterial(uint32_t material);
    void RemoveTexture(uint32_t texture);
    void RemoveLight(uint32_t light);

    // Tells whether rays are traversed by Raygraph's own shaders, by GpuSceneDesc or by measurement
    // (PrepareSettings::buildsWideBvhs).
    bool UsesWideBvhs() const;

    // Sets the position from which the scene is viewed, in world space. The origin of the device's
    // coordinates, which are floats, is near it or at the scene's nearest place (docs/scenes.md). The call
    // costs nothing while the viewpoint is within 128 m of the origin. Beyond that the origin moves: the TLAS
    // is rebuilt and lights are placed again, while Revisions do not change. Up to 1024 m the origin moves
    // only after eight such calls in a row, so that alternating viewpoints do not move it; the first call for
    // a scene moves it at once. Without a viewpoint, the origin is the scene's place that is nearest to the
    // world's origin.
    void SetViewpoint(const glm::dvec3& eye);

    // Instance indices are those of SceneData::instances. The translation is PlacedTransform::Place, added in
    // double; a plain matrix has no rest. A flat transform is given a thickness (transforms.h). Throws
    // Error{Usage} for an index out of range, and for a transform that is not finite or scales to nothing or
    // to a line.
    void SetTransform(uint32_t instance, const scene::PlacedTransform& objectToWorld) {
        SetTransforms({&instance, 1}, {&objectToWorld, 1});
    }
    void SetTransform(uint32_t instance, const glm::mat4x3& objectToWorld) {
        SetTransform(instance, scene::PlacedTransform{objectToWorld});
    }
    // Sets many transforms, which costs less than one by one. The last one counts for an instance that is
    // listed twice. Error{Usage} also for lists of different lengths; Error{OutOfMemory}. On an Error nothing
    // has changed.
    void SetTransforms(std::span<const uint32_t> instances,
                       std::span<const scene::PlacedTransform> objectToWorld);
    bool HasInstance(uint32_t instance) const;  // false for one that was removed
    // The current transform, with its thickness if a flat one was set: setting it again changes nothing.
    const scene::PlacedTransform& Transform(uint32_t instance) const;
    // --- Instances with Instance::isDeformed. Those that agree in mesh, skin and, with morph targets, node
    // share one deformed copy of the mesh. SetScene shows the pose that the scene's nodes have; from then on
    // the host moves it by SetPose, or by SetJointMatrices and SetMorphWeights. A copy whose instances are
    // all invisible is updated in the frame in which one is shown.
    //
    // SetPose applies everything that a PoseApplier has changed: transforms and visibility of instances,
    // materials, lights, joint matrices and morph weights. SetScene consumes its data, so a host that
    // animates keeps an outline of the scene, a copy without vertices and images, and passes it to the
    // evaluator, to the applier and to this call:
    //
    //     scene::DeformInstances(data);
    //     scene::SceneData posed = scene::PoseOutline(data);
    //     scene::PoseEvaluator evaluator(posed);
    //     scene::PoseApplier applier(posed);
    //     gpuScene.SetScene(std::move(data));
    //     ...every frame...
    //     gpuScene.SetPose(posed, applier, applier.Apply(posed, evaluator.Evaluate(posed, clips)));
    //
    // A joint whose matrix is not finite gets the identity; the applier hides the instances that it moves.
    // Objects that have been removed are ignored. Throws Error{Usage}, before anything has changed, for a
    // scene with other numbers of instances, skins, materials, lights, joints or weights than the one that
    // was set. Otherwise the errors are those of the setters, and what was set before the error has changed.
    void SetPose(const scene::SceneData& posed, const scene::PoseApplier& applier,
                 const scene::PoseChanges& changes);
    // Applies everything that an applier may change, changed or not: after an Error, or PoseApplier::Refresh.
    void SetPose(const scene::SceneData& posed, const scene::PoseApplier& applier);
    // Adds the instances and lights that the outline has beyond those that were set, as copies that an
    // editor makes: SetPose moves them like the others, and they get the outline's indices. They are
    // invisible until SetPose shows them. Throws Error{Usage} for an instance that is deformed, and if
    // AddInstance or AddLight have taken an index; Error{OutOfMemory}. On an Error nothing has changed.
    void Extend(const scene::SceneData& posed);
    // For a host that animates by itself: one matrix per joint of the skin, from the mesh's object space to
    // that of the instances with the skin (scene::JointMatrices). The next frame deforms their vertices and
    // refits their BLASes. Throws Error{Usage} for a skin that does not exist, another count (none for a skin
    // that no deformed instance has), and for numbers that are not finite.
    void SetJointMatrices(uint32_t skin, std::span<const glm::mat4x3> matrices);
    // The weights of the morph targets of an instance, and of all that share its copy. Errors as above.
    void SetMorphWeights(uint32_t instance, std::span<const float> weights);

    // No ray hits an invisible instance, and no view draws it. SetScene makes the instances of invisible
    // nodes invisible. A change updates the TLAS, as SetTransform does.
    void SetVisible(uint32_t instance, bool isVisible) { SetVisible({&instance, 1}, isVisible); }
    // Sets many at once, which costs less than one by one. On an Error nothing has changed.
    void SetVisible(std::span<const uint32_t> instances, bool isVisible);
    bool IsVisible(uint32_t instance) const;

    // --- What a host's own passes meet (docs/write-a-pass.md). Raygraph's pictures do not depend on these:
    // a change updates the TLAS and restarts nothing. New instances have the defaults, those of SetScene too;
    // files have no such data. Errors change nothing: Error{Usage} for an instance that does not exist and
    // values out of range; Error{OutOfMemory}.
    //
    // Sets the host's bits, kMaskHost, of the mask by which rays meet a visible instance; by default all of
    // them. Rays of which each bit is one of the host's meet exactly the instances that share a bit.
    void SetHostMask(uint32_t instance, uint8_t mask) { SetHostMask({&instance, 1}, mask); }
    void SetHostMask(std::span<const uint32_t> instances, uint8_t mask);
    uint8_t HostMask(uint32_t instance) const;
    // Sets the number of the hit set, below kHitSetNumbers: passes that have hit groups for it
    // (PassBuilder::HitGroup, HitSetOf) run them, all others run those of number 0, the default.
    void SetHitSet(uint32_t instance, uint32_t number) { SetHitSet({&instance, 1}, number); }
    void SetHitSet(std::span<const uint32_t> instances, uint32_t number);
    uint32_t HitSet(uint32_t instance) const;

    // Changes factors; textures stay. Where rays treat the surface differently afterwards (culling, alpha,
    // straight transmission), the next frame rebuilds the BLASes that contain it, whose memory is allocated
    // when this returns. A material that did not emit when the scene was set, and has no emissive texture,
    // does not become a sampled light when it emits: only BSDF sampling finds it. On an Error nothing
    // changes: Error{Usage} for an index out of range and for numbers that scene::Check refuses;
    // Error{OutOfMemory}.
    void SetMaterial(uint32_t material, const scene::Material& values);

    // Exchanges the images of a[0] and b[0], of a[1] and b[1] and so on, in all materials: what read one
    // texture reads the other one's image, with its sampler. Light sampling keeps the means of emissive
    // textures that it has. Throws Error{Usage} for textures that do not exist and lists of different
    // lengths; Error{OutOfMemory}. On an Error nothing changes.
    void SwapTextures(std::span<const uint32_t> a, std::span<const uint32_t> b);

    // Shows a variant of the scene, an index into SceneData::variants; scene::kNone: none. SetScene shows
    // SceneData::variant. The picture equals that of a scene that was set with this variant
    // (scene::SetVariant), except for materials that SetMaterial has changed. Rebuilds the light tables if
    // emission has changed, and BLASes like SetMaterial. On an Error nothing changes: Error{Usage} out of
    // range; Error{OutOfMemory}.
    void SetVariant(uint32_t variant);
    uint32_t Variant() const;

    // Changes a punctual light; indices are those of SceneData::lights. Updates the light tables, and nothing
    // else. Throws Error{Usage} for an index out of range, and for values that no file can have: numbers that
    // are not finite, a negative color or intensity, cone angles that are not 0 <= inner < outer <= pi / 2, a
    // profile that the scene does not have.
    void SetLight(uint32_t light, const scene::Light& values);
    const scene::Light& Light(uint32_t light) const;
    // An invisible light does not shine. A change updates the light tables. Error{Usage} out of range.
    void SetLightVisible(uint32_t light, bool isVisible);
    bool IsLightVisible(uint32_t light) const;

    // Sets the groups of lights that Trace renders separately, for the current scene: SetScene removes them.
    // Throws Error{Usage} for lists that are neither empty nor of the scene's sizes, or a group that is out
    // of range.
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
    // Texels are finite and non-negative, rows go from the zenith down; otherwise, or for an empty image,
    // this throws Error{Usage}. The map stays when the scene is replaced, and overrides the map of a scene.
    void SetEnvironmentMap(const image::ImageF& equirectangular);
    void RemoveEnvironmentMap();

    // Declares the work of this frame and returns the ids to trace against. Must be called once a frame,
    // before the passes that use them.
    SceneIds Declare(Renderer& renderer);

    const GpuSceneStatistics& Statistics() const;
    // Edits are counted when they are made, even before a frame applies them.
    const SceneRevisions& Revisions() const;
    // Describes what passes of the last frame read by address and by slot, for a copy of the scene.
    SceneMemory Memory() const;
    // Imports the textures of the scene for a pass of the host, which reads them by the slots of Memory().
    TextureSetId Textures(Renderer& renderer) const;
    // Returns whether structures and deformed vertices are up to date: another frame without an edit would
    // build, compact, deform and refit nothing. The device's structures are ignored if the last frame traced
    // by Raygraph's own BVHs alone.
    bool IsSettled() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

}  // namespace raygraph
