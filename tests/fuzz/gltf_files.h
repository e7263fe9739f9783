// Holds glTF files in memory, and the folder in which a fuzzed one seems to be.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "renderer/scene/gltf/file_access.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "tests/fuzz/target.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::fuzz {

inline constexpr const char* kSceneName = "scene.gltf";
inline constexpr const char* kBufferName = "b.bin";  // 64 KiB of zeros
inline constexpr const char* kImageName = "i.png";   // SmallPng()

// Has a folder with a scene, a buffer and an image. As a reader it returns what is in memory, and reports a
// finding if any other file is read.
class SceneFolder final : public scene::FileReader {
  public:
    SceneFolder();
    std::filesystem::path Scene() const { return m_path / kSceneName; }
    scene::LoadOptions Options();  // uses this as the reader, with low limits
    // Loads the file as the scene; false if it was refused.
    bool Load(Input file, scene::SceneData* loaded = nullptr);
    std::vector<std::byte> Read(const std::filesystem::path& path, uint64_t maxBytes) override;

  private:
    test::TemporaryFolder m_folder;
    std::filesystem::path m_path;  // canonical
    std::map<std::string, Bytes> m_files;
    Input m_scene;
};

// Returns the one that all calls share.
SceneFolder& SharedSceneFolder();

// Makes a .glb of a JSON and a BIN chunk.
Bytes MakeGlb(std::string_view json, Input binary);
// Returns the .glb that the target gltf_accessors makes of an input.
Bytes AccessorFile(Input input);
// Returns the .glb that the target gltf_compressed makes of an input of four bytes or more.
Bytes CompressedFile(Input input);
// Returns a PNG of 2 x 2 texels.
Bytes SmallPng();

}  // namespace raygraph::fuzz
