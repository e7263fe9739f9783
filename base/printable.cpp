#include "base/printable.h"

namespace raygraph {

// Follows table 3-7 of the Unicode standard, which refuses three-byte surrogates and overlong forms.
size_t Utf8Length(std::string_view text) {
    const auto byte = [&](size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
    const auto isTail = [&](size_t i) { return (byte(i) & 0xC0u) == 0x80u; };
    const unsigned first = byte(0);
    if (first < 0x80) return 1;
    if (first >= 0xC2 && first <= 0xDF) return isTail(1) ? 2 : 0;
    if (first >= 0xE0 && first <= 0xEF) {
        if (!isTail(1) || !isTail(2)) return 0;
        const bool isOverlong = first == 0xE0 && byte(1) < 0xA0;
        const bool isSurrogate = first == 0xED && byte(1) > 0x9F;
        return isOverlong || isSurrogate ? 0 : 3;
    }
    if (first >= 0xF0 && first <= 0xF4) {
        if (!isTail(1) || !isTail(2) || !isTail(3)) return 0;
        const bool isOverlong = first == 0xF0 && byte(1) < 0x90;
        const bool isTooHigh = first == 0xF4 && byte(1) > 0x8F;
        return isOverlong || isTooHigh ? 0 : 4;
    }
    return 0;
}

std::string Printable(std::string_view text, size_t maxBytes) {
    std::string out;
    while (!text.empty()) {
        size_t length = Utf8Length(text);
        const unsigned first = static_cast<unsigned char>(text[0]);
        const unsigned second = text.size() > 1 ? static_cast<unsigned char>(text[1]) : 0u;
        // C0, DEL and C1 controls: a terminal may act on them.
        const bool isControl = first < 0x20 || first == 0x7F || (first == 0xC2 && second < 0xA0);
        // U+2028 and U+2029 end a line too.
        const bool endsLine = text.substr(0, 3) == "\xE2\x80\xA8" || text.substr(0, 3) == "\xE2\x80\xA9";
        const bool isShown = length > 0 && !isControl && !endsLine;
        if (length == 0) length = 1;
        const std::string_view piece = isShown ? text.substr(0, length) : std::string_view("?");
        if (out.size() + piece.size() > maxBytes) return out + "...";
        out += piece;
        text.remove_prefix(length);
    }
    return out;
}

std::string Quoted(std::string_view text, size_t maxBytes) {
    return '"' + Printable(text, maxBytes) + '"';
}

}  // namespace raygraph
