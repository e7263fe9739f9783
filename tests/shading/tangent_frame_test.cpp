// Tests of triangles' frames along their texture coordinates, and of how they turn smooth frames.
#include "core/frame.glsl"

#include <gtest/gtest.h>

#include <random>

namespace raygraph::shading::tangent_frame_test {

namespace {

// A unit normal, and two directions perpendicular to it that are no multiples of each other.
struct Plane {
    vec3 n, alongU, alongV;
};

class Random {
  public:
    float Number() { return m_number(m_engine); }
    vec3 Direction() { return normalize(vec3(Number(), Number(), Number())); }
    // Returns an affine map from texture coordinates to space whose axes are at most 70 degrees from a right
    // angle.
    Plane NextPlane() {
        for (;;) {
            Plane plane;
            plane.n = Direction();
            plane.alongU = cross(plane.n, Direction());
            plane.alongV = cross(plane.n, Direction());
            const float sine = dot(plane.n, cross(plane.alongU, plane.alongV)) /
                               (length(plane.alongU) * length(plane.alongV));
            if (std::abs(sine) > 0.34f) return plane;
        }
    }
    // Returns two edges, in texture coordinates, of a triangle that is no sliver.
    glm::mat2 Edges() {
        for (;;) {
            const glm::mat2 edges(Number(), Number(), Number(), Number());
            if (std::abs(determinant(edges)) > 0.3f) return edges;
        }
    }

  private:
    std::mt19937 m_engine{5};
    std::normal_distribution<float> m_number;
};

vec3 Xyz(const vec4& v) {
    return {v.x, v.y, v.z};
}

}  // namespace

// All triangles of an affine map have one frame, whatever their corners and the unit of the coordinates.
TEST(TangentFrame, TriangleTangent_LiesAlongUAndSaysWhereTheImagesTopIs) {
    Random random;
    for (int trial = 0; trial < 20'000; ++trial) {
        Plane plane = random.NextPlane();
        const glm::mat2 uv = random.Edges();
        const float unit = std::exp2(8.0f * random.Number());
        const vec3 e1 = uv[0].x * plane.alongU + uv[0].y * plane.alongV;
        const vec3 e2 = uv[1].x * plane.alongU + uv[1].y * plane.alongV;
        if (dot(cross(e1, e2), plane.n) < 0.0f) plane.n = -plane.n;  // n is on the front, as the winding says
        const vec4 tangent = TriangleTangent(e1, e2, unit * uv[0], unit * uv[1], plane.n);
        ASSERT_NEAR(dot(Xyz(tangent), normalize(plane.alongU)), 1.0f, 1e-4f);
        ASSERT_NEAR(dot(Xyz(tangent), plane.n), 0.0f, 1e-5f);
        // v points downwards
        ASSERT_LT(dot(tangent.w * cross(plane.n, Xyz(tangent)), plane.alongV), 0.0f);
        ASSERT_EQ(std::abs(tangent.w), 1.0f);
        // MikkTSpace's sign is that of the coordinates, whatever side the normal is on
        ASSERT_EQ(TriangleTangent(e1, e2, unit * uv[0], unit * uv[1], -plane.n), tangent);
    }
}

TEST(TangentFrame, TriangleTangent_IsPerpendicularToAnInterpolatedNormal) {
    const vec3 n = normalize(vec3(0.3f, -0.2f, 1.0f));
    const vec4 tangent =
        TriangleTangent(vec3(2, 0, 0), vec3(0, 3, 0), vec2(0.5f, 0.0f), vec2(0.0f, -0.25f), n);
    const vec3 expected = normalize(vec3(1, 0, 0) - n.x * n);
    EXPECT_LT(length(Xyz(tangent) - expected), 1e-6f);
    EXPECT_EQ(tangent.w, 1.0f);
}

TEST(TangentFrame, TriangleTangent_IsNoneWithoutAreaOrDirection) {
    const vec3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1), none(0.0f);
    EXPECT_EQ(TriangleTangent(x, y, vec2(1, 1), vec2(2, 2), z), vec4(0.0f));
    EXPECT_EQ(TriangleTangent(x, y, vec2(0.0f), vec2(0.0f), z), vec4(0.0f));
    EXPECT_EQ(TriangleTangent(none, none, vec2(1, 0), vec2(0, 1), z), vec4(0.0f));
    EXPECT_EQ(TriangleTangent(x, y, vec2(1, 0), vec2(0, 1), x), vec4(0.0f)) << "u grows along the normal";
}

// The triangle's frame is turned exactly into its other frame. A frame that is turned about the normal
// relative to the first is turned by as much relative to the second, and mirrored with it.
TEST(TangentFrame, TurnTangent_TurnsAsTheTrianglesFramesAreTurned) {
    Random random;
    for (int trial = 0; trial < 20'000; ++trial) {
        const Plane plane = random.NextPlane();
        const glm::mat2 uv = random.Edges(), linear = random.Edges();
        const auto edge = [&](int i) { return uv[i].x * plane.alongU + uv[i].y * plane.alongV; };
        const vec4 from = TriangleTangent(edge(0), edge(1), uv[0], uv[1], plane.n);
        const vec4 to = TriangleTangent(edge(0), edge(1), linear * uv[0], linear * uv[1], plane.n);
        ASSERT_EQ(to.w, determinant(linear) < 0.0f ? -from.w : from.w);
        ASSERT_LT(length(TurnTangent(from, from, to, plane.n) - to), 1e-5f);
        // Turns a tangent by 0.3 radians about n
        const auto turned = [&](const vec4& tangent) {
            const vec3 t = std::cos(0.3f) * Xyz(tangent) + std::sin(0.3f) * cross(plane.n, Xyz(tangent));
            return vec4(t.x, t.y, t.z, tangent.w);
        };
        ASSERT_LT(length(TurnTangent(turned(from), from, to, plane.n) - turned(to)), 1e-5f);
    }
}

}  // namespace raygraph::shading::tangent_frame_test
