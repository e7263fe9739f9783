#include "renderer/scene/gltf/container.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/printable.h"
#include "base/text.h"

namespace raygraph::scene {
namespace {

constexpr uint32_t kGlbMagic = 0x46546C67;     // "glTF"
constexpr uint32_t kJsonChunk = 0x4E4F534A;    // "JSON"
constexpr uint32_t kBinaryChunk = 0x004E4942;  // "BIN\0"

[[noreturn]] void Fail(const std::string& label, const std::string& why) {
    throw MakeError(ErrorKind::BadInput, "{}: {}", label, why);
}

// Reads little endian, whatever the machine.
uint32_t ReadU32(std::span<const std::byte> bytes, size_t at) {
    uint32_t value = 0;
    for (size_t i = 0; i < 4; ++i) value |= std::to_integer<uint32_t>(bytes[at + i]) << (8 * i);
    return value;
}

std::string_view AsText(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

GltfContainer OpenGlb(std::span<const std::byte> file, const std::string& label) {
    if (file.size() < 12) Fail(label, Text("the .glb header is cut short ({} bytes)", file.size()));
    if (const uint32_t version = ReadU32(file, 4); version != 2)
        Fail(label, Text("is a .glb of version {}, must be 2", version));
    const uint32_t length = ReadU32(file, 8);
    if (length < 12 || length > file.size())
        Fail(label, Text("the .glb header claims {} bytes, the file has {}", length, file.size()));
    // Bytes after the stated length are no part of the scene.
    file = file.first(length);

    GltfContainer container{.json = {}, .binary = {}, .rest = {}, .isGlb = true};
    std::optional<std::string_view> json;
    size_t at = 12;
    for (size_t chunk = 0; at < file.size(); ++chunk) {
        if (file.size() - at < 8) Fail(label, Text("chunk {}: its header is cut short", chunk));
        const uint32_t size = ReadU32(file, at);
        const uint32_t type = ReadU32(file, at + 4);
        at += 8;
        if (size > file.size() - at)
            Fail(label, Text("chunk {}: claims {} bytes, {} are left", chunk, size, file.size() - at));
        const auto content = file.subspan(at, size);
        if ((type == kJsonChunk) != (chunk == 0))
            Fail(label, chunk == 0 ? "the first chunk is not JSON"
                                   : Text("chunk {}: is a second JSON chunk", chunk));
        if (type == kJsonChunk) json = AsText(content);
        if (type == kBinaryChunk) {
            if (container.hasBinary) Fail(label, Text("chunk {}: is a second BIN chunk", chunk));
            container.binary = content;
            container.hasBinary = true;
        }
        at += size;
        if (chunk == 0) container.rest = file.subspan(at);
    }
    if (!json) Fail(label, "the .glb has no JSON chunk");
    container.json = *json;
    return container;
}

// Scans without parsing: counts brackets outside strings.
void CheckDepth(std::string_view text, const std::string& label, uint32_t maxDepth) {
    uint32_t depth = 0;
    bool isInString = false;
    for (size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (isInString) {
            if (c == '\\') ++i;
            if (c == '"') isInString = false;
        } else if (c == '"') {
            isInString = true;
        } else if (c == '{' || c == '[') {
            if (++depth > maxDepth)
                Fail(label, Text("JSON is nested deeper than {} levels at byte {}", maxDepth, i));
        } else if ((c == '}' || c == ']') && depth > 0) {
            --depth;
        }
    }
}

// Returns the code unit if `text` starts with "\\u" and four hexadecimal digits; else nothing.
std::optional<unsigned> EscapedUnit(std::string_view text) {
    if (text.size() < 6 || !text.starts_with("\\u")) return std::nullopt;
    unsigned unit = 0;
    const auto [end, error] = std::from_chars(text.data() + 2, text.data() + 6, unit, 16);
    if (error != std::errc() || end != text.data() + 6) return std::nullopt;
    return unit;
}

// Holds the first character of a text inside of a JSON string.
struct Character {
    size_t bytes = 1;
    bool isBroken = false;
};

Character FirstCharacter(std::string_view text) {
    if (text[0] != '\\') {
        const size_t bytes = Utf8Length(text);
        return {std::max<size_t>(bytes, 1), bytes == 0 || static_cast<unsigned char>(text[0]) < 0x20};
    }
    const std::optional<unsigned> unit = EscapedUnit(text);
    if (!unit) return {2};  // Another escape; the parser refuses one that is none.
    if (*unit < 0xD800 || *unit > 0xDFFF) return {6};
    const std::optional<unsigned> next = EscapedUnit(text.substr(6));
    const bool isPair = *unit < 0xDC00 && next && *next >= 0xDC00 && *next <= 0xDFFF;
    return isPair ? Character{12} : Character{6, true};
}

}  // namespace

std::optional<RepairedText> RepairStrings(std::string_view json) {
    RepairedText repaired;
    size_t kept = 0;  // bytes of `json` already handled: up to here they are in the text
    bool isInString = false;
    for (size_t at = 0; at < json.size();) {
        if (json[at] == '"') isInString = !isInString;
        if (!isInString || json[at] == '"') {
            ++at;
            continue;
        }
        const Character character = FirstCharacter(json.substr(at));
        if (character.isBroken) {
            if (repaired.count++ == 0) repaired.firstByte = at;
            repaired.text += json.substr(kept, at - kept);
            repaired.text += "\\ufffd";
            kept = at + character.bytes;
        }
        at += character.bytes;
    }
    if (repaired.count == 0) return std::nullopt;
    repaired.text += json.substr(std::min(kept, json.size()));
    return repaired;
}

namespace {

// The starts of files that are mistaken for glTF.
constexpr std::pair<std::string_view, const char*> kOtherFormats[] = {
    {"\x89PNG", "a PNG picture"},
    {"\xFF\xD8\xFF", "a JPEG picture"},
    {"RIFF", "a RIFF file, as WebP"},
    {"\xABKTX", "a KTX texture"},
    {"DDS ", "a DDS texture"},
    {"#?RADIANCE", "a Radiance picture"},
    {"v/1\x01", "an OpenEXR picture"},
    {"Kaydara FBX", "an FBX file"},
    {"BLENDER", "a .blend file"},
    {"PXR-USDC", "a USD file"},
    {"#usda", "a USD file"},
    {"PK\x03\x04", "a ZIP archive, as .usdz"},
    {"\x1F\x8B", "compressed with gzip"},
    {"ply", "a PLY file"},
    {"solid", "an STL file"},
    {"<", "an XML or HTML text, as COLLADA"},
    {"version https://git-lfs", "a pointer of Git LFS: run git lfs pull"}};

// Refuses text that does not begin as an object of JSON.
void RequireObjectText(std::string_view text, const std::string& label) {
    if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
    const size_t start = text.find_first_not_of(" \t\r\n");
    if (start != text.npos && text[start] == '{') return;
    for (const auto& [begin, format] : kOtherFormats)
        if (text.starts_with(begin)) Fail(label, Text("not a glTF file, but {}", format));
    Fail(label, "not a glTF file: it begins with neither { nor glTF");
}

}  // namespace

GltfContainer OpenContainer(std::span<const std::byte> file, const std::string& label) {
    if (file.empty()) Fail(label, "the file is empty");
    if (file.size() >= 4 && ReadU32(file, 0) == kGlbMagic) return OpenGlb(file, label);
    RequireObjectText(AsText(file), label);
    return {.json = AsText(file), .binary = {}, .rest = {}};
}

std::vector<std::byte> MakeGlb(std::string_view json, std::span<const std::byte> rest) {
    const size_t padded = (json.size() + 3) / 4 * 4, length = 20 + padded + rest.size();
    if (length > 0xFFFFFFFFu) throw MakeError(ErrorKind::Usage, "a .glb cannot have {} bytes", length);
    std::vector<std::byte> file;
    file.reserve(length);
    const auto put = [&](size_t value) {
        for (int i = 0; i < 4; ++i) file.push_back(static_cast<std::byte>(value >> (8 * i) & 0xFFu));
    };
    put(kGlbMagic);
    put(2);
    put(length);
    put(padded);
    put(kJsonChunk);
    for (const char character : json) file.push_back(static_cast<std::byte>(character));
    file.resize(20 + padded, static_cast<std::byte>(' '));
    file.insert(file.end(), rest.begin(), rest.end());
    return file;
}

nlohmann::json ParseJson(GltfContext& context, std::string_view text) {
    const std::string& label = context.label;
    const LoadLimits& limits = context.options.limits;
    if (text.size() > limits.maxJsonBytes)
        Fail(label, Text("JSON of {} bytes exceeds the limit of {}", text.size(), limits.maxJsonBytes));
    CheckDepth(text, label, limits.maxJsonDepth);
    const std::optional<RepairedText> repaired = RepairStrings(text);
    if (repaired) {
        context.Warn(
            "", "characters",
            Text("{} not well-formed, the first at byte {}; taken as U+FFFD",
                 Counted(repaired->count, "character of its strings is", "characters of its strings are"),
                 repaired->firstByte));
        text = repaired->text;
    }
    try {
        nlohmann::json json = nlohmann::json::parse(text);
        if (!json.is_object()) Fail(label, "the JSON text is not an object");
        if (!json.contains("asset")) Fail(label, "not a glTF file: its JSON has no \"asset\"");
        return json;
    } catch (const nlohmann::json::exception& error) {
        // The text is "[json.exception.parse_error.101] parse error at line 1, column 3: ..." without the
        // code.
        std::string_view what = error.what();
        if (const size_t end = what.find("] "); what.starts_with('[') && end != what.npos)
            what.remove_prefix(end + 2);
        const bool isCut = what.find("unexpected end of input") != what.npos;
        Fail(label, Text("{}not valid JSON: {}", isCut ? "cut short: " : "", Printable(what, 300)));
    }
}

// --- URIs ---

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
