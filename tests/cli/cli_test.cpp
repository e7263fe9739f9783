#include "tests/cli/cli_test.h"

#include <cmath>

namespace raygraph::test {

namespace {

// Returns sample n of a picture, which depends on texel and salt.
std::vector<float> MadeUpSample(size_t pixels, float scale, uint32_t n, float salt) {
    std::vector<float> texels(4 * pixels);
    for (size_t i = 0; i < texels.size(); ++i)
        texels[i] = scale * (1.5f + std::sin(static_cast<float>(i) + 1.3f * static_cast<float>(n) + salt));
    return texels;
}

}  // namespace

std::vector<std::string> Words(std::string_view line) {
    std::vector<std::string> words;
    bool isInWord = false, isQuoted = false;
    for (const char character : line) {
        const bool isEnd = character == ' ' && !isQuoted;
        if (!isEnd && !isInWord) words.emplace_back();
        isInWord = !isEnd;
        if (character == '\'')
            isQuoted = !isQuoted;
        else if (!isEnd)
            words.back() += character;
    }
    return words;
}

session::RenderFile MakeRender(uint32_t firstSample, uint32_t sampleCount, float salt) {
    session::RenderFile render;
    render.size = {5, 3};
    const size_t pixels = session::PixelCount(render.size);
    const auto fill = [&](session::Texels& mean, passes::ExactSums& sums, float scale, bool withSquares) {
        sums = passes::MakeExactSums(pixels, withSquares);
        for (uint32_t n = firstSample; n < firstSample + sampleCount; ++n)
            passes::AddSample(sums, MadeUpSample(pixels, scale, n, salt));
        mean = passes::MeanOf(sums, sampleCount);
    };
    fill(render.radiance, render.sums.radiance, 1.0f, true);
    render.variance = passes::VarianceOf(render.sums.radiance, sampleCount);
    fill(render.albedo, render.sums.albedo, 0.5f, false);
    fill(render.normal, render.sums.normal, 0.3f, false);
    for (size_t i = 0; i < pixels; ++i) {
        render.depth.push_back(i == 7 ? INFINITY : 1.0f + static_cast<float>(i));
        render.instance.push_back(i == 7 ? 0xFFFFFFFFu : static_cast<uint32_t>(i));
        render.material.push_back(i == 7 ? 0xFFFFFFFFu : static_cast<uint32_t>(i % 3));
        render.motion.push_back(0.5f + static_cast<float>(i));
        render.motion.push_back(-static_cast<float>(i));
    }
    render.samples = {{firstSample, sampleCount}};
    session::PictureSettings settings;
    settings.size = render.size;
    settings.paths.seed = 9;
    render.settings = session::Texts(settings);
    render.sceneFile = "box.gltf";
    render.sceneHash = "0123456789abcdef";
    render.environmentFile = "sky.hdr";
    render.environmentHash = "fedcba9876543210";
    render.version = "1.2.3";
    render.device = "a device";
    render.driver = "a driver";
    return render;
}

}  // namespace raygraph::test
