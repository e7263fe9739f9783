#include "editor/session/settings/parse.h"

#include <charconv>
#include <cmath>

#include "base/printable.h"
#include "base/text.h"
#include "shaders/core/color.glsl"

namespace raygraph::session {

namespace {

[[noreturn]] void RejectText(std::string_view text, const std::string& expected) {
    throw MakeError(ErrorKind::Usage, "{} is not {}", Quoted(text), expected);
}

// Returns a bound as the user would write it: 1000000, not 1000000.000000.
std::string BoundText(double value) {
    std::array<char, 32> text{};
    const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
    return {text.data(), end};
}

constexpr std::string_view kAutomatic = "auto", kUnits = "KMG";

}  // namespace

uint32_t ParseCount(std::string_view text, uint32_t minimum, uint32_t maximum) {
    uint32_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (text.empty() || error != std::errc() || end != text.data() + text.size() || value < minimum ||
        value > maximum)
        RejectText(text, Text("a whole number from {} to {}", minimum, maximum));
    return value;
}

double ParseNumber(std::string_view text, double minimum, double maximum) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool isNumber =
        !text.empty() && error == std::errc() && end == text.data() + text.size() && std::isfinite(value);
    if (isNumber && value >= minimum && value <= maximum) return value;

    const bool hasMinimum = minimum > std::numeric_limits<double>::lowest();
    const bool hasMaximum = maximum < std::numeric_limits<double>::max();
    std::string expected = "a number";
    if (hasMinimum && hasMaximum)
        expected += " from " + BoundText(minimum) + " to " + BoundText(maximum);
    else if (hasMinimum)
        expected += " of at least " + BoundText(minimum);
    else if (hasMaximum)
        expected += " of at most " + BoundText(maximum);
    RejectText(text, expected);
}

uint64_t ParseBudget(std::string_view text) {
    if (text == kAutomatic) return 0;
    constexpr double kMostBytes = 0x1p50;
    const size_t unit = text.empty() ? std::string_view::npos : kUnits.find(text.back());
    const std::string_view digits = text.substr(0, text.size() - (unit == std::string_view::npos ? 0 : 1));
    try {
        const double units = unit == std::string_view::npos ? 1.0 : std::exp2(10.0 * (1.0 + double(unit)));
        const double bytes = std::floor(ParseNumber(digits, 0.0, kMostBytes) * units);
        if (bytes >= 1.0 && bytes <= kMostBytes) return static_cast<uint64_t>(bytes);
    } catch (const Error&) {
        // The message for the whole text says more than the one for its digits
    }
    RejectText(text, Text("{} or a size like 512M or 1.5G", kAutomatic));
}

rhi::Extent2D ParseSize(std::string_view text) {
    const size_t cross = text.find('x');
    if (cross != std::string_view::npos) {
        try {
            return {ParseCount(text.substr(0, cross), 1, kMaxImageSide),
                    ParseCount(text.substr(cross + 1), 1, kMaxImageSide)};
        } catch (const Error&) {
            // The message for the whole text says more than the one for its half
        }
    }
    RejectText(text, Text("a size like 640x360, each side from 1 to {}", kMaxImageSide));
}

std::array<float, 3> ParseRadiance(std::string_view text) {
    std::array<float, 3> radiance{};
    try {
        const std::vector<std::string_view> parts = ParseList(text);
        if (parts.size() == radiance.size()) {
            for (size_t i = 0; i < parts.size(); ++i)
                radiance[i] =
                    static_cast<float>(ParseNumber(parts[i], 0.0, std::numeric_limits<float>::max()));
            return radiance;
        }
    } catch (const Error&) {
        // The check below rejects the text
    }
    RejectText(text, "three numbers like 0.5,0.5,1, none of them negative");
}

namespace {

constexpr std::pair<std::string_view, std::string_view> kColorNames[] = {
    {"black", "#000000"}, {"gray", "#808080"}, {"white", "#ffffff"},  {"red", "#ff0000"},
    {"green", "#008000"}, {"blue", "#0000ff"}, {"yellow", "#ffff00"}, {"orange", "#ffa500"}};

}  // namespace

std::array<float, 3> ParseColor(std::string_view text) {
    std::string_view digits = text;
    std::string names;
    for (const auto& [name, code] : kColorNames) {
        if (text == name) digits = code;
        (names += names.empty() ? "" : ", ") += name;
    }
    std::array<float, 3> color{};
    uint32_t code = 0;
    if (digits.size() == 7 && digits[0] == '#' &&
        std::from_chars(digits.data() + 1, digits.data() + 7, code, 16).ptr == digits.data() + 7) {
        for (int i = 0; i < 3; ++i)
            color[i] = shading::SrgbDecode(static_cast<float>(code >> (16 - 8 * i) & 255u) / 255.0f);
        return color;
    }
    try {
        if (text.find(',') != text.npos) return ParseRadiance(text);
        color.fill(static_cast<float>(ParseNumber(text, 0.0, std::numeric_limits<float>::max())));
        return color;
    } catch (const Error&) {
        RejectText(text, "a color: a number, three as 0.5,0.5,1, none of them negative, #rrggbb, or one of " +
                             names);
    }
}

std::vector<std::string_view> ParseList(std::string_view text) {
    std::vector<std::string_view> parts;
    for (size_t begin = 0; begin <= text.size();) {
        const size_t end = std::min(text.find(',', begin), text.size());
        if (end == begin) RejectText(text, "a list of names with single commas between them");
        parts.push_back(text.substr(begin, end - begin));
        begin = end + 1;
    }
    return parts;
}

size_t ParseChoice(std::string_view text, const std::vector<std::string_view>& names) {
    std::string list;
    for (size_t i = 0; i < names.size(); ++i) {
        if (names[i] == text) return i;
        if (i > 0) list += i + 1 == names.size() ? " or " : ", ";
        list += names[i];
    }
    RejectText(text, (names.size() > 1 ? "one of " : "") + list);
}

std::string ListForHelp(std::vector<std::string_view> texts, const std::vector<std::string_view>& notes,
                        size_t ofDefault) {
    std::string list;
    for (size_t i = 0; i < texts.size(); ++i) {
        if (i > 0) list += i + 1 == texts.size() ? " or " : ", ";
        list += texts[i];
        std::string note(notes[i]);
        if (i == ofDefault) note += note.empty() ? "default" : "; default";
        if (!note.empty()) list += " (" + note + ")";
    }
    return list;
}

std::string ToText(float value) {
    std::array<char, 32> text{};
    const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
    return {text.data(), end};
}

std::optional<passes::BackdropSettings> ParseBackdrop(std::string_view text) {
    constexpr std::string_view kBlur = "blur:";
    if (text == "transparent") return std::nullopt;
    if (text == "map") return passes::BackdropSettings{};
    if (text.starts_with(kBlur)) {
        const double degrees = ParseNumber(text.substr(kBlur.size()), 0.5, 90.0);
        return passes::BackdropSettings{.blurDegrees = static_cast<float>(degrees)};
    }
    try {
        const std::array<float, 3> color = ParseColor(text);
        return passes::BackdropSettings{.color = glm::vec3(color[0], color[1], color[2])};
    } catch (const Error& error) {
        throw MakeError(error.Kind(), "{}; nor map, blur:N or transparent", error.what());
    }
}

std::string BackdropText(const std::optional<passes::BackdropSettings>& backdrop) {
    if (!backdrop) return "transparent";
    if (const auto& color = backdrop->color) return ToText({color->x, color->y, color->z});
    return backdrop->blurDegrees > 0.0f ? "blur:" + ToText(backdrop->blurDegrees) : "map";
}

std::string ToText(rhi::Extent2D size) {
    return Text("{}x{}", size.width, size.height);
}

std::string BudgetText(uint64_t bytes) {
    if (bytes == 0) return std::string(kAutomatic);
    size_t units = 0;
    for (; units < kUnits.size() && bytes % 1024 == 0; ++units) bytes /= 1024;
    return Text("{}{}", bytes, units == 0 ? "" : kUnits.substr(units - 1, 1));
}

std::string ToText(const std::array<float, 3>& radiance) {
    return ToText(radiance[0]) + "," + ToText(radiance[1]) + "," + ToText(radiance[2]);
}

}  // namespace raygraph::session
