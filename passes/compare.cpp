#include "passes/compare.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/text.h"
#include "passes/add_compute.h"
#include "renderer/graph/readback_values.h"

namespace raygraph::passes {

TextureId Wipe(Renderer& renderer, TextureId left, TextureId right, float position) {
    const Extent2D extent = RequireComparable(renderer, "Wipe", left, right, Format::Rgba8Unorm);
    TextureId display = renderer.CreateTexture("display", {extent, Format::Rgba8Unorm});
    struct Constants {
        int32_t column;
        int32_t lineWidth;
    };
    const float place = std::isfinite(position) ? std::clamp(position, 0.0f, 1.0f) : 0.0f;
    const auto column = static_cast<int32_t>(std::lround(double{place} * extent.width));
    // The line is thin, but visible on a picture of many pixels
    const int32_t lineWidth = column == 0 ? 0 : 1 + static_cast<int32_t>(extent.width / 1000);
    AddCompute(renderer, "Wipe", "post/wipe.comp", extent, [&](PassBuilder& pass) {
        pass.Reads("left", left);
        pass.Reads("right", right);
        pass.Constants(Constants{column, lineWidth});
        display = pass.Writes("display", display);
    });
    return display;
}

TextureId SideBySide(Renderer& renderer, TextureId left, TextureId right) {
    const Extent2D extent = RequireComparable(renderer, "SideBySide", left, right, Format::Rgba8Unorm);
    TextureId display = renderer.CreateTexture("display", {extent, Format::Rgba8Unorm});
    AddCompute(renderer, "SideBySide", "post/side_by_side.comp", extent, [&](PassBuilder& pass) {
        pass.Reads("left", left);
        pass.Reads("right", right);
        display = pass.Writes("display", display);
    });
    return display;
}

namespace {

constexpr uint32_t kBlock = 16;  // side of a block in post/reduce_blocks.comp

uint64_t BlockCount(Extent2D extent) {
    const Extent2D blocks = BlocksOf(extent, kBlock);
    return uint64_t{blocks.width} * blocks.height;
}

void RequireNumbers(const Renderer& renderer, const char* pass, TextureId values) {
    const Format format = renderer.Desc(values).format;
    if (format != Format::R32Float)
        throw MakeError(ErrorKind::Usage, "{}: a map of {}, must be {}", pass, rhi::Name(format),
                        rhi::Name(Format::R32Float));
}

}  // namespace

DifferenceIds Difference(Renderer& renderer, TextureId a, TextureId b) {
    const Extent2D extent = RequireComparable(renderer, "Difference", a, b, Format::Rgba32Float);
    DifferenceIds ids{renderer.CreateTexture("difference", {extent, Format::Rgba32Float}),
                      renderer.CreateTexture("luminance", {extent, Format::R32Float})};
    AddCompute(renderer, "Difference", "post/difference.comp", extent, [&](PassBuilder& pass) {
        pass.Reads("a", a);
        pass.Reads("b", b);
        ids.difference = pass.Writes("difference", ids.difference);
        ids.luminance = pass.Writes("luminance", ids.luminance);
    });
    return ids;
}

TextureId RelativeError(Renderer& renderer, TextureId reference, TextureId test, float minimum) {
    const Extent2D extent =
        RequireComparable(renderer, "RelativeError", reference, test, Format::Rgba32Float);
    TextureId error = renderer.CreateTexture("relativeError", {extent, Format::R32Float});
    AddCompute(renderer, "RelativeError", "post/relative_error.comp", extent, [&](PassBuilder& pass) {
        pass.Reads("reference", reference);
        pass.Reads("test", test);
        pass.Constants(minimum);
        error = pass.Writes("error", error);
    });
    return error;
}

SquaredErrorIds RelativeSquaredError(Renderer& renderer, TextureId test, const AccumulatedIds& samples,
                                     const Accumulation::Progress& progress) {
    const Extent2D extent =
        RequireComparable(renderer, "RelativeSquaredError", test, samples.mean, Format::Rgba32Float);
    if (progress.sampleCount == 0)
        throw MakeError(ErrorKind::Usage, "RelativeSquaredError: pixels of the reference have no sample");
    SquaredErrorIds ids{renderer.CreateTexture("squaredError", {extent, Format::R32Float}),
                        renderer.CreateTexture("squaredNoise", {extent, Format::R32Float})};
    const struct {
        uint32_t sampleCount, doneRows, doneColumns, bandHeight;
    } constants{progress.sampleCount, progress.cursor.Y(), progress.cursor.X(), progress.cursor.BandHeight()};
    AddCompute(renderer, "RelativeSquaredError", "post/squared_error.comp", extent, [&](PassBuilder& pass) {
        pass.Reads("test", test);
        ReadSums(pass, samples, true);
        pass.Constants(constants);
        ids.error = pass.Writes("error", ids.error);
        ids.noise = pass.Writes("noise", ids.noise);
    });
    return ids;
}

TextureId Flicker(Renderer& renderer, TextureId picture, TextureId moments, float weight) {
    const Extent2D extent = renderer.Desc(picture).extent;
    if (!(renderer.Desc(moments).extent == extent))
        throw MakeError(ErrorKind::Usage, "Flicker: moments of another extent than the picture");
    TextureId flicker = renderer.CreateTexture("flicker", {extent, Format::R32Float});
    AddCompute(renderer, "Flicker", "post/flicker.comp", extent, [&](PassBuilder& pass) {
        pass.Reads("picture", picture);
        pass.Constants(weight);
        moments = pass.Updates("moments", moments);
        flicker = pass.Writes("flicker", flicker);
    });
    return flicker;
}

TextureId Heat(Renderer& renderer, TextureId values, float maximum) {
    RequireNumbers(renderer, "Heat", values);
    const Extent2D extent = renderer.Desc(values).extent;
    TextureId display = renderer.CreateTexture("display", {extent, Format::Rgba8Unorm});
    AddCompute(renderer, "Heat", "post/heat.comp", extent, [&](PassBuilder& pass) {
        pass.Reads("values", values);
        pass.Constants(maximum);
        display = pass.Writes("display", display);
    });
    return display;
}

BufferId ReduceBlocks(Renderer& renderer, TextureId values) {
    RequireNumbers(renderer, "ReduceBlocks", values);
    const Extent2D extent = renderer.Desc(values).extent;
    BufferId sums = renderer.CreateBuffer("blocks", {.size = BlockCount(extent) * 2 * sizeof(float)});
    AddCompute(renderer, "ReduceBlocks", "post/reduce_blocks.comp", BlocksOf(extent, kBlock),
               [&](PassBuilder& pass) {
                   pass.Reads("values", values);
                   sums = pass.Writes("blocks", sums);
               });
    return sums;
}

MapStatistics StatisticsOf(const Readback& blocks, Extent2D extent) {
    const std::vector<float> values = ValuesOf<float>(blocks);
    if (values.size() != BlockCount(extent) * 2)
        throw MakeError(ErrorKind::Usage, "StatisticsOf: {} numbers are not the blocks of a picture of {}x{}",
                        values.size(), extent.width, extent.height);
    MapStatistics statistics;
    for (size_t i = 0; i < values.size(); i += 2) {
        statistics.mean += double{values[i]};
        statistics.maximum = std::max(statistics.maximum, values[i + 1]);
    }
    statistics.mean /= double(extent.width) * extent.height;
    return statistics;
}

TextureId Subtract(Renderer& renderer, TextureId whole, TextureId part) {
    const GraphTextureDesc desc = renderer.Desc(whole), other = renderer.Desc(part);
    if (!(desc.extent == other.extent))
        throw MakeError(ErrorKind::Usage, "Subtract: a picture of {}x{} from one of {}x{}",
                        other.extent.width, other.extent.height, desc.extent.width, desc.extent.height);
    TextureId difference = renderer.CreateTexture("difference", {desc.extent, Format::Rgba32Float});
    AddCompute(renderer, "Subtract", "post/subtract.comp", desc.extent, [&](PassBuilder& pass) {
        pass.Reads("whole", whole);
        pass.Reads("part", part);
        difference = pass.Writes("difference", difference);
    });
    return difference;
}

Extent2D RequireComparable(const Renderer& renderer, const char* pass, TextureId a, TextureId b,
                           Format format) {
    const GraphTextureDesc first = renderer.Desc(a), second = renderer.Desc(b);
    const auto text = [](const GraphTextureDesc& desc) {
        return Text("{}x{} {}", desc.extent.width, desc.extent.height, rhi::Name(desc.format));
    };
    if (!(first == second) || first.format != format)
        throw MakeError(ErrorKind::Usage, "{}: pictures of {} and {}; both must be {} of one extent", pass,
                        text(first), text(second), rhi::Name(format));
    return first.extent;
}

Extent2D RequireComparable(const Renderer& renderer, const char* pass, TextureId first,
                           std::initializer_list<TextureId> others, Format format) {
    Extent2D extent;
    for (const TextureId other : others) extent = RequireComparable(renderer, pass, first, other, format);
    return extent;
}

}  // namespace raygraph::passes
