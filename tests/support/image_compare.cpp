#include "tests/support/image_compare.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace raygraph::test {
namespace {

void CheckPlane(const PlaneView& plane) {
    const size_t count = plane.PixelCount();
    if (count == 0 || plane.stride == 0 || plane.samples.size() < (count - 1) * plane.stride + 1) {
        throw std::invalid_argument("a plane without its pixels");
    }
}

void CheckPair(const PlaneView& a, const PlaneView& b) {
    CheckPlane(a);
    CheckPlane(b);
    if (a.width != b.width || a.height != b.height) throw std::invalid_argument("planes of two sizes");
}

double VarianceAt(const Estimate& estimate, size_t pixel) {
    return estimate.varianceOfMean.samples.empty() ? 0.0 : estimate.varianceOfMean.At(pixel);
}

}  // namespace

double Mean(const PlaneView& plane) {
    CheckPlane(plane);
    double sum = 0.0;
    for (size_t i = 0; i < plane.PixelCount(); ++i) sum += plane.At(i);
    return sum / static_cast<double>(plane.PixelCount());
}

double MaxAbsDifference(const PlaneView& a, const PlaneView& b) {
    CheckPair(a, b);
    double greatest = 0.0;
    for (size_t i = 0; i < a.PixelCount(); ++i) {
        const double difference = std::abs(a.At(i) - b.At(i));
        if (std::isnan(difference)) return difference;
        greatest = std::max(greatest, difference);
    }
    return greatest;
}

double RelativeMse(const PlaneView& test, const PlaneView& reference, double epsilon) {
    CheckPair(test, reference);
    double sum = 0.0;
    for (size_t i = 0; i < test.PixelCount(); ++i) {
        const double expected = reference.At(i), difference = test.At(i) - expected;
        sum += difference * difference / (expected * expected + epsilon);
    }
    return sum / static_cast<double>(test.PixelCount());
}

BlockMeans MeansOfBlocks(const PlaneView& plane, uint32_t size) {
    CheckPlane(plane);
    if (size == 0) throw std::invalid_argument("blocks of no pixels");
    BlockMeans blocks{(plane.width + size - 1) / size, (plane.height + size - 1) / size, {}};
    blocks.means.resize(size_t{blocks.columns} * blocks.rows);
    std::vector<double> counts(blocks.means.size());
    for (uint32_t y = 0; y < plane.height; ++y) {
        for (uint32_t x = 0; x < plane.width; ++x) {
            const size_t block = size_t{y / size} * blocks.columns + x / size;
            blocks.means[block] += plane.At(size_t{y} * plane.width + x);
            counts[block] += 1.0;
        }
    }
    for (size_t i = 0; i < counts.size(); ++i) blocks.means[i] /= counts[i];
    return blocks;
}

double TwoSidedProbability(double z) {
    return std::erfc(std::abs(z) / std::sqrt(2.0));
}

double TwoSidedDeviate(double probability) {
    if (!(probability > 1e-300 && probability <= 1.0)) throw std::invalid_argument("not such a probability");
    double low = 0.0, high = 40.0;
    while (high - low > 1e-12 * high) {
        const double middle = 0.5 * (low + high);
        (TwoSidedProbability(middle) > probability ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

ZTestResult ZTest(const Estimate& test, const Estimate& reference, const ZTestSettings& settings) {
    CheckPair(test.mean, reference.mean);
    for (const PlaneView& variance : {test.varianceOfMean, reference.varianceOfMean}) {
        if (!variance.samples.empty()) CheckPair(test.mean, variance);
    }
    ZTestResult result;
    result.pixelCount = test.mean.PixelCount();
    const double count = static_cast<double>(result.pixelCount);
    result.threshold = TwoSidedDeviate(-std::expm1(std::log1p(-settings.significance) / count));
    const double nominal = TwoSidedDeviate(settings.significance);
    size_t nominalCount = 0;
    double differenceSum = 0.0, varianceSum = 0.0;
    for (size_t i = 0; i < result.pixelCount; ++i) {
        const double expected = reference.mean.At(i), difference = test.mean.At(i) - expected;
        const double floor = std::max(settings.relativeFloor * std::abs(expected), settings.absoluteFloor);
        const double variance = std::max(VarianceAt(test, i) + VarianceAt(reference, i), floor * floor);
        double z = std::abs(difference) / std::sqrt(variance);
        // NaN and an infinite variance must not pass as agreement.
        if (!std::isfinite(z) || !std::isfinite(variance)) z = std::numeric_limits<double>::infinity();
        differenceSum += difference;
        varianceSum += variance;
        if (z > nominal) ++nominalCount;
        if (z > result.threshold) ++result.failedCount;
        if (z > result.greatestZ) {
            result.greatestZ = z;
            result.greatestPixel = i;
        }
    }
    result.failedFraction = static_cast<double>(result.failedCount) / count;
    result.nominalFraction = static_cast<double>(nominalCount) / count;
    result.overallZ = differenceSum / std::sqrt(varianceSum);
    return result;
}

}  // namespace raygraph::test
