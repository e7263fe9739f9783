// Numbers that say how far two pictures are apart, and whether noise explains it. For any test kind: list
// ../support/image_compare.cpp among its sources. Functions of two planes throw std::invalid_argument unless the
// sizes agree; sums are in double.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace raygraph::test {

// One channel of a picture where it lies: pixel (x, y) is samples[(y * width + x) * stride]. Owns nothing.
struct PlaneView {
    uint32_t width = 0, height = 0;
    std::span<const float> samples;
    uint32_t stride = 1;

    size_t PixelCount() const { return size_t{width} * height; }
    double At(size_t pixel) const { return samples[pixel * stride]; }
};

double Mean(const PlaneView& plane);
// NaN if either has a NaN.
double MaxAbsDifference(const PlaneView& a, const PlaneView& b);
// Mean of (test - reference)^2 / (reference^2 + epsilon).
double RelativeMse(const PlaneView& test, const PlaneView& reference, double epsilon = 1e-2);

struct BlockMeans {
    uint32_t columns = 0, rows = 0;
    std::vector<double> means;  // Row by row.
};
// Blocks of size x size pixels from the top left; those at the right and bottom edges may be smaller.
BlockMeans MeansOfBlocks(const PlaneView& plane, uint32_t size);

// A mean over samples with the variance *of that mean*: the samples' variance over their count. An exact
// reference has no variance plane (empty samples).
struct Estimate {
    PlaneView mean, varianceOfMean;
};

struct ZTestSettings {
    double significance = 0.01;  // probability that a correct picture is rejected
    double relativeFloor =
        1e-5;  // Standard errors are at least this times |reference|: rounding is no error.
    double absoluteFloor = 1e-12;  // And at least this.
};

// z = (test - reference) / sqrt(both variances), normal under the null hypothesis once the means are over
// enough samples (some tens; more where the integrand is spiky: a variance estimated from few samples makes z
// Student's). A pixel that is not finite counts as beyond every threshold.
struct ZTestResult {
    size_t pixelCount = 0;
    // |z| that a right picture exceeds anywhere with probability `significance`: two-sided, Sidak-corrected
    // to 1 - (1 - significance)^(1 / pixelCount) a pixel.
    double threshold = 0.0;
    size_t failedCount = 0;       // Pixels beyond the threshold.
    double failedFraction = 0.0;  // fraction of all pixels
    double nominalFraction =
        0.0;                 // Pixels beyond the uncorrected level: about `significance` if all is right.
    double greatestZ = 0.0;  // largest |z|, and its pixel
    size_t greatestPixel = 0;
    // z of the sum over all pixels, which are taken to be independent: finds a small bias that no pixel
    // shows.
    double overallZ = 0.0;

    bool HasFailures() const { return failedCount > 0; }
};
ZTestResult ZTest(const Estimate& test, const Estimate& reference, const ZTestSettings& settings = {});

// Probability of a normal deviate beyond |z| on either side, and the z of that probability (above 1e-300).
double TwoSidedProbability(double z);
double TwoSidedDeviate(double probability);

}  // namespace raygraph::test
