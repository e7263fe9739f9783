// check_pictures SHOWN SHARPENED EDITED: checks the pictures of the examples 3, 5 and 6, which are of one scene: none is black
// or uniform, the second is the first with steeper edges, and the third has other objects. Exits with 1 and one line if not.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "renderer/image/image.h"

using namespace raygraph;  // NOLINT: an example

namespace {

void Require(bool holds, const char* file, const char* what) {
    if (!holds) throw std::runtime_error(std::string(file) + ": not so: " + what);
}

// Green, of 8 bits.
struct Statistics {
    std::vector<int> values;
    double mean = 0.0, deviation = 0.0;
    double contrast = 0.0;  // mean difference of neighbors in a row
};

Statistics StatisticsOf(const char* file) {
    std::ifstream stream(file, std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(stream), {}};
    const image::Image8 picture = image::DecodeImage8(std::as_bytes(std::span(bytes)), file);
    Require(picture.width == 160 && picture.height == 160, file, "it has 160 x 160 pixels");
    Statistics result;
    const double count = 160.0 * 160.0;
    for (size_t i = 1; i < picture.rgba.size(); i += 4) result.values.push_back(picture.rgba[i]);
    for (const int value : result.values) result.mean += value / count;
    for (const int value : result.values) result.deviation += std::pow(value - result.mean, 2.0) / count;
    result.deviation = std::sqrt(result.deviation);
    for (size_t i = 1; i < result.values.size(); ++i)
        if (i % 160 != 0) result.contrast += std::abs(result.values[i] - result.values[i - 1]) / count;
    Require(result.mean > 20.0, file, "there is light in it");
    Require(result.deviation > 10.0, file, "there are objects in it");
    return result;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 4) return 2;
    try {
        const Statistics shown = StatisticsOf(argv[1]), sharpened = StatisticsOf(argv[2]);
        Require(std::abs(sharpened.mean - shown.mean) < 4.0, argv[2], "it is as bright as without the pass");
        Require(sharpened.contrast > 1.5 * shown.contrast, argv[2],
                "its edges are steeper than without the pass");
        const Statistics edited = StatisticsOf(argv[3]);
        int others = 0;
        for (size_t i = 0; i < shown.values.size(); ++i)
            others += std::abs(edited.values[i] - shown.values[i]) > 8;
        Require(others > 160 * 160 / 10, argv[3], "a tenth of the pixels differs from before the edits");
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "check_pictures: %s\n", error.what());
        return 1;
    }
}
