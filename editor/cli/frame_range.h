// FrameRange gives the frames of an animation that one command renders.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>

#include "editor/cli/shard.h"

namespace raygraph::cli {

struct FrameRange {
    double first = 0.0, last = 0.0, step = 1.0;  // seconds
    std::optional<ShardPart> part = {};          // the shard's part of these frames; none: all

    static constexpr uint32_t kMaxCount = 100'000;

    // `last` is included if it is a whole number of steps after `first`.
    uint32_t Count() const;
    double TimeOf(
        uint32_t frame) const;  // rounded to a billionth of a second; `frame` is relative to the part
    // Returns the number in file names, counted as if the animation began at 0, so that ranges that are
    // rendered separately fit together.
    int64_t NumberOf(uint32_t frame) const;
};

// Returns the frames that the shard renders.
FrameRange PartOf(const Shard& shard, const FrameRange& frames);

// Parses "A:B:STEP". Throws Error{Usage}.
FrameRange ParseFrames(std::string_view text);

// Returns whether the file's name, without its folder, has a place for the number: exactly one run of '#'.
bool HasNumberPlaceholder(const std::filesystem::path& path);
// Puts the number there, padded with zeros to the width of the run: "a.####.exr" becomes "a.0007.exr".
std::filesystem::path Numbered(const std::filesystem::path& path, int64_t number);

}  // namespace raygraph::cli
