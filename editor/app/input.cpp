#include "editor/app/input.h"

#include <algorithm>
#include <cctype>

#include "base/text.h"

namespace raygraph::editor {

namespace {

#define RAYGRAPH_NAME_KEY(name) #name,
constexpr std::array<const char*, kKeyCount> kKeyNames{RAYGRAPH_KEYS(RAYGRAPH_NAME_KEY)};
#undef RAYGRAPH_NAME_KEY

}  // namespace

bool IsSameName(std::string_view a, std::string_view b) {
    return std::ranges::equal(
        a, b, [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}
const char* Name(Key key) {
    return kKeyNames[static_cast<size_t>(key)];
}

Key KeyFromName(std::string_view name) {
    for (size_t i = 0; i < kKeyCount; ++i)
        if (IsSameName(kKeyNames[i], name)) return static_cast<Key>(i);
    throw MakeError(ErrorKind::Usage, "there is no key '{}'", name);
}

}  // namespace raygraph::editor
