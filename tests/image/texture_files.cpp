#include "tests/image/texture_files.h"

namespace raygraph::test {

void PutNumber(std::vector<std::byte>& bytes, uint64_t value, size_t count) {
    for (size_t i = 0; i < count; ++i) bytes.push_back(static_cast<std::byte>(value >> (8 * i) & 0xFF));
}

void PutBytes(std::vector<std::byte>& bytes, std::span<const uint8_t> more) {
    for (const uint8_t byte : more) bytes.push_back(std::byte{byte});
}

std::vector<std::byte> MakeDds(const DdsDesc& desc, std::span<const uint8_t> texels) {
    std::vector<std::byte> bytes;
    const auto put = [&](uint32_t value) { PutNumber(bytes, value); };
    const auto putCode = [&](std::string_view code) {
        for (const char character : code) bytes.push_back(static_cast<std::byte>(character));
    };
    const bool isNamed = desc.dxgiFormat != 0 || !desc.fourCc.empty();
    putCode("DDS ");
    put(124);
    put(0x1007);  // Caps, height, width, pixel format.
    put(desc.height);
    put(desc.width);
    for (int i = 0; i < 14; ++i) put(0);  // Pitch, depth, levels, 11 reserved.
    put(32);
    put(isNamed ? 4 : desc.formatFlags);
    if (isNamed)
        putCode(desc.dxgiFormat != 0 ? "DX10" : desc.fourCc);
    else
        put(0);
    put(isNamed ? 0 : desc.bitCount);
    for (const uint32_t mask : desc.masks) put(isNamed ? 0 : mask);
    put(0x1000);  // A texture.
    put(desc.caps2);
    for (int i = 0; i < 3; ++i) put(0);
    if (desc.dxgiFormat != 0)
        for (const uint32_t value :
             {desc.dxgiFormat, desc.dimension, desc.miscFlags, desc.arraySize, desc.alphaMode})
            put(value);
    PutBytes(bytes, texels);
    return bytes;
}

std::vector<std::byte> MakePlainDds(uint32_t width, uint32_t height, const std::array<uint8_t, 4>& color) {
    std::vector<uint8_t> texels;
    for (uint32_t i = 0; i < width * height; ++i) texels.insert(texels.end(), color.begin(), color.end());
    return MakeDds({.width = width, .height = height}, texels);
}

}  // namespace raygraph::test
