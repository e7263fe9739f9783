#include "renderer/scene/geometry/round_primitives.h"

#include <charconv>
#include <cmath>

#include "base/error.h"
#include "base/text.h"

namespace raygraph::scene {

RoundRadius ParseRoundRadius(std::string_view text) {
    if (text == "off") return {};
    RoundRadius radius{.isRelative = text.ends_with('%')};
    const std::string_view number = text.substr(0, text.size() - (radius.isRelative ? 1 : 0));
    double value = 0.0;
    const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), value);
    const bool isNumber = error == std::errc() && end == number.data() + number.size();
    const bool isInRange = radius.isRelative ? value >= 1e-7 && value <= 1e3 : value >= 1e-9 && value <= 1e9;
    if (!isNumber || !isInRange)
        throw MakeError(ErrorKind::Usage,
                        "\"{}\" is not a radius: 1e-9 to 1e9 in meters, 1e-7% to 1000% of the diagonal of "
                        "the scene's bounds, or off",
                        text);
    radius.value = static_cast<float>(radius.isRelative ? value / 100.0 : value);
    return radius;
}

std::string ToText(const RoundRadius& radius) {
    if (!radius.IsOn()) return "off";
    if (!radius.isRelative) return Text("{}", radius.value);
    // The shortest percentage that is read back as the same
    for (int digits = 1; digits < 17; ++digits) {
        std::string text = Text("{:.{}g}%", 100.0 * static_cast<double>(radius.value), digits);
        if (ParseRoundRadius(text) == radius) return text;
    }
    return Text("{}%", 100.0 * static_cast<double>(radius.value));
}

Bounds RoundBox(const glm::vec3& a, const glm::vec3& b, float radius) {
    constexpr float kRoom = 1e-6f;
    const glm::vec3 reach = radius + kRoom * (radius + glm::max(glm::abs(a), glm::abs(b)));
    return {glm::min(a, b) - reach, glm::max(a, b) + reach};
}

Bounds RoundBounds(const Primitive& primitive) {
    Bounds bounds;
    for (size_t i = 0; i < primitive.radii.size(); ++i)
        bounds.Extend(RoundBox(primitive.positions[primitive.indices[2 * i]],
                               primitive.positions[primitive.indices[2 * i + 1]], primitive.radii[i]));
    return bounds;
}

Bounds BoundsOf(std::span<const glm::vec3> positions) {
    Bounds bounds;
    for (const glm::vec3& position : positions) bounds.Extend(position);
    return bounds;
}

}  // namespace raygraph::scene
