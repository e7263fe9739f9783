// Fuzzes the importer of glTF, and the writer of edited scenes.
#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <memory>

#include "renderer/scene/animation/pose.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/gltf/save_gltf.h"
#include "renderer/scene/model/check.h"
#include "tests/fuzz/gltf_files.h"

namespace raygraph::fuzz {

namespace {

// Saves the scene with every editable value edited: the file must load again, with the edited values.
void SaveEdited(SceneFolder& folder, scene::SceneData& scene, const std::filesystem::path& target) {
    for (const uint32_t node : scene.nodeOrder) scene.nodes[node].translation += glm::vec3(1.0f);
    for (scene::Material& material : scene.materials) {
        material.baseColorFactor = glm::vec4(0.25f);
        material.roughnessFactor = 0.75f;
        material.emissiveFactor = glm::vec3(0.5f);
        material.emissiveStrength = 3.0f;
        material.ior = 1.25f;
        material.isDoubleSided = !material.isDoubleSided;
    }
    for (scene::Light& light : scene.lights) light.intensity = 2.0f;
    for (scene::Node& node : scene.nodes) node.isVisible = !node.isVisible;
    const std::string name = target.filename().string();
    // The target itself, or a file beside it
    if (!Succeeds("", {ErrorKind::BadInput, ErrorKind::Io, ErrorKind::Usage},
                  [&] { scene::SaveGltf(folder.Scene(), scene, target, folder.Options()); }))
        return;
    scene::LoadOptions options = folder.Options();
    scene::DiskFileReader disk;
    options.reader = &disk;
    Require(Succeeds("", {},
                     [&] {
                         const scene::SceneData saved = scene::LoadGltf(target, options);
                         Require(saved.nodes.size() == scene.nodes.size(), "nodes are lost");
                         Require(saved.lights.size() == scene.lights.size(), "lights are lost");
                         Require(saved.materials.size() >= scene.materials.size(), "materials are lost");
                         for (size_t i = 0; i < scene.lights.size(); ++i)
                             Require(saved.lights[i].intensity == 2.0f, "a light's intensity is lost");
                         for (size_t i = 0; i < scene.nodes.size(); ++i)
                             Require(saved.nodes[i].isVisible == scene.nodes[i].isVisible,
                                     "a node's visibility is lost");
                         for (size_t i = 0; i < scene.materials.size(); ++i) {
                             Require(saved.materials[i].baseColorFactor == glm::vec4(0.25f),
                                     "a base color is lost");
                             Require(saved.materials[i].ior == 1.25f, "an ior is lost");
                             Require(saved.materials[i].emissiveStrength == 3.0f,
                                     "an emissive strength is lost");
                         }
                     }),
            "");
}

// Plays all animations, each at some times: the scene must stay drawable, and an animation with a defect must
// be refused. Ends in the rest pose.
void Play(scene::SceneData& scene) {
    scene::PoseEvaluator evaluator(scene);
    scene::PoseApplier applier(scene);
    for (uint32_t i = 0; i < scene.animations.size(); ++i)
        for (const double share : {0.0, 0.3, 1.0}) {
            const std::array clips{scene::ClipState{i, share * double{scene.animations[i].duration}}};
            if (!scene.animations[i].defect.empty()) {
                Require(!Succeeds(std::string(kSceneName) + ": animations[", {ErrorKind::BadInput},
                                  [&] { evaluator.Evaluate(scene, clips); }),
                        "an animation with a defect is played");
                continue;
            }
            applier.Apply(scene, evaluator.Evaluate(scene, clips));
            scene::Check(scene);
        }
    applier.Apply(scene, evaluator.Rest());
}

}  // namespace

SceneFolder::SceneFolder() {
    m_path = std::filesystem::canonical(m_folder.Path());
    for (const char* name : {kSceneName, kBufferName, kImageName}) std::ofstream(m_path / name).flush();
    m_files[kBufferName] = Bytes(65536);
    m_files[kImageName] = SmallPng();
    // The files also exist in the folder, to be copied beside a saved scene
    for (const auto& [name, bytes] : m_files)
        std::ofstream(m_path / name, std::ios::binary)
            .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

scene::LoadOptions SceneFolder::Options() {
    scene::LoadOptions options;
    // Limits are low, so that a file that claims much costs little time
    options.limits.maxGeometryBytes = 1 << 20;
    options.limits.maxImageExtent = 256;
    options.limits.maxImageTexels = 1 << 16;
    options.limits.maxAllImageTexels = 1 << 17;
    options.pointsAndLines = {.points = {.value = 0.1f}, .lines = {.value = 0.01f, .isRelative = true}};
    options.reader = this;
    return options;
}

std::vector<std::byte> SceneFolder::Read(const std::filesystem::path& path, uint64_t maxBytes) {
    Require(path.parent_path() == m_path, "a file outside of the scene's folder is read: " + path.string());
    const std::string name = path.filename().string();
    Bytes bytes = name == kSceneName ? Bytes(m_scene.begin(), m_scene.end()) : m_files.at(name);
    if (bytes.size() > maxBytes) throw Error(ErrorKind::Io, path.string() + ": too long");
    return bytes;
}

bool SceneFolder::Load(Input file, scene::SceneData* loaded) {
    m_scene = file;
    return Succeeds(std::string(kSceneName) + ": ", {ErrorKind::BadInput}, [&] {
        scene::SceneData scene = scene::LoadGltf(Scene(), Options());
        Require(Succeeds("", {}, [&] { scene::Check(scene); }), "");
        for (const std::string& warning : scene.warnings)
            Require(warning.find_first_of("\n\r\x1b") == warning.npos, "a warning is no line: " + warning);
        scene::UpdateWorldTransforms(scene);
        scene::HasEmission(scene);
        scene::Statistics(scene);
        Require(Succeeds("", {}, [&] { Play(scene); }), "");
        if (loaded) *loaded = std::move(scene);
    });
}

SceneFolder& SharedSceneFolder() {
    static SceneFolder folder;
    return folder;
}

void RunGltfText(Input input) {
    SharedSceneFolder().Load(input);
}

void RunGltfContainer(Input input) {
    SharedSceneFolder().Load(input);
}

void RunGltfSave(Input input) {
    if (input.empty()) return;
    // The first byte chooses the format to save
    const bool isGlb = std::to_integer<uint32_t>(input[0]) % 2 == 1;
    SceneFolder& folder = SharedSceneFolder();
    scene::SceneData scene;
    if (!folder.Load(input.subspan(1), &scene)) return;
    const test::TemporaryFolder saved;
    SaveEdited(folder, scene, saved / (isGlb ? "saved.glb" : "saved.gltf"));
}

}  // namespace raygraph::fuzz
