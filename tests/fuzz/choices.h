// Choices reads an input as decisions, for targets that build their own, mostly valid, files. After the end
// of the input, all decisions are 0.
#pragma once

#include <array>
#include <cstring>

#include "tests/fuzz/target.h"

namespace raygraph::fuzz {

class Choices {
  public:
    explicit Choices(Input input) : m_rest(input) {}

    uint8_t Byte() {
        if (m_rest.empty()) return 0;
        const auto value = std::to_integer<uint8_t>(m_rest[0]);
        m_rest = m_rest.subspan(1);
        return value;
    }
    bool Flag() { return Byte() % 2 == 1; }
    // Returns `usual` for half of all bytes, else an unusual or a small number.
    uint64_t Number(uint64_t usual) {
        constexpr std::array<uint64_t, 16> kUnusual{1,
                                                    2,
                                                    3,
                                                    5,
                                                    252,
                                                    253,
                                                    65535,
                                                    65536,
                                                    0x7FFFFFFF,
                                                    0x80000000,
                                                    0xFFFFFFFE,
                                                    0xFFFFFFFF,
                                                    1ull << 32,
                                                    1ull << 53,
                                                    0x8000000000000000,
                                                    0xFFFFFFFFFFFFFFFF};
        const uint8_t choice = Byte();
        if (choice < 128) return usual;
        if (choice < 128 + kUnusual.size()) return kUnusual[choice - 128];
        if (choice < 160) return usual + choice - 152;  // close to it
        return choice - 160;
    }
    template <size_t N>
    auto OneOf(const std::array<const char*, N>& all, size_t usual) {
        const uint8_t choice = Byte();
        return all[choice < 128 ? usual : choice % N];
    }
    Input Rest() const { return m_rest; }

  private:
    Input m_rest;
};

}  // namespace raygraph::fuzz
