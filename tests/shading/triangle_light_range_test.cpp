// Tests of a triangle light seen from 1e-7 to 1e3 times its size away: above its middle, its edges and its
// corners, and from beside it. Sampled light, light that rays find, and closed forms in double precision
// agree.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "core/rng.glsl"
#include "tests/shading/light_scene.h"
#include "tests/shading/random_values.h"
#include "tests/support/chi_square.h"

namespace raygraph::shading::triangle_light_range_test {
namespace {

using glm::dvec2;
using glm::dvec3;

constexpr double kTolerance = 1e-3;

struct View {
    std::string name;
    LightRecord light{};    // seen from the origin
    double rounding = 0.0;  // relative error of what is seen, by rounded coordinates
    bool isSliver = false;
};

double Turn(dvec2 a, dvec2 b) {
    return a.x * b.y - a.y * b.x;
}

// A triangle as seen from the origin, in double precision. The light's record is taken as exact.
class Seen {
  public:
    explicit Seen(const LightRecord& light)
        : m_corners{dvec3(light.p0), dvec3(light.p0) + dvec3(light.e1), dvec3(light.p0) + dvec3(light.e2)},
          m_normal(glm::normalize(glm::cross(dvec3(light.e1), dvec3(light.e2)))) {
        if (glm::dot(m_corners[0], m_normal) < 0.0) m_normal = -m_normal;
        m_height = glm::dot(m_corners[0], m_normal);
        m_x = glm::normalize(dvec3(light.e1));
        m_y = glm::cross(m_normal, m_x);
        for (int i = 0; i < 3; ++i)
            m_flat[i] = dvec2(glm::dot(m_corners[i], m_x), glm::dot(m_corners[i], m_y));
        if (Turn(m_flat[1] - m_flat[0], m_flat[2] - m_flat[0]) < 0.0) std::swap(m_flat[1], m_flat[2]);
        for (int i = 0; i < 3; ++i) m_isInside &= Turn(m_flat[(i + 1) % 3] - m_flat[i], -m_flat[i]) >= 0.0;
        if (m_isInside) return;
        const dvec2 middle = (m_flat[0] + m_flat[1] + m_flat[2]) / 3.0;
        const double center = std::atan2(middle.y, middle.x);
        m_low = m_high = center;
        for (const dvec2& corner : m_flat) {
            const double turn = std::atan2(Turn(middle, corner), glm::dot(middle, corner));
            m_low = std::min(m_low, center + turn);
            m_high = std::max(m_high, center + turn);
        }
    }

    dvec3 Normal() const { return m_normal; }
    double Height() const { return m_height; }
    double NearestCorner() const {
        return std::min({glm::length(m_corners[0]), glm::length(m_corners[1]), glm::length(m_corners[2])});
    }
    // The triangle is seen only in azimuths about the normal between these.
    double Low() const { return m_low; }
    double High() const { return m_high; }
    double AzimuthOf(dvec3 direction) const {
        const double azimuth = std::atan2(glm::dot(direction, m_y), glm::dot(direction, m_x));
        return m_low + std::fmod(azimuth - m_low + 4.0 * M_PI, 2.0 * M_PI);
    }

    // Gives the range of cosines to the normal of those directions of an azimuth that meet the triangle.
    // Returns false if none do.
    bool Cosines(double azimuth, double& least, double& most) const {
        const dvec2 d(std::cos(azimuth), std::sin(azimuth));
        double near = 0.0, far = std::numeric_limits<double>::infinity();
        for (int i = 0; i < 3; ++i) {
            const dvec2 edge = m_flat[(i + 1) % 3] - m_flat[i];
            const double at = Turn(edge, -m_flat[i]), slope = Turn(edge, d);  // inside: at + t slope >= 0
            if (slope > 0.0) near = std::max(near, -at / slope);
            if (slope < 0.0) far = std::min(far, -at / slope);
            if (slope == 0.0 && at < 0.0) return false;
        }
        if (!(near < far)) return false;
        most = m_height / std::hypot(m_height, near);
        least = m_height / std::hypot(m_height, far);
        return true;
    }
    bool IsMet(dvec3 direction) const {
        double least = 0.0, most = 0.0;
        const double cosine = glm::dot(direction, m_normal) / glm::length(direction);
        return Cosines(AzimuthOf(direction), least, most) && cosine >= least && cosine <= most;
    }

    // Returns the irradiance on the parallel plane through the origin by Lambert's formula ("Photometria",
    // 1760), or by quadrature where its terms cancel.
    double Irradiance() const {
        double sum = 0.0;
        for (int i = 0; i < 3; ++i) {
            const dvec3 a = m_corners[i], b = m_corners[(i + 1) % 3], across = glm::cross(a, b);
            const double sine = glm::length(across);
            if (sine > 0.0) sum += std::atan2(sine, glm::dot(a, b)) * glm::dot(across / sine, m_normal);
        }
        if (std::abs(sum) > 1e-10) return 0.5 * std::abs(sum);
        constexpr int kSteps = 20'000;
        sum = 0.0;
        for (int i = 0; i < kSteps; ++i) {
            double least = 0.0, most = 0.0;
            if (Cosines(m_low + (m_high - m_low) * (i + 0.5) / kSteps, least, most))
                sum += 0.5 * (most * most - least * least) * (m_high - m_low) / kSteps;
        }
        return sum;
    }

  private:
    dvec3 m_corners[3];
    dvec2 m_flat[3];  // in the plane, relative to the origin's projection
    dvec3 m_normal, m_x{0.0}, m_y{0.0};
    double m_height = 0.0, m_low = -M_PI, m_high = M_PI;
    bool m_isInside = true;
};

struct Shape {
    const char* name;
    dvec2 corners[3];
    bool isAlongAxis[3];  // [i]: the edge from corner i to the next one is along an axis
    bool isSliver = false;
};

constexpr int kLeastExponent = -7, kMaxExponent = 3;

// Adds all views of a shape, in a turned plane or not, from 10^exponent times its size away.
void AddViews(const Shape& shape, bool isTurned, int exponent, std::vector<View>& views) {
    const dvec3 z = isTurned ? glm::normalize(dvec3(0.3, -0.5, 0.8)) : dvec3(0, 0, 1);
    const dvec3 x = isTurned ? glm::normalize(glm::cross(dvec3(0.2, 0.9, 0.1), z)) : dvec3(1, 0, 0);
    const glm::dmat3 turn(x, glm::cross(z, x), z);
    const double r = std::pow(10.0, exponent);
    const auto& c = shape.corners;
    const auto add = [&](const std::string& place, dvec2 foot, double height, double rounding) {
        View view{.name = std::string(shape.name) + (isTurned ? ", turned, " : ", ") + place + ", 1e" +
                          std::to_string(exponent),
                  .rounding = rounding,
                  .isSliver = shape.isSliver};
        vec3 p[3];
        for (int i = 0; i < 3; ++i) p[i] = turn * dvec3(c[i] - foot, height);
        view.light.p0 = p[0];
        view.light.e1 = p[1] - p[0];
        view.light.e2 = p[2] - p[0];
        view.light.flags = kLightDoubleSided;
        views.push_back(view);
    };
    // Rounding of a corner turns the plane through the origin and a near edge, or moves the triangle's plane
    // if it is seen edge-on
    const auto nearby = [&](bool isExact) { return isExact ? 0.0 : 2e-8 / r; };
    add("middle", (c[0] + c[1] + c[2]) / 3.0, r, 0.0);
    for (int i = 0; i < 3; ++i) {
        const dvec2 edge = glm::normalize(c[(i + 1) % 3] - c[i]), inward(-edge.y, edge.x);
        const dvec2 on = c[i] + 0.37 * (c[(i + 1) % 3] - c[i]);
        const double rounding = nearby(!isTurned && shape.isAlongAxis[i]);
        const std::string number = std::to_string(i);
        add("edge " + number, on, r, rounding);
        add("inside of edge " + number, on + r * inward, r, rounding);
        add("outside of edge " + number, on - r * inward, r, rounding);
        add("corner " + number, c[i] + dvec2(0.3 * r, -0.2 * r), 0.5 * r, nearby(false));
    }
    add("flat inside of edge 0", c[0] + dvec2(0.37, 20.0 * r), r, nearby(!isTurned));
    add("flat outside of edge 0", c[0] + dvec2(0.37, -20.0 * r), r, nearby(!isTurned));
    add("beside", c[1] + (0.2 + r) * dvec2(0.8, -0.6), 0.05 * r, isTurned ? 3e-6 / r : 0.0);
}

std::vector<View> Views() {
    const Shape shapes[] = {{"half of a square", {{0, 0}, {1, 0}, {1, 1}}, {true, true, false}},
                            {"obtuse", {{0, 0}, {1, 0}, {0.4, 0.15}}, {true, false, false}},
                            {"sliver", {{0, 0}, {1, 0}, {0.3, 2e-3}}, {true, false, false}, true}};
    std::vector<View> views;
    for (const Shape& shape : shapes)
        for (int exponent = kLeastExponent; exponent <= kMaxExponent; ++exponent) {
            AddViews(shape, false, exponent, views);
            if (exponent % 2 != 0) AddViews(shape, true, exponent, views);
        }
    return views;
}

bool IsByAngle(const SphericalTriangle& t) {
    return t.density > 0.0f;
}

// Directions are counted in cells of azimuth and of cosine to the normal, whose solid angles are exact.
constexpr int kTurns = 16, kRings = 8, kSteps = 250;

struct Cells {
    std::vector<double> solidAngles = std::vector<double>(kTurns * kRings, 0.0);
    double least = 1.0, most = 0.0;  // cosines

    explicit Cells(const Seen& seen) {
        const double step = (seen.High() - seen.Low()) / (kTurns * kSteps);
        const auto each = [&](auto&& visit) {
            for (int i = 0; i < kTurns * kSteps; ++i) {
                double from = 0.0, to = 0.0;
                if (seen.Cosines(seen.Low() + (i + 0.5) * step, from, to)) visit(i / kSteps, from, to);
            }
        };
        each([&](int, double from, double to) {
            least = std::min(least, from);
            most = std::max(most, to);
        });
        const double ring = (most - least) / kRings;
        each([&](int column, double from, double to) {
            for (int k = 0; k < kRings; ++k)
                solidAngles[size_t(column * kRings + k)] +=
                    step *
                    std::max(0.0, std::min(to, least + (k + 1) * ring) - std::max(from, least + k * ring));
        });
    }
    size_t CellOf(const Seen& seen, dvec3 direction) const {
        const double turn = (seen.AzimuthOf(direction) - seen.Low()) / (seen.High() - seen.Low());
        const double cosine = glm::dot(direction, seen.Normal()) / glm::length(direction);
        const int column = std::clamp(int(turn * kTurns), 0, kTurns - 1);
        const int row = std::clamp(int((cosine - least) / (most - least) * kRings), 0, kRings - 1);
        return size_t(column * kRings + row);
    }
};

TEST(TriangleLightRange, SampledDirectionsFollowTheDensityOfFoundOnes) {
    constexpr int kCount = 20'000;
    const std::vector<View> views = Views();
    const double level = test::SidakLevel(0.01, int(views.size()));
    std::mt19937 random(61);
    int count = 0;
    for (const View& view : views) {
        const SphericalTriangle t = SphericalTriangleFrom(view.light, vec3(0.0f));
        const Seen seen(view.light);
        // A sliver that is farther away covers too few azimuths for these cells
        const bool isFar = seen.NearestCorner() > (view.isSliver ? 0.05 : 0.5);
        if (!IsByAngle(t) || view.rounding > 1e-2 || isFar) continue;
        ++count;
        const Cells cells(seen);
        const double density = double(TriangleLightPDF(view.light, vec3(0.0f), 1.0f));
        std::vector<double> expected;
        double met = 0.0;
        for (const double solidAngle : cells.solidAngles) {
            expected.push_back(kCount * density * solidAngle);
            met += expected.back();
        }
        EXPECT_NEAR(met / kCount, 1.0, kTolerance + view.rounding) << view.name;
        std::vector<double> observed(expected.size(), 0.0);
        int strayCount = 0;  // samples that rounding put beside the triangle
        for (int i = 0; i < kCount; ++i) {
            const vec2 u(Uniform(random), Uniform(random));
            const TrianglePoint point = SampleTriangleLight(view.light, t, vec3(0.0f), u);
            ASSERT_NEAR(length(point.wi), 1.0f, 1e-5f) << view.name;
            const dvec3 place = dvec3(view.light.p0) + double{point.barycentrics.x} * dvec3(view.light.e1) +
                                double{point.barycentrics.y} * dvec3(view.light.e2);
            ASSERT_NEAR(double{point.distance}, glm::length(place), 1e-4 * glm::length(place) + 3e-7)
                << view.name;  // and roundings of the place
            const size_t cell = cells.CellOf(seen, dvec3(point.wi));
            if (!(point.pdf > 0.0f) || expected[cell] < 0.5 || !seen.IsMet(dvec3(point.wi)))
                ++strayCount;
            else
                observed[cell] += 1.0;
        }
        EXPECT_LT(strayCount, (kTolerance + view.rounding) * kCount) << view.name;
        EXPECT_GT(test::ChiSquareTest(observed, expected).pValue, level) << view.name;
    }
    EXPECT_GT(count, 100);
}

// A lamp 1 m long and 1 mm to 10 cm wide is sampled by solid angle from as near as its width. Points chosen
// by area would almost all be too far away to contribute.
TEST(TriangleLightRange, LongLampsAreSampledWellFromNear) {
    constexpr uint kCount = 1u << 14;
    testLights = {};
    testLights.scene.emission = {vec3(1.0f)};
    for (const float width : {1e-1f, 1e-2f, 1e-3f})
        for (const float height : {1.0f, 10.0f, 100.0f}) {
            LightRecord light{};
            light.p0 = vec3(-0.37f, -0.3f * width, height * width);
            light.e1 = vec3(1.0f, 0.0f, 0.0f);
            light.e2 = vec3(1.0f, width, 0.0f);
            light.flags = kLightDoubleSided;
            const double expected = Seen(light).Irradiance();
            double sum = 0.0, squares = 0.0;
            for (uint i = 0; i < kCount; ++i) {
                Sampler rng = StartPixelSample(uvec2(3u, 5u), i, 1u);
                const LightSample s = SampleTriangle(light, {vec3(0.0f), vec3(0, 0, 1)}, Get2D(rng));
                const double value = s.pdf > 0.0f ? double(s.wi.z / s.pdf) : 0.0;
                sum += value;
                squares += value * value;
            }
            const double mean = sum / kCount;
            EXPECT_NEAR(mean, expected, kTolerance * expected)
                << width << " m wide, " << height << " widths off";
            EXPECT_LT(squares / kCount - mean * mean, mean * mean)
                << width << " m wide, " << height << " widths off";
        }
}

// The irradiance of all views is estimated by light sampling and cosine-distributed rays, weighted by the
// balance heuristic with the density of TriangleLightPDF. Where the light is sampled by solid angle, light
// sampling alone is checked, too.
TEST(TriangleLightRange, IrradianceIsLamberts) {
    constexpr uint kCount = 1u << 14;
    testLights = {};
    testLights.scene.emission = {vec3(1.0f)};
    for (const View& view : Views()) {
        const SphericalTriangle t = SphericalTriangleFrom(view.light, vec3(0.0f));
        const Seen seen(view.light);
        const vec3 normal(seen.Normal());
        const Frame frame = FrameFromZ(normal);
        const double expected = seen.Irradiance();
        double alone = 0.0, both = 0.0, squares = 0.0;
        for (uint i = 0; i < kCount; ++i) {
            Sampler rng = StartPixelSample(uvec2(3u, 5u), i, 1u);
            const LightSample s = SampleTriangle(view.light, {vec3(0.0f), normal}, Get2D(rng));
            double value = 0.0;
            if (s.pdf > 0.0f) {
                const double cosine = std::max(double(dot(s.wi, normal)), 0.0);
                alone += cosine / double(s.pdf);
                value += cosine / (double(s.pdf) + cosine / M_PI);
            }
            const dvec3 found(FromLocal(frame, SampleCosineHemisphere(Get2D(rng))));
            if (seen.IsMet(found)) {
                const double cosine = glm::dot(found, seen.Normal());
                const float pdf = TriangleLightPDF(view.light, vec3(0.0f), float(seen.Height() / cosine));
                value += cosine / (double(pdf) + cosine / M_PI);
            }
            both += value;
            squares += value * value;
        }
        alone /= kCount;
        both /= kCount;
        const double tolerance = (kTolerance + view.rounding) * expected;
        const double deviation = std::sqrt(std::max(squares / kCount - both * both, 0.0) / kCount);
        EXPECT_NEAR(both, expected, tolerance + 4.0 * deviation) << view.name << ", with found light";
        if (IsByAngle(t)) {
            EXPECT_NEAR(alone, expected, tolerance) << view.name;
        }
    }
}

}  // namespace
}  // namespace raygraph::shading::triangle_light_range_test
