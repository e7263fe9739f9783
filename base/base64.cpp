#include "base/base64.h"

#include <cstdint>
#include <string_view>

namespace raygraph {

std::string EncodeBase64(std::span<const std::byte> bytes) {
    constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (size_t i = 0; i < bytes.size(); i += 3) {
        const auto at = [&](size_t k) { return k < bytes.size() ? std::to_integer<uint32_t>(bytes[k]) : 0u; };
        const uint32_t three = at(i) << 16 | at(i + 1) << 8 | at(i + 2);
        for (int digit = 0; digit < 4; ++digit)
            text += size_t(digit) <= bytes.size() - i ? kDigits[(three >> (18 - 6 * digit)) & 63u] : '=';
    }
    return text;
}

}  // namespace raygraph
