#include "shaders/embedded.h"

#include <zstd.h>

#include <map>
#include <mutex>
#include <vector>

#include "base/check.h"

namespace raygraph {

std::span<const uint32_t> EmbeddedShader::Words() const {
    static std::mutex mutex;
    static std::map<std::string_view, std::vector<uint32_t>> modules;
    const std::lock_guard lock(mutex);
    const auto [module, isNew] = modules.try_emplace(name);
    if (isNew) {
        const auto bytes = ZSTD_getFrameContentSize(compressed.data(), compressed.size());
        module->second.resize(bytes / sizeof(uint32_t));
        // Outside of the check, which builds without RAYGRAPH_ASSERTS do not evaluate.
        [[maybe_unused]] const size_t written =
            ZSTD_decompress(module->second.data(), bytes, compressed.data(), compressed.size());
        RG_CHECK_EQ(written, bytes);
    }
    return module->second;
}

}  // namespace raygraph
