#include "editor/session/file/sample_ranges.h"

#include <algorithm>

#include "base/check.h"
#include "base/printable.h"
#include "base/text.h"
#include "editor/session/settings/parse.h"

namespace raygraph::session {

uint64_t SampleCount(const SampleRanges& ranges) {
    uint64_t count = 0;
    for (const SampleRange& range : ranges) count += range.count;
    return count;
}

std::string ToText(const SampleRanges& ranges) {
    std::string text;
    for (const SampleRange& range : ranges)
        text += Text("{}{}-{}", text.empty() ? "" : " ", range.first, range.End() - 1);
    return text;
}

SampleRanges ParseSampleRanges(std::string_view text) {
    const auto refuse = [&]() -> Error {
        return {ErrorKind::BadInput, Quoted(text) + " is no list of sample ranges like 0-63"};
    };
    SampleRanges ranges;
    for (size_t begin = 0; begin <= text.size();) {
        const size_t end = std::min(text.find(' ', begin), text.size());
        const std::string_view part = text.substr(begin, end - begin);
        begin = end + 1;
        const size_t dash = part.find('-');
        if (dash == std::string_view::npos) throw refuse();
        uint32_t first = 0, last = 0;
        try {
            first = ParseCount(part.substr(0, dash));
            last = ParseCount(part.substr(dash + 1), first);
        } catch (const Error&) {
            throw refuse();
        }
        const bool isInOrder = ranges.empty() || first >= ranges.back().End();
        if (!isInOrder || last - first == 0xFFFFFFFFu) throw refuse();
        ranges.push_back({first, last - first + 1});
    }
    return ranges;
}

bool Overlap(const SampleRanges& a, const SampleRanges& b) {
    return std::ranges::any_of(a, [&](const SampleRange& x) {
        return std::ranges::any_of(
            b, [&](const SampleRange& y) { return x.first < y.End() && y.first < x.End(); });
    });
}

SampleRanges Union(const SampleRanges& a, const SampleRanges& b) {
    SampleRanges all = a;
    all.insert(all.end(), b.begin(), b.end());
    std::ranges::sort(all, {}, &SampleRange::first);
    SampleRanges joined;
    for (const SampleRange& range : all) {
        if (!joined.empty()) RG_CHECK_LE(joined.back().End(), uint64_t{range.first});
        if (!joined.empty() && joined.back().End() == range.first)
            joined.back().count += range.count;
        else
            joined.push_back(range);
    }
    return joined;
}

}  // namespace raygraph::session
