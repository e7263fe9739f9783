#include "editor/cli/diagnostic_view.h"

#include <cmath>

#include "tests/cli/cli_test.h"

namespace raygraph::cli {
namespace {

using Rgb = std::array<int, 3>;

Rgb PixelOf(const image::Image8& picture, size_t i) {
    EXPECT_EQ(picture.rgba[4 * i + 3], 255);
    return {picture.rgba[4 * i], picture.rgba[4 * i + 1], picture.rgba[4 * i + 2]};
}

TEST(DiagnosticView, NormalsMapMinusOneToOneOntoTheBytes) {
    RenderFile render;
    render.size = {3, 1};
    render.normal = {0, 0, 1, 0, -1, 0, 0, 0, 0, 0, 0, 0};
    const image::Image8 picture = ShowView(View::Normals, render);
    EXPECT_EQ(PixelOf(picture, 0), (Rgb{128, 128, 255}));
    EXPECT_EQ(PixelOf(picture, 1), (Rgb{0, 128, 128}));
    EXPECT_EQ(PixelOf(picture, 2), (Rgb{0, 0, 0}));  // a miss
}

TEST(DiagnosticView, AlbedoIsSrgbEncoded) {
    RenderFile render;
    render.size = {2, 1};
    render.albedo = {0.21404114f, 0.0f, 1.0f, 1, 0.5f, 0.5f, 0.5f, 1};
    const image::Image8 picture = ShowView(View::Albedo, render);
    EXPECT_EQ(PixelOf(picture, 0), (Rgb{128, 0, 255}));
    EXPECT_EQ(PixelOf(picture, 1), (Rgb{188, 188, 188}));
}

TEST(DiagnosticView, NearIsBrighterThanFarAndAMissIsBlack) {
    RenderFile render;
    render.size = {4, 1};
    render.depth = {2.0f, 4.0f, INFINITY, 3.0f};
    const image::Image8 picture = ShowView(View::Depth, render);
    const int near = PixelOf(picture, 0)[0], far = PixelOf(picture, 1)[0], between = PixelOf(picture, 3)[0];
    EXPECT_EQ(near, 255);
    EXPECT_GT(far, 0);
    EXPECT_NEAR(between, 0.5 * (near + far), 1.0);
    EXPECT_EQ(PixelOf(picture, 2), (Rgb{0, 0, 0}));
    const Texels texels = ViewTexels(View::Depth, render);
    EXPECT_EQ((Texels(texels.begin(), texels.begin() + 4)), (Texels{2, 2, 2, 1}));
    EXPECT_EQ(texels[11], 0.0f);
}

TEST(DiagnosticView, EachIdHasAColorOfItsOwn) {
    RenderFile render;
    render.size = {8, 1};
    render.instance = {0, 1, 2, 3, 4, 5, 6, 0xFFFFFFFFu};
    const image::Image8 picture = ShowView(View::Instance, render);
    for (size_t i = 0; i < 8; i++)
        for (size_t j = 0; j < i; j++) {
            const Rgb a = PixelOf(picture, i), b = PixelOf(picture, j);
            EXPECT_GT(std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]), 40)
                << i << " and " << j;
        }
    EXPECT_EQ(PixelOf(picture, 7), (Rgb{0, 0, 0}));
}

TEST(DiagnosticView, NormalsTakeTheirCoverageFromTheAlbedo) {
    RenderFile render;
    render.size = {2, 1};
    render.albedo = {1, 1, 1, 0.75f, 0, 0, 0, 0};
    render.normal = {0, 1, 0, 0, 0, 0, 0, 0};
    EXPECT_EQ(ViewTexels(View::Normals, render), (Texels{0, 1, 0, 0.75f, 0, 0, 0, 0}));
}

}  // namespace
}  // namespace raygraph::cli
