#include "renderer/gpu_scene/lights/emitters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "base/check.h"
#include "renderer/gpu_scene/materials/texture_plan.h"
#include "renderer/scene/model/scene_fields.h"

namespace raygraph {

namespace {

// Small meshes may read more texels of their texture each triangle.
constexpr uint32_t kFewTriangles = 1024, kManyCuts = 32, kFewCuts = 6;
// Replaces an estimate of 0 where the texture is not black, so that a light keeps some importance.
constexpr float kMinMean = 1e-4f;

bool IsEmission(const scene::AnimationTarget& target) {
    if (target.property != scene::AnimatedProperty::MaterialField) return false;
    uint8_t index = 0;
    bool isEmission = false;
    scene::ForEachMaterialField([&](const auto& field) {
        const std::string_view name = field.name;
        isEmission |= index++ == target.field && (name == "emissiveFactor" || name == "emissiveStrength");
    });
    return isEmission;
}

// By material: tells whether an animation changes how much it emits.
std::vector<bool> AnimatedEmission(const scene::SceneData& scene) {
    std::vector<bool> isAnimated(scene.materials.size());
    for (const scene::Animation& animation : scene.animations)
        for (const scene::AnimationChannel& channel : animation.channels)
            if (IsEmission(channel.target)) isAnimated[channel.target.object] = true;
    return isAnimated;
}

// Returns the texels along one axis, as two ranges, that a sampler may read for coordinates between low and
// high.
std::array<glm::uvec2, 2> TexelRanges(float low, float high, uint32_t size, scene::WrapMode mode) {
    const glm::uvec2 none(0, 0);
    constexpr double kFar = 1e15;
    const glm::uvec2 all(0, size);
    const double begin = std::floor(double{low} * size - 0.5),
                 last = std::floor(double{high} * size - 0.5) + 1.0;
    if (!(begin > -kFar && last < kFar)) return {all, none};
    const bool isClamped = mode == scene::WrapMode::ClampToEdge;
    if (!isClamped && last - begin + 1.0 >= size) return {all, none};
    const uint32_t a = WrapTexel(static_cast<int64_t>(begin), size, mode);
    const uint32_t b = WrapTexel(static_cast<int64_t>(last), size, mode);
    const double fold = std::floor(last / size);  // the edge that is crossed, if any
    if (isClamped || std::floor(begin / size) == fold)
        return {glm::uvec2(std::min(a, b), std::max(a, b) + 1), none};
    if (mode == scene::WrapMode::Repeat) return {glm::uvec2(0, b + 1), glm::uvec2(a, size)};
    const bool isAtZero = std::fmod(fold, 2.0) == 0.0;
    return {isAtZero ? glm::uvec2(0, std::max(a, b) + 1) : glm::uvec2(std::min(a, b), size), none};
}

}  // namespace

uint32_t EmitterFinder::LitTexels::Count(uint32_t width, glm::uvec2 begin, glm::uvec2 end) const {
    const size_t stride = size_t{width} + 1;
    // The sums wrap modulo 2^32, which is more than any count
    return sums[end.y * stride + end.x] - sums[begin.y * stride + end.x] - sums[end.y * stride + begin.x] +
           sums[begin.y * stride + begin.x];
}

const EmitterFinder::LitTexels& EmitterFinder::LitTexelsOf(uint32_t image) {
    const auto [found, isNew] = m_litTexels.try_emplace(image);
    if (!isNew) return found->second;
    const scene::ImageData& data = m_scene.images[image];
    std::vector<uint32_t>& sums = found->second.sums;
    const size_t stride = size_t{data.width} + 1;
    sums.assign(stride * (size_t{data.height} + 1), 0);
    for (uint32_t y = 0; y < data.height; ++y) {
        uint32_t inRow = 0;
        for (uint32_t x = 0; x < data.width; ++x) {
            const uint8_t* rgba = &data.rgba[4 * (size_t{y} * data.width + x)];
            inRow += (rgba[0] | rgba[1] | rgba[2]) != 0;
            sums[(y + size_t{1}) * stride + x + 1] = sums[y * stride + x + 1] + inRow;
        }
    }
    return found->second;
}

glm::vec3 EmitterFinder::Mean(const scene::Texture& texture, const glm::vec2 (&uv)[3], uint32_t maxCuts) {
    const scene::ImageData& image = m_scene.images[texture.image];
    const glm::vec2 low = glm::min(uv[0], glm::min(uv[1], uv[2]));
    const glm::vec2 high = glm::max(uv[0], glm::max(uv[1], uv[2]));
    const LitTexels& litTexels = LitTexelsOf(texture.image);
    uint32_t litCount = 0;
    for (const glm::uvec2& columns : TexelRanges(low.x, high.x, image.width, texture.sampler.wrapU))
        for (const glm::uvec2& rows : TexelRanges(low.y, high.y, image.height, texture.sampler.wrapV))
            litCount += litTexels.Count(image.width, {columns.x, rows.x}, {columns.y, rows.y});
    if (litCount == 0) return glm::vec3(0.0f);

    // Samples one point in the middle of each of cuts^2 equal triangles, about as many as there are texels
    const glm::vec2 size(image.width, image.height);
    const glm::vec2 a = (uv[1] - uv[0]) * size, b = (uv[2] - uv[0]) * size;
    const float texels = 0.5f * std::abs(a.x * b.y - a.y * b.x);
    const float wanted = std::ceil(std::sqrt(texels));
    const auto cuts =
        wanted < static_cast<float>(maxCuts) ? std::max(static_cast<uint32_t>(wanted), 2u) : maxCuts;
    glm::vec3 sum(0.0f);
    const auto add = [&](float i, float j) {
        sum += glm::vec3(
            LookUp(texture, image, uv[0] + (i * (uv[1] - uv[0]) + j * (uv[2] - uv[0])) / float(cuts)));
    };
    for (uint32_t i = 0; i < cuts; ++i)
        for (uint32_t j = 0; i + j < cuts; ++j) {
            add(float(i) + 1.0f / 3.0f, float(j) + 1.0f / 3.0f);
            if (i + j + 1 < cuts) add(float(i) + 2.0f / 3.0f, float(j) + 2.0f / 3.0f);
        }
    return glm::max(sum / float(cuts * cuts), glm::vec3(kMinMean));
}

EmitterFinder::EmitterFinder(const scene::SceneData& scene)
    : m_scene(scene), m_isAnimated(AnimatedEmission(scene)) {}

std::vector<EmitterFinder::Candidate> EmitterFinder::CandidatesOf(const scene::Primitive& primitive) const {
    std::vector<uint32_t> materials{primitive.material};
    for (const scene::VariantMaterial& variant : primitive.variants) materials.push_back(variant.material);
    std::sort(materials.begin() + 1, materials.end());
    materials.erase(std::unique(materials.begin() + 1, materials.end()), materials.end());
    std::vector<Candidate> candidates;
    for (const uint32_t index : materials) {
        if (!candidates.empty() && index == primitive.material) continue;
        const scene::Material& material = m_scene.materials[index];
        candidates.push_back({.material = index,
                              .mayEmit = m_isAnimated[index] || material.emissiveTexture.IsPresent() ||
                                         material.EmittedRadiance() != glm::vec3(0.0f),
                              .toTexture = material.emissiveTexture.transform.Matrix()});
    }
    return candidates;
}

bool EmitterFinder::MayEmit(const scene::Primitive& primitive) const {
    return std::ranges::any_of(CandidatesOf(primitive), &Candidate::mayEmit);
}

void Enclosure::Add(const glm::vec3& p0, const glm::vec3& p1, const glm::vec3& p2) {
    const glm::dvec3 area =
        0.5 * glm::cross(glm::dvec3(p1) - glm::dvec3(p0), glm::dvec3(p2) - glm::dvec3(p0));
    m_areas += area;
    m_area += glm::length(area);
    m_volume += glm::dot(glm::dvec3(p0) - m_center, area) / 3.0;
    const glm::vec3 sizes = glm::abs(p0);
    m_farthest = std::max({m_farthest, double{sizes.x}, double{sizes.y}, double{sizes.z}});
}

Enclosure Enclosure::Of(const scene::Mesh& mesh) {
    scene::Bounds bounds;
    for (const scene::Primitive& primitive : mesh.primitives) {
        bounds.min = glm::min(bounds.min, primitive.bounds.min);
        bounds.max = glm::max(bounds.max, primitive.bounds.max);
    }
    Enclosure result(bounds.IsEmpty() ? glm::dvec3(0.0) : glm::dvec3(bounds.Center()));
    for (const scene::Primitive& primitive : mesh.primitives) {
        if (primitive.IsRound()) continue;
        const auto at = [&](size_t corner) { return primitive.positions[primitive.indices[corner]]; };
        for (size_t i = 0; i + 2 < primitive.indices.size(); i += 3) result.Add(at(i), at(i + 1), at(i + 2));
    }
    return result;
}

Enclosure Enclosure::Of(std::span<const glm::vec3> corners) {
    glm::dvec3 sum(0.0);
    for (const glm::vec3& corner : corners) sum += glm::dvec3(corner);
    Enclosure result(sum / std::max(1.0, static_cast<double>(corners.size())));
    for (size_t i = 0; i + 2 < corners.size(); i += 3) result.Add(corners[i], corners[i + 1], corners[i + 2]);
    return result;
}

double Enclosure::Fullness() const {
    const double volume = std::abs(m_volume), size = std::sqrt(m_area);
    const double rounding = 1e-6 * size + 0x1p-23 * m_farthest;
    return volume > rounding * m_area ? volume / (size * m_area) : 0.0;
}

bool Enclosure::IsClosed() const {
    constexpr double kAbout = 0.1;
    return glm::length(m_areas) <= kAbout * m_area && Fullness() > 0.0;
}

glm::vec3 EmitterFinder::MeanTexture(const Candidate& candidate, const scene::Primitive& primitive,
                                     const uint32_t (&vertices)[3], uint32_t maxCuts) {
    const scene::TextureRef& reference = m_scene.materials[candidate.material].emissiveTexture;
    if (!reference.IsPresent()) return glm::vec3(1.0f);
    const std::vector<glm::vec2>& stream = reference.texCoord == 1 ? primitive.uv1 : primitive.uv0;
    glm::vec2 uv[3]{};
    if (!stream.empty())
        for (size_t i = 0; i < 3; ++i) uv[i] = stream[vertices[i]];
    for (glm::vec2& place : uv) place = candidate.toTexture * glm::vec3(place, 1.0f);
    return Mean(m_scene.textures[static_cast<size_t>(reference.texture)], uv, maxCuts);
}

EmitterLists EmitterFinder::Find(const GroupTriangles& triangles,
                                 std::span<const scene::Primitive* const> primitives, bool isDoubleSided) {
    EmitterLists found;
    std::vector<std::vector<Candidate>> candidatesOf;  // by primitive; empty: it never emits
    bool hasEmitter = false;
    for (const scene::Primitive* primitive : primitives) {
        candidatesOf.push_back(CandidatesOf(*primitive));
        if (std::ranges::none_of(candidatesOf.back(), &Candidate::mayEmit)) candidatesOf.back().clear();
        hasEmitter |= !candidatesOf.back().empty();
    }
    if (!hasEmitter) return found;
    const size_t triangleCount = triangles.indices.size() / 3;
    const uint32_t maxCuts = triangleCount <= kFewTriangles ? kManyCuts : kFewCuts;
    for (uint32_t triangle = 0; triangle < triangleCount; ++triangle) {
        const uint32_t part = triangles.geometries.empty() ? 0 : triangles.geometries[triangle];
        const std::vector<Candidate>& candidates = candidatesOf[part];
        if (candidates.empty()) continue;
        const uint32_t* corners = &triangles.indices[size_t{3} * triangle];
        const uint32_t firstVertex = triangles.firstVertices[part];
        const uint32_t vertices[3] = {corners[0] - firstVertex, corners[1] - firstVertex,
                                      corners[2] - firstVertex};
        const auto index = static_cast<uint32_t>(found.emitters.size());
        const size_t variantCount = found.variants.size();
        bool isLit = false;
        glm::vec3 shownMean(1.0f);
        for (const Candidate& candidate : candidates) {
            const glm::vec3 mean = MeanTexture(candidate, *primitives[part], vertices, maxCuts);
            if (&candidate == &candidates.front()) shownMean = mean;
            isLit |= candidate.mayEmit && mean != glm::vec3(0.0f);
            if (candidates.size() > 1) found.variants.push_back({index, part, candidate.material, mean});
        }
        if (!isLit) {
            found.variants.resize(variantCount);
            continue;
        }
        found.emitters.push_back({.p0 = triangles.positions[corners[0]],
                                  .p1 = triangles.positions[corners[1]],
                                  .p2 = triangles.positions[corners[2]],
                                  .primitive = triangle,
                                  .material = candidates.front().material,
                                  .isDoubleSided = isDoubleSided,
                                  .meanTexture = shownMean});
    }
    return found;
}

std::vector<uint32_t> TriangleLights(std::span<const Emitter> emitters, size_t triangleCount) {
    if (emitters.empty()) return {};
    std::vector<uint32_t> lights(triangleCount, gpu::kNoLight);
    for (uint32_t i = 0; i < emitters.size(); ++i) lights[emitters[i].primitive] = i;
    return lights;
}

}  // namespace raygraph
