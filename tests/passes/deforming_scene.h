// A sheet that a chain of joints bends and morph targets push, with a clip that moves them; and what the CPU
// makes of it.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>
#include <vector>

#include "passes/raster.h"
#include "renderer/scene/animation/deform.h"
#include "renderer/scene/animation/pose.h"
#include "renderer/scene/geometry/round_primitives.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing {

struct SheetOptions {
    uint32_t influences = 2;  // of each vertex; 0: no skin
    uint32_t targets = 0;
    bool isFlat = false;
    glm::uvec2 cells{6, 24};
};

// 1 wide, 4 high, in the xy plane, facing +z.
inline scene::Mesh Sheet(const SheetOptions& options, uint32_t material = 0) {
    scene::Mesh mesh;
    scene::Primitive& sheet = mesh.primitives.emplace_back();
    sheet.material = material;
    const auto at = [&](uint32_t x, uint32_t y) {
        const float u = float(x) / float(options.cells.x), v = float(y) / float(options.cells.y);
        return glm::vec3(u - 0.5f, 4.0f * v, 0.1f * std::sin(9.0f * u + 5.0f * v));
    };
    const auto add = [&](uint32_t x, uint32_t y) {
        sheet.positions.push_back(at(x, y));
        sheet.normals.push_back(glm::normalize(glm::vec3(0.1f * float(x), -0.05f, 1.0f)));
        sheet.tangents.push_back(glm::vec4(glm::normalize(glm::vec3(1.0f, 0.02f * float(y), 0.0f)), -1.0f));
        sheet.uv0.push_back(glm::vec2(x, y));
        return uint32_t(sheet.positions.size() - 1);
    };
    for (uint32_t y = 0; y < options.cells.y; ++y)
        for (uint32_t x = 0; x < options.cells.x; ++x)
            for (const auto& [i, j] : {std::pair{0u, 0u}, {1u, 0u}, {1u, 1u}, {0u, 0u}, {1u, 1u}, {0u, 1u}})
                sheet.indices.push_back(add(x + i, y + j));
    sheet.hasFlatNormals = options.isFlat;
    const size_t count = sheet.positions.size();
    sheet.bounds = scene::BoundsOf(sheet.positions);
    sheet.influences.perVertex = options.influences;
    for (size_t i = 0; i < count && options.influences > 0; ++i) {
        std::vector<std::pair<float, uint16_t>> near;
        for (uint16_t joint = 0; joint < 4; ++joint)
            near.push_back({std::exp(-2.0f * std::abs(sheet.positions[i].y - float(joint))), joint});
        for (uint16_t joint = 4; joint < options.influences; ++joint)
            near.push_back({0.01f, uint16_t(joint - 4)});
        std::ranges::sort(near, std::greater());
        near.resize(options.influences);
        float sum = 0.0f;
        for (const auto& [weight, joint] : near) sum += weight;
        for (const auto& [weight, joint] : near) {
            sheet.influences.joints.push_back(joint);
            sheet.influences.weights.push_back(weight / sum);
        }
    }
    for (uint32_t t = 0; t < options.targets; ++t) {
        scene::MorphTarget& target = sheet.targets.emplace_back();
        for (const glm::vec3& p : sheet.positions) {
            target.positions.push_back({0.0f, 0.1f * std::sin(float(t) + p.y), 0.3f * std::cos(p.x * p.y)});
            if (t == 0) continue;  // one without normals and tangents
            target.normals.push_back({0.2f * p.x, 0.1f * p.y, 0.0f});
            if (!sheet.tangents.empty()) target.tangents.push_back({0.0f, 0.3f * p.x, 0.2f});
        }
    }
    mesh.weights.assign(options.targets, 0.0f);
    scene::UpdateDeformationBounds(sheet);
    return mesh;
}

// One instance of the sheet. Nodes 0 to 3 are the joints, a chain along +y; node 4 has the mesh. Clip 0, one
// second long, bends the chain and sets the weights.
inline scene::SceneData SheetScene(const SheetOptions& options,
                                   const scene::Material& material = Lambert(glm::vec3(0.5f))) {
    scene::SceneData scene = SceneOf({Sheet(options)}, {material});
    scene.nodes.resize(5);
    scene.nodeOrder = {0, 1, 2, 3, 4};
    scene.instances[0].node = 4;
    scene.nodes[4].mesh = 0;
    scene::Animation& clip = scene.animations.emplace_back();
    clip.duration = 1.0f;
    const auto animate = [&](scene::AnimatedProperty property, uint32_t node, std::vector<float> values) {
        scene::AnimationSampler& sampler = clip.samplers.emplace_back();
        sampler.times = {0.0f, 0.5f, 1.0f};
        sampler.width = uint32_t(values.size() / 3);
        sampler.values = std::move(values);
        clip.channels.push_back({uint32_t(clip.samplers.size() - 1), {.property = property, .object = node}});
    };
    if (options.influences > 0) {
        scene::Skin& skin = scene.skins.emplace_back();
        scene.nodes[4].skin = 0;
        for (uint32_t joint = 0; joint < 4; ++joint) {
            if (joint > 0) {
                scene.nodes[joint].parent = joint - 1;
                scene.nodes[joint].translation = {0, 1, 0};
            }
            skin.joints.push_back(joint);
            skin.inverseBinds.push_back(Translation({0, -float(joint), 0}));
            const float s = std::sin(0.35f), c = std::cos(0.35f);
            if (joint > 0)
                animate(scene::AnimatedProperty::Rotation, joint,
                        {0, 0, 0, 1, joint % 2 ? s : 0.0f, joint % 2 ? 0.0f : s, 0, c, 0, 0, -s, c});
        }
    }
    if (options.targets > 0) {
        std::vector<float> weights(3 * options.targets);
        for (size_t i = options.targets; i < weights.size(); ++i) weights[i] = 0.3f * float(i) - 0.5f;
        animate(scene::AnimatedProperty::Weights, 4, std::move(weights));
    }
    scene::DeformInstances(scene);
    return scene;
}

// A scene that moves by its first clip: the full one, posed on the CPU.
class PosedScene {
  public:
    explicit PosedScene(scene::SceneData data) : scene(std::move(data)), m_evaluator(scene), applier(scene) {}

    const scene::PoseChanges& MoveTo(double seconds, uint32_t clip = 0) {
        return applier.Apply(scene, m_evaluator.Evaluate(scene, std::array{scene::ClipState{clip, seconds}}));
    }
    scene::DeformedStreams Streams(uint32_t instance = 0, uint32_t primitive = 0) const {
        scene::DeformedStreams streams;
        const scene::Instance& placed = scene.instances[instance];
        const scene::Primitive& shape = scene.meshes[placed.mesh].primitives[primitive];
        const uint32_t skin = scene.nodes[placed.node].skin;
        std::span<const float> weights = scene::MorphWeights(scene, placed);
        if (shape.targets.empty()) weights = {};
        scene::DeformPrimitive(shape, weights, applier.JointMatricesOf(skin), streams);
        return streams;
    }
    // The pose as a scene of its own that nothing deforms: each deformed instance has a mesh of its own.
    scene::SceneData Frozen() const {
        scene::SceneData frozen = scene;
        for (uint32_t i = 0; i < scene.instances.size(); ++i) {
            scene::Instance& instance = frozen.instances[i];
            if (!instance.isDeformed) continue;
            instance.mesh = static_cast<uint32_t>(frozen.meshes.size());
            scene::Mesh& mesh = frozen.meshes.emplace_back(scene.meshes[scene.instances[i].mesh]);
            for (uint32_t p = 0; p < mesh.primitives.size(); ++p) {
                scene::Primitive& primitive = mesh.primitives[p];
                scene::DeformedStreams streams = Streams(i, p);
                primitive.positions = std::move(streams.positions);
                primitive.normals = std::move(streams.normals);
                primitive.tangents = std::move(streams.tangents);
                primitive.influences = {};
                primitive.targets.clear();
                primitive.bounds = scene::BoundsOf(primitive.positions);
            }
            mesh.weights.clear();
            instance.isDeformed = false;
        }
        for (scene::Instance& instance : frozen.instances) instance.node = scene::kNone;
        for (scene::Light& light : frozen.lights) light.node = scene::kNone;
        frozen.nodes.clear();
        frozen.nodeOrder.clear();
        frozen.skins.clear();
        frozen.animations.clear();
        return frozen;
    }

    scene::SceneData scene;

  private:
    scene::PoseEvaluator m_evaluator;

  public:
    scene::PoseApplier applier;
};

}  // namespace raygraph::testing

// The fixture of tests of deforming meshes: what is on the device, and what the views see.
namespace raygraph::testing {

// All of the sheet, in every pose.
inline passes::TraceSettings Front(uint32_t size = 48) {
    return LookAt({0.5f, 2.5f, 9.0f}, {0, 2, 0}, 0.7f, size);
}

class DeformTest : public VulkanTest {
  protected:
    // The streams on the device, of each copy and of each of its groups that deforms: the positions of all
    // parts, then normals and tangents of one part after the other.
    using Group = std::vector<scene::DeformedStreams>;
    std::vector<Group> OnDevice(const std::vector<Group>& like) {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const Readback streams = render.renderer.ReadBack(ids.deformedStreams);
        render.renderer.Execute();
        streams.Wait();
        size_t offset = 0;
        const auto take = [&](auto& into) {
            using Value = typename std::remove_reference_t<decltype(into)>::value_type;
            into = As<Value>(streams.Bytes().subspan(offset, into.size() * sizeof(Value)));
            offset += into.size() * sizeof(Value);
        };
        const auto align = [&] { offset = (offset + 15) / 16 * 16; };
        std::vector<Group> result = like;
        for (Group& group : result) {
            for (scene::DeformedStreams& part : group) take(part.positions);
            align();
            for (scene::DeformedStreams& part : group) {
                take(part.normals);
                align();
                take(part.tangents);
                align();
            }
        }
        return result;
    }
    scene::DeformedStreams OnDevice(const scene::DeformedStreams& like) {
        return OnDevice(std::vector<Group>{{like}})[0][0];
    }
    static void ExpectNear(const scene::DeformedStreams& actual, const scene::DeformedStreams& expected) {
        constexpr float kSize = 4.0f;
        for (size_t i = 0; i < expected.positions.size(); ++i)
            ASSERT_LE(glm::length(actual.positions[i] - expected.positions[i]), 1e-5f * kSize) << i;
        for (size_t i = 0; i < expected.normals.size(); ++i)
            ASSERT_LE(glm::length(actual.normals[i] - expected.normals[i]), 2e-5f) << i;
        for (size_t i = 0; i < expected.tangents.size(); ++i)
            ASSERT_LE(glm::length(actual.tangents[i] - expected.tangents[i]), 2e-5f) << i;
    }
    void ExpectFormula(const SheetOptions& options) {
        PosedScene posed(SheetScene(options));
        scene::SceneData data = posed.scene;
        render.scene.SetScene(std::move(data));
        scene::DeformedStreams before = posed.Streams();
        ExpectNear(OnDevice(before), before);
        for (const double seconds : {0.2, 0.5, 0.9}) {
            SCOPED_TRACE(seconds);
            const scene::PoseChanges& changes = posed.MoveTo(seconds);
            render.scene.SetPose(posed.scene, posed.applier, changes);
            const scene::DeformedStreams expected = posed.Streams(), actual = OnDevice(posed.Streams());
            EXPECT_NE(expected.positions, before.positions);
            ExpectNear(actual, expected);
            for (size_t i = 0; i < actual.tangents.size() && (options.targets > 0 || options.isFlat); ++i)
                ASSERT_NEAR(glm::dot(glm::vec3(actual.tangents[i]), actual.normals[i]), 0.0f, 1e-5f) << i;
            before = expected;
        }
    }
    // Same surfaces at the same places.
    static void ExpectSameHits(const SceneRender::Hits& actual, const SceneRender::Hits& expected,
                               size_t edgePixels, float size = 4.0f) {
        size_t others = 0, surfaces = 0;
        for (size_t i = 0; i < expected.ids.size(); ++i) {
            if (glm::uvec3(actual.ids[i]) != glm::uvec3(expected.ids[i])) {  // but for the geometry's index
                ++others;
                continue;
            }
            if (expected.ids[i].x == 0xFFFFFFFFu) continue;
            ++surfaces;
            ASSERT_LE(glm::length(glm::vec3(actual.position.values[i] - expected.position.values[i])),
                      5e-5f * size)
                << i;
            ASSERT_LE(glm::length(glm::vec3(actual.normal.values[i] - expected.normal.values[i])), 1e-3f)
                << i;
        }
        EXPECT_LE(others, edgePixels);
        EXPECT_GT(surfaces, 50u);
    }
    SceneRender::Hits Drawn(const passes::TraceSettings& settings) {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const passes::RasterVisibility seen =
            passes::DrawVisibility(render.renderer, ids, settings, passes::FilmPosition::Center);
        return render.ReadHits(passes::RasterHits(render.renderer, ids, settings, seen));
    }

    SceneRender render{Device()};
};

}  // namespace raygraph::testing
