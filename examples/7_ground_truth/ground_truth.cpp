// ground_truth SCENE [twice]: a renderer draws the base colors of a scene, and Verify says whether they are
// right, and what is off if they are not. With `twice` the renderer has a mistake: it encodes them in sRGB.
#include <cmath>
#include <cstdio>
#include <string_view>

#include "editor/session/verify/verify.h"
#include "renderer/scene/model/camera_view.h"

using namespace raygraph;  // NOLINT: an example

namespace {

constexpr Extent2D kSize{64, 48};
constexpr uint32_t kFiner = 8;  // each pixel is the mean of so many samples a side

// Stands for your renderer: a z-buffer, without clipping and textures.
std::vector<float> Draw(const scene::SceneData& scene) {
    const uint32_t width = kFiner * kSize.width, height = kFiner * kSize.height;
    const scene::CameraView view = scene::ChooseView(scene, "", float(width) / float(height));
    std::vector<float> nearest(size_t{width} * height, 0.0f);  // 1 / distance
    std::vector<glm::vec3> colors(nearest.size(), glm::vec3(0.0f));
    for (const scene::Instance& instance : scene.instances)
        for (const scene::Primitive& primitive : scene.meshes[instance.mesh].primitives) {
            std::vector<glm::vec3> screen;  // pixels, and 1 / distance
            for (const glm::vec3& position : primitive.positions) {
                const glm::vec3 p = instance.objectToWorld * glm::vec4(position, 1.0f) - glm::vec3(view.eye);
                const float z = glm::dot(p, view.forward), scale = 1.0f / (z * std::tan(0.5f * view.yFov));
                screen.emplace_back(
                    (0.5f + 0.5f * glm::dot(p, view.right) * scale / view.aspect) * float(width),
                    (0.5f - 0.5f * glm::dot(p, view.up) * scale) * float(height), 1.0f / z);
            }
            const auto area = [](const glm::vec2& a, const glm::vec2& b, const glm::vec2& c) {
                return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
            };
            for (size_t i = 0; i + 2 < primitive.indices.size(); i += 3) {
                const glm::vec3 a = screen[primitive.indices[i]], b = screen[primitive.indices[i + 1]],
                                c = screen[primitive.indices[i + 2]];
                const float whole = area(a, b, c);
                const glm::vec3 low = glm::min(glm::min(a, b), c), high = glm::max(glm::max(a, b), c);
                if (whole == 0.0f || low.z <= 0.0f) continue;
                for (auto y = uint32_t(std::max(low.y, 0.0f)); y < height && float(y) <= high.y; ++y)
                    for (auto x = uint32_t(std::max(low.x, 0.0f)); x < width && float(x) <= high.x; ++x) {
                        const glm::vec2 at(float(x) + 0.5f, float(y) + 0.5f);
                        const float u = area(at, b, c) / whole, v = area(a, at, c) / whole, w = 1.0f - u - v;
                        const float z = u * a.z + v * b.z + w * c.z;
                        if (u < 0.0f || v < 0.0f || w < 0.0f || z <= nearest[y * width + x]) continue;
                        nearest[y * width + x] = z;
                        colors[y * width + x] = scene.materials[primitive.material].baseColorFactor;
                    }
            }
        }
    std::vector<float> rgba(size_t{4} * kSize.width * kSize.height, 0.0f);
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x)
            for (int c = 0; c < 3; ++c)
                rgba[4 * (size_t{y / kFiner} * kSize.width + x / kFiner) + size_t(c)] +=
                    colors[y * width + x][c] / float(kFiner * kFiner);
    return rgba;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2) return 2;
    session::SceneInput scene = session::LoadInput(argv[1]);
    session::Picture picture{.name = "base colors", .size = kSize, .radiance = Draw(scene.data)};
    if (argc > 2 && std::string_view(argv[2]) == "twice")
        for (float& value : picture.radiance) value = session::Transfer().Encode(value);

    const auto device = rhi::Device::Create();  // any with Vulkan's ray tracing, as Mesa's on a CPU
    session::VerifyDesc desc{.settings = {.size = kSize, .view = session::View::Albedo}};
    desc.tolerance.pixels = 0.1;  // edges, where the renderer's filter is another one
    session::Verify verify(*device, std::move(scene), std::move(desc));
    const session::VerifyResult result = verify.Check(picture);
    for (const session::VerdictCheck& check : result.verdict.checks)
        std::printf("%s: %.4f, limit %.4f%s\n", check.name.c_str(), check.value, check.limit,
                    check.isPassed ? "" : " FAILED");
    for (const session::Hypothesis& hypothesis : result.diagnosis.hypotheses)
        std::printf("%.0f %%: %s\n", 100.0 * hypothesis.explained, hypothesis.text.c_str());
    std::puts(result.verdict.isRight ? "right" : "not right");
    return result.verdict.isRight ? 0 : 7;
}
