#include "sharpen.h"

#include <gtest/gtest.h>

#include <string>
#include <tuple>

#include "renderer/graph/pass_harness.h"

using namespace raygraph;
using raygraph::testing::PassHarness;
using raygraph::testing::Texels;

const RendererDesc kOwnShaders{.shaderRoot = OWN_SHADERS, .shaderIncludes = {RAYGRAPH_SHADERS}};

rhi::Device& TheDevice() {
    static const auto device = rhi::Device::Create({.validation = true});
    return *device;
}

// A gray step, one row: 1 1 3 3.
TextureId Step(PassHarness& h) {
    return h.Texture("step", {4, 1}, Format::Rgba32Float, {1, 1, 1, 1, 1, 1, 1, 1, 3, 3, 3, 1, 3, 3, 3, 1});
}

TEST(Sharpen, Step_GetsSteeper) {
    PassHarness harness(TheDevice(), kOwnShaders);
    const Texels out = harness.Run([](PassHarness& h) { return Sharpen(h.Graph(), Step(h), 0.5f); });
    // The second texel's neighbors are 1, 3, 1 and 1: it goes away from 1.5 by half of the difference.
    const float expected[] = {1.0f, 0.75f, 3.25f, 3.0f};
    for (uint32_t x = 0; x < 4; ++x) {
        EXPECT_NEAR(out.At(x, 0)[0], expected[x], 1e-5f) << x;
        EXPECT_EQ(out.At(x, 0)[3], 1.0f) << x;
    }
}

TEST(Sharpen, WaitsForItsInputAlone) {
    PassHarness harness(TheDevice(), kOwnShaders);
    harness.Run([](PassHarness& h) {
        std::ignore = Sharpen(h.Graph(), Step(h), 2.0f);  // leads nowhere
        return Sharpen(h.Graph(), Step(h), 0.5f);
    });
    const std::string plan = harness.Plan();
    EXPECT_NE(plan.find("3 Sharpen (compute)\n"
                        "    reads   step v1 (storage read)\n"
                        "    writes  sharpened v1 (storage write)\n"
                        "    waits   step: Transfer write -> ComputeShader read, CopyTarget -> General\n"),
              std::string::npos)
        << plan;
    EXPECT_NE(plan.find("    Sharpen (compute): nothing needs sharpened\n"), std::string::npos) << plan;
}

TEST(Sharpen, PictureOfTheWrongFormat_IsRefusedByName) {
    PassHarness harness(TheDevice(), kOwnShaders);
    try {
        harness.Run([](PassHarness& h) {
            return Sharpen(h.Graph(), h.Texture("bytes", {1, 1}, Format::Rgba8Unorm, {1, 1, 1, 1}), 0.5f);
        });
        ADD_FAILURE() << "it was taken";
    } catch (const Error& error) {
        EXPECT_EQ(error.Kind(), ErrorKind::Usage);
        EXPECT_NE(std::string(error.what()).find("binds \"picture\" to \"bytes\" of format rgba8"),
                  std::string::npos)
            << error.what();
    }
}
