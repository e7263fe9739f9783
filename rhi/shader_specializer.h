// Specializes SPIR-V for given values of its constants, without the code that they switch off, and keeps the
// results on disk.
//
// A driver may inline every function before it looks at the constants: code that is off then takes as long
// to compile as code that runs. With Mesa's CPU driver, that is most of the time to a first picture;
// NVIDIA's compiles the shaders of the wavefront in 0.4 of the time without that code. This uses
// SPIRV-Tools; if the library was built without it, nothing is specialized here and the driver does all of
// it. For rhi/ alone. Threads: any.
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

// Returns the versions of SPIRV-Tools and of this code. Empty without SPIRV-Tools.
std::string SpecializerVersion();

// Returns the values of constants that the module has, in the order of its declarations.
std::vector<SpecializationValue> ValuesOf(std::span<const uint32_t> spirv,
                                          std::span<const SpecializationValue> values);

// Returns the module with constants instead of its specialization constants: `values` where given, otherwise
// the defaults. Branches that they decide, functions that are no longer called, and names are removed;
// bindings and results do not change. Empty without SPIRV-Tools, or if it cannot read the module.
std::vector<uint32_t> SpecializeSpirv(std::span<const uint32_t> spirv,
                                      std::span<const SpecializationValue> values);

// SpecializedShaders keeps the results of SpecializeSpirv on disk, because specializing a large shader takes
// up to a second, and in memory only while a caller holds the words. Without a folder, up to 64 MiB stay in
// memory.
//
// There is one file per module and values, "shaders/<key>.spv" in the folder of the pipeline cache, named by
// the first half of a 128-bit hash of the module, the values and the specializer's version. Its header holds
// the hash, size and checksum; a file that is damaged or of another hash is made again. Beyond 64 MiB the
// least recently used files are removed. Processes may share the folder.
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
