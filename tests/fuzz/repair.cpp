// Repairs the parts of files that a decoder checks first.
#include <algorithm>
#include <cstring>

#include "tests/fuzz/gltf_files.h"

namespace raygraph::fuzz {

namespace {

void PutLittle(Bytes& bytes, size_t at, size_t value) {
    for (size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<std::byte>(value >> (8 * i) & 0xFFu);
}

void PutBig(Bytes& bytes, size_t at, size_t value) {
    for (size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<std::byte>(value >> (24 - 8 * i) & 0xFFu);
}

size_t Little(const Bytes& bytes, size_t at) {
    size_t value = 0;
    for (size_t i = 0; i < 4; ++i) value |= std::to_integer<size_t>(bytes[at + i]) << (8 * i);
    return value;
}

size_t Big(const Bytes& bytes, size_t at) {
    size_t value = 0;
    for (size_t i = 0; i < 4; ++i) value = value << 8 | std::to_integer<size_t>(bytes[at + i]);
    return value;
}

void PutText(Bytes& bytes, size_t at, std::string_view text) {
    std::memcpy(bytes.data() + at, text.data(), text.size());
}

uint32_t Crc(Input bytes) {
    uint32_t crc = ~0u;
    for (const std::byte byte : bytes) {
        crc ^= std::to_integer<uint32_t>(byte);
        for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (0xEDB88320u & (0u - (crc & 1u)));
    }
    return ~crc;
}

void PutChunk(Bytes& png, std::string_view type, Input content) {
    const size_t at = png.size();
    png.resize(at + 12 + content.size());
    PutBig(png, at, content.size());
    PutText(png, at + 4, type);
    std::ranges::copy(content, png.begin() + static_cast<ptrdiff_t>(at + 8));
    PutBig(png, png.size() - 4, Crc(Input(png).subspan(at + 4, content.size() + 4)));
}

}  // namespace

Bytes MakeGlb(std::string_view json, Input binary) {
    const auto padded = [](size_t size) { return (size + 3) / 4 * 4; };
    const size_t jsonSize = padded(json.size()), binarySize = padded(binary.size());
    Bytes glb(20 + jsonSize, std::byte{' '});
    PutText(glb, 0, "glTF");
    PutLittle(glb, 4, 2);
    PutLittle(glb, 12, jsonSize);
    PutText(glb, 16, "JSON");
    PutText(glb, 20, json);
    glb.resize(glb.size() + 8 + binarySize);
    PutLittle(glb, 20 + jsonSize, binarySize);
    PutText(glb, 24 + jsonSize, std::string_view("BIN\0", 4));
    std::ranges::copy(binary, glb.begin() + static_cast<ptrdiff_t>(28 + jsonSize));
    PutLittle(glb, 8, glb.size());
    return glb;
}

Bytes SmallPng() {
    Bytes png(8);
    PutText(png, 0, "\x89PNG\r\n\x1a\n");
    // 2 x 2 texels of 8-bit gray in a zlib stream of one stored block, with a filter byte per row
    constexpr uint8_t kHeader[] = {0, 0, 0, 2, 0, 0, 0, 2, 8, 0, 0, 0, 0};
    constexpr uint8_t kRows[] = {0x78, 0x01, 0x01, 6,   0, 0xF9, 0xFF, 0,   50,
                                 100,  0,    150,  200, 4, 0x84, 0x01, 0xF5};
    PutChunk(png, "IHDR", std::as_bytes(std::span(kHeader)));
    PutChunk(png, "IDAT", std::as_bytes(std::span(kRows)));
    PutChunk(png, "IEND", {});
    return png;
}

// Repairs the lengths of the header and of the first two chunks: the first ends with the JSON text if its
// stated length does not lead to a chunk.
void RepairGlb(Bytes& file) {
    if (file.size() < 28) return;
    PutText(file, 0, "glTF");
    PutLittle(file, 4, 2);
    PutLittle(file, 8, file.size());
    PutText(file, 16, "JSON");
    constexpr std::string_view kBin("BIN\0", 4);
    const std::string_view text = AsText(file);
    size_t end = 20 + Little(file, 12);
    if (end + 8 > file.size() || text.substr(end + 4, 4) != kBin) {
        const size_t found = text.find(kBin, 24);
        end = found == text.npos ? file.size() : found - 4;
        PutLittle(file, 12, end - 20);
    }
    if (end + 8 <= file.size()) PutLittle(file, end, file.size() - end - 8);
}

// Repairs the checksums of the chunks.
void RepairPng(Bytes& file) {
    if (file.size() < 8 || AsText(file).substr(1, 3) != "PNG") return;
    for (size_t at = 8; at + 12 <= file.size();) {
        const size_t length = std::min(Big(file, at), file.size() - at - 12);
        PutBig(file, at, length);
        PutBig(file, at + 8 + length, Crc(Input(file).subspan(at + 4, length + 4)));
        at += 12 + length;
    }
}

}  // namespace raygraph::fuzz
