#include "shaders/embedded.h"

#include <zstd.h>

#include <map>
#include <mutex>
#include <utility>
#include <vector>

#include "base/check.h"

namespace raygraph {

std::span<const uint32_t> EmbeddedShader::Words() const {
    static std::mutex mutex;
    // The map is never destroyed, so that modules live as long as the program.
    static auto& modules = *new std::map<std::string_view, std::vector<uint32_t>>;
    const std::lock_guard lock(mutex);
    const auto known = modules.find(name);
    if (known != modules.end()) return known->second;
    const auto bytes = ZSTD_getFrameContentSize(compressed.data(), compressed.size());
    RG_CHECK(bytes != ZSTD_CONTENTSIZE_ERROR && bytes != ZSTD_CONTENTSIZE_UNKNOWN);
    std::vector<uint32_t> words(bytes / sizeof(uint32_t));
    // Outside of the check, which builds without RAYGRAPH_ASSERTS do not evaluate.
    [[maybe_unused]] const size_t written =
        ZSTD_decompress(words.data(), bytes, compressed.data(), compressed.size());
    RG_CHECK_EQ(written, bytes);
    return modules.emplace(name, std::move(words)).first->second;
}

}  // namespace raygraph
