#include "tests/fuzz/mutator.h"

#include <algorithm>

namespace raygraph::fuzz {

namespace {

// std::mt19937 yields the same numbers everywhere; the distributions of the library do not.
size_t Below(std::mt19937& random, size_t bound) {
    return bound == 0 ? 0 : random() % bound;
}

auto At(Bytes& bytes, size_t index) {
    return bytes.begin() + static_cast<ptrdiff_t>(index);
}

// Replaces a decimal number in the text, if there is one.
void ChangeNumber(Bytes& bytes, std::mt19937& random) {
    constexpr const char* kNumbers[] = {
        "0",     "1",      "-1",  "65536", "2147483648",           "4294967295", "4294967296",
        "1e308", "1e-308", "0.5", "nan",   "18446744073709551615", "",           "123456789012345678901"};
    const auto isDigit = [](std::byte b) { return b >= std::byte{'0'} && b <= std::byte{'9'}; };
    const auto from = std::find_if(At(bytes, Below(random, bytes.size())), bytes.end(), isDigit);
    const auto to = std::find_if_not(from, bytes.end(), isDigit);
    if (from == to) return;
    const Input number = AsInput(kNumbers[Below(random, std::size(kNumbers))]);
    const auto at = bytes.erase(from, to);
    bytes.insert(at, number.begin(), number.end());
}

void Change(Bytes& bytes, std::mt19937& random) {
    if (bytes.empty()) {
        bytes.push_back(static_cast<std::byte>(random()));
        return;
    }
    const size_t at = Below(random, bytes.size());
    const size_t length = 1 + Below(random, std::min<size_t>(bytes.size() - at, 32));
    switch (Below(random, 8)) {
        case 0:
            bytes[at] ^= static_cast<std::byte>(1u << Below(random, 8));
            break;
        case 1:
            bytes[at] = static_cast<std::byte>(random());
            break;
        case 2:
            std::fill_n(At(bytes, at), length, Below(random, 2) ? std::byte{0xFF} : std::byte{0});
            break;
        case 3:
            bytes.erase(At(bytes, at), At(bytes, at + length));
            break;
        case 4: {
            const Bytes piece(At(bytes, at), At(bytes, at + length));
            bytes.insert(At(bytes, Below(random, bytes.size())), piece.begin(), piece.end());
            break;
        }
        case 5:
            bytes.resize(at);
            break;
        default:
            ChangeNumber(bytes, random);
    }
}

}  // namespace

Bytes Mutate(std::span<const Seed> inputs, size_t maxBytes, std::mt19937& random) {
    Bytes bytes = inputs[Below(random, inputs.size())].bytes;
    if (Below(random, 8) == 0) {
        const Bytes& other = inputs[Below(random, inputs.size())].bytes;
        bytes.resize(Below(random, bytes.size() + 1));
        const Input rest = Input(other).subspan(Below(random, other.size() + 1));
        bytes.insert(bytes.end(), rest.begin(), rest.end());
    }
    for (size_t i = 1 + Below(random, 4); i > 0; --i) Change(bytes, random);
    if (bytes.size() > maxBytes) bytes.resize(maxBytes);
    return bytes;
}

}  // namespace raygraph::fuzz
