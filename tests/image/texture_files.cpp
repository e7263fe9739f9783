#include "tests/image/texture_files.h"

#include <algorithm>
#include <random>
#include <span>
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

namespace {

class BitWriter {
  public:
    void Put(uint32_t value, unsigned count) {
        for (unsigned i = 0; i < count; ++i, ++m_count) {
            if (m_count % 8 == 0) m_bytes.push_back(std::byte{0});
            m_bytes.back() |= static_cast<std::byte>((value >> i & 1) << m_count % 8);
        }
    }
    void PutChunks(uint32_t value, unsigned chunkBits) {
        for (bool hasMore = true; hasMore; value >>= chunkBits) {
            hasMore = value >> chunkBits != 0;
            Put((value & ((1u << chunkBits) - 1)) | (hasMore ? 1u << chunkBits : 0), chunkBits + 1);
        }
    }
    std::vector<std::byte> Take() const { return m_bytes; }

  private:
    std::vector<std::byte> m_bytes;
    size_t m_count = 0;
};

// Is a complete canonical code: all symbols have nearly equal numbers of bits, or 1, 2, 3, ... bits.
class Code {
  public:
    explicit Code(size_t symbolCount, bool isSkewed = false) {
        unsigned longest = 1;
        while (size_t{1} << longest < symbolCount) ++longest;
        const size_t shortCount = (size_t{1} << longest) - symbolCount;
        for (size_t i = 0; i < symbolCount; ++i) {
            const size_t skewed = std::min(i + 1, std::max<size_t>(symbolCount - 1, 1));
            const size_t flat = i < shortCount && longest > 1 ? longest - 1 : longest;
            m_lengths.push_back(static_cast<uint8_t>(isSkewed && symbolCount <= 17 ? skewed : flat));
        }
        m_words.resize(symbolCount);
        uint32_t word = 0;
        for (unsigned length = 1; length <= 16; ++length, word <<= 1)
            for (size_t i = 0; i < symbolCount; ++i)
                if (m_lengths[i] == length) m_words[i] = word++;
    }

    void PutSymbol(BitWriter& bits, size_t symbol) const {
        for (unsigned i = m_lengths[symbol]; i-- > 0;) bits.Put(m_words[symbol] >> i & 1, 1);
    }

    // Writes the lengths in the file's format, with runs by their symbols.
    void PutTable(BitWriter& bits) const {
        bits.Put(static_cast<uint32_t>(m_lengths.size()), 14);
        const Code lengthCode(21);
        constexpr std::array<uint8_t, 21> kOrder{17, 18, 19, 20, 0,  8, 7,  9, 6,  10, 5,
                                                 11, 4,  12, 3,  13, 2, 14, 1, 15, 16};
        bits.Put(21, 5);
        for (const uint8_t symbol : kOrder) bits.Put(lengthCode.m_lengths[symbol], 3);
        for (size_t i = 0; i < m_lengths.size();) {
            size_t run = 1;
            while (i + run < m_lengths.size() && m_lengths[i + run] == m_lengths[i]) ++run;
            lengthCode.PutSymbol(bits, m_lengths[i]);
            ++i, --run;
            if (run >= 7) {
                run = std::min<size_t>(run, 134);
                lengthCode.PutSymbol(bits, 20);
                bits.Put(static_cast<uint32_t>(run - 7), 7);
                i += run;
            } else if (run >= 3) {
                lengthCode.PutSymbol(bits, 19);
                bits.Put(static_cast<uint32_t>(run - 3), 2);
                i += run;
            }
        }
    }

  private:
    std::vector<uint8_t> m_lengths;
    std::vector<uint32_t> m_words;
};

std::vector<std::byte> PackColors(const BasisPicture& picture) {
    BitWriter bits;
    const std::array<Code, 3> codes{Code(32), Code(32), Code(32)};
    const Code tables(8, picture.areCodesSkewed);
    for (const Code& code : codes) code.PutTable(bits);
    tables.PutTable(bits);
    bits.Put(picture.isGray ? 1 : 0, 1);
    BasisColor last{{16, 16, 16}, 0};
    for (const BasisColor& color : picture.colors) {
        tables.PutSymbol(bits, (color.table - last.table) & 7);
        for (size_t c = 0; c < (picture.isGray ? 1u : 3u); ++c) {
            const size_t code = last.rgb[c] <= 9 ? 0 : last.rgb[c] <= 21 ? 1 : 2;
            codes[code].PutSymbol(bits, (color.rgb[c] - last.rgb[c]) & 31);
        }
        last = color;
    }
    return bits.Take();
}

std::vector<std::byte> PackPatterns(const BasisPicture& picture) {
    BitWriter bits;
    bits.Put(0, 2);
    bits.Put(picture.arePatternsRaw ? 1 : 0, 1);
    const Code code(256);
    if (!picture.arePatternsRaw) code.PutTable(bits);
    for (size_t i = 0; i < picture.patterns.size(); ++i) {
        for (unsigned row = 0; row < 4; ++row) {
            const uint32_t here = picture.patterns[i] >> 8 * row & 255;
            if (picture.arePatternsRaw || i == 0)
                bits.Put(here, 8);
            else
                code.PutSymbol(bits, here ^ (picture.patterns[i - 1] >> 8 * row & 255));
        }
    }
    return bits.Take();
}

struct SliceCodes {
    Code predictions, steps, patterns, runs;

    explicit SliceCodes(const BasisPicture& picture)
        : predictions(257),
          steps(picture.colors.size(), picture.areCodesSkewed),
          patterns(picture.patterns.size() + picture.historySize + 1, picture.areCodesSkewed),
          runs(64) {}
};

std::vector<std::byte> PackCodes(const BasisPicture& picture, const SliceCodes& codes) {
    BitWriter bits;
    for (const Code* code : {&codes.predictions, &codes.steps, &codes.patterns, &codes.runs})
        code->PutTable(bits);
    bits.Put(picture.historySize, 13);
    return bits.Take();
}

class SliceWriter {
  public:
    SliceWriter(const BasisPicture& picture, const BasisSlice& slice, const SliceCodes& codes)
        : m_picture(picture),
          m_slice(slice),
          m_codes(codes),
          m_columns((picture.width + 3) / 4),
          m_rows((picture.height + 3) / 4),
          m_random(picture.seed),
          m_history(picture.historySize),
          m_rover(picture.historySize / 2) {
        ChoosePredictions();
    }

    std::vector<std::byte> Pack() {
        uint32_t last = 0;
        for (uint32_t y = 0; y < m_rows; ++y) {
            for (uint32_t x = 0; x < m_columns; ++x) {
                if (x % 2 == 0 && y % 2 == 0) PutPredictions((y / 2) * ((m_columns + 1) / 2) + x / 2);
                const auto count = static_cast<uint32_t>(m_picture.colors.size());
                const uint32_t color = m_slice.colors[y * m_columns + x];
                if (PredictionOf(x, y) == 3) m_codes.steps.PutSymbol(m_bits, (color + count - last) % count);
                last = color;
                PutPattern(y * m_columns + x);
            }
        }
        return m_bits.Take();
    }

  private:
    uint32_t ColorAt(uint32_t x, uint32_t y) const { return m_slice.colors[y * m_columns + x]; }
    uint32_t PredictionOf(uint32_t x, uint32_t y) const {
        const uint32_t symbol = m_symbols[(y / 2) * ((m_columns + 1) / 2) + x / 2];
        return symbol >> (2 * (x % 2) + 4 * (y % 2)) & 3;
    }

    // Chooses a symbol for each group of two by two: any neighbor of the same color will do, and none always
    // does.
    void ChoosePredictions() {
        m_symbols.resize(size_t{(m_columns + 1) / 2} * ((m_rows + 1) / 2));
        for (uint32_t y = 0; y < m_rows; ++y) {
            for (uint32_t x = 0; x < m_columns; ++x) {
                std::vector<uint32_t> choices;
                if (x > 0 && ColorAt(x - 1, y) == ColorAt(x, y)) choices.push_back(0);
                if (y > 0 && ColorAt(x, y - 1) == ColorAt(x, y)) choices.push_back(1);
                if (x > 0 && y > 0 && ColorAt(x - 1, y - 1) == ColorAt(x, y)) choices.push_back(2);
                if (choices.empty() || (m_picture.seed != 0 && m_random() % 8 == 0)) choices.assign(1, 3u);
                if (m_picture.seed == 0) choices.resize(1);
                m_symbols[(y / 2) * ((m_columns + 1) / 2) + x / 2] |= choices[m_random() % choices.size()]
                                                                      << (2 * (x % 2) + 4 * (y % 2));
            }
        }
    }

    void PutPredictions(size_t group) {
        if (m_repeats > 0) {
            --m_repeats;
            return;
        }
        uint32_t run = 0;
        while (group + run < m_symbols.size() && m_symbols[group + run] == m_lastSymbol) ++run;
        if (run >= 3) {
            m_codes.predictions.PutSymbol(m_bits, 256);
            m_bits.PutChunks(run - 3, 4);
            m_repeats = run - 1;
        } else {
            m_codes.predictions.PutSymbol(m_bits, m_lastSymbol = m_symbols[group]);
        }
    }

    void PutPattern(size_t block) {
        if (m_run > 0) {
            --m_run;
            return;
        }
        const auto patternCount = static_cast<uint32_t>(m_picture.patterns.size());
        const uint32_t pattern = m_slice.patterns[block];
        uint32_t run = 0;
        while (!m_history.empty() && block + run < m_slice.patterns.size() &&
               m_slice.patterns[block + run] == m_history[0])
            ++run;
        if (run >= 3) {
            m_codes.patterns.PutSymbol(m_bits, patternCount + m_picture.historySize);
            m_codes.runs.PutSymbol(m_bits, std::min(run - 3, 63u));
            if (run - 3 >= 63) m_bits.PutChunks(run - 3, 7);
            m_run = run - 1;
            return;
        }
        const auto found = std::ranges::find(m_history, pattern);
        if (found != m_history.end()) {
            const auto place = static_cast<size_t>(found - m_history.begin());
            m_codes.patterns.PutSymbol(m_bits, patternCount + place);
            std::swap(m_history[place], m_history[place / 2]);
            return;
        }
        m_codes.patterns.PutSymbol(m_bits, pattern);
        if (m_history.empty()) return;
        m_history[m_rover++] = pattern;
        if (m_rover == m_history.size()) m_rover = m_history.size() / 2;
    }

    const BasisPicture& m_picture;
    const BasisSlice& m_slice;
    const SliceCodes& m_codes;
    uint32_t m_columns, m_rows;
    std::mt19937 m_random;
    BitWriter m_bits;
    std::vector<uint32_t> m_symbols;
    uint32_t m_lastSymbol = 0, m_repeats = 0, m_run = 0;
    std::vector<uint32_t> m_history;
    size_t m_rover;
};

}  // namespace

BasisFile CompressBasis(const BasisPicture& picture) {
    const SliceCodes codes(picture);
    BasisFile file;
    file.level = SliceWriter(picture, picture.color, codes).Pack();
    const size_t colorBytes = file.level.size();
    const bool hasAlpha = !picture.alpha.colors.empty();
    if (hasAlpha) {
        const std::vector<std::byte> alpha = SliceWriter(picture, picture.alpha, codes).Pack();
        file.level.insert(file.level.end(), alpha.begin(), alpha.end());
    }
    const std::array parts{PackColors(picture), PackPatterns(picture), PackCodes(picture, codes)};
    std::vector<std::byte>& global = file.desc.global;
    PutNumber(global, picture.colors.size(), 2);
    PutNumber(global, picture.patterns.size(), 2);
    for (const auto& part : parts) PutNumber(global, part.size());
    PutNumber(global, 0);
    for (uint32_t level = 0; level < picture.levels; ++level) {
        PutNumber(global, picture.imageFlags);
        PutNumber(global, 0);
        PutNumber(global, colorBytes);
        PutNumber(global, hasAlpha ? colorBytes : 0);
        PutNumber(global, file.level.size() - colorBytes);
    }
    for (const auto& part : parts) global.insert(global.end(), part.begin(), part.end());
    file.desc.width = picture.width;
    file.desc.height = picture.height;
    file.desc.levels = picture.levels;
    file.desc.supercompression = 1;
    file.desc.model = kEtc1s;
    file.desc.channels = picture.channels;
    if (file.desc.channels.empty())
        file.desc.channels = hasAlpha ? std::vector<uint32_t>{0, 15} : std::vector<uint32_t>{0};
    return file;
}

std::vector<std::byte> MakeBasisLz(const BasisPicture& picture) {
    const BasisFile file = CompressBasis(picture);
    return MakeKtx2(file.desc, file.level);
}

std::vector<uint8_t> TexelsOf(const BasisPicture& picture) {
    // These are ETC1's, by the index of the table and of the pattern.
    constexpr int kModifiers[8][4] = {{-8, -2, 2, 8},       {-17, -5, 5, 17},    {-29, -9, 9, 29},
                                      {-42, -13, 13, 42},   {-60, -18, 18, 60},  {-80, -24, 24, 80},
                                      {-106, -33, 33, 106}, {-183, -47, 47, 183}};
    const uint32_t columns = (picture.width + 3) / 4;
    const auto valueOf = [&](const BasisSlice& slice, uint32_t x, uint32_t y, size_t channel) {
        const size_t block = size_t{y / 4} * columns + x / 4;
        const BasisColor& color = picture.colors[slice.colors[block]];
        const uint32_t index = picture.patterns[slice.patterns[block]] >> 2 * (4 * (y % 4) + x % 4) & 3;
        const uint32_t wide = color.rgb[channel] * 8 + color.rgb[channel] / 4;
        return static_cast<uint8_t>(
            std::clamp(static_cast<int>(wide) + kModifiers[color.table][index], 0, 255));
    };
    std::vector<uint8_t> texels;
    for (uint32_t y = 0; y < picture.height; ++y)
        for (uint32_t x = 0; x < picture.width; ++x) {
            for (size_t c = 0; c < 3; ++c) texels.push_back(valueOf(picture.color, x, y, c));
            texels.push_back(picture.alpha.colors.empty() ? uint8_t{255} : valueOf(picture.alpha, x, y, 1));
        }
    return texels;
}

BasisPicture RandomBasisPicture(uint32_t width, uint32_t height, bool hasAlpha, uint32_t seed) {
    std::mt19937 random(seed);
    const auto below = [&](size_t count) { return static_cast<uint32_t>(random() % count); };
    BasisPicture picture{.width = width, .height = height, .seed = seed};
    picture.isGray = below(3) == 0;
    picture.arePatternsRaw = below(3) == 0;
    picture.areCodesSkewed = below(2) == 0;
    constexpr std::array<uint32_t, 5> kHistorySizes{0, 1, 2, 8, 64};
    picture.historySize = kHistorySizes[below(kHistorySizes.size())];
    for (uint32_t i = 0, count = 1 + below(20); i < count; ++i) {
        BasisColor color{{below(32), below(32), below(32)}, below(8)};
        if (picture.isGray) color.rgb[1] = color.rgb[2] = color.rgb[0];
        picture.colors.push_back(color);
    }
    for (uint32_t i = 0, count = 1 + below(40); i < count; ++i)
        picture.patterns.push_back(static_cast<uint32_t>(random()));
    const size_t blockCount = size_t{(width + 3) / 4} * ((height + 3) / 4);
    const uint32_t alike = 1 + below(30);
    for (BasisSlice* slice : {&picture.color, &picture.alpha}) {
        if (slice == &picture.alpha && !hasAlpha) break;
        for (size_t i = 0; i < blockCount; ++i) {
            const bool isColorNew = i == 0 || below(alike) == 0, isPatternNew = i == 0 || below(alike) == 0;
            slice->colors.push_back(isColorNew ? below(picture.colors.size()) : slice->colors.back());
            slice->patterns.push_back(isPatternNew ? below(picture.patterns.size()) : slice->patterns.back());
        }
    }
    return picture;
}

}  // namespace raygraph::test
