// Writes the --report of a merge, schema 1.
#pragma once

#include <string>
#include <vector>

#include "editor/session/file/image_statistics.h"
#include "editor/session/file/merge.h"
#include "editor/session/file/render_file.h"

namespace raygraph::cli {

// Describes a merged render, or the result.
struct MergedPart {
    std::string file;
    rhi::Extent2D size;
    session::SampleRanges samples;
    session::ImageStatistics image;
    std::string scene, device, driver;
    session::SettingTexts settings;
    session::AovSet aovs;
};
MergedPart DescribePart(const session::NamedRender& part);

struct MergeReport {
    std::vector<MergedPart> inputs;
    MergedPart output;
};

// Returns pretty-printed JSON with a newline at the end. Unknown numbers are null.
std::string ToJson(const MergeReport& report);

}  // namespace raygraph::cli
