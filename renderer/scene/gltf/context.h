// The state that the parts of one glTF import share. Internal to renderer/scene.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/gltf/place.h"

namespace raygraph::scene {

// Warnings of one import, one line per topic: the first occurrence, then how many more there were. A repeated
// warning, such as for an accessor that several primitives share, counts once.
class Warnings {
  public:
    // `topic` groups warnings; "scene.gltf: materials[2].metallicFactor: is 3, taken as 1 (and 4 more)".
    void Add(std::string_view topic, std::string text);
    std::vector<std::string> Take();

  private:
    struct Entry {
        std::string topic;
        std::string text;
        size_t count = 0;
    };
    // Returns whether it is new. Of very many warnings the later ones count as new.
    bool IsNew(std::string_view topic, std::string_view text);

    std::vector<Entry> m_entries;
    std::unordered_set<uint64_t> m_said;  // hashes
};

// Returns "there are 2 meshes" or "there is 1 mesh". `one` and `many` are as of Counted.
std::string CountPhrase(uint64_t count, std::string_view one, std::string_view many = {});

struct GltfContext {
    std::string label;  // The file's name, printable: every message starts with it.
    const LoadOptions& options;
    const ConfinedFolder& folder;
    Warnings warnings;
    uint64_t bytesRead = 0;        // of all files and data URIs so far
    uint64_t geometryBytes = 0;    // charged so far
    uint64_t compressedBytes = 0;  // charged for primitives so far
    uint64_t imageTexels = 0;      // decoded so far

    // Returns "label: path: what", without the path if it is empty.
    std::string Line(const std::string& path, const std::string& what) const;
    // Throws Error{BadInput} with that line.
    [[noreturn]] void Fail(const std::string& path, const std::string& why) const;
    // A warning about a place in the file.
    void Warn(const std::string& path, std::string_view topic, const std::string& what);
    // Counts memory about to be taken for vertices or indices; fails at `where` beyond the limit.
    void ChargeGeometry(const Place& where, uint64_t bytes);
    // Counts compressed bytes about to be decoded: all primitives may name the same. Fails at `where` beyond
    // sixteen times what has been read.
    void ChargeCompressed(const Place& where, uint64_t bytes);
    // Fails if a model of a document of so many bytes of JSON would take too much memory.
    void CheckModelBytes(uint64_t bytes, uint64_t jsonBytes) const;
    void Progress(std::string_view stage, float fraction) const;
    // Returns LoadOptions::maxThreads, resolved to a number.
    unsigned ThreadCount() const;

    // Returns the bytes of a URI: a data URI, or a file in the scene's folder. Fails at `where`.
    std::vector<std::byte> ReadUri(const std::string& uri, const Place& where);

  private:
    // Returns the limit for the data that so many bytes are decoded to.
    uint64_t MemoryLimit(uint64_t sourceBytes) const;
};

}  // namespace raygraph::scene
