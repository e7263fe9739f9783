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
    put(0x1007);  // caps, height, width, pixel format
    put(desc.height);
    put(desc.width);
    for (int i = 0; i < 14; ++i) put(i == 2 ? desc.levels : 0);  // pitch, depth, levels, 11 reserved words
    put(32);
    put(isNamed ? 4 : desc.formatFlags);
    if (isNamed)
        putCode(desc.dxgiFormat != 0 ? "DX10" : desc.fourCc);
    else
        put(0);
    put(isNamed ? 0 : desc.bitCount);
    for (const uint32_t mask : desc.masks) put(isNamed ? 0 : mask);
    put(0x1000);  // a texture
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

std::vector<std::byte> MakeKtx2(const Ktx2Desc& desc, std::span<const uint8_t> level) {
    return MakeKtx2(desc, std::as_bytes(level));
}

std::vector<std::byte> MakeKtx2(const Ktx2Desc& desc, std::span<const std::byte> level) {
    std::vector<std::byte> descriptor;
    const auto blockBytes = static_cast<uint32_t>(24 + 16 * desc.channels.size());
    PutNumber(descriptor, 4 + blockBytes);
    PutNumber(descriptor, 0);
    PutNumber(descriptor, 2 | blockBytes << 16);
    PutNumber(descriptor, desc.model | 1 << 8 | (desc.isSrgb ? 2u : 1u) << 16 | desc.flags << 24);
    for (int i = 0; i < 3; ++i) PutNumber(descriptor, 0);  // sizes of blocks and planes
    for (const uint32_t channel : desc.channels) {
        PutNumber(descriptor, 127 << 16 | channel << 24);
        for (int i = 0; i < 3; ++i) PutNumber(descriptor, 0);
    }
    std::vector<std::byte> keys;
    for (const auto& [key, value] : desc.keys) {
        const std::string entry = key + '\0' + value + '\0';
        PutNumber(keys, entry.size());
        for (const char character : entry) keys.push_back(static_cast<std::byte>(character));
        keys.resize((keys.size() + 3) / 4 * 4);
    }
    std::vector<std::byte> bytes;
    for (const char character : std::string_view("\xabKTX 20\xbb\r\n\x1a\n"))
        bytes.push_back(static_cast<std::byte>(character));
    const auto put = [&](uint64_t value) { PutNumber(bytes, value); };
    for (const uint32_t value : {desc.vkFormat, 1u, desc.width, desc.height, desc.depth, desc.layers,
                                 desc.faces, desc.levels, desc.supercompression})
        put(value);
    const uint64_t levelCount = desc.levels == 0 ? 1 : desc.levels;
    const uint64_t descriptorAt = 80 + 24 * levelCount, keysAt = descriptorAt + descriptor.size();
    const uint64_t globalAt = keysAt + keys.size(), levelAt = globalAt + desc.global.size();
    put(descriptorAt);
    put(descriptor.size());
    put(keys.empty() ? 0 : keysAt);
    put(keys.size());
    PutNumber(bytes, desc.global.empty() ? 0 : globalAt, 8);
    PutNumber(bytes, desc.global.size(), 8);
    std::vector<std::byte> others;
    for (uint64_t i = 0; i < levelCount; ++i) {
        if (i > 0 && i <= desc.smaller.size()) {
            const auto& [stored, inflated] = desc.smaller[i - 1];
            PutNumber(bytes, levelAt + level.size() + others.size(), 8);
            PutNumber(bytes, stored.size(), 8);
            PutNumber(bytes, inflated, 8);
            PutBytes(others, stored);
            continue;
        }
        PutNumber(bytes, levelAt, 8);
        PutNumber(bytes, level.size(), 8);
        PutNumber(bytes, desc.inflatedBytes.value_or(desc.supercompression == 1 ? 0 : level.size()), 8);
    }
    for (const auto& part :
         {std::span<const std::byte>(descriptor), std::span<const std::byte>(keys),
          std::span<const std::byte>(desc.global), level, std::span<const std::byte>(others)})
        bytes.insert(bytes.end(), part.begin(), part.end());
    return bytes;
}

}  // namespace raygraph::test
