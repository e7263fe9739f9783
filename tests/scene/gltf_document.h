// A glTF file under construction, for tests: every accessor gets a buffer of its own as a data URI.
#pragma once

#include <array>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <glm/glm.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/model/scene_data.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::test {

using Json = nlohmann::json;
using Bytes = std::vector<std::byte>;

Bytes ToBytes(std::string_view text);
std::string DataUri(std::span<const std::byte> bytes);

template <typename T>
Bytes BytesOf(const std::vector<T>& values) {
    Bytes bytes(values.size() * sizeof(T));
    if (!bytes.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
    return bytes;
}

// glTF's numbers of component types.
inline constexpr int kInt8 = 5120, kUint8 = 5121, kInt16 = 5122, kUint16 = 5123, kUint32 = 5125,
                     kFloat = 5126;

template <typename T>
constexpr int ComponentTypeOf() {
    if constexpr (std::is_same_v<T, int8_t>) return kInt8;
    if constexpr (std::is_same_v<T, uint8_t>) return kUint8;
    if constexpr (std::is_same_v<T, int16_t>) return kInt16;
    if constexpr (std::is_same_v<T, uint16_t>) return kUint16;
    if constexpr (std::is_same_v<T, uint32_t>) return kUint32;
    return kFloat;
}

class GltfDocument {
  public:
    GltfDocument();

    // Each returns the index of what it added.
    size_t AddBufferView(const Bytes& bytes);
    // `components` values an element; the type's name follows from it (1: SCALAR, 3: VEC3).
    template <typename T>
    size_t AddAccessor(const std::vector<T>& values, size_t components, bool isNormalized = false) {
        return AddAccessorOver(AddBufferView(BytesOf(values)), ComponentTypeOf<T>(),
                               values.size() / components, components, isNormalized);
    }
    size_t AddAccessorOver(size_t view, int componentType, size_t count, size_t components,
                           bool isNormalized);
    size_t AddMesh(const Json& primitive);
    size_t AddMaterial(const Json& material);
    // A node in the default scene.
    size_t AddNode(const Json& node);
    size_t Add(const char* array, const Json& value);

    // The triangle (0,0,0) (1,0,0) (0,1,0), normals +z, on a node at the origin. Returns the primitive, to be
    // changed.
    Json& AddTriangle();

    std::string Text() const { return json.dump(); }

    Json json;
};

// A folder with a scene file in it, and a reader that records what is read from where.
class SceneFolder final : public scene::FileReader {
  public:
    SceneFolder();

    std::filesystem::path Write(std::string_view name, std::span<const std::byte> bytes) const;
    std::filesystem::path Write(std::string_view name, std::string_view text) const;
    const std::filesystem::path& Path() const { return m_path; }

    scene::SceneData Load(const GltfDocument& document, scene::LoadOptions options = {});
    scene::SceneData Load(std::span<const std::byte> file, scene::LoadOptions options = {});
    // The message of the Error{BadInput} that loading ends with; "loaded" or the other kind's name if it does
    // not.
    std::string LoadError(const GltfDocument& document, scene::LoadOptions options = {});
    std::string LoadError(std::span<const std::byte> file, scene::LoadOptions options = {});

    std::vector<std::byte> Read(const std::filesystem::path& path, uint64_t maxBytes) override;
    // Lists the files that were read, and holds bytes to return in place of a file's own.
    std::vector<std::filesystem::path> reads;
    std::map<std::filesystem::path, Bytes> replacements;

  private:
    TemporaryFolder m_folder;
    std::filesystem::path m_path;  // Canonical.
    scene::DiskFileReader m_disk;
};

// Loads from a folder made for this one call.
scene::SceneData Load(const GltfDocument& document, const scene::LoadOptions& options = {});
std::string LoadError(const GltfDocument& document, const scene::LoadOptions& options = {});

// Is a change that must be refused: the value at a JSON pointer, and the message after "scene.gltf: ".
struct RefusedChange {
    const char* where;
    Json value;
    const char* message;
};
// Each by itself; the changed document loads if the message is "loaded".
void ExpectRefused(const GltfDocument& document, const std::vector<RefusedChange>& changes);

// The only primitive of the only placed mesh.
const scene::Primitive& OnlyPrimitive(const scene::SceneData& scene);

// Packs JSON text and a BIN chunk (left out if nullptr) as .glb.
Bytes MakeGlb(std::string_view json, const Bytes* binary);

// A PNG of the given size, every texel `color`.
Bytes MakePng(uint32_t width, uint32_t height, std::array<uint8_t, 4> color);
// A PNG of these texels, 4 bytes each, rows from the top.
Bytes MakePngOf(uint32_t width, uint32_t height, const std::vector<uint8_t>& rgba);

// An accessor of 4 x 4 matrices, column by column.
size_t AddMatrices(GltfDocument& document, const std::vector<float>& values);

// An animation with one channel for `target`, e.g. {{"node", 0}, {"path", "scale"}}. Returns its index.
size_t AddAnimation(GltfDocument& document, size_t input, size_t output, const Json& target,
                    const char* interpolation = "LINEAR");
// The target of KHR_animation_pointer.
Json Pointer(const std::string& pointer);
// AddAnimation with accessors of these values, `components` numbers an element.
size_t Animate(GltfDocument& document, const Json& target, const std::vector<float>& times,
               const std::vector<float>& values, size_t components, const char* interpolation = "LINEAR");

// A triangle (0,0,0) (1,0,0) (0,1,0) with normals +z at node 0, whose vertices follow the joints node 1, node 2
// and half of each. Inverse bind matrices: node 1 none, node 2 moves by (-1, 0, 0). Both joints are roots, node 1
// at the origin, node 2 at (1, 0, 0): in the rest pose the mesh is as it was bound.
GltfDocument SkinnedTriangle();

// The greatest distance of two columns.
float Apart(const glm::mat4x3& a, const glm::mat4x3& b);

// Expects all that a file says to be alike. `tolerance` of transforms; 0: to the bit.
void ExpectSame(const scene::SceneData& a, const scene::SceneData& b, float tolerance = 0.0f);

}  // namespace raygraph::test
