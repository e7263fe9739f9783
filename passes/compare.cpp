#include "passes/compare.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "base/text.h"
#include "renderer/graph/readback_values.h"
#include "shaders/shared/flip_kernels.h"

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
    // Thin, but visible on a picture of many pixels
    const int32_t lineWidth = column == 0 ? 0 : 1 + static_cast<int32_t>(extent.width / 1000);
    renderer.AddPass(
        "Wipe", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("post/wipe.comp");
            pass.Reads("left", left);
            pass.Reads("right", right);
            pass.Constants(Constants{column, lineWidth});
            display = pass.Writes("display", display);
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
    return display;
}

TextureId SideBySide(Renderer& renderer, TextureId left, TextureId right) {
    const Extent2D extent = RequireComparable(renderer, "SideBySide", left, right, Format::Rgba8Unorm);
    TextureId display = renderer.CreateTexture("display", {extent, Format::Rgba8Unorm});
    renderer.AddPass(
        "SideBySide", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("post/side_by_side.comp");
            pass.Reads("left", left);
            pass.Reads("right", right);
            display = pass.Writes("display", display);
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
    return display;
}

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

// --- Flip ---

namespace {

using Taps = std::vector<double>;  // from 0 to the radius

// Returns the sum over all taps of the symmetric (or, in size, antisymmetric) filter.
double SumOf(const Taps& taps) {
    double sum = taps[0];
    for (size_t i = 1; i < taps.size(); ++i) sum += 2.0 * taps[i];
    return sum;
}

Taps Gaussian(uint32_t radius, double exponentOfSquare) {
    Taps taps(radius + 1);
    for (size_t i = 0; i < taps.size(); ++i) taps[i] = std::exp(exponentOfSquare * double(i * i));
    return taps;
}

void Store(const Taps& taps, double factor, glm::vec4* into, int channel) {
    for (size_t i = 0; i < taps.size(); ++i) into[i][channel] = static_cast<float>(factor * taps[i]);
}

// Section 3.1.1, table 1: contrast sensitivity as sums of Gaussians a sqrt(pi / b) exp(-pi^2 x^2 / b), x
// in degrees.
void MakeColorFilters(gpu::FlipKernels& kernels, double pixelsPerDegree) {
    struct Term {
        double a, b;
    };
    constexpr Term kTerms[4] = {{1.0, 0.0047}, {1.0, 0.0053}, {34.1, 0.04}, {13.5, 0.025}};
    const double widest = std::sqrt(0.04 / (2.0 * std::numbers::pi * std::numbers::pi));
    kernels.colorRadius = static_cast<uint32_t>(std::ceil(3.0 * widest * pixelsPerDegree));
    double weights[4];
    for (int i = 0; i < 4; ++i) {
        const Taps taps =
            Gaussian(kernels.colorRadius, -std::numbers::pi * std::numbers::pi /
                                              (kTerms[i].b * pixelsPerDegree * pixelsPerDegree));
        const double sum = SumOf(taps);
        Store(taps, 1.0 / sum, kernels.color, i);
        // The weight is that of the filter in two dimensions.
        weights[i] = kTerms[i].a * std::sqrt(std::numbers::pi / kTerms[i].b) * sum * sum;
    }
    const double both = weights[2] + weights[3];
    kernels.blueYellow = {static_cast<float>(weights[2] / both), static_cast<float>(weights[3] / both)};
}

// Section 3.2: Gaussians and their derivatives, 0.082 degrees wide.
void MakeFeatureFilters(gpu::FlipKernels& kernels, double pixelsPerDegree) {
    const double deviation = 0.5 * 0.082 * pixelsPerDegree;
    kernels.featureRadius = static_cast<uint32_t>(std::ceil(3.0 * deviation));
    const Taps gaussian = Gaussian(kernels.featureRadius, -0.5 / (deviation * deviation));
    Taps edge = gaussian, point = gaussian;
    double edgeSum = 0.0, positive = 0.0, negative = 0.0;
    for (size_t i = 0; i < gaussian.size(); ++i) {
        const double x = double(i), count = i == 0 ? 1.0 : 2.0;
        edge[i] *= x;
        edgeSum += edge[i];
        point[i] *= x * x / (deviation * deviation) - 1.0;
        (point[i] > 0.0 ? positive : negative) += count * std::abs(point[i]);
    }
    for (double& tap : point) tap /= tap > 0.0 ? positive : negative;
    Store(gaussian, 1.0 / SumOf(gaussian), kernels.feature, 0);
    Store(edge, edgeSum > 0.0 ? 1.0 / edgeSum : 0.0, kernels.feature, 1);
    Store(point, 1.0, kernels.feature, 2);
}

gpu::FlipKernels KernelsFor(float pixelsPerDegree) {
    if (!(pixelsPerDegree >= 1.0f && pixelsPerDegree <= 400.0f))
        throw MakeError(ErrorKind::Usage, "Flip: {} pixels per degree, must be from 1 to 400",
                        pixelsPerDegree);
    gpu::FlipKernels kernels{};
    MakeColorFilters(kernels, double{pixelsPerDegree});
    MakeFeatureFilters(kernels, double{pixelsPerDegree});
    return kernels;
}

struct FilteredRows {
    TextureId colors, features;
};
// The features by which pictures are compared, see shaders/post/flip_columns.comp.
struct Filtered {
    TextureId labAndEdge, point;
};

FilteredRows FilterRows(Renderer& renderer, TextureId picture, const gpu::FlipKernels& kernels) {
    const Extent2D extent = renderer.Desc(picture).extent;
    FilteredRows rows{renderer.CreateTexture("flipColors", {extent, Format::Rgba32Float}),
                      renderer.CreateTexture("flipFeatures", {extent, Format::Rgba32Float})};
    renderer.AddPass(
        "FlipRows", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("post/flip_rows.comp");
            pass.Reads("picture", picture,
                       {.magFilter = rhi::Filter::Nearest, .minFilter = rhi::Filter::Nearest});
            pass.Uniform("kernels", kernels);
            rows.colors = pass.Writes("colors", rows.colors);
            rows.features = pass.Writes("features", rows.features);
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
    return rows;
}

// Filters either picture by the same program, so that equal parts give equal bits.
Filtered FilterColumns(Renderer& renderer, const FilteredRows& rows, const gpu::FlipKernels& kernels) {
    const Extent2D extent = renderer.Desc(rows.colors).extent;
    Filtered filtered{renderer.CreateTexture("flipLabAndEdge", {extent, Format::Rgba32Float}),
                      renderer.CreateTexture("flipPoint", {extent, Format::R32Float})};
    renderer.AddPass(
        "FlipColumns", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("post/flip_columns.comp");
            pass.Reads("colors", rows.colors);
            pass.Reads("features", rows.features);
            pass.Uniform("kernels", kernels);
            filtered.labAndEdge = pass.Writes("labAndEdge", filtered.labAndEdge);
            filtered.point = pass.Writes("point", filtered.point);
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
    return filtered;
}

}  // namespace

TextureId Flip(Renderer& renderer, TextureId reference, TextureId test, const FlipSettings& settings) {
    const Extent2D extent = RequireComparable(renderer, "Flip", reference, test, Format::Rgba8Unorm);
    const gpu::FlipKernels kernels = KernelsFor(settings.pixelsPerDegree);
    const Filtered filteredReference =
        FilterColumns(renderer, FilterRows(renderer, reference, kernels), kernels);
    const Filtered filteredTest = FilterColumns(renderer, FilterRows(renderer, test, kernels), kernels);
    TextureId error = renderer.CreateTexture("flip", {extent, Format::R32Float});
    renderer.AddPass(
        "FlipCompare", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("post/flip_compare.comp");
            pass.Reads("referenceLabAndEdge", filteredReference.labAndEdge);
            pass.Reads("referencePoint", filteredReference.point);
            pass.Reads("testLabAndEdge", filteredTest.labAndEdge);
            pass.Reads("testPoint", filteredTest.point);
            error = pass.Writes("error", error);
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
    return error;
}

TextureId Subtract(Renderer& renderer, TextureId whole, TextureId part) {
    const GraphTextureDesc desc = renderer.Desc(whole), other = renderer.Desc(part);
    if (!(desc.extent == other.extent))
        throw MakeError(ErrorKind::Usage, "Subtract: a picture of {}x{} from one of {}x{}",
                        other.extent.width, other.extent.height, desc.extent.width, desc.extent.height);
    TextureId difference = renderer.CreateTexture("difference", {desc.extent, Format::Rgba32Float});
    renderer.AddPass(
        "Subtract", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("post/subtract.comp");
            pass.Reads("whole", whole);
            pass.Reads("part", part);
            difference = pass.Writes("difference", difference);
        },
        [extent = desc.extent](CommandList& commands) { commands.DispatchOver(extent); });
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

}  // namespace raygraph::passes
