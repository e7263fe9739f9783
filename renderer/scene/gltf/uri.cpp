#include "renderer/scene/gltf/uri.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "base/text.h"

namespace raygraph::scene {
namespace {

bool IsLetter(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}
bool IsDigit(char c) {
    return c >= '0' && c <= '9';
}
char Lower(char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

int HexDigit(char c) {
    if (IsDigit(c)) return c - '0';
    c = Lower(c);
    return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

bool EqualsIgnoringCase(std::string_view a, std::string_view b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](char x, char y) { return Lower(x) == Lower(y); });
}

[[noreturn]] void Fail(const std::string& why) {
    throw MakeError(ErrorKind::BadInput, "data URI: {}", why);
}

// 0..63, or 255 for a character outside the alphabet (RFC 4648, also its URL-safe form).
constexpr std::array<uint8_t, 256> kBase64 = [] {
    std::array<uint8_t, 256> table{};
    table.fill(255);
    constexpr std::string_view alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < alphabet.size(); ++i)
        table[static_cast<unsigned char>(alphabet[i])] = static_cast<uint8_t>(i);
    table[static_cast<unsigned char>('-')] = 62;
    table[static_cast<unsigned char>('_')] = 63;
    return table;
}();

std::vector<std::byte> DecodeBase64(std::string_view text, uint64_t maxBytes) {
    for (int i = 0; i < 2 && text.ends_with('='); ++i) text.remove_suffix(1);
    if (text.size() % 4 == 1) Fail("its base64 text is cut short");
    const size_t size = text.size() / 4 * 3 + (text.size() % 4 ? text.size() % 4 - 1 : 0);
    if (size > maxBytes) Fail(Text("{} bytes exceed the limit of {}", size, maxBytes));
    std::vector<std::byte> bytes(size);
    uint32_t bits = 0;
    size_t at = 0;
    for (size_t i = 0; i < text.size(); ++i) {
        const uint8_t value = kBase64[static_cast<unsigned char>(text[i])];
        if (value == 255) Fail(Text("character {} of its data is not base64", i));
        bits = (bits << 6) | value;
        if (i % 4 != 0) bytes[at++] = static_cast<std::byte>(bits >> (2 * (3 - i % 4)) & 0xFFu);
    }
    return bytes;
}

}  // namespace

std::optional<std::string_view> UriScheme(std::string_view uri) {
    if (uri.empty() || !IsLetter(uri[0])) return std::nullopt;
    for (size_t i = 1; i < uri.size(); ++i) {
        const char c = uri[i];
        if (c == ':') return uri.substr(0, i);
        if (!IsLetter(c) && !IsDigit(c) && c != '+' && c != '-' && c != '.') return std::nullopt;
    }
    return std::nullopt;
}

bool IsDataUri(std::string_view uri) {
    const auto scheme = UriScheme(uri);
    return scheme && EqualsIgnoringCase(*scheme, "data");
}

std::string PercentDecode(std::string_view text) {
    std::string out;
    out.reserve(text.size());
    for (size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '%' && i + 2 < text.size() && HexDigit(text[i + 1]) >= 0 &&
            HexDigit(text[i + 2]) >= 0) {
            out += static_cast<char>(HexDigit(text[i + 1]) * 16 + HexDigit(text[i + 2]));
            i += 2;
        } else {
            out += text[i];
        }
    }
    return out;
}

std::vector<std::byte> DecodeDataUri(std::string_view uri, uint64_t maxBytes) {
    const size_t comma = uri.find(',');
    if (comma == std::string_view::npos) Fail("it has no comma");
    const std::string_view header = uri.substr(0, comma);
    const std::string_view data = uri.substr(comma + 1);
    constexpr std::string_view kMark = ";base64";
    const bool isBase64 = header.size() >= kMark.size() &&
                          EqualsIgnoringCase(header.substr(header.size() - kMark.size()), kMark);
    if (isBase64) {
        if (data.find('%') == std::string_view::npos) return DecodeBase64(data, maxBytes);
        return DecodeBase64(PercentDecode(data), maxBytes);
    }
    const std::string text = PercentDecode(data);
    if (text.size() > maxBytes) Fail(Text("{} bytes exceed the limit of {}", text.size(), maxBytes));
    std::vector<std::byte> bytes(text.size());
    if (!text.empty()) std::memcpy(bytes.data(), text.data(), text.size());
    return bytes;
}

}  // namespace raygraph::scene
