// The meshes of a SceneData: their vertices, and what deforms them. Value types only; units and invariants at
// the top of scene_data.h. Threads: plain values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <string>
#include <vector>

#include "base/api.h"

namespace raygraph::scene {

// The value of an index that refers to nothing.
inline constexpr uint32_t kNone = 0xFFFFFFFFu;

// Describes an axis-aligned box. Default-constructed: empty (min above max).
struct RAYGRAPH_API Bounds {
    glm::vec3 min{std::numeric_limits<float>::infinity()};
    glm::vec3 max{-std::numeric_limits<float>::infinity()};

    bool IsEmpty() const { return !(min.x <= max.x && min.y <= max.y && min.z <= max.z); }
    void Extend(const glm::vec3& point);
    void Extend(const Bounds& other);
    glm::vec3 Center() const { return 0.5f * (min + max); }
    // Returns half the diagonal; 0 for an empty box.
    float Radius() const { return IsEmpty() ? 0.0f : 0.5f * glm::length(max - min); }
    // Returns the box around this box's eight corners moved by an affine transform; empty stays empty.
    Bounds Transformed(const glm::mat4x3& transform) const;
};

// Holds the material that a variant of the scene gives a primitive. `variant` indexes SceneData::variants;
// kNone is for those that are not listed, and for none chosen.
struct VariantMaterial {
    uint32_t variant = kNone;
    uint32_t material = 0;

    bool operator==(const VariantMaterial&) const = default;
};

// Holds the joints of a skin that move the vertices of a primitive, and their weights: `perVertex` of each
// vertex, those of vertex i from perVertex * i on. A node that places the mesh has the skin, so that the same
// vertices may follow several. Empty: nothing does.
struct JointInfluences {
    uint32_t perVertex = 0;
    std::vector<uint16_t> joints;  // Into Skin::joints of every skin that the mesh is placed with.
    // Not negative, with a sum of 1 for each vertex, up to rounding. The greatest come first; unused places
    // are 0, of joint 0.
    std::vector<float> weights;
    // By joint, up to the highest that is used: the box around the positions that it moves, before targets
    // are added; empty for a joint that moves none.
    std::vector<Bounds> bounds;

    bool IsEmpty() const { return perVertex == 0; }
    size_t JointCount() const { return bounds.size(); }
};

// Holds displacements of a primitive's vertices, added as many times as the target's weight says. Each stream
// is empty (all zeros) or as long as `positions` of the primitive. Tangents have a direction to be displaced,
// their w stays.
struct MorphTarget {
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals;
    std::vector<glm::vec3> tangents;
    Bounds bounds;  // the bounds of `positions`; empty without them
};

// One draw's worth of triangles, or of round primitives, with one material. All streams but positions and
// indices are optional (empty).
//
// Round primitives are capsules: the points that are nearer to the segment between two vertices than a
// radius. Of a segment without length that is a sphere. They are solids with a surface of their own, whose
// normals need no stream and stay exact: radius and segment are placed by the instance's transform, which may
// make ellipsoids of spheres. Colors and texture coordinates vary along the segment.
struct Primitive {
    std::vector<glm::vec3> positions;
    // Unit length. Never empty after import: flat ones are made, vertices then split.
    std::vector<glm::vec3> normals;
    // xyz unit length, w = +1 or -1: bitangent = cross(normal, tangent.xyz) * w. There if the material, or
    // that of a variant, has a normal map, of its coat at least, or is anisotropic, and there are the texture
    // coordinates for them.
    std::vector<glm::vec4> tangents;
    // The texture coordinate set, 0 or 1, along which the tangents were generated, without a texture's
    // transform; a map that is read by other coordinates has another frame (shaders/core/frame.glsl).
    // kNone: the tangents were given, and all maps of the primitive are read along them.
    uint32_t tangentTexCoord = kNone;
    // By vertex: cosine and sine of the angle about the normal from the tangent to the tangent of the other
    // texture coordinate set. Empty: maps of that set use the frame of each triangle.
    std::vector<glm::vec2> frameTurns;
    std::vector<glm::vec2> uv0;
    std::vector<glm::vec2> uv1;
    // Linear, multiplies the base color. Alpha is 1 where the file has three channels.
    std::vector<glm::vec4> colors;
    // Triangle list, three a triangle, counter-clockwise seen from the front; or two a capsule.
    std::vector<uint32_t> indices;
    uint32_t material = 0;  // index into SceneData::materials; always valid
    Bounds bounds;          // object space; for round primitives with their radii
    // KHR_materials_variants: what scene::SetVariant chooses `material` from, ascending by variant. Empty:
    // `material` in all of them.
    std::vector<VariantMaterial> variants;
    // The radii of round primitives, one for each. Such a primitive has no normals and no tangents. Empty for
    // triangles.
    std::vector<float> radii;
    // The deformation (renderer/scene/animation/deform.h). Positions, normals and tangents are the base
    // shape, before joints and targets. Round primitives have neither.
    JointInfluences influences;
    std::vector<MorphTarget> targets;  // empty, or as many as Mesh::weights
    // Each triangle has its own normal, which no stream of the file said: three vertices a triangle, in
    // order. Deformed, the normals are again those of the triangles.
    bool hasFlatNormals = false;

    bool IsRound() const { return !radii.empty(); }
    size_t TriangleCount() const { return IsRound() ? 0 : indices.size() / 3; }
};

struct Mesh {
    std::string name;
    // Empty for a mesh that the loaded scene does not place, and for one of points and lines only if they are
    // left out.
    std::vector<Primitive> primitives;
    // The weight of each morph target where a node has no weights of its own: as many as there are targets,
    // any numbers.
    std::vector<float> weights;
};

}  // namespace raygraph::scene
