// SpecializedShaders keeps the results of SpecializeSpirv (rhi/shader_specializer.h) on disk, because
// specializing a large shader takes up to a second, and in memory only while a caller holds the words.
// Without a folder, up to 64 MiB stay in memory.
//
// There is one file per module and values, "shaders/<key>.spv" in the folder of the pipeline cache, named by
// the first half of a 128-bit hash of the module, the values and the specializer's version. Its header holds
// the hash, size and checksum; a file that is damaged or of another hash is made again. Beyond 64 MiB the
// least recently used files are removed. Processes may share the folder. Threads: any. For rhi/ alone.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/log.h"
#include "rhi/shader_stage.h"

namespace raygraph::rhi {

class SpecializedShaders {
  public:
    using Words = std::shared_ptr<const std::vector<uint32_t>>;

    // `folder` is that of the pipeline cache; if it is empty, nothing is kept on disk. `log` receives
    // messages about damaged files, and about files that cannot be written. `version` is that of the
    // specializer (SpecializerVersion); if it is empty, no shader is specialized.
    SpecializedShaders(const std::filesystem::path& folder, Log log, std::string version);

    // Returns null if the module has none of the values, if it cannot be specialized, or if there is no
    // version: the shader is then used as it is. While one thread specializes a shader, others that need the
    // same wait for it. Throws only std::bad_alloc.
    Words Find(std::span<const uint32_t> spirv, std::span<const SpecializationValue> values);

  private:
    using Key = std::pair<uint64_t, uint64_t>;
    std::filesystem::path FileOf(const Key& key) const;
    Words Load(const Key& key) const;
    void Save(const Key& key, const std::vector<uint32_t>& words) const;
    void RemoveOldFiles() const;

    std::filesystem::path m_folder;
    Log m_log;
    std::string m_version;
    struct Shader {
        std::mutex mutex;  // held while the shader is specialized
        std::weak_ptr<const std::vector<uint32_t>> words;
        Words kept;  // the same words, if there is no folder
    };
    std::mutex m_mutex;  // guards the map
    std::map<Key, Shader> m_shaders;
    std::atomic<uint64_t> m_keptBytes = 0;
};

}  // namespace raygraph::rhi
