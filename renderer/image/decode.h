// Private to renderer/image: common functions of the decoders.
#pragma once

#include <string>
#include <string_view>

#include "renderer/image/image.h"

namespace raygraph::image {

// Throws Error{BadInput} "name: what", on one line whatever a library or a file put into the texts.
[[noreturn]] void Reject(std::string_view name, std::string_view what);

// Returns the warning for a file that has the whole picture but lacks its end.
std::string TruncationWarning(std::string_view name);

// Throws Error{OutOfMemory} for a picture within the limits that does not fit the machine.
[[noreturn]] void RejectMemory(std::string_view name, uint64_t width, uint64_t height);

// Refuses an empty picture and one beyond the limits.
void CheckSize(std::string_view name, uint64_t width, uint64_t height, const DecodeLimits& limits);

// These decode the formats that SniffFormat() names. Each checks everything beyond the first bytes itself.
Image8 DecodePng(std::span<const std::byte> bytes, std::string_view name, const DecodeLimits& limits);
Image8 DecodeJpeg(std::span<const std::byte> bytes, std::string_view name, const DecodeLimits& limits);
Image8 DecodeWebp(std::span<const std::byte> bytes, std::string_view name, const DecodeLimits& limits);
Image8 DecodeDds(std::span<const std::byte> bytes, std::string_view name, const DecodeLimits& limits);
Image8 DecodeKtx2(std::span<const std::byte> bytes, std::string_view name, const DecodeLimits& limits);
ImageF DecodeHdr(std::span<const std::byte> bytes, std::string_view name, const DecodeLimits& limits,
                 std::vector<std::string>& warnings);
// Returns R G B [A] or Y of an EXR as RGBA, with values as they are.
ImageF DecodeExrColor(std::span<const std::byte> bytes, std::string_view name, const DecodeLimits& limits);

// Throws Error{Usage} unless the picture is not empty and has its four numbers for each texel.
void CheckTexelCount(const std::filesystem::path& path, uint64_t width, uint64_t height, size_t texelNumbers);

}  // namespace raygraph::image
