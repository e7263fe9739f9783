#include "editor/cli/frame_range.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/printable.h"
#include "base/text.h"
#include "editor/session/settings/parse.h"

namespace raygraph::cli {

namespace {

// Times with decimal digits have rounding errors of up to this fraction of a step.
constexpr double kRounding = 1e-6;

double Steps(const FrameRange& range) {
    return (range.last - range.first) / range.step;
}

uint32_t Skipped(const FrameRange& range) {
    return range.part ? range.part->begin : 0;
}

}  // namespace

uint32_t FrameRange::Count() const {
    if (part) return part->end - part->begin;
    return static_cast<uint32_t>(std::floor(Steps(*this) + kRounding)) + 1;
}

// Rounding gives a frame the same time in each part of a sequence: 3 * 0.1 is not 0.3.
double FrameRange::TimeOf(uint32_t frame) const {
    return std::round((first + (Skipped(*this) + frame) * step) * 1e9) / 1e9;
}

int64_t FrameRange::NumberOf(uint32_t frame) const {
    return std::llround(first / step) + Skipped(*this) + frame;
}

FrameRange PartOf(const Shard& shard, const FrameRange& frames) {
    FrameRange range = frames;
    range.part = PartOf(shard, frames.Count());
    return range;
}

FrameRange ParseFrames(std::string_view text) {
    const size_t a = text.find(':'), b = text.rfind(':');
    if (a == text.npos || a == b) throw MakeError(ErrorKind::Usage, "{} is not A:B:STEP", Quoted(text));
    const auto seconds = [](std::string_view part) { return session::ParseNumber(part, -1e6, 1e6); };
    const FrameRange range{.first = seconds(text.substr(0, a)),
                           .last = seconds(text.substr(a + 1, b - a - 1)),
                           .step = session::ParseNumber(text.substr(b + 1), 1e-6, 1e6)};
    if (range.last < range.first) throw MakeError(ErrorKind::Usage, "{} ends before it begins", Quoted(text));
    if (Steps(range) + kRounding >= FrameRange::kMaxCount)
        throw MakeError(ErrorKind::Usage, "{} has more than {} frames", Quoted(text), FrameRange::kMaxCount);
    return range;
}

bool HasNumberPlaceholder(const std::filesystem::path& path) {
    const std::string name = path.filename().string();
    const size_t first = name.find('#');
    return first != name.npos &&
           name.find('#', std::min(name.find_first_not_of('#', first), name.size())) == name.npos;
}

std::filesystem::path Numbered(const std::filesystem::path& path, int64_t number) {
    std::string name = path.filename().string();
    const size_t first = name.find('#');
    if (first == name.npos) return path;  // an empty path, for example of a report that is not written
    const size_t width = std::min(name.find_first_not_of('#', first), name.size()) - first;
    name.replace(first, width, Text("{:0{}}", number, width));
    return path.parent_path() / name;
}

}  // namespace raygraph::cli
