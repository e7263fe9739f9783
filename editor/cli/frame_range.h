// The frames of an animation that one command renders.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>

#include "editor/cli/shard.h"

namespace raygraph::cli {

struct FrameRange {
    double first = 0.0, last = 0.0, step = 1.0;  // seconds
    std::optional<ShardPart> part = {};          // of the frames of these times; none: all

    static constexpr uint32_t kMaxCount = 100'000;

    // `last` is one of them if it is a whole number of steps away.
    uint32_t Count() const;
    double TimeOf(
        uint32_t frame) const;  // to a billionth of a second; `frame` counts from the first of the part
    // In file names: as if the animation began at 0, so that parts that are rendered each by itself fit
    // together.
    int64_t NumberOf(uint32_t frame) const;
};

// Its frames that are the shard's.
FrameRange PartOf(const Shard& shard, const FrameRange& frames);

// "A:B:STEP". Error{Usage}.
FrameRange ParseFrames(std::string_view text);

// Whether the name of the file, without its folder, has a place for the number: one run of '#'.
bool HasNumberPlace(const std::filesystem::path& path);
// With the number there, with zeros before it until it is as wide as the run: "a.####.exr" is "a.0007.exr".
std::filesystem::path Numbered(const std::filesystem::path& path, int64_t number);

}  // namespace raygraph::cli
