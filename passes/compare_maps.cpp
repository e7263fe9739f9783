#include "passes/compare_maps.h"

#include "base/text.h"

#include <algorithm>
#include <vector>

#include "passes/same_extent.h"
#include "renderer/graph/readback_values.h"

namespace raygraph::passes {

namespace {

constexpr uint32_t kBlock = 16;  // of post/sum_groups.comp

Extent2D BlocksOf(Extent2D extent) {
    return {(extent.width + kBlock - 1) / kBlock, (extent.height + kBlock - 1) / kBlock};
}

uint64_t GroupCount(Extent2D extent) {
    return uint64_t{BlocksOf(extent).width} * BlocksOf(extent).height;
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
    renderer.AddPass(
        "Difference", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("post/difference.comp");
            pass.Reads("a", a);
            pass.Reads("b", b);
            ids.difference = pass.Writes("difference", ids.difference);
            ids.luminance = pass.Writes("luminance", ids.luminance);
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
    return ids;
}

TextureId RelativeError(Renderer& renderer, TextureId reference, TextureId test, float minimum) {
    const Extent2D extent =
        RequireComparable(renderer, "RelativeError", reference, test, Format::Rgba32Float);
    TextureId error = renderer.CreateTexture("relativeError", {extent, Format::R32Float});
    renderer.AddPass(
        "RelativeError", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("post/relative_error.comp");
            pass.Reads("reference", reference);
            pass.Reads("test", test);
            pass.Constants(minimum);
            error = pass.Writes("error", error);
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
    return error;
}

TextureId Heat(Renderer& renderer, TextureId values, float maximum) {
    RequireNumbers(renderer, "Heat", values);
    const Extent2D extent = renderer.Desc(values).extent;
    TextureId display = renderer.CreateTexture("display", {extent, Format::Rgba8Unorm});
    renderer.AddPass(
        "Heat", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("post/heat.comp");
            pass.Reads("values", values);
            pass.Constants(maximum);
            display = pass.Writes("display", display);
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
    return display;
}

BufferId SumGroups(Renderer& renderer, TextureId values) {
    RequireNumbers(renderer, "SumGroups", values);
    const Extent2D extent = renderer.Desc(values).extent;
    BufferId groups = renderer.CreateBuffer("groups", {.size = GroupCount(extent) * 2 * sizeof(float)});
    renderer.AddPass(
        "SumGroups", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("post/sum_groups.comp");
            pass.Reads("values", values);
            groups = pass.Writes("groups", groups);
        },
        [blocks = BlocksOf(extent)](CommandList& commands) { commands.DispatchOver(blocks); });
    return groups;
}

MapNumbers NumbersOf(const Readback& groups, Extent2D extent) {
    const std::vector<float> values = ValuesOf<float>(groups);
    if (values.size() != GroupCount(extent) * 2)
        throw MakeError(ErrorKind::Usage, "NumbersOf: {} numbers are not the groups of a picture of {}x{}",
                        values.size(), extent.width, extent.height);
    MapNumbers numbers;
    for (size_t i = 0; i < values.size(); i += 2) {
        numbers.mean += double{values[i]};
        numbers.maximum = std::max(numbers.maximum, values[i + 1]);
    }
    numbers.mean /= double(extent.width) * extent.height;
    return numbers;
}

}  // namespace raygraph::passes
