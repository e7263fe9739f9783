// Parses texts of settings strictly: the whole text must be the value, in range. Every failure is
// Error{Usage} that quotes the text and says what it should be; the caller prefixes the setting's name.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "passes/backdrop.h"
#include "rhi/format.h"

namespace raygraph::session {

// Bounds the width and height of a picture, in pixels.
inline constexpr uint32_t kMaxImageSide = 16384;

// Parses decimal digits alone: no sign, no space, no "0x".
uint32_t ParseCount(std::string_view text, uint32_t minimum = 0,
                    uint32_t maximum = std::numeric_limits<uint32_t>::max());
// Parses a finite decimal number, "-1.5" or "2e3".
double ParseNumber(std::string_view text, double minimum = std::numeric_limits<double>::lowest(),
                   double maximum = std::numeric_limits<double>::max());
// Parses "auto" as 0, else a size in memory above 0: "512M", "1.5G", "65536"; K, M and G count by 1024.
uint64_t ParseBudget(std::string_view text);
// Parses "640x360".
rhi::Extent2D ParseSize(std::string_view text);
// Parses "R,G,B" of finite numbers that are not negative.
std::array<float, 3> ParseRadiance(std::string_view text);
// Parses a color that is not negative as linear numbers: "R,G,B", one number for all three, "#rrggbb" of
// sRGB, or a name such as "gray", with the numbers that CSS has for it.
std::array<float, 3> ParseColor(std::string_view text);
// Converts between a backdrop and "map", "blur:N", a color as above, or "transparent": none.
std::optional<passes::BackdropSettings> ParseBackdrop(std::string_view text);
std::string BackdropText(const std::optional<passes::BackdropSettings>& backdrop);
// Returns the parts between commas; throws for an empty part.
std::vector<std::string_view> ParseList(std::string_view text);

// Returns the index of `text` among `names`; the error lists them.
size_t ParseChoice(std::string_view text, const std::vector<std::string_view>& names);
std::string ListForHelp(std::vector<std::string_view> texts, const std::vector<std::string_view>& notes,
                        size_t ofDefault);
// Returns the value with this name.
template <typename Choice>
Choice ParseChoice(std::string_view text) {
    constexpr auto kTexts = Texts(Choice{});
    return static_cast<Choice>(ParseChoice(text, {kTexts.begin(), kTexts.end()}));
}

// Returns the names of all values with their notes, for help: "beckmann, ggx (best; default) or phong".
template <typename Choice>
std::string ListForHelp(Choice ofDefault) {
    constexpr auto kTexts = Texts(Choice{}), kNotes = Notes(Choice{});
    return ListForHelp({kTexts.begin(), kTexts.end()}, {kNotes.begin(), kNotes.end()},
                       static_cast<size_t>(ofDefault));
}

// Returns the shortest text that reads back as the same number.
std::string ToText(float value);
std::string ToText(rhi::Extent2D size);
// Returns text that ParseBudget reads.
std::string BudgetText(uint64_t bytes);
std::string ToText(const std::array<float, 3>& radiance);

}  // namespace raygraph::session
