#include "tests/cli/cli_test.h"

#include <cmath>

namespace raygraph::test {

cli::RenderFile MakeRender(uint32_t firstSample, uint32_t sampleCount, float salt) {
    cli::RenderFile render;
    render.size = {5, 3};
    const size_t pixels = render.size.PixelCount();
    const auto fill = [&](cli::Texels& texels, float scale) {
        texels.resize(4 * pixels);
        for (size_t i = 0; i < texels.size(); i++)
            texels[i] = scale * (1.5f + std::sin(static_cast<float>(i) + salt));
    };
    fill(render.radiance, 1.0f);
    fill(render.variance, 0.25f);
    fill(render.albedo, 0.5f);
    fill(render.normal, 0.3f);
    for (size_t i = 0; i < pixels; i++) {
        render.depth.push_back(i == 7 ? INFINITY : 1.0f + static_cast<float>(i));
        render.instance.push_back(i == 7 ? 0xFFFFFFFFu : static_cast<uint32_t>(i));
        render.material.push_back(i == 7 ? 0xFFFFFFFFu : static_cast<uint32_t>(i % 3));
    }
    render.samples = {{firstSample, sampleCount}};
    cli::PictureSettings settings;
    settings.size = render.size;
    settings.seed = 9;
    render.settings = cli::Texts(settings);
    render.sceneFile = "box.gltf";
    render.sceneHash = "0123456789abcdef";
    render.environmentFile = "sky.hdr";
    render.environmentHash = "fedcba9876543210";
    render.version = "0.1.0";
    render.device = "a device";
    render.driver = "a driver";
    return render;
}

}  // namespace raygraph::test
