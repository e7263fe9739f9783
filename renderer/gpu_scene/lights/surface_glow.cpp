#include "renderer/gpu_scene/lights/surface_glow.h"

#include <algorithm>
#include <cmath>

#include "renderer/gpu_scene/lights/emitters.h"
#include "renderer/gpu_scene/materials/texture_plan.h"

namespace raygraph {

namespace {

constexpr size_t kFacetsOfBar = 12;
// The bits of a corner's index: 1 and 2 select the sides, 4 the end.
constexpr uint8_t kFaces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                  {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};

// Returns the corners of a facet of a bar.
glm::uvec3 CornersOf(size_t facet) {
    const auto& face = kFaces[facet / 2];
    return facet % 2 == 0 ? glm::uvec3(face[0], face[1], face[2]) : glm::uvec3(face[0], face[2], face[3]);
}

// Appends a square bar around each capsule, or a cube around a sphere.
void AppendBars(const scene::Primitive& primitive, const Facet& like, std::vector<Facet>& facets) {
    for (size_t i = 0; i < primitive.radii.size(); ++i) {
        const glm::vec3 a = primitive.positions[primitive.indices[2 * i]];
        const glm::vec3 b = primitive.positions[primitive.indices[2 * i + 1]];
        const float radius = primitive.radii[i], length = glm::distance(a, b);
        const glm::vec3 axis = length > 0.0f ? (b - a) / length : glm::vec3(0.0f, 0.0f, 1.0f);
        const glm::vec3 other = std::abs(axis.x) < 0.5f ? glm::vec3(1.0f, 0.0f, 0.0f) : glm::vec3(0, 1, 0);
        const glm::vec3 u = radius * glm::normalize(glm::cross(axis, other)), v = glm::cross(axis, u);
        glm::vec3 corners[8];
        for (uint32_t c = 0; c < 8; ++c)
            corners[c] = ((c & 4u) != 0 ? b + radius * axis : a - radius * axis) + ((c & 1u) != 0 ? u : -u) +
                         ((c & 2u) != 0 ? v : -v);
        for (size_t f = 0; f < kFacetsOfBar; ++f) {
            const glm::uvec3 cornerIds = CornersOf(f);
            Facet facet = like;
            facet.p0 = corners[cornerIds.x];
            facet.p1 = corners[cornerIds.y];
            facet.p2 = corners[cornerIds.z];
            facets.push_back(facet);
        }
    }
}

template <typename T>
T WeightedSum(const std::vector<T>& values, const uint32_t (&vertices)[3], const glm::vec3& weights) {
    return weights.x * values[vertices[0]] + weights.y * values[vertices[1]] +
           weights.z * values[vertices[2]];
}

}  // namespace

SurfaceGlow::SurfaceGlow(const scene::SceneData& scene)
    : m_scene(scene), m_pose(FindBrightestPose(scene)), m_firstFacets(scene.meshes.size()) {}

bool SurfaceGlow::MayGlow(const scene::Primitive& primitive) const {
    return m_pose.emission[primitive.material] != glm::vec3(0.0f) ||
           m_pose.unlitColors[primitive.material] != glm::vec3(0.0f);
}

bool SurfaceGlow::MayGlow(const scene::Mesh& mesh) const {
    return std::ranges::any_of(mesh.primitives, [&](const auto& primitive) { return MayGlow(primitive); });
}

bool SurfaceGlow::IsAny() const {
    return m_pose.hasLight || std::ranges::any_of(m_scene.instances, [&](const scene::Instance& instance) {
               return scene::IsVisible(m_pose.visibleNodes, instance) &&
                      MayGlow(m_scene.meshes[instance.mesh]);
           });
}

std::vector<Facet> SurfaceGlow::AddMesh(uint32_t mesh) {
    std::vector<Facet> facets;
    std::vector<uint32_t>& firsts = m_firstFacets[mesh];
    firsts.assign(1, 0);
    for (const scene::Primitive& primitive : m_scene.meshes[mesh].primitives) {
        const scene::Material& material = m_scene.materials[primitive.material];
        const bool isLeftOut = material.IsTransmissive() && !MayGlow(primitive);
        Facet facet{.isBackCulled = !primitive.IsRound() && material.IsBackCulled(),
                    .isTested = material.alphaMode != scene::AlphaMode::Opaque};
        if (!isLeftOut && primitive.IsRound()) AppendBars(primitive, facet, facets);
        if (!isLeftOut && !primitive.IsRound())
            for (size_t i = 0; i + 2 < primitive.indices.size(); i += 3) {
                facet.p0 = primitive.positions[primitive.indices[i]];
                facet.p1 = primitive.positions[primitive.indices[i + 1]];
                facet.p2 = primitive.positions[primitive.indices[i + 2]];
                facets.push_back(facet);
            }
        firsts.push_back(static_cast<uint32_t>(facets.size()));
    }
    return facets;
}

const scene::Primitive& SurfaceGlow::PrimitiveOf(uint32_t mesh, uint32_t facet, uint32_t& first) const {
    const std::vector<uint32_t>& firsts = m_firstFacets[mesh];
    const auto next = std::ranges::upper_bound(firsts, facet);
    first = *(next - 1);
    return m_scene.meshes[mesh].primitives[static_cast<size_t>(next - 1 - firsts.begin())];
}

SurfaceGlow::Place SurfaceGlow::At(uint32_t mesh, uint32_t facet, const glm::vec2& barycentrics) const {
    uint32_t first = 0;
    Place place{.primitive = &PrimitiveOf(mesh, facet, first)};
    place.weights = {1.0f - barycentrics.x - barycentrics.y, barycentrics.x, barycentrics.y};
    const size_t cornerIds = facet - first;
    const std::vector<uint32_t>& indices = place.primitive->indices;
    const glm::uvec3 corners = CornersOf(cornerIds % kFacetsOfBar);
    for (uint32_t c = 0; c < 3; ++c)
        place.vertices[c] =
            place.primitive->IsRound()
                ? indices[2 * (cornerIds / kFacetsOfBar) + ((corners[static_cast<int>(c)] & 4u) != 0)]
                : indices[3 * cornerIds + c];
    return place;
}

glm::vec4 SurfaceGlow::Read(const scene::TextureRef& reference, const Place& place) const {
    if (!reference.IsPresent()) return glm::vec4(1.0f);
    const scene::Texture& texture = m_scene.textures[static_cast<size_t>(reference.texture)];
    const std::vector<glm::vec2>& stream =
        reference.texCoord == 1 ? place.primitive->uv1 : place.primitive->uv0;
    const glm::vec2 uv =
        stream.empty() ? glm::vec2(0.0f) : WeightedSum(stream, place.vertices, place.weights);
    return LookUp(texture, m_scene.images[texture.image], reference.transform.Matrix() * glm::vec3(uv, 1.0f));
}

glm::vec4 SurfaceGlow::BaseTexture(const scene::Material& material, const Place& place) const {
    const std::vector<glm::vec4>& colors = place.primitive->colors;
    const glm::vec4 color = Read(material.baseColorTexture, place);
    return colors.empty() ? color : color * WeightedSum(colors, place.vertices, place.weights);
}

float SurfaceGlow::LuminanceAt(uint32_t mesh, uint32_t facet, const glm::vec2& barycentrics) const {
    uint32_t first = 0;
    const uint32_t index = PrimitiveOf(mesh, facet, first).material;
    const glm::vec3 &emission = m_pose.emission[index], &unlit = m_pose.unlitColors[index];
    if (emission == glm::vec3(0.0f) && unlit == glm::vec3(0.0f)) return 0.0f;
    const scene::Material& material = m_scene.materials[index];
    const Place place = At(mesh, facet, barycentrics);
    const glm::vec3 radiance = material.isUnlit ? unlit * glm::vec3(BaseTexture(material, place))
                                                : emission * glm::vec3(Read(material.emissiveTexture, place));
    return static_cast<float>(Luminance(radiance));
}

float SurfaceGlow::OpacityAt(uint32_t mesh, uint32_t facet, const glm::vec2& barycentrics) const {
    uint32_t first = 0;
    const scene::Material& material = m_scene.materials[PrimitiveOf(mesh, facet, first).material];
    if (material.alphaMode == scene::AlphaMode::Opaque) return 1.0f;
    const Place place = At(mesh, facet, barycentrics);
    const float alpha = material.baseColorFactor.w * BaseTexture(material, place).w;
    if (material.alphaMode == scene::AlphaMode::Mask) return alpha >= material.alphaCutoff ? 1.0f : 0.0f;
    return alpha;
}

bool SurfaceGlow::IsUnlit(uint32_t mesh, uint32_t facet) const {
    uint32_t first = 0;
    return m_scene.materials[PrimitiveOf(mesh, facet, first).material].isUnlit;
}

std::vector<float> SurfaceGlow::EmittedMeans(uint32_t mesh, size_t facetCount, EmitterFinder& finder) const {
    std::vector<float> means(facetCount, 0.0f);
    const std::vector<scene::Primitive>& primitives = m_scene.meshes[mesh].primitives;
    for (size_t i = 0; i < primitives.size(); ++i) {
        const scene::Primitive& primitive = primitives[i];
        const glm::vec3& emission = m_pose.emission[primitive.material];
        const size_t first = m_firstFacets[mesh][i], end = m_firstFacets[mesh][i + 1];
        if (emission == glm::vec3(0.0f) || first == end) continue;
        const scene::Material& material = m_scene.materials[primitive.material];
        if (primitive.IsRound() || !material.emissiveTexture.IsPresent()) {
            std::fill(means.begin() + static_cast<ptrdiff_t>(first),
                      means.begin() + static_cast<ptrdiff_t>(end), static_cast<float>(Luminance(emission)));
            continue;
        }
        const GroupTriangles triangles{.positions = primitive.positions,
                                       .indices = primitive.indices,
                                       .geometries = {},
                                       .originals = {},
                                       .firstVertices = {0}};
        const scene::Primitive* const only = &primitive;
        for (const Emitter& emitter : finder.Find(triangles, {&only, 1}, material.isDoubleSided).emitters)
            means[first + emitter.primitive] = static_cast<float>(Luminance(emission * emitter.meanTexture));
    }
    return means;
}

}  // namespace raygraph
