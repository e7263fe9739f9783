#include "base/text.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace raygraph {

std::string BytesText(uint64_t bytes) {
    constexpr std::array kUnits{"B", "KiB", "MiB", "GiB", "TiB"};
    auto value = static_cast<double>(bytes);
    size_t unit = 0;
    for (; value >= 1024.0 && unit + 1 < kUnits.size(); ++unit) value /= 1024.0;
    return Text("{:.{}f} {}", value, value == std::floor(value) ? 0 : 1, kUnits[unit]);
}

std::string DurationText(double seconds) {
    if (seconds < 0.00995) return Text("{:.1f} ms", seconds * 1e3);
    if (seconds < 0.9995) return Text("{:.0f} ms", seconds * 1e3);
    if (seconds < 9.95) return Text("{:.1f} s", seconds);
    const auto whole = std::llround(std::min(seconds, 1e12));
    if (whole < 60) return Text("{} s", whole);
    if (whole < 3600) return Text("{} min {} s", whole / 60, whole % 60);
    return Text("{} h {} min", whole / 3600, whole % 3600 / 60);
}

}  // namespace raygraph
