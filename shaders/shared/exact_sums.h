// Exact sums of samples: one source for C++ and GLSL, in 32-bit integers only, so that every device and the
// host give the same bits.
//
// A sample is taken as the nearest multiple of 2^-64 (ties to even): exactly, unless it is below 2^-40. One
// beyond +-2^40 counts as +-2^40; one that is not finite counts as 0. Its sum is an integer in units of
// 2^-64, kSumWords words, lowest first, two's complement; that of its squares likewise, kSquareWords words,
// never negative, each square rounded to the nearest unit. Integers have no rounding that depends on an
// order: sums over any parts of the samples, added up in any order, are the sum over all of them.
//
// Room: sums up to 2^63 and sums of squares up to 2^96: 7e8 samples of 1e10 and their squares. Larger sums
// wrap around.
#ifndef RAYGRAPH_SHARED_EXACT_SUMS_H
#define RAYGRAPH_SHARED_EXACT_SUMS_H

#ifdef __cplusplus
#include <bit>
#include <cstdint>

namespace raygraph::gpu {
using uint = uint32_t;
#define RAYGRAPH_CONSTANT inline constexpr
#define RAYGRAPH_FUNCTION inline
#else
#define RAYGRAPH_CONSTANT const
#define RAYGRAPH_FUNCTION
#endif

RAYGRAPH_CONSTANT int kSumWords = 4;
RAYGRAPH_CONSTANT int kSquareWords = 5;
RAYGRAPH_CONSTANT int kUnitExponent = -64;
RAYGRAPH_CONSTANT int kMaxExponent = 40;  // exponent of the greatest value

struct ExactSum {
    uint words[4];
};
struct ExactSquares {
    uint words[5];
};
struct ExactNumber {  // wide enough for all on the way to mean and variance
    uint words[8];
};
struct UintPair {
    uint low, high;
};

// magnitude * 2^shift units.
struct ExactValue {
    UintPair magnitude;  // below 2^48
    int shift;           // at least 0
    bool isNegative;
};

// Describes a value as words in units: words[0] is word `first`, and those beyond these are 0. Of a negative
// one the complement of all words: adding 1 makes it the two's complement.
struct ExactWords {
    uint words[3];
    int first;
    uint complement;  // all ones for a negative one, else 0
};

// Describes a count of samples as sums are divided by it: divisor / 2^shift is the count, and the highest bit
// of the divisor is set. `reciprocal` is floor((2^64 - 1) / divisor) - 2^32.
struct ExactDivisor {
    uint divisor, reciprocal;
    int shift;
};

RAYGRAPH_FUNCTION UintPair MultiplyUints(uint a, uint b) {
    UintPair product;
#ifdef __cplusplus
    const uint64_t wide = uint64_t{a} * b;
    product.low = static_cast<uint>(wide);
    product.high = static_cast<uint>(wide >> 32);
#else
    umulExtended(a, b, product.high, product.low);
#endif
    return product;
}

// Zeros above the highest bit of a value that is not 0.
RAYGRAPH_FUNCTION int LeadingZeros(uint value) {
#ifdef __cplusplus
    return std::countl_zero(value);
#else
    return 31 - findMSB(value);
#endif
}

// Returns the 32 bits of `value` from bit `offset` on; those outside of it are 0.
RAYGRAPH_FUNCTION uint BitsFrom(UintPair value, int offset) {
    if (offset <= -32 || offset >= 64) return 0u;
    if (offset < 0) return value.low << uint(-offset);
    if (offset == 0) return value.low;
    if (offset < 32) return (value.low >> uint(offset)) | (value.high << uint(32 - offset));
    return value.high >> uint(offset - 32);
}

// value * 2^-shift for a shift of 0 to 63.
RAYGRAPH_FUNCTION UintPair ShiftRight(UintPair value, int shift) {
    uint bits = uint(shift) & 31u;
    UintPair result;
    result.low = shift < 32 ? (value.low >> bits) | ((value.high << 1u) << (31u - bits)) : value.high >> bits;
    result.high = shift < 32 ? value.high >> bits : 0u;
    return result;
}

// value * 2^-shift, to the nearest, ties to even. `value` is below 2^48 and shift at least 1.
RAYGRAPH_FUNCTION UintPair ShiftRightRounded(UintPair value, int shift) {
    shift = shift < 50 ? shift : 50;  // nothing is left of the value from there on
    UintPair odd = ShiftRight(value, shift), under, sum;
    odd.low &= 1u;
    // Half of the result's unit, less one bit: it carries from just above the tie on, or from the tie if the
    // result is odd
    int bits = shift - 1;
    under.low = bits < 32 ? (1u << (uint(bits) & 31u)) - 1u : 0xFFFFFFFFu;
    under.high = bits < 32 ? 0u : (1u << (uint(bits) & 31u)) - 1u;
    uint added = under.low + odd.low;
    uint carry = added < odd.low ? 1u : 0u;
    sum.low = value.low + added;
    carry += sum.low < added ? 1u : 0u;
    sum.high = value.high + under.high + carry;
    return ShiftRight(sum, shift);
}

// Returns the value of a sample in units, from the bits of its float.
RAYGRAPH_FUNCTION ExactValue ExactSample(uint bits) {
    int exponent = int((bits >> 23u) & 255u);
    ExactValue value;
    value.isNegative = (bits >> 31u) != 0u;
    value.magnitude.low = (bits & 0x7FFFFFu) | 0x800000u;  // also for a denormal: it is far below a unit
    value.magnitude.high = 0u;
    value.shift = exponent - 150 - kUnitExponent;
    if (exponent == 255) {
        value.magnitude.low = 0u;
        value.shift = 0;
    } else if (exponent >= 127 + kMaxExponent) {
        value.magnitude.low = 0x800000u;
        value.shift = kMaxExponent - 23 - kUnitExponent;
    } else if (value.shift < 0) {
        value.magnitude = ShiftRightRounded(value.magnitude, -value.shift);
        value.shift = 0;
    }
    return value;
}

RAYGRAPH_FUNCTION ExactValue ExactSquare(ExactValue value) {
    ExactValue square;
    square.isNegative = false;
    square.magnitude = MultiplyUints(value.magnitude.low, value.magnitude.low);
    square.shift = 2 * value.shift + kUnitExponent;
    if (square.shift < 0) {
        square.magnitude = ShiftRightRounded(square.magnitude, -square.shift);
        square.shift = 0;
    }
    return square;
}

RAYGRAPH_FUNCTION ExactWords WordsOf(ExactValue value) {
    uint bits = uint(value.shift) & 31u;
    ExactWords result;
    result.first = value.shift >> 5;
    result.complement = value.isNegative ? 0xFFFFFFFFu : 0u;
    result.words[0] = value.magnitude.low << bits;
    result.words[1] = (value.magnitude.high << bits) | ((value.magnitude.low >> 1u) >> (31u - bits));
    result.words[2] = (value.magnitude.high >> 1u) >> (31u - bits);
    return result;
}

RAYGRAPH_FUNCTION uint WordOf(ExactWords value, int k) {
    int i = k - value.first;
    uint word = i == 0 ? value.words[0] : i == 1 ? value.words[1] : i == 2 ? value.words[2] : 0u;
    return word ^ value.complement;
}

// Returns the bits of the float nearest to (value + rest) * 2^exponent, ties to even. `value` is at least
// 2^24, and rest is below 1: 0 if `hasRest` is false. Below the least normal float: 0.
RAYGRAPH_FUNCTION uint NearestFloat(uint value, bool hasRest, int exponent) {
    uint extra = uint(8 - LeadingZeros(value));  // bits beyond 24
    uint halfway = 1u << (extra - 1u), below = value & (2u * halfway - 1u);
    uint mantissa = value >> extra;
    if (below > halfway || (below == halfway && (hasRest || (mantissa & 1u) != 0u))) mantissa += 1u;
    int biased = exponent + int(extra) + 150;
    if (biased <= 0) return 0u;
    return (uint(biased) << 23u) + (mantissa - 0x800000u);  // carries into the exponent from 2^24
}

// Returns the bits of the float nearest to n * 2^exponent / (high * 2^32 + low), ties to even. The divisor is
// not 0. Below the least normal float: 0. Restoring division, a bit a step.
RAYGRAPH_FUNCTION uint NearestQuotient(ExactNumber n, int exponent, UintPair divisor) {
    for (int step = 0; step < 7; ++step) {
        if (n.words[7] != 0u) break;
        for (int i = 7; i > 0; --i) n.words[i] = n.words[i - 1];
        n.words[0] = 0u;
        exponent -= 32;
    }
    if (n.words[7] == 0u) return 0u;
    // The highest bits of n, from its first one on, and whether others are below them
    int zeros = LeadingZeros(n.words[7]);
    uint top[3];
    for (int i = 0; i < 3; ++i) {
        UintPair pair;
        pair.low = n.words[i + 4];
        pair.high = n.words[i + 5];
        top[i] = BitsFrom(pair, 32 - zeros);
    }
    exponent -= zeros;
    uint rest = (n.words[4] << uint(zeros)) | n.words[3] | n.words[2] | n.words[1] | n.words[0];

    if (divisor.high == 0u) {
        divisor.high = divisor.low;
        divisor.low = 0u;
        exponent += 32;
    }
    int divisorZeros = LeadingZeros(divisor.high);
    divisor.high = BitsFrom(divisor, 32 - divisorZeros);
    divisor.low <<= uint(divisorZeros);
    exponent += divisorZeros;

    // 63 bits are less than the divisor; the 26 that follow give a quotient of 25 or 26 bits
    uint low = (top[1] >> 1u) | (top[2] << 31u), high = top[2] >> 1u;
    uint next = (top[1] << 31u) | (top[0] >> 1u);
    rest |= (next & 63u) | (top[0] & 1u);
    uint quotient = 0u;
    for (int step = 0; step < 26; ++step) {
        bool isBeyond = (high >> 31u) != 0u;
        high = (high << 1u) | (low >> 31u);
        low = (low << 1u) | (next >> 31u);
        next <<= 1u;
        quotient <<= 1u;
        if (isBeyond || high > divisor.high || (high == divisor.high && low >= divisor.low)) {
            high -= divisor.high + (low < divisor.low ? 1u : 0u);
            low -= divisor.low;
            quotient |= 1u;
        }
    }
    rest |= high | low;
    exponent += 5 * 32 + 7;  // adjusts for the words and bits of n that the quotient leaves out

    return NearestFloat(quotient, rest != 0u, exponent);
}

// Returns the magnitude of a sum; the words above it are 0.
RAYGRAPH_FUNCTION ExactNumber MagnitudeOf(ExactSum sum) {
    bool isNegative = (sum.words[3] >> 31u) != 0u;
    ExactNumber magnitude;
    uint carry = isNegative ? 1u : 0u;
    for (int i = 0; i < 4; ++i) {
        uint word = isNegative ? ~sum.words[i] : sum.words[i];
        magnitude.words[i] = word + carry;
        carry = magnitude.words[i] < carry ? 1u : 0u;
        magnitude.words[i + 4] = 0u;
    }
    return magnitude;
}

#ifdef __cplusplus
// Takes a count of at least 1.
inline ExactDivisor DivisorOf(uint count) {
    const int zeros = LeadingZeros(count);
    const uint divisor = count << zeros;
    return {divisor, static_cast<uint>(~uint64_t{0} / divisor - (uint64_t{1} << 32)), zeros};
}
#endif

// Returns the bits of the float nearest to the mean of samples whose count is the divisor's.
RAYGRAPH_FUNCTION uint MeanOfExactSum(ExactSum sum, ExactDivisor count) {
    ExactNumber n = MagnitudeOf(sum);
    // The highest words of the number, from the first that is not 0.
    uint first = n.words[3], second = n.words[2], third = n.words[1], rest = n.words[0];
    int exponent = kUnitExponent + 65;
    for (int step = 0; step < 3; ++step) {
        bool isFound = first != 0u;
        first = isFound ? first : second;
        second = isFound ? second : third;
        third = isFound ? third : rest;
        rest = isFound ? rest : 0u;
        exponent -= isFound ? 0 : 32;
    }
    if (first == 0u) return 0u;
    // The highest 63 bits of the number, which are less than the divisor followed by 32 zeros.
    uint zeros = uint(LeadingZeros(first)), ones = 31u - zeros;
    uint top = (first << zeros) | ((second >> 1u) >> ones);
    uint next = (second << zeros) | ((third >> 1u) >> ones);
    rest |= (third << zeros) | (next & 1u);
    uint high = top >> 1u, low = (top << 31u) | (next >> 1u);
    exponent += count.shift - int(zeros);
    // Division by a reciprocal: N. Möller and T. Granlund 2011, "Improved Division by Invariant Integers",
    // IEEE Transactions on Computers 60(2), algorithm 4
    UintPair estimate = MultiplyUints(count.reciprocal, high);
    estimate.low += low;
    uint quotient = estimate.high + high + (estimate.low < low ? 1u : 0u) + 1u;
    uint remainder = low - quotient * count.divisor;
    if (remainder > estimate.low) {
        quotient -= 1u;
        remainder += count.divisor;
    }
    if (remainder >= count.divisor) {
        quotient += 1u;
        remainder -= count.divisor;
    }
    uint mean = NearestFloat(quotient, (rest | remainder) != 0u, exponent);
    return mean == 0u ? 0u : mean | (sum.words[3] & 0x80000000u);
}

// Returns the bits of the float nearest to the unbiased variance of `count` samples, 0 below two: (count *
// sum(x^2) - sum(x)^2) / (count * (count - 1)), in integers.
RAYGRAPH_FUNCTION uint VarianceOfExactSums(ExactSum sum, ExactSquares squares, uint count) {
    if (count < 2u) return 0u;
    // count * squares, in units of 2^-128
    ExactNumber n;
    n.words[0] = 0u;
    n.words[1] = 0u;
    uint carry = 0u;
    for (int i = 0; i < 5; ++i) {
        UintPair product = MultiplyUints(squares.words[i], count);
        n.words[i + 2] = product.low + carry;
        carry = product.high + (n.words[i + 2] < carry ? 1u : 0u);
    }
    n.words[7] = carry;
    // sum^2
    ExactNumber magnitude = MagnitudeOf(sum), square;
    for (int i = 0; i < 8; ++i) square.words[i] = 0u;
    for (int i = 0; i < 4; ++i) {
        carry = 0u;
        for (int j = 0; j < 4; ++j) {
            UintPair product = MultiplyUints(magnitude.words[i], magnitude.words[j]);
            uint added = product.low + carry;
            carry = product.high + (added < carry ? 1u : 0u);
            square.words[i + j] += added;
            carry += square.words[i + j] < added ? 1u : 0u;
        }
        square.words[i + 4] = carry;
    }
    // Rounded squares may leave less than nothing
    uint borrow = 0u;
    for (int i = 0; i < 8; ++i) {
        uint from = n.words[i], less = square.words[i];
        n.words[i] = from - less - borrow;
        borrow = from < less || (from == less && borrow != 0u) ? 1u : 0u;
    }
    if (borrow != 0u) return 0u;
    UintPair divisor = MultiplyUints(count, count - 1u);
    return NearestQuotient(n, 2 * kUnitExponent, divisor);
}

#undef RAYGRAPH_CONSTANT
#undef RAYGRAPH_FUNCTION

#ifdef __cplusplus
}  // namespace raygraph::gpu
#endif
#undef RAYGRAPH_FUNCTION

#endif
