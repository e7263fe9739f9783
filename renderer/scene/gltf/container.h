// The outer shell of a glTF file: .glb chunks or plain JSON text, the JSON tree, and URIs. Internal to
// renderer/scene.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/scene/gltf/context.h"

namespace raygraph::scene {

// Views into the bytes of the file, which must outlive them.
struct GltfContainer {
    std::string_view json;
    std::span<const std::byte> binary;  // the BIN chunk
    bool hasBinary = false;
    std::span<const std::byte> rest;  // all chunks of a .glb after the first
    bool isGlb = false;
};

// Distinguishes .glb from .gltf by the first four bytes, whatever the file's name. Throws Error{BadInput},
// "label: ...", on a broken .glb; unknown chunks are skipped, as the format asks.
GltfContainer OpenContainer(std::span<const std::byte> file, const std::string& label);

// Returns the bytes of a .glb: a JSON chunk, and what comes after it, as chunks. Error{Usage} above 4 GiB.
std::vector<std::byte> MakeGlb(std::string_view json, std::span<const std::byte> rest);

// Describes a JSON text in whose strings U+FFFD stands for halves of surrogate pairs, bytes that are not
// UTF-8 and control characters: parsers refuse a text for the sake of any, and most are in names.
struct RepairedText {
    std::string text;
    size_t count = 0;  // the number of replacements
    size_t firstByte = 0;
};
// Returns the repaired text; nullopt if all characters are well-formed.
std::optional<RepairedText> RepairStrings(std::string_view json);

// Parses JSON text whose length and depth are checked first, because a parser's tree may be many times its
// text. Strings are repaired with a warning. Throws Error{BadInput}, "label: ...".
nlohmann::json ParseJson(GltfContext& context, std::string_view text);

// --- What glTF does with a URI: tell its scheme, undo percent-encoding, unpack a data URI ---

// Returns "data" for "data:...", by the grammar of RFC 3986; nullopt if the text has no scheme.
std::optional<std::string_view> UriScheme(std::string_view uri);

bool IsDataUri(std::string_view uri);

// Replaces "%20" by a space and so on; a '%' without two hexadecimal digits stays.
std::string PercentDecode(std::string_view text);

// Returns the bytes of a data URI, base64 or percent-encoded (RFC 2397). Throws Error{BadInput} with the
// reason alone (the caller puts the place before it) if it is malformed or has more than `maxBytes`.
std::vector<std::byte> DecodeDataUri(std::string_view uri, uint64_t maxBytes);

}  // namespace raygraph::scene
