// The forms of the integrator give one picture. A device is needed.
#include <algorithm>
#include <cmath>

#include "editor/session/form_text.h"
#include "editor/session/session.h"
#include "tests/cli/cli_test.h"
#include "tests/cli/session_case.h"

namespace raygraph::session {

namespace {

using test::ExpectError;

class SessionFormsTest : public SessionCaseTest {
  protected:
    static RenderFile Render(const SessionCase& of, const char* form, uint32_t samples = 4,
                             uint32_t samplesAtOnce = 1) {
        return RenderCase(of, {{"size", "20x12"}, {"integrator-form", form}}, samples, samplesAtOnce);
    }
    static double MeanOfColors(const Texels& texels) {
        double sum = 0.0;
        for (size_t i = 0; i < texels.size(); ++i)
            if (i % 4 != 3) sum += static_cast<double>(texels[i]);
        return sum / std::max(static_cast<double>(texels.size()), 1.0);
    }
    // Mesa's CPU driver rounds alike in all shaders. Other compilers contract expressions, each shader in its
    // own way, so that now and then a path takes another turn.
    static void ExpectSame(const Texels& texels, const Texels& others, const char* what) {
        ASSERT_EQ(texels.size(), others.size()) << what;
        if (Device().Info().type == rhi::DeviceType::Cpu)
            EXPECT_TRUE(texels == others) << what;
        else
            EXPECT_NEAR(MeanOfColors(texels), MeanOfColors(others), 0.1 * MeanOfColors(texels) + 1e-6)
                << what;
    }
    static void ExpectSame(const RenderFile& a, const RenderFile& b) {
        ExpectSame(a.radiance, b.radiance, "radiance");
        ASSERT_EQ(AovsOf(a), AovsOf(b));
        for (const Aov aov : kAovs)
            if (const Texels* mean = MeanOf(a, aov)) ExpectSame(*mean, *MeanOf(b, aov), Name(aov));
        ASSERT_EQ(a.lightGroups.size(), b.lightGroups.size());
        for (size_t i = 0; i < a.lightGroups.size(); ++i)
            ExpectSame(a.lightGroups[i], b.lightGroups[i], "light group");
    }
};

}  // namespace

TEST_P(SessionFormsTest, AWavefrontOfAnyNumberOfStepsGivesThePictureOfTheLoop) {
    const RenderFile loop = Render(GetParam(), "loop");
    EXPECT_GT(MeanOfColors(loop.radiance), 0.0);
    for (const char* form : {"wavefront:1", "wavefront:3"}) {
        SCOPED_TRACE(form);
        ExpectSame(loop, Render(GetParam(), form));
    }
}

// With 1, 1, 2, 4, 4 and 1 of them in a frame: as the first of a picture and those at its end are rendered.
TEST_P(SessionFormsTest, SeveralSamplesAtOnceGiveTheBitsOfOneAfterTheOther) {
    const bool isWavefront = GetParam().hasAll;
    const char* form = isWavefront ? "wavefront:2" : "loop";
    const RenderFile one = Render(GetParam(), form, 13, 1);
    const RenderFile several = Render(GetParam(), form, 13, 4);
    EXPECT_EQ(one.sums.radiance, several.sums.radiance);
    EXPECT_EQ(one.sums.albedo, several.sums.albedo);
    EXPECT_EQ(one.sums.parts, several.sums.parts);
    EXPECT_EQ(one.sums.lightGroups, several.sums.lightGroups);
    EXPECT_TRUE(one.variance == several.variance);
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, SessionFormsTest,
    ::testing::Values(SessionCase{"cornell.gltf", {{"max-depth", "5"}, {"clamp-indirect", "0.5"}}, true},
                      SessionCase{"cornell.gltf", {{"nee", "off"}, {"crop", "3,2,9,5"}, {"aperture", "0.1"}}},
                      SessionCase{"many_lights.gltf", {{"rr", "frame:0.5"}, {"sampler", "pcg"}}},
                      SessionCase{"nested_dielectrics.gltf", {}, true},
                      SessionCase{"scattering_grid.gltf", {}},
                      SessionCase{"terrace.gltf", {{"texture-lod", "0"}}, true},
                      SessionCase{"glass_sphere.gltf", {{"aperture", "0.2"}, {"background", "1,2,3"}}},
                      SessionCase{"points_and_lines.gltf", {{"points", "2%"}, {"lines", "1%"}}}));

TEST(FormText, ReadsBack) {
    for (const char* text : {"auto", "loop", "wavefront:1", "wavefront:64"})
        EXPECT_EQ(FormText(ParseForm(text)), text);
    EXPECT_EQ(FormText(ParseForm("wavefront")), "wavefront:4");
    for (const char* text : {"", "auto:4", "loop:4", "wavefront:0", "wavefront:65", "wavefront:", "both"})
        ExpectError(
            ErrorKind::Usage, [&] { std::ignore = ParseForm(text); }, "");
}

}  // namespace raygraph::session
