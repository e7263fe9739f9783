#include "passes/flip.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "base/text.h"
#include "passes/add_compute.h"
#include "passes/compare.h"
#include "shaders/shared/flip_kernels.h"

namespace raygraph::passes {

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

// Follows section 3.1.1, table 1: contrast sensitivity as sums of Gaussians a sqrt(pi / b) exp(-pi^2 x^2 /
// b), x in degrees.
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

// Follows section 3.2: Gaussians and their derivatives, 0.082 degrees wide.
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
// Holds the features by which pictures are compared, see shaders/post/flip_columns.comp.
struct Filtered {
    TextureId labAndEdge, point;
};

FilteredRows FilterRows(Renderer& renderer, TextureId picture, const gpu::FlipKernels& kernels) {
    const Extent2D extent = renderer.Desc(picture).extent;
    FilteredRows rows{renderer.CreateTexture("flipColors", {extent, Format::Rgba32Float}),
                      renderer.CreateTexture("flipFeatures", {extent, Format::Rgba32Float})};
    AddCompute(renderer, "FlipRows", "post/flip_rows.comp", extent, [&](PassBuilder& pass) {
        pass.Reads("picture", picture,
                   {.magFilter = rhi::Filter::Nearest, .minFilter = rhi::Filter::Nearest});
        pass.Uniform("kernels", kernels);
        rows.colors = pass.Writes("colors", rows.colors);
        rows.features = pass.Writes("features", rows.features);
    });
    return rows;
}

// Filters either picture by the same program, so that equal parts give equal bits.
Filtered FilterColumns(Renderer& renderer, const FilteredRows& rows, const gpu::FlipKernels& kernels) {
    const Extent2D extent = renderer.Desc(rows.colors).extent;
    Filtered filtered{renderer.CreateTexture("flipLabAndEdge", {extent, Format::Rgba32Float}),
                      renderer.CreateTexture("flipPoint", {extent, Format::R32Float})};
    AddCompute(renderer, "FlipColumns", "post/flip_columns.comp", extent, [&](PassBuilder& pass) {
        pass.Reads("colors", rows.colors);
        pass.Reads("features", rows.features);
        pass.Uniform("kernels", kernels);
        filtered.labAndEdge = pass.Writes("labAndEdge", filtered.labAndEdge);
        filtered.point = pass.Writes("point", filtered.point);
    });
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
    AddCompute(renderer, "FlipCompare", "post/flip_compare.comp", extent, [&](PassBuilder& pass) {
        pass.Reads("referenceLabAndEdge", filteredReference.labAndEdge);
        pass.Reads("referencePoint", filteredReference.point);
        pass.Reads("testLabAndEdge", filteredTest.labAndEdge);
        pass.Reads("testPoint", filteredTest.point);
        error = pass.Writes("error", error);
    });
    return error;
}

}  // namespace raygraph::passes
