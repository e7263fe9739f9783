#include "tests/support/direct_light_reference.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace raygraph::test {

namespace {

constexpr double kOffSurface = 1e-6;  // meters; rays that start on a surface do not meet it

int64_t Wrapped(int64_t texel, int64_t size, scene::WrapMode mode) {
    if (mode == scene::WrapMode::ClampToEdge) return std::clamp<int64_t>(texel, 0, size - 1);
    const int64_t period = mode == scene::WrapMode::MirroredRepeat ? 2 * size : size;
    const int64_t within = (texel % period + period) % period;
    return within < size ? within : period - 1 - within;
}

glm::dvec4 Texel(const scene::ImageData& image, scene::ColorSpace space, int64_t column, int64_t row) {
    glm::dvec4 value;
    for (int channel = 0; channel < 4; ++channel) {
        const size_t index = 4 * (static_cast<size_t>(row) * image.width + static_cast<size_t>(column)) +
                             static_cast<size_t>(channel);
        const double stored = image.rgba[index] / 255.0;
        value[channel] = space == scene::ColorSpace::Srgb && channel < 3 ? DecodeSrgb(stored) : stored;
    }
    return value;
}

glm::dvec3 Normalized(const glm::dvec3& v) {
    return v / std::sqrt(glm::dot(v, v));
}

}  // namespace

double DecodeSrgb(double encoded) {
    return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

glm::dvec4 ReadTexture(const scene::SceneData& scene, uint32_t texture, const glm::dvec2& uv) {
    const scene::Texture& source = scene.textures.at(texture);
    const scene::ImageData& image = scene.images.at(source.image);
    const int64_t width = image.width, height = image.height;
    // Texel (i, j) covers i <= x < i + 1 and j <= y < j + 1
    const double x = uv.x * static_cast<double>(width), y = uv.y * static_cast<double>(height);
    const auto at = [&](double column, double row) {
        return Texel(image, source.colorSpace,
                     Wrapped(static_cast<int64_t>(column), width, source.sampler.wrapU),
                     Wrapped(static_cast<int64_t>(row), height, source.sampler.wrapV));
    };
    if (source.sampler.magFilter == scene::FilterMode::Nearest) return at(std::floor(x), std::floor(y));
    const double left = std::floor(x - 0.5), top = std::floor(y - 0.5);
    const double s = x - 0.5 - left, t = y - 0.5 - top;
    return (1.0 - t) * ((1.0 - s) * at(left, top) + s * at(left + 1.0, top)) +
           t * ((1.0 - s) * at(left, top + 1.0) + s * at(left + 1.0, top + 1.0));
}

DirectLightReference::DirectLightReference(const scene::SceneData& scene) : m_scene(scene) {
    for (const scene::Instance& instance : scene.instances)
        for (const scene::Primitive& primitive : scene.meshes.at(instance.mesh).primitives)
            AddPrimitive(primitive, instance.objectToWorld);
    for (const scene::Light& light : scene.lights) {
        if (light.type != scene::LightType::Directional) continue;
        m_suns.push_back({.toLight = Normalized(glm::dvec3(light.lightToWorld[2])),
                          .illuminance = glm::dvec3(light.color) * static_cast<double>(light.intensity)});
    }
}

void DirectLightReference::AddPrimitive(const scene::Primitive& primitive, const glm::mat4x3& objectToWorld) {
    const glm::dmat4x3 toWorld(objectToWorld);
    const bool isMirrored = glm::determinant(glm::dmat3(toWorld)) < 0.0;
    for (size_t i = 0; i + 2 < primitive.indices.size(); i += 3) {
        Triangle triangle;
        triangle.material = &m_scene.materials.at(primitive.material);
        for (size_t corner = 0; corner < 3; ++corner) {
            const uint32_t vertex = primitive.indices[i + corner];
            triangle.corners[corner] = toWorld * glm::dvec4(glm::dvec3(primitive.positions[vertex]), 1.0);
            if (!primitive.uv0.empty()) triangle.uv[0][corner] = primitive.uv0[vertex];
            if (!primitive.uv1.empty()) triangle.uv[1][corner] = primitive.uv1[vertex];
            if (!primitive.colors.empty()) triangle.colors[corner] = primitive.colors[vertex];
        }
        triangle.normal = Normalized(
            glm::cross(triangle.corners[1] - triangle.corners[0], triangle.corners[2] - triangle.corners[0]));
        if (isMirrored) triangle.normal = -triangle.normal;
        m_triangles.push_back(triangle);
    }
}

std::vector<DirectLightReference::Crossing> DirectLightReference::Crossings(
    const glm::dvec3& origin, const glm::dvec3& direction) const {
    std::vector<Crossing> crossings;
    for (const Triangle& triangle : m_triangles) {
        const double slope = glm::dot(triangle.normal, direction);
        if (slope == 0.0 || (slope > 0.0 && !triangle.material->isDoubleSided)) continue;
        const double distance = glm::dot(triangle.normal, triangle.corners[0] - origin) / slope;
        if (distance < kOffSurface) continue;
        // Weights as shares of the triangle's area
        const glm::dvec3 place = origin + distance * direction;
        glm::dvec3 weights;
        for (int i = 0; i < 3; ++i) {
            const glm::dvec3& from = triangle.corners[(i + 1) % 3];
            const glm::dvec3& to = triangle.corners[(i + 2) % 3];
            weights[i] = glm::dot(glm::cross(to - from, place - from), triangle.normal);
        }
        const double area = weights.x + weights.y + weights.z;
        weights /= area;
        if (weights.x < 0.0 || weights.y < 0.0 || weights.z < 0.0) continue;
        Crossing crossing{distance, weights, &triangle, 1.0};
        crossing.opacity = OpacityAt(crossing);
        if (crossing.opacity > 0.0) crossings.push_back(crossing);
    }
    std::sort(crossings.begin(), crossings.end(),
              [](const Crossing& a, const Crossing& b) { return a.distance < b.distance; });
    return crossings;
}

glm::dvec4 DirectLightReference::TextureAt(const scene::TextureRef& reference,
                                           const Crossing& crossing) const {
    if (!reference.IsPresent()) return glm::dvec4(1.0);
    const glm::dvec2* uv = crossing.triangle->uv[reference.texCoord];
    return ReadTexture(m_scene, static_cast<uint32_t>(reference.texture),
                       crossing.weights.x * uv[0] + crossing.weights.y * uv[1] + crossing.weights.z * uv[2]);
}

glm::dvec4 DirectLightReference::BaseColorAt(const Crossing& crossing) const {
    const glm::dvec4* colors = crossing.triangle->colors;
    const scene::Material& material = *crossing.triangle->material;
    return glm::dvec4(material.baseColorFactor) * TextureAt(material.baseColorTexture, crossing) *
           (crossing.weights.x * colors[0] + crossing.weights.y * colors[1] + crossing.weights.z * colors[2]);
}

double DirectLightReference::OpacityAt(const Crossing& crossing) const {
    const scene::Material& material = *crossing.triangle->material;
    if (material.alphaMode == scene::AlphaMode::Opaque) return 1.0;
    const double alpha = BaseColorAt(crossing).w;
    if (material.alphaMode == scene::AlphaMode::Blend) return alpha;
    return alpha >= static_cast<double>(material.alphaCutoff) ? 1.0 : 0.0;
}

glm::dvec3 DirectLightReference::RadianceOf(const Crossing& crossing, const glm::dvec3& place,
                                            const glm::dvec3& direction) const {
    const scene::Material& material = *crossing.triangle->material;
    glm::dvec3 radiance = glm::dvec3(material.emissiveFactor) *
                          static_cast<double>(material.emissiveStrength) *
                          glm::dvec3(TextureAt(material.emissiveTexture, crossing));
    const glm::dvec3& front = crossing.triangle->normal;
    const glm::dvec3 normal = glm::dot(front, direction) < 0.0 ? front : -front;
    for (const Sun& sun : m_suns) {
        const double cosine = glm::dot(normal, sun.toLight);
        if (cosine <= 0.0) continue;
        double passed = 1.0;
        for (const Crossing& blocker : Crossings(place, sun.toLight)) passed *= 1.0 - blocker.opacity;
        radiance +=
            passed * cosine * std::numbers::inv_pi * sun.illuminance * glm::dvec3(BaseColorAt(crossing));
    }
    return radiance;
}

glm::dvec4 DirectLightReference::Along(const glm::dvec3& origin, const glm::dvec3& direction) const {
    glm::dvec3 radiance(0.0);
    double passed = 1.0;
    for (const Crossing& crossing : Crossings(origin, direction)) {
        radiance += passed * crossing.opacity *
                    RadianceOf(crossing, origin + crossing.distance * direction, direction);
        passed *= 1.0 - crossing.opacity;
        if (passed == 0.0) break;
    }
    return {radiance, 1.0 - passed};
}

std::vector<glm::dvec4> DirectLightReference::Picture(const scene::CameraView& camera, uint32_t width,
                                                      uint32_t height, uint32_t raysAcross) const {
    const bool isPerspective = camera.projection == scene::Projection::Perspective;
    const double halfHeight = isPerspective ? std::tan(0.5 * static_cast<double>(camera.yFov))
                                            : 0.5 * static_cast<double>(camera.height);
    const glm::dvec3 right = halfHeight * static_cast<double>(camera.aspect) * glm::dvec3(camera.right);
    const glm::dvec3 up = halfHeight * glm::dvec3(camera.up), forward(camera.forward), eye(camera.eye);
    std::vector<glm::dvec4> pixels;
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x) {
            glm::dvec4 sum(0.0);
            for (uint32_t i = 0; i < raysAcross * raysAcross; ++i) {
                const double column = x + (i % raysAcross + 0.5) / raysAcross;
                const double row = y + (i / raysAcross + 0.5) / raysAcross;
                const glm::dvec3 offset =
                    (2.0 * column / width - 1.0) * right + (1.0 - 2.0 * row / height) * up;
                sum += isPerspective ? Along(eye, Normalized(forward + offset))
                                     : Along(eye + offset, Normalized(forward));
            }
            pixels.push_back(sum / static_cast<double>(raysAcross * raysAcross));
        }
    return pixels;
}

}  // namespace raygraph::test
