#include "renderer/image/uastc_block.h"

#include <algorithm>
#include <tuple>

namespace raygraph::image {
namespace {

// Describes a mode. Numbers of an endpoint are so many bits below a digit of base 1 (none), 3 or 5; digits
// are stored together.
struct Mode {
    uint8_t code, codeBits;  // the first bits of a block of the mode
    uint8_t hintBits;        // for transcoders to other formats
    uint8_t parts, partBits;
    uint8_t channels;  // 2: luminance and alpha
    bool hasSecondPlane;
    uint8_t base, numberBits, weightBits;
};

// Indexed by mode. The eighth mode has one color; its other fields are not used.
constexpr uint32_t kModeCount = 19, kSolidMode = 8, kNoMode = 255;
constexpr std::array<Mode, kModeCount> kModes{{
    {0x01, 4, 15, 1, 0, 3, false, 3, 6, 4}, {0x35, 6, 15, 1, 0, 3, false, 1, 8, 2},
    {0x1D, 5, 15, 2, 5, 3, false, 1, 4, 3}, {0x03, 5, 15, 3, 4, 3, false, 3, 2, 2},
    {0x13, 5, 15, 2, 5, 3, false, 5, 3, 2}, {0x0B, 5, 15, 1, 0, 3, false, 1, 8, 3},
    {0x1B, 5, 15, 1, 0, 3, true, 5, 5, 2},  {0x07, 5, 15, 2, 5, 3, false, 5, 3, 2},
    {0x17, 5, 0, 1, 0, 4, false, 1, 8, 0},  {0x0F, 5, 23, 2, 5, 4, false, 1, 4, 2},
    {0x02, 3, 17, 1, 0, 4, false, 3, 4, 4}, {0x00, 2, 17, 1, 0, 4, true, 3, 4, 2},
    {0x06, 3, 17, 1, 0, 4, false, 3, 6, 3}, {0x1F, 5, 23, 1, 0, 4, true, 1, 8, 1},
    {0x0D, 5, 23, 1, 0, 4, false, 1, 8, 2}, {0x05, 7, 23, 1, 0, 2, false, 1, 8, 4},
    {0x15, 6, 23, 2, 5, 2, false, 1, 8, 2}, {0x25, 6, 23, 1, 0, 2, true, 1, 8, 2},
    {0x09, 4, 15, 1, 0, 3, false, 1, 5, 5},
}};

// Gives the mode by the lowest seven bits of a block.
constexpr std::array<uint8_t, 128> kModeOfBits = [] {
    std::array<uint8_t, 128> modes;
    for (uint32_t bits = 0; bits < modes.size(); ++bits) {
        modes[bits] = kNoMode;
        for (uint8_t mode = 0; mode < kModeCount; ++mode)
            if ((bits & ((1u << kModes[mode].codeBits) - 1)) == kModes[mode].code) modes[bits] = mode;
    }
    return modes;
}();

// Follows ASTC's color unquantization of a number to 8 bits. `upper` and `lowest` are its bits, `digit`
// stands above them.
constexpr uint8_t Unquantized(uint32_t base, uint32_t numberBits, uint32_t number) {
    if (base == 1) {
        uint32_t value = number << (8 - numberBits);
        for (uint32_t filled = numberBits; filled < 8; filled *= 2) value |= value >> filled;
        return static_cast<uint8_t>(value);
    }
    const uint32_t digit = number >> numberBits, upper = (number & ((1u << numberBits) - 1)) >> 1;
    const uint32_t flip = (number & 1) * 0x1FF;
    uint32_t spread = 0, scale = 0;
    switch (10 * base + numberBits) {
        case 32:
            spread = upper * 0b100010110, scale = 93;
            break;
        case 34:
            spread = upper << 6 | upper, scale = 22;
            break;
        case 36:
            spread = upper << 4 | upper >> 4, scale = 5;
            break;
        case 53:
            spread = upper << 7 | upper << 1 | upper >> 1, scale = 26;
            break;
        default:
            spread = upper << 5 | upper >> 3, scale = 6;
            break;
    }
    const uint32_t value = (digit * scale + spread) ^ flip;
    return static_cast<uint8_t>((flip & 0x80) | value >> 2);
}

// Holds all numbers that a mode's endpoints may have.
constexpr auto kUnquantized = [] {
    std::array<std::array<uint8_t, 256>, kModeCount> tables = {};
    for (uint32_t mode = 0; mode < kModeCount; ++mode)
        for (uint32_t number = 0; number < (uint32_t{kModes[mode].base} << kModes[mode].numberBits); ++number)
            tables[mode][number] = Unquantized(kModes[mode].base, kModes[mode].numberBits, number);
    return tables;
}();

// Indexed by the number of bits of an index, 1 to 5. The weights are 64ths of the second endpoint.
constexpr auto kWeights = [] {
    std::array<std::array<uint8_t, 32>, 6> tables = {};
    for (uint32_t bits = 1; bits < 6; ++bits) {
        for (uint32_t index = 0; index < 1u << bits; ++index) {
            uint32_t weight = index << (6 - bits);
            for (uint32_t filled = bits; filled < 6; filled *= 2) weight |= weight >> filled;
            tables[bits][index] = static_cast<uint8_t>(weight + (weight > 32 ? 1 : 0));
        }
    }
    return tables;
}();

// There are two ends of up to three parts.
using Endpoints = std::array<std::array<uint8_t, 4>, 6>;

Endpoints ReadEndpoints(uint32_t modeNumber, BlockBits& bits) {
    const Mode& mode = kModes[modeNumber];
    const uint32_t count = 2u * mode.parts * mode.channels;
    std::array<uint8_t, 18> digits = {};
    const uint32_t digitsPerGroup = mode.base == 3 ? 5 : 3;
    for (uint32_t first = 0; mode.base > 1 && first < count; first += digitsPerGroup) {
        const uint32_t inGroup = std::min(count - first, digitsPerGroup);
        constexpr std::array<uint8_t, 6> kBitsOfTrits{0, 2, 4, 5, 7, 8};
        uint32_t group = bits.Take(mode.base == 3 ? kBitsOfTrits[inGroup] : 7);
        for (uint32_t i = 0; i < inGroup; ++i, group /= mode.base)
            digits[first + i] = static_cast<uint8_t>(group % mode.base);
    }
    Endpoints endpoints = {};
    uint32_t at = 0;
    for (size_t part = 0; part < mode.parts; ++part) {
        auto& low = endpoints[2 * part];
        auto& high = endpoints[2 * part + 1];
        low[3] = high[3] = 255;
        for (size_t c = 0; c < mode.channels; ++c) {
            const size_t channel = mode.channels == 2 ? 3 * c : c;
            for (auto* end : {&low, &high}) {
                const uint32_t number =
                    uint32_t{digits[at++]} << mode.numberBits | bits.Take(mode.numberBits);
                (*end)[channel] = kUnquantized[modeNumber][number];
            }
        }
        if (mode.channels == 2)
            for (auto* end : {&low, &high}) (*end)[1] = (*end)[2] = (*end)[0];
    }
    return endpoints;
}

struct Parts {
    std::array<uint8_t, 16> ofTexel = {};
    uint32_t anchors = 0;  // a bit for each first texel of a part, whose index has one bit less
};

// Returns the divisions of a table that has so many bits a texel.
template <typename Numbers>
constexpr auto Divisions(const Numbers& numbers, uint32_t bitsPerTexel) {
    std::array<Parts, std::tuple_size_v<Numbers>> all;
    for (size_t number = 0; number < all.size(); ++number) {
        uint32_t seen = 0;
        for (uint32_t i = 0; i < 16; ++i) {
            const uint32_t part =
                uint32_t{numbers[number]} >> (bitsPerTexel * i) & ((1u << bitsPerTexel) - 1);
            all[number].ofTexel[i] = static_cast<uint8_t>(part);
            if ((seen >> part & 1) == 0) all[number].anchors |= 1u << i;
            seen |= 1u << part;
        }
    }
    return all;
}
constexpr std::array<Parts, 1> kWhole{Parts{{}, 1}};
constexpr auto kTwoParts = Divisions(uastc::kTwoParts, 1);
constexpr auto kTwoPartsOfMode7 = Divisions(uastc::kTwoPartsOfMode7, 1);
constexpr auto kThreeParts = Divisions(uastc::kThreeParts, 2);

std::span<const Parts> DivisionsOf(uint32_t modeNumber) {
    switch (kModes[modeNumber].parts) {
        case 1:
            return kWhole;
        case 3:
            return kThreeParts;
        default:
            if (modeNumber == 7) return kTwoPartsOfMode7;
            return kTwoParts;
    }
}

}  // namespace

bool DecodeUastc(std::span<const std::byte, 16> block, bool isSrgb, BlockTexels& texels) {
    const uint32_t modeNumber = kModeOfBits[std::to_integer<uint8_t>(block[0]) & 127];
    if (modeNumber == kNoMode) return false;
    const Mode& mode = kModes[modeNumber];
    BlockBits bits(block);
    bits.Take(mode.codeBits);
    if (modeNumber == kSolidMode) {
        const uint32_t color = bits.Take(32);
        for (unsigned i = 0; i < texels.size(); ++i) texels[i] = static_cast<uint8_t>(color >> 8 * (i % 4));
        return true;
    }
    bits.Take(mode.hintBits);
    const std::span<const Parts> divisions = DivisionsOf(modeNumber);
    const uint32_t division = bits.Take(mode.partBits);
    if (division >= divisions.size()) return false;
    const Parts& parts = divisions[division];
    // The second plane has alpha in modes where the block does not choose its channel
    const bool isChosen = mode.hasSecondPlane && mode.channels > 2;
    const uint32_t ofSecondPlane = isChosen ? bits.Take(2) : 3;
    const Endpoints endpoints = ReadEndpoints(modeNumber, bits);
    // These are in 64ths of 16 bits
    std::array<std::array<int32_t, 4>, 3> starts, steps;
    for (size_t part = 0; part < mode.parts; ++part) {
        for (size_t c = 0; c < 4; ++c) {
            const auto wide = [&](uint8_t value) { return value << 8 | (isSrgb ? 0x80 : value); };
            const int32_t low = wide(endpoints[2 * part][c]), high = wide(endpoints[2 * part + 1][c]);
            starts[part][c] = 64 * low + 32;
            steps[part][c] = high - low;
        }
    }
    const std::array<uint8_t, 32>& table = kWeights[mode.weightBits];
    for (size_t i = 0; i < 16; ++i) {
        const uint32_t weightBits = mode.weightBits - (parts.anchors >> i & 1);
        std::array<int32_t, 4> weights;
        weights.fill(table[bits.Take(weightBits)]);
        if (mode.hasSecondPlane) weights[ofSecondPlane] = table[bits.Take(weightBits)];
        const auto& start = starts[parts.ofTexel[i]];
        const auto& step = steps[parts.ofTexel[i]];
        for (size_t c = 0; c < 4; ++c)
            texels[4 * i + c] = static_cast<uint8_t>((start[c] + step[c] * weights[c]) >> 14);
    }
    return true;
}

}  // namespace raygraph::image
