// SampleRanges holds the samples of a render: disjoint, sorted ranges of sample indices. Samples are
// functions of their index, so none must be counted twice. Threads: plain values and pure functions, for any
// thread.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/api.h"

namespace raygraph::session {

struct SampleRange {
    uint32_t first = 0;
    uint32_t count = 0;

    bool operator==(const SampleRange&) const = default;
    uint64_t End() const { return uint64_t{first} + count; }  // one past the last
};

using SampleRanges = std::vector<SampleRange>;

// Returns the number of samples in all ranges.
RAYGRAPH_API uint64_t SampleCount(const SampleRanges& ranges);

// Returns the first and last sample of each range: "0-63", "0-63 128-191".
RAYGRAPH_API std::string ToText(const SampleRanges& ranges);
// Parses ToText's result. Throws Error{BadInput} for malformed text, or empty, unsorted or overlapping
// ranges.
RAYGRAPH_API SampleRanges ParseSampleRanges(std::string_view text);

// Returns whether some sample is in both.
RAYGRAPH_API bool Overlap(const SampleRanges& a, const SampleRanges& b);
// Returns the union, with adjacent ranges joined. They must not overlap.
RAYGRAPH_API SampleRanges Union(const SampleRanges& a, const SampleRanges& b);

}  // namespace raygraph::session
