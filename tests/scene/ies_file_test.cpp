// Files of light profiles, as they are and as they must not be.
#include "renderer/scene/formats/ies_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/error.h"
#include "tests/support/ies_text.h"

namespace raygraph::test::ies_file_test {
namespace {

using scene::IesFile;
using scene::LightProfile;
using scene::PhotometricType;

constexpr double kDegree = std::numbers::pi / 180.0;

LightProfile Parse(const IesText& file) {
    const IesFile parsed = scene::ParseIes(file.Text());
    EXPECT_TRUE(parsed.warnings.empty());
    return parsed.profile;
}

std::string Refusal(const std::string& text) {
    try {
        scene::ParseIes(text);
    } catch (const Error& error) {
        EXPECT_EQ(error.Kind(), ErrorKind::BadInput);
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
        return error.what();
    }
    return "read";
}

void ExpectAngles(const std::vector<float>& angles, const std::vector<double>& degrees) {
    ASSERT_EQ(angles.size(), degrees.size());
    for (size_t i = 0; i < degrees.size(); ++i) EXPECT_NEAR(angles[i], degrees[i] * kDegree, 1e-6) << i;
}

// Expects that a plane of the web holds 1000 h + v at the angles of the file.
void ExpectPlanes(const LightProfile& profile, const std::vector<double>& vertical,
                  const std::vector<double>& fileHorizontal) {
    ASSERT_EQ(profile.candela.size(), vertical.size() * fileHorizontal.size());
    size_t i = 0;
    for (const double h : fileHorizontal)
        for (const double v : vertical) EXPECT_EQ(profile.candela[i++], static_cast<float>(1000.0 * h + v));
}

IesText Named(int type, std::vector<double> vertical, std::vector<double> horizontal) {
    return {.type = type,
            .vertical = std::move(vertical),
            .horizontal = std::move(horizontal),
            .candela = [](double v, double h) { return 1000.0 * h + std::abs(v); }};
}

TEST(IesFile, PartsOfTypeCAreCompletedToATurn) {
    const std::vector<double> v{0, 30, 90};
    LightProfile profile = Parse(Named(1, v, {0}));
    EXPECT_EQ(profile.type, PhotometricType::C);
    ExpectAngles(profile.vertical, v);
    ExpectAngles(profile.horizontal, {0});
    ExpectPlanes(profile, v, {0});
    profile = Parse(Named(1, v, {0, 20, 90}));
    ExpectAngles(profile.horizontal, {0, 20, 90, 160, 180, 200, 270, 340, 360});
    ExpectPlanes(profile, v, {0, 20, 90, 20, 0, 20, 90, 20, 0});
    profile = Parse(Named(1, v, {0, 20, 180}));
    ExpectAngles(profile.horizontal, {0, 20, 180, 340, 360});
    ExpectPlanes(profile, v, {0, 20, 180, 20, 0});
    profile = Parse(Named(1, v, {90, 100, 270}));
    ExpectAngles(profile.horizontal, {90, 100, 270, 440, 450});
    ExpectPlanes(profile, v, {90, 100, 270, 100, 90});
    profile = Parse(Named(1, v, {0, 120, 360}));
    ExpectAngles(profile.horizontal, {0, 120, 360});
    ExpectPlanes(profile, v, {0, 120, 360});
    // The last plane may be left out
    profile = Parse(Named(1, v, {0, 120, 240}));
    ExpectAngles(profile.horizontal, {0, 120, 240, 360});
    ExpectPlanes(profile, v, {0, 120, 240, 0});
}

TEST(IesFile, HalvesOfTypesAAndBAreMirrored) {
    for (const int type : {2, 3}) {
        const std::vector<double> v{-90, 0, 90};
        LightProfile profile = Parse(Named(type, v, {0, 10, 90}));
        EXPECT_EQ(profile.type, type == 2 ? PhotometricType::B : PhotometricType::A);
        ExpectAngles(profile.vertical, v);
        ExpectAngles(profile.horizontal, {-90, -10, 0, 10, 90});
        profile =
            Parse({.type = type, .vertical = v, .horizontal = {-90, 0, 90}, .candela = [](double, double h) {
                       return 90.0 + h;
                   }});
        ExpectAngles(profile.horizontal, {-90, 0, 90});
        EXPECT_EQ(profile.candela.front(), 0.0f);
        EXPECT_EQ(profile.candela.back(), 180.0f);
    }
}

TEST(IesFile, FactorsAreMultipliedAsTheVersionSays) {
    IesText file{.multiplier = 2.0, .ballast = 0.5, .ballastLamp = 0.25};
    for (const auto& [version, factor] :
         std::vector<std::pair<std::string, float>>{{"IESNA:LM-63-1995", 1.0f},
                                                    {"IESNA:LM-63-2002", 1.0f},
                                                    {"IES:LM-63-2019", 1.0f},
                                                    {"IESNA91", 0.25f},
                                                    {"[LUMINAIRE] of 1986", 0.25f}}) {
        file.version = version;
        EXPECT_EQ(Parse(file).MaxIntensity(), 100.0f * factor) << version;
    }
}

TEST(IesFile, TiltAndSeparatorsAreReadOver) {
    IesText file;
    file.tilt = "TILT=INCLUDE\r\n1\r\n3\r\n0 45 90\r\n1 0.9 0.8";
    EXPECT_EQ(Parse(file).MaxIntensity(), 100.0f);
    file.tilt = " TILT = of_another.tlt ";
    EXPECT_EQ(Parse(file).MaxIntensity(), 100.0f);
    const IesFile loose = scene::ParseIes("TILT=NONE\n1,-1;+2e0, 2 1\t1 1 0 0 0 1 1 1\n0\n90, 0\n\n 7,\n8");
    EXPECT_EQ(loose.profile.candela, (std::vector<float>{14.0f, 16.0f}));
}

TEST(IesFile, NegativeIntensitiesAreNone) {
    const IesFile file = scene::ParseIes("TILT=NONE 1\n1 1 1 2 1 1 1 0 0 0 1 1 1 0 90 0 -1 5");
    EXPECT_EQ(file.profile.candela, (std::vector<float>{0.0f, 5.0f}));
    ASSERT_EQ(file.warnings.size(), 1u);
    EXPECT_EQ(file.warnings[0], "1 candela value is negative, taken as 0");
}

TEST(IesFile, MalformedOnesAreRefusedByLine) {
    EXPECT_EQ(Refusal(""), "line 0: there is no line with TILT=");
    EXPECT_EQ(Refusal("IESNA:LM-63-2002\n[X] y\n"), "line 2: there is no line with TILT=");
    EXPECT_EQ(Refusal("TILT=NONE\n1 1 1 2 1 1 1 0 0 0\n1 1 1\n0 90\n0\n5"),
              "line 6: ends where a candela value should be");
    const auto numbers = [](const std::string& ten, const std::string& rest = "") {
        return Refusal("TILT=NONE\n" + ten + "\n1 1 1\n" + rest);
    };
    EXPECT_EQ(numbers("1 1 x 2 1 1 1 0 0 0"), "line 2: the candela multiplier is \"x\", must be a number");
    EXPECT_EQ(numbers("1 1 nan 2 1 1 1 0 0 0"),
              "line 2: the candela multiplier is \"nan\", must be a number");
    EXPECT_EQ(numbers("1 1 -1 2 1 1 1 0 0 0"), "line 2: the candela multiplier is -1, must not be negative");
    EXPECT_EQ(numbers("1 1 1 1 1 1 1 0 0 0"),
              "line 2: the number of vertical angles is 1, must be a whole number of 2 to 10000");
    EXPECT_EQ(numbers("1 1 1 2 1e9 1 1 0 0 0"),
              "line 2: the number of horizontal angles is 1e+09, must be a whole number of 1 to 10000");
    EXPECT_EQ(numbers("1 1 1 2 1.5 1 1 0 0 0"),
              "line 2: the number of horizontal angles is 1.5, must be a whole number of 1 to 10000");
    EXPECT_EQ(numbers("1 1 1 2 1 4 1 0 0 0"), "line 2: the photometric type is 4, must be 1, 2 or 3");
    EXPECT_EQ(numbers("1 1 1 2 1 1 1 0 0 0", "0 200\n"),
              "line 4: vertical angle 1 is 200, must be 0 to 180 degrees");
    EXPECT_EQ(numbers("1 1 1 2 1 1 1 0 0 0", "90 90\n"),
              "line 4: vertical angle 1 is 90, must be above 90, the one before");
    EXPECT_EQ(
        numbers("1 1 1 2 2 1 1 0 0 0", "0 90\n30 60\n1 1 1 1"),
        "line 6: horizontal angles are 30 to 60, must be 0, 0 to 90, 0 to 180, 90 to 270, or all around "
        "from 0");
    EXPECT_EQ(numbers("1 1 1 2 1 2 1 0 0 0", "0 90\n0\n1 1"),
              "line 5: there is one horizontal angle; types A and B need two or more");
    EXPECT_EQ(numbers("1 1 1e20 2 1 1 1 0 0 0", "0 90\n0\n1 1e20"),
              "line 6: a candela value is 1e+40 with its factors, must be at most 1e+30");
}

// The intensities are polynomials of the cosine, over fine webs.
TEST(LightProfile, MeanIntensityIsTheIntegralOverAllDirections) {
    const auto cosine = [](double v, double) { return std::cos(v * kDegree); };
    const IesText lambert{.vertical = Steps(0, 90, 1), .candela = cosine};
    EXPECT_NEAR(Parse(lambert).MeanIntensity(), 0.25, 1e-4);  // pi over 4 pi
    const IesText all{
        .vertical = {0, 180}, .horizontal = {0, 360}, .candela = [](double, double) { return 3.0; }};
    EXPECT_NEAR(Parse(all).MeanIntensity(), 3.0, 1e-6);
    const IesText half{
        .vertical = {90, 180}, .horizontal = {0, 90}, .candela = [](double, double) { return 3.0; }};
    EXPECT_NEAR(Parse(half).MeanIntensity(), 1.5, 1e-6);
    // Lambert's again, along the other axes: cos h cos v of type B is -d.z, and so it is of type A
    for (const int type : {2, 3}) {
        const IesText other{.type = type,
                            .vertical = Steps(-90, 90, 1),
                            .horizontal = Steps(0, 90, 1),
                            .candela = [](double v, double h) {
                                return std::max(std::cos(v * kDegree) * std::cos(h * kDegree), 0.0);
                            }};
        EXPECT_NEAR(Parse(other).MeanIntensity(), 0.25, 1e-4) << type;
    }
}

}  // namespace
}  // namespace raygraph::test::ies_file_test
