// The scene as plain CPU data: produced by an importer or a host, uploaded by GpuScene. Value types only,
// independent of the file format. Copying a SceneData copies every vertex and texel: move it.
//
// Space and units are glTF's: right-handed, +y up, meters, radians; a camera and a spot light look along
// their node's -z; colors are linear Rec. 709 unless a texture says sRGB; texture coordinate (0, 0) is the
// upper left texel corner.
//
// Far from the origin float has no digits left for small details: at 10 km its steps are 1 mm. So transforms
// into the world also store the remainder of their translation: objectToWorld[3] + translationResidual, added
// in double, is the translation. A host without one leaves it 0.
//
// Holds for a SceneData that LoadGltf returned, and GpuScene::SetScene requires it
// (renderer/scene/model/check.h):
//   - every index is in range, or kNone / -1 where the field allows it;
//   - every vertex index of a primitive is below its vertex count;
//   - the number of indices is a multiple of 3; of round primitives, twice that of radii, which are above 0;
//   - every optional vertex stream is empty or exactly as long as `positions`;
//   - every float is finite and in the range of its field, and no instance is scaled to nothing or to a line;
//   - nodeOrder lists nodes after their parents;
//   - a primitive's `variants` are empty, or ascend and end with kNone;
//   - the bounds of a primitive are around its positions, and an image has all of its texels,
//     and of its blocks levels from the largest one on;
//   - what mesh_data.h says of joints and morph targets, and animation.h of animations and skins: a node's
//     skin has all joints that its mesh names, and its weights are none or as many as those of its mesh.
//
// Threads: plain values; pure functions, for any thread. Editing one needs exclusive access.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/api.h"
#include "renderer/image/image.h"
#include "renderer/scene/animation/animation.h"
#include "renderer/scene/model/light_profile.h"
#include "renderer/scene/model/mesh_data.h"
#include "shaders/shared/choice.h"

namespace raygraph::scene {

// KHR_texture_transform: from a primitive's texture coordinates to those that a texture is read at.
struct TextureTransform {
    glm::vec2 offset{0.0f};
    float rotation = 0.0f;  // Radians, about the corner (0, 0), from +v to +u: the image turns clockwise.
    glm::vec2 scale{1.0f};

    // Scales, then rotates, then moves: matrix * (u, v, 1).
    glm::mat3x2 Matrix() const {
        const float c = std::cos(rotation), s = std::sin(rotation);
        return {glm::vec2(c, -s) * scale.x, glm::vec2(s, c) * scale.y, offset};
    }

    bool operator==(const TextureTransform&) const = default;
};

// Describes a reference of a material to a texture. `texture` indexes SceneData::textures; -1: none, only the
// factor counts.
struct TextureRef {
    int32_t texture = -1;
    int32_t texCoord = 0;  // 0 or 1: uv0 or uv1. The primitive may lack that stream: (0, 0) then.
    TextureTransform transform = {};

    bool IsPresent() const { return texture >= 0; }

    bool operator==(const TextureRef&) const = default;
};

// glTF's metallic-roughness material with those of its extensions that are read. Each texture is multiplied
// with the factor beside it.
struct RAYGRAPH_API Material {
    std::string name;
    glm::vec4 baseColorFactor{1.0f};  // linear rgb, alpha
    TextureRef baseColorTexture;      // sRGB rgb, linear alpha
    float metallicFactor = 1.0f;
    float roughnessFactor = 1.0f;         // perceptual: alpha = roughness^2
    TextureRef metallicRoughnessTexture;  // g = roughness, b = metallic
    TextureRef normalTexture;     // tangent space, rgb in [0,1] -> [-1,1], +y to the image's top (green up)
    float normalScale = 1.0f;     // on the x and y of the unpacked normal
    TextureRef occlusionTexture;  // r. Kept for raster views; a path tracer has no use for it.
    float occlusionStrength = 1.0f;
    glm::vec3 emissiveFactor{0.0f};  // radiance, W/(sr m^2) as a number, before `emissiveStrength`
    float emissiveStrength = 1.0f;   // KHR_materials_emissive_strength
    TextureRef emissiveTexture;      // sRGB
    AlphaMode alphaMode = AlphaMode::Opaque;
    float alphaCutoff = 0.5f;  // for AlphaMode::Mask: where alpha is below it there is a hole
    bool isDoubleSided = false;

    float ior = 1.5f;                     // KHR_materials_ior: at least 1; or 0: reflects everything
    float specularFactor = 1.0f;          // KHR_materials_specular: strength of the dielectric's reflection,
    TextureRef specularTexture;           // alpha;
    glm::vec3 specularColorFactor{1.0f};  // and its color at normal incidence, not bounded by 1,
    TextureRef specularColorTexture;      // sRGB
    float transmissionFactor = 0.0f;      // KHR_materials_transmission: share transmitted, not diffuse,
    TextureRef transmissionTexture;       // r
    float thicknessFactor = 0.0f;         // KHR_materials_volume: above 0, the surface bounds a medium
    glm::vec3 attenuationColor{1.0f};     // Color of white light after a path through the medium
    float attenuationDistance = 0.0f;     // of this length, meters; 0 = infinite
    bool isUnlit = false;                 // KHR_materials_unlit: shows its base color and nothing else
    float clearcoatFactor = 0.0f;         // KHR_materials_clearcoat: weight of a layer over all of it,
    TextureRef clearcoatTexture;          // r;
    float clearcoatRoughnessFactor = 0.0f;
    TextureRef clearcoatRoughnessTexture;  // g;
    TextureRef clearcoatNormalTexture;     // the layer's own; without one it does not follow normalTexture.
    float clearcoatNormalScale = 1.0f;
    glm::vec3 sheenColorFactor{
        0.0f};                     // KHR_materials_sheen: fibers that stand on the surface, below the coat,
    TextureRef sheenColorTexture;  // sRGB;
    float sheenRoughnessFactor = 0.0f;
    TextureRef sheenRoughnessTexture;  // alpha
    // KHR_materials_anisotropy: the strength of the stretching of highlights, and its direction in radians,
    // counterclockwise from the tangent.
    float anisotropyStrength = 0.0f;
    float anisotropyRotation = 0.0f;
    TextureRef anisotropyTexture;  // rg = direction in [-1,1], which rotation turns; b = strength.
    // KHR_materials_iridescence: share of the surface under a thin film, the film's index, and its thickness
    // in nm where the texture's g is 0 and where it is 1, or there is none.
    float iridescenceFactor = 0.0f;
    TextureRef iridescenceTexture;  // r
    float iridescenceIor = 1.3f;
    float iridescenceThicknessMinimum = 100.0f;
    float iridescenceThicknessMaximum = 400.0f;
    TextureRef iridescenceThicknessTexture;
    float dispersion = 0.0f;  // KHR_materials_dispersion: 20 / Abbe number of the medium
    // KHR_materials_diffuse_transmission: share of the diffuse light that passes to the other side, and its
    // color.
    float diffuseTransmissionFactor = 0.0f;
    TextureRef diffuseTransmissionTexture;  // alpha
    glm::vec3 diffuseTransmissionColorFactor{1.0f};
    TextureRef diffuseTransmissionColorTexture;  // sRGB
    float retroreflectionFactor = 0.0f;  // KHR_materials_retroreflection: share of the facets' reflection
    TextureRef retroreflectionTexture;   // that goes back to where the light came from; r.
    // KHR_materials_volume_scatter: the medium's albedo by multiple scattering, and the mean cosine of the
    // scattering angle.
    glm::vec3 multiscatterColorFactor{0.0f};
    float scatterAnisotropy = 0.0f;
    // KHR_materials_scatter, which replaces the former. Of a medium, its albedo is strength * color, without
    // textures. A surface that bounds none scatters this share of what it would transmit: half of it to each
    // side, or (1 + mean cosine) / 2 to the other one.
    float scatterStrengthFactor = 0.0f;
    TextureRef scatterStrengthTexture;  // alpha
    glm::vec3 scatterColorFactor{1.0f};
    TextureRef scatterColorTexture;  // sRGB
    float scatterMeanCosine = 0.0f;
    // KHR_materials_pbrSpecularGlossiness: roughness is 1 - glossiness, which the alpha of
    // specularColorTexture scales: 1 - (1 - roughnessFactor) * alpha. Everything else of the extension is
    // said by the fields above: its specular color is the reflection of an infinite ior (0) times
    // specularColor, and metallicFactor is 0. The importer leaves no texture of metallicRoughness and
    // specular.
    bool isSpecularGlossiness = false;
    // Where media of closed surfaces overlap, the one of higher priority is present. Not glTF's: a whole
    // number `priority` in the material's `extras`.
    uint32_t priority = 0;
    // True: where the environment is hidden (passes::TraceSettings), the camera sees only the shadow on the
    // surface, which is horizontal (shaders/integrator/shadow_catcher.glsl). No file has it: see GroundUnder.
    bool isShadowCatcher = false;

    // Returns the textures whose texels are directions in the tangent frame. A primitive's tangents are
    // generated along the coordinates of the first of these whose set it has. Anisotropy without any such
    // texture needs a frame, too: an absent texture that reads the first set then stands for it.
    std::vector<TextureRef> DirectionalTextures() const;
    bool IsAnisotropic() const { return anisotropyStrength > 0.0f; }
    // Returns the emitted radiance before the texture. An unlit material emits its base color instead.
    glm::vec3 EmittedRadiance() const {
        return isUnlit ? glm::vec3(0.0f) : emissiveFactor * emissiveStrength;
    }
    // Returns whether the material transmits light, so that back faces count as much as front faces.
    bool IsTransmissive() const { return transmissionFactor > 0.0f || diffuseTransmissionFactor > 0.0f; }
    bool BoundsMedium() const { return IsTransmissive() && thicknessFactor > 0.0f; }
    // Returns the extinction coefficient of the medium, 1/m: exp(-extinction d) of the light passes d meters.
    // At most kMaxExtinction, which an attenuationColor of 0 means.
    glm::vec3 Extinction() const;
    // Returns the scattering coefficient, from the color of multiple scattering; the rest of the extinction
    // is absorption.
    glm::vec3 Scattering() const;
    // Returns the mean cosine of the scattering angle, from the same extension as Scattering.
    float ScatteringMeanCosine() const;
    // Returns whether back faces are culled for all rays (glTF 2.0, 3.9.5).
    bool IsBackCulled() const { return !isDoubleSided && !IsTransmissive(); }

    static constexpr float kMaxExtinction = 1e9f;
    static constexpr float kMaxFilm = 1e5f;                 // nm: far above where a film has any color.
    static constexpr float kMaxScatterAnisotropy = 0.999f;  // a beam hardly wider than no scattering at all
    static constexpr float kMaxIor = 1e4f;  // a mirror to four digits, and its square far from a float's end
};

enum class WrapMode : uint8_t { Repeat, MirroredRepeat, ClampToEdge };
enum class FilterMode : uint8_t { Nearest, Linear };

struct Sampler {
    WrapMode wrapU = WrapMode::Repeat;
    WrapMode wrapV = WrapMode::Repeat;
    FilterMode magFilter = FilterMode::Linear;
    FilterMode minFilter = FilterMode::Linear;
    FilterMode mipFilter = FilterMode::Linear;  // between levels; meaningless without `usesMips`
    bool usesMips = true;

    bool operator==(const Sampler&) const = default;
};

enum class ColorSpace : uint8_t {
    Linear,  // data: normals, roughness, occlusion
    Srgb,    // Color: decode r, g and b by the sRGB curve when sampled; alpha is linear.
};

// Describes an image, how to sample it and how to read its values. An image used both as color and as data
// gives two textures.
struct Texture {
    std::string name;
    uint32_t image = 0;  // index into SceneData::images
    Sampler sampler;
    ColorSpace colorSpace = ColorSpace::Linear;
};

// Describes a decoded image: 8-bit RGBA, rows from the top, tightly packed: rgba.size() == 4 * width *
// height. Alpha is not premultiplied. The textures that use it say whether rgb is sRGB or linear.
struct ImageData {
    std::string name;
    uint32_t width = 0;
    uint32_t height = 0;
    std::vector<uint8_t> rgba;
    // These texels as blocks that GPUs read, if the file has them, with the smaller levels of the file.
    image::BlockLevels blocks = {};
    // LowestAlpha() of rgba, which the importer has computed where it decoded: who changes rgba resets this.
    std::optional<uint8_t> lowestAlpha = {};
    std::string file = {};  // its path from the scene's folder; "": the scene file or a buffer has it
};

// A node of the scene graph. Its index is the file's node index, so that animation and editing can name it.
struct RAYGRAPH_API Node {
    std::string name;
    uint32_t parent = kNone;
    // Local transform: `matrix` if the file gave one, else translation * rotation * scale.
    glm::vec3 translation{0.0f};
    glm::vec3 translationResidual{0.0f};         // the part that `translation`, or the matrix's, loses by
                                                 // rounding
    glm::quat rotation{1.0f, 0.0f, 0.0f, 0.0f};  // w, x, y, z; unit length
    glm::vec3 scale{1.0f};
    std::optional<glm::mat4x3> matrix;
    uint32_t mesh = kNone;
    // KHR_node_visibility. False: meshes and lights of the node and of all below it are neither seen nor
    // shine (VisibleNodes).
    bool isVisible = true;
    uint32_t skin = kNone;       // index into SceneData::skins: what deforms its mesh
    std::vector<float> weights;  // weights of its mesh's morph targets; empty: Mesh::weights

    // Returns the transform from node space to parent space.
    glm::mat4x3 LocalTransform() const;
};

// Describes one placed mesh: that of a node, or one of those that the node has placed by
// EXT_mesh_gpu_instancing. The transform may mirror (negative determinant): the winding seen in world space
// is then reversed, but the front stays the front. So take the geometric normal in object space and carry it
// over by the inverse transpose (which keeps sides), or cross the world-space edges and multiply by -1 if
// IsMirrored(). If the scene's nodes are flat, the transform has a thickness (transforms.h). LoadGltf leaves
// out a node whose mesh is scaled to nothing or to a line, with a warning.
struct Instance {
    uint32_t mesh = 0;
    uint32_t node = kNone;  // the node that placed it; kNone for one without a node
    glm::mat4x3 objectToWorld{1.0f};
    glm::vec3 translationResidual{0.0f};
    glm::mat4x3 objectToNode{1.0f};  // Moves with the node. The identity without EXT_mesh_gpu_instancing.
    // True if its vertices are drawn deformed, by the skin and the weights of its node
    // (renderer/scene/animation/deform.h, which says what objectToWorld then is); false: in their base shape,
    // where the node is.
    bool isDeformed = false;
    // The instance is not seen now, but may be at another time: it is scaled to nothing or to a line, or its
    // deformation is not finite. If scaled so, objectToWorld is that of another time or any invertible one.
    bool isCollapsed = false;

    bool IsMirrored() const { return glm::determinant(glm::mat3(objectToWorld)) < 0.0f; }
};

enum class Projection : uint8_t { Perspective, Orthographic };

// Describes a camera placed by a node; one per node that refers to a camera.
struct Camera {
    std::string name;  // The camera's, else the node's; may be empty.
    uint32_t node = kNone;
    Projection projection = Projection::Perspective;
    float yFov = 0.8f;         // perspective: full vertical angle, radians
    float aspectRatio = 0.0f;  // perspective: width over height the author had in mind; 0 = not given
    float xMag = 1.0f;         // orthographic: half the width of the view, meters
    float yMag = 1.0f;         // orthographic: half the height of the view, meters
    float zNear = 0.0f;        // Meters. Kept for raster views.
    float zFar = 0.0f;         // meters; 0 = infinite
    glm::mat4x3 cameraToWorld{1.0f};
    glm::vec3 translationResidual{0.0f};
};

// The notes are glTF's names.
#define RAYGRAPH_LIGHT_TYPES(X, Of)                     \
    X(Of, Directional, 0, "directional", "directional") \
    X(Of, Point, 1, "point", "point")                   \
    X(Of, Spot, 2, "spot", "spot")
RAYGRAPH_CHOICE(LightType, RAYGRAPH_LIGHT_TYPES)

// Describes a light of KHR_lights_punctual placed by a node, along the node's -z where it has a direction; or
// one of EXT_lights_ies: a point light with a profile, whose axes are those of the node.
struct Light {
    std::string name;  // The light's, else the node's; may be empty.
    uint32_t node = kNone;
    LightType type = LightType::Point;
    glm::vec3 color{1.0f};  // linear
    // Point and spot: cd. Directional: lx. The values are used as they are, see the README. A light with a
    // profile multiplies it with this factor.
    float intensity = 1.0f;
    float range = 0.0f;           // Meters; 0 = infinite. A hint for raster views, no part of the physics.
    float innerConeAngle = 0.0f;  // spot: radians from the axis, full intensity within
    float outerConeAngle = 0.785398163f;  // spot: radians from the axis, nothing outside
    uint32_t profile = kNone;             // index into SceneData::profiles, of a point light
    glm::mat4x3 lightToWorld{1.0f};
    glm::vec3 translationResidual{0.0f};

    bool operator==(const Light&) const = default;
};

// Holds the light from infinity that a scene brings along (EXT_lights_image_based), turned and scaled.
struct EnvironmentLight {
    std::string name;
    uint32_t faceSize = 0;  // texels a side of the file's cube map
    image::ImageF map;      // as GpuScene::SetEnvironmentMap takes it; empty: none

    bool IsPresent() const { return !map.rgba.empty(); }
};

struct SceneData {
    std::string name;
    std::vector<Mesh> meshes;
    std::vector<Material> materials;  // One more than the file has if a primitive names none: glTF's default.
    std::vector<Texture> textures;    // only those that materials use
    std::vector<ImageData> images;    // only those that textures use
    std::vector<Node> nodes;          // all of the file's nodes, in the file's order
    std::vector<uint32_t> nodeOrder;  // the nodes of the loaded scene, every parent before its children
    std::vector<std::vector<uint32_t>> otherScenes;  // the roots of each other scene of the file
    // One per node of `nodeOrder` whose mesh has a primitive, in that order; those of a node with
    // EXT_mesh_gpu_instancing are neighbors. One that is scaled to nothing or to a line is left out when
    // loading, with a warning.
    std::vector<Instance> instances;
    std::vector<Camera> cameras;  // those placed in the loaded scene, by the file's camera index
    // The lights placed in the loaded scene, by the file's light index; then those with a profile, by its
    // index.
    std::vector<Light> lights;
    std::vector<LightProfile> profiles;  // only those that lights use
    EnvironmentLight environment;
    Bounds bounds;                      // world space, of all visible instances
    std::vector<std::string> warnings;  // One line each: what was skipped or repaired while loading.
    std::vector<std::string> variants;  // KHR_materials_variants: their names, in the file's order
    uint32_t variant = kNone;           // the one shown (renderer/scene/model/variants.h)
    std::vector<Skin> skins;            // all of the file's, in the file's order
    std::vector<Animation> animations;  // Likewise. They are no part of what is shown: pose.h applies them.
};

// Describes a transform whose translation has the digits of a double: matrix[3] + rest.
struct RAYGRAPH_API PlacedTransform {
    glm::mat4x3 matrix{1.0f};
    glm::vec3 rest{0.0f};

    glm::dvec3 Place() const { return glm::dvec3(matrix[3]) + glm::dvec3(rest); }
    // Returns the transform relative to `origin`, rounded once.
    glm::mat4x3 RelativeTo(const glm::dvec3& origin) const;

    bool operator==(const PlacedTransform&) const = default;
};

// Returns the transform `a` after `b`, with the translation computed in double.
RAYGRAPH_API PlacedTransform Compose(const PlacedTransform& a, const PlacedTransform& b);

// Returns the transforms from node to world, one per entry of `scene.nodes`; identity for nodes outside
// `nodeOrder`. Linear time.
RAYGRAPH_API std::vector<PlacedTransform> WorldTransforms(const SceneData& scene);

// Returns the transform from object to world of an instance of a node with this transform.
RAYGRAPH_API PlacedTransform PlaceInstance(const PlacedTransform& nodeToWorld, const Instance& instance);

// Recomputes the transforms of instances, cameras and lights, and `bounds`, after nodes were moved. Of
// deformed instances as renderer/scene/animation/deform.h says, of flat ones as transforms.h does. A
// collapsed instance stays collapsed as long as it is scaled to nothing or to a line.
RAYGRAPH_API void UpdateWorldTransforms(SceneData& scene);

// Returns, for each entry of `scene.nodes`, whether the node and all above it are visible; true for nodes
// outside `nodeOrder`. Linear time.
RAYGRAPH_API std::vector<bool> VisibleNodes(const SceneData& scene);
// Returns the visibility of an object of this node; an object without a node (kNone) is visible.
inline bool IsVisible(const std::vector<bool>& visibleNodes, uint32_t node) {
    return node == kNone || visibleNodes[node];
}
inline bool IsVisible(const std::vector<bool>& visibleNodes, const Instance& instance) {
    return !instance.isCollapsed && IsVisible(visibleNodes, instance.node);
}

// Returns true if some placed and visible surface emits light; an unlit surface emits its base color.
RAYGRAPH_API bool HasEmission(const SceneData& scene);
// Returns true if some light is visible.
RAYGRAPH_API bool HasVisibleLight(const SceneData& scene);

// Returns the lowest of all texels' alpha, 0 to 255: what is known of the image, else by looking at each.
RAYGRAPH_API uint8_t LowestAlpha(const ImageData& image);

struct SceneStatistics {
    uint64_t uniqueTriangles = 0;  // Each mesh that is placed at least once counted once.
    uint64_t placedTriangles = 0;  // each instance counted
    uint64_t placedSpheres = 0;    // Likewise of round primitives: segments without length,
    uint64_t placedCapsules = 0;   // and the others
    uint64_t instanceCount = 0;
    uint64_t meshCount = 0;
    uint64_t materialCount = 0;
    uint64_t textureCount = 0;
    uint64_t lightCount = 0;
    uint64_t cameraCount = 0;
    uint64_t geometryBytes = 0;  // host bytes of all vertex and index streams
    uint64_t imageBytes = 0;     // host bytes of all decoded images
};
RAYGRAPH_API SceneStatistics Statistics(const SceneData& scene);

}  // namespace raygraph::scene
