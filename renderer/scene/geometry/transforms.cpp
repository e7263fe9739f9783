#include "renderer/scene/geometry/transforms.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "renderer/scene/model/check.h"

namespace raygraph::scene {
namespace {

constexpr double kLeastRatio = 0x1p-30;
constexpr double kLeastDeterminant = 0x1p-21;  // is several roundings of float
constexpr double kLeastWidth = 0x1p-18;        // is s2 / s1, below which a mesh is a line

// Returns the sum of the sizes of the terms of the determinant.
double TermsOf(const glm::dmat3& m) {
    const glm::dvec3 x = glm::abs(m[0]), y = glm::abs(m[1]), z = glm::abs(m[2]);
    return x.x * (y.y * z.z + y.z * z.y) + x.y * (y.z * z.x + y.x * z.z) + x.z * (y.x * z.y + y.y * z.x);
}

// Nearly all are: their ratios are above all limits. False for numbers whose products overflow.
bool IsSurelySolid(const glm::mat4x3& m) {
    // The limit of the square of the determinant relative to the cube of the squared norm. Where s3 is
    // kObliqueThickness of s1 = s2, that ratio is 1.2e-7.
    constexpr float kFar = 1.5e-7f;
    const float determinant = glm::dot(m[0], glm::cross(m[1], m[2]));
    const float square = glm::dot(m[0], m[0]) + glm::dot(m[1], m[1]) + glm::dot(m[2], m[2]);
    const float least = kFar * square * square * square;
    return std::isnormal(least) && determinant * determinant >= least;
}

// Holds the decomposition of a matrix whose s3 is far below its s2.
struct Squeeze {
    glm::dvec3 normal{0.0}, squeezed{0.0};  // n and m
    double s3 = 0.0;                        // negative if the matrix mirrors
};
Squeeze SqueezeOf(const glm::dmat3& linear, const glm::dmat3& cofactors) {
    // The cofactors are s1 s2 n m^T, and s3 / s2 of that in another direction, which the products take away
    constexpr std::array kColumns{0, 1, 2};
    const int longest = *std::ranges::max_element(
        kColumns, {}, [&](int column) { return glm::dot(cofactors[column], cofactors[column]); });
    Squeeze result{.normal = glm::normalize(cofactors[longest])};
    for (int i = 0; i < 2; ++i) {
        result.squeezed = glm::normalize(result.normal * cofactors);
        result.normal = glm::normalize(cofactors * result.squeezed);
    }
    result.s3 = glm::dot(result.normal, linear * result.squeezed);
    return result;
}

// The result is `matrix`, but that its s3 is `thickness`.
glm::mat4x3 Thickened(const glm::mat4x3& matrix, const Squeeze& squeeze, double thickness) {
    glm::mat4x3 result = matrix;
    for (int i = 0; i < 3; ++i)
        result[i] = glm::vec3(glm::dvec3(matrix[i]) +
                              (thickness - squeeze.s3) * squeeze.squeezed[i] * squeeze.normal);
    return result;
}

// Returns the sine of the angle between a unit vector and the nearest axis.
double ObliquityOf(const glm::dvec3& unit) {
    const glm::dvec3 sizes = glm::abs(unit);
    const double cosine = std::max({sizes.x, sizes.y, sizes.z});
    return std::sqrt(std::max(glm::dot(unit, unit) - cosine * cosine, 0.0));
}

// inPlane is the square root of the area that the box has in the plane, `along` the box's extent in the
// squeezed direction.
struct Sizes {
    double inPlane = 0.0, along = 0.0;
};
Sizes SizesOf(const Bounds& mesh, const glm::dmat3& linear, const glm::dvec3& squeezed) {
    if (mesh.IsEmpty()) return {};
    const glm::dvec3 extent = glm::dvec3(mesh.max) - glm::dvec3(mesh.min);
    std::array<double, 3> sides{};
    for (int i = 0; i < 3; ++i) sides[static_cast<size_t>(i)] = extent[i] * glm::length(linear[i]);
    std::ranges::sort(sides);
    return {std::sqrt(sides[1] * sides[2]), glm::dot(glm::abs(squeezed), extent)};
}

bool IsNodeMirrored(const Node& node) {
    if (node.matrix) return IsMirrored(*node.matrix);
    return (node.scale.x < 0.0f) != ((node.scale.y < 0.0f) != (node.scale.z < 0.0f));
}

// The product of the signs of its scales and of those above it tells, where 0 counts as positive.
bool IsMirroredAt(const SceneData& scene, uint32_t node) {
    bool isMirrored = false;
    for (; node != kNone; node = scene.nodes[node].parent) isMirrored ^= IsNodeMirrored(scene.nodes[node]);
    return isMirrored;
}

}  // namespace

bool IsFlat(const glm::mat4x3& transform) {
    if (IsSurelySolid(transform)) return false;
    const glm::dmat3 linear(transform);
    const double determinant = std::abs(glm::determinant(linear));
    if (!(determinant > kLeastDeterminant * TermsOf(linear))) return true;
    const double area = std::sqrt(SquareOf(Cofactors(linear)));
    const Widths widths = WidthsOf(SquareOf(linear), area);
    return determinant < kLeastRatio * area * widths.s1;
}

bool MayGainThickness(const glm::mat4x3& transform) {
    return !IsSurelySolid(transform) && (Flatness(transform) < kObliqueThickness || IsFlat(transform));
}

std::optional<PlacedTransform> WithThickness(const PlacedTransform& placed, const Bounds& mesh,
                                             bool isMirrored) {
    const auto ifShown = [](const PlacedTransform& transform) {
        const bool isShown = CanInvert(transform.matrix) && IsFinite(transform.rest);
        return isShown ? std::optional(transform) : std::nullopt;
    };
    if (!MayGainThickness(placed.matrix) || !IsFinite(placed.matrix)) return ifShown(placed);
    const bool isFlat = IsFlat(placed.matrix);
    const glm::dmat3 linear(placed.matrix), cofactors = Cofactors(linear);
    const double area = std::sqrt(SquareOf(cofactors));
    const Widths widths = WidthsOf(SquareOf(linear), area);
    if (!(widths.s2 > kLeastWidth * widths.s1)) return isFlat ? std::nullopt : ifShown(placed);
    const Squeeze squeeze = SqueezeOf(linear, cofactors);
    const Sizes sizes = SizesOf(mesh, linear, squeeze.squeezed);
    // A mesh that reaches far along what is squeezed does not become so thick that it would be seen
    constexpr double kSeen = 2.0 * kObliqueThickness;
    const double size = sizes.along > 0.0 ? sizes.inPlane / sizes.along : 1.0;
    const double forRays = kObliqueThickness * ObliquityOf(squeeze.squeezed) * widths.s2;
    const double forSides = sizes.along > 0.0 ? std::min(forRays, kSeen * size) : forRays;
    // A matrix that was thickened and rounded since is thick enough.
    constexpr double kEnough = 0.75;
    if (!isFlat && !(std::abs(squeeze.s3) < kEnough * forSides)) return ifShown(placed);
    // Vertex normals that were at 45 degrees are then within that share of the plane's
    const double most = kObliqueThickness * widths.s2;
    const double wanted = sizes.along > 0.0 ? std::max(kFlatThickness * size, forSides) : most;
    // It is as thick as it takes to tell its sides; a mesh without area in the plane stays as thin as that
    const double thickness = isFlat ? std::clamp(wanted, kLeastRatio * widths.s1, most) : forSides;
    const double side = (isFlat ? isMirrored : squeeze.s3 < 0.0) ? -1.0 : 1.0;
    PlacedTransform shown{Thickened(placed.matrix, squeeze, side * thickness), placed.rest};
    const auto isThick = [](const glm::mat4x3& matrix) { return !IsFlat(matrix) && CanInvert(matrix); };
    for (double thicker = thickness; !isThick(shown.matrix) && thicker < most;) {
        thicker *= 2.0;
        const glm::mat4x3 matrix = Thickened(placed.matrix, squeeze, side * thicker);
        if (isThick(matrix)) shown.matrix = matrix;
    }
    if (!mesh.IsEmpty()) {
        const glm::dvec3 middle = 0.5 * (glm::dvec3(mesh.min) + glm::dvec3(mesh.max));
        const glm::dvec3 moved = (glm::dmat3(shown.matrix) - linear) * middle;
        const FloatPair place = ToFloatPair(placed.Place() - moved);
        shown.matrix[3] = place.rounded;
        shown.rest = place.rest;
    }
    return ifShown(shown);
}

std::optional<PlacedTransform> WithThickness(const SceneData& scene, const Instance& instance,
                                             const PlacedTransform& placed) {
    if (!MayGainThickness(placed.matrix)) return WithThickness(placed, {});
    Bounds mesh;
    for (const Primitive& primitive : scene.meshes[instance.mesh].primitives) mesh.Extend(primitive.bounds);
    return WithThickness(placed, mesh,
                         IsMirrored(instance.objectToNode) != IsMirroredAt(scene, instance.node));
}

PlacedTransform WithDirections(const SceneData& scene, uint32_t node, const PlacedTransform& nodeToWorld) {
    if (!IsFlat(nodeToWorld.matrix)) return nodeToWorld;
    return WithThickness(nodeToWorld, {}, IsMirroredAt(scene, node)).value_or(nodeToWorld);
}

double MeanScale(const glm::mat4x3& transform) {
    const glm::dmat3 linear(transform);
    if (IsFlat(transform)) return std::sqrt(std::sqrt(SquareOf(Cofactors(linear))));
    return std::cbrt(std::abs(glm::determinant(linear)));
}

// --- Translation, rotation and scale ---

namespace {

glm::mat4x3 Matrix(const TransformParts& parts) {
    Node node;
    node.translation = parts.translation;
    node.rotation = parts.rotation;
    node.scale = parts.scale;
    return node.LocalTransform();
}

// Returns whether both are equal within rounding of products of such matrices.
bool IsNear(const glm::mat4x3& a, const glm::mat4x3& b) {
    for (int column = 0; column < 4; ++column) {
        const float size = glm::length(a[column]) + glm::length(b[column]);
        if (glm::length(a[column] - b[column]) > 4e-6f * size) return false;
    }
    return true;
}

}  // namespace

std::optional<TransformParts> PartsOf(const glm::mat4x3& local, const Node& own) {
    TransformParts parts{own.translation, own.rotation, own.scale};
    parts.translation = local[3];
    if (IsNear(Matrix(parts), local)) return parts;
    const auto turned = [&](const glm::vec3& scale) {
        glm::mat3 turn(local);
        for (int i = 0; i < 3; ++i) turn[i] /= scale[i];
        return glm::normalize(glm::quat_cast(turn));
    };
    if (own.scale.x != 0.0f && own.scale.y != 0.0f && own.scale.z != 0.0f) {
        parts.rotation = turned(own.scale);
        if (IsNear(Matrix(parts), local)) return parts;
    }
    glm::vec3 scale(glm::length(local[0]), glm::length(local[1]), glm::length(local[2]));
    if (IsMirrored(local)) scale.x = -scale.x;
    for (int i = 0; i < 3; ++i)
        if (scale[i] == 0.0f) return std::nullopt;
    parts.scale = scale;
    parts.rotation = own.rotation;
    if (IsNear(Matrix(parts), local)) return parts;
    parts.rotation = turned(scale);
    if (IsNear(Matrix(parts), local)) return parts;
    return std::nullopt;
}

// Where GCC 12 vectorizes this loop, it leaves out the rounding to float: `volatile` keeps it.
FloatPair ToFloatPair(const glm::dvec3& position) {
    FloatPair pair;
    for (int i = 0; i < 3; ++i) {
        const volatile float rounded = static_cast<float>(position[i]);
        pair.rounded[i] = rounded;
        pair.rest[i] = static_cast<float>(position[i] - static_cast<double>(rounded));
    }
    return pair;
}

}  // namespace raygraph::scene
