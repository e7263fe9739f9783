// The white balance against published chromaticities, and in closed form.
#include "passes/white_balance.h"

#include <gtest/gtest.h>

#include <tuple>

#include "base/error.h"

namespace raygraph::passes::white_balance_test {
namespace {

// CIE 15: illuminant A, and daylight of 5000 and 7500 K nominally.
constexpr glm::dvec2 kA(0.44758, 0.40745), kD50(0.34567, 0.35851), kD75(0.29903, 0.31488);

void ExpectNear(const glm::dvec2& a, const glm::dvec2& b, double tolerance) {
    EXPECT_NEAR(a.x, b.x, tolerance);
    EXPECT_NEAR(a.y, b.y, tolerance);
}

TEST(WhiteBalance, WhitePointsAreThoseOfTheStandardIlluminants) {
    ExpectNear(WhitePointAt(2856.0), kA, 4e-4);
    ExpectNear(WhitePointAt(5003.0), kD50,
               2e-4);  // the constants of radiation have changed since D50 was named
    ExpectNear(WhitePointAt(7504.0), kD75, 2e-4);
    EXPECT_EQ(WhitePointAt(6500.0), glm::dvec2(kDisplayWhite[0], kDisplayWhite[1]));
    ExpectNear(WhitePointAt(6504.0), WhitePointAt(6500.0), 2e-4);
    // Black bodies at 2000 and 3500 K (Kang et al. 2002, and Planck's law)
    ExpectNear(WhitePointAt(2000.0), {0.5267, 0.4133}, 5e-4);
    ExpectNear(WhitePointAt(3500.0), {0.4053, 0.3907}, 5e-4);
    for (const double kelvin : {999.0, 25001.0, -1.0})
        EXPECT_THROW(std::ignore = WhitePointAt(kelvin), Error) << kelvin;
}

TEST(WhiteBalance, TheDisplaysWhiteChangesNothing) {
    EXPECT_EQ(WhiteBalance(WhitePointAt(6500.0)), glm::mat3(1.0f));
    ExpectNear(ChromaticityOf(glm::dvec3(1.0)), WhitePointAt(6500.0), 1e-12);
    const glm::mat3 almost = WhiteBalance(ChromaticityOf(glm::dvec3(0.3)));
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) EXPECT_NEAR(almost[c][r], c == r ? 1.0f : 0.0f, 1e-6f);
}

// Linear Rec. 709 of a chromaticity, by the inverse of IEC 61966-2-1's matrix, of luminance 1.
glm::dvec3 ColorOf(const glm::dvec2& xy) {
    const double x = xy.x / xy.y, z = (1.0 - xy.x - xy.y) / xy.y;
    return {3.2406 * x - 1.5372 - 0.4986 * z, -0.9689 * x + 1.8758 + 0.0415 * z,
            0.0557 * x - 0.2040 + 1.0570 * z};
}

TEST(WhiteBalance, TheWhiteOfALightBecomesNeutralOfTheSameLuminance) {
    for (const glm::dvec2& white : {kA, kD50, kD75, glm::dvec2(0.33, 0.36)}) {
        const glm::dvec3 shown = glm::dmat3(WhiteBalance(white)) * ColorOf(white);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(shown[c], 1.0, 2e-3);
    }
    // Of illuminant A by its temperature: to the precision of the locus
    const glm::dvec3 shown = glm::dmat3(WhiteBalance(WhitePointAt(2856.0))) * ColorOf(kA);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(shown[c], 1.0, 1e-2);
}

// Bradford's matrix from D50 to D65 as it is published (B. Lindbloom, from ASTM E308's whites).
TEST(WhiteBalance, IsBradfordsAdaptation) {
    const glm::dmat3 published = glm::transpose(glm::dmat3{{0.9555766, -0.0230393, 0.0631636},
                                                           {-0.0282895, 1.0099416, 0.0210077},
                                                           {0.0122982, -0.0204830, 1.3299098}});
    const glm::dmat3 toXyz = glm::transpose(glm::dmat3{{0.4124564, 0.3575761, 0.1804375},
                                                       {0.2126729, 0.7151522, 0.0721750},
                                                       {0.0193339, 0.1191920, 0.9503041}});
    const glm::dvec2 white(0.96422 / (0.96422 + 1.0 + 0.82521), 1.0 / (0.96422 + 1.0 + 0.82521));
    const glm::dmat3 expected = glm::inverse(toXyz) * published * toXyz, made(WhiteBalance(white));
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) EXPECT_NEAR(made[c][r], expected[c][r], 1e-3) << c << " " << r;
}

}  // namespace
}  // namespace raygraph::passes::white_balance_test
