#include "tests/images/reference_image.h"

#include "renderer/image/exr.h"
#include "tests/support/reference_assets.h"

namespace raygraph::testing {

glm::dvec3 ReferenceImage::Mean() const {
    glm::dvec3 mean(0.0);
    for (int c = 0; c < 3; ++c)
        for (const float value : channels[c]) mean[c] += double{value};
    return mean / double(channels[0].size());
}

void ReferenceTest::SetUp() {
    VulkanTest::SetUp();
    RAYGRAPH_SKIP_WITHOUT_ASSETS();
    assets = *test::ReferenceAssets();
}

ReferenceImage ReferenceTest::Read(const std::string& name) const {
    const image::ExrImage exr = image::ReadExr(assets / "references" / name);
    ReferenceImage reference{exr.width, exr.height, {}};
    for (int c = 0; c < 3; ++c) {
        const std::vector<float>* channel = exr.FloatChannel(std::string(1, "RGB"[c]));
        EXPECT_NE(channel, nullptr);
        if (channel != nullptr) reference.channels[c] = *channel;
    }
    return reference;
}

}  // namespace raygraph::testing
