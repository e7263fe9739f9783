// Back faces of single-sided materials are culled for every ray, whatever the transform.
#include "tests/support/error_of.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::facing_test {

namespace {

scene::Material SingleSided(const glm::vec3& albedo, const glm::vec3& emission = glm::vec3(0.0f)) {
    scene::Material material = Lambert(albedo, emission);
    material.isDoubleSided = false;
    return material;
}

glm::mat4x3 Scaling(const glm::vec3& scale) {
    return {glm::vec3(scale.x, 0, 0), glm::vec3(0, scale.y, 0), glm::vec3(0, 0, scale.z), glm::vec3(0.0f)};
}

struct Sides {
    bool front = false;
    bool back = false;

    bool operator==(const Sides&) const = default;
};
void PrintTo(const Sides& sides, std::ostream* out) {
    *out << (sides.front ? "front" : "no front") << ", " << (sides.back ? "back" : "no back");
}
constexpr Sides kFront{true, false}, kBack{false, true}, kBoth{true, true};

class Facing : public VulkanTest {
  protected:
    // From where a quad that faces +z is seen: from +z (its front), from -z.
    Sides Seen(const scene::Material& material, const glm::mat4x3& transform = glm::mat4x3(1.0f)) {
        render.scene.SetScene(SceneOf({QuadMesh(1.0f)}, {material}, {transform}));
        return Seen();
    }
    Sides Seen() {
        const auto sees = [this](float z) {
            return render.PrimaryHits(LookAt({0, 0, z}, {0, 0, 0}, 0.1f, 1)).ids[0].x == 0u;
        };
        return {sees(3.0f), sees(-3.0f)};
    }

    // Radiance that leaves a floor of albedo 0.5 upwards in an environment of radiance `sky`, with a quad
    // parallel to it at half its own width above, whose front faces up or down.
    glm::dvec3 FloorBelow(const scene::Material& quad, bool facesUp, float sky) {
        const glm::vec3 z(0, 0, facesUp ? 1 : -1), x(facesUp ? 1 : -1, 0, 0);
        const glm::mat4x3 placed(x, glm::vec3(0, 1, 0), z, glm::vec3(0, 0, 1));  // a turn, no mirror
        render.scene.SetScene(SceneOf({QuadMesh(0.2f, 0), QuadMesh(1.0f, 1)},
                                      {SingleSided(glm::vec3(0.5f)), quad}, {glm::mat4x3(1.0f), placed}));
        render.scene.SetEnvironment({.radiance = glm::vec3(sky)});
        // From between the two
        return render.Render(LookAt({0, 0.05f, 0.9f}, {0, 0, 0}, 0.1f, 16), 64).mean.Mean();
    }

    SceneRender render{Device()};
};

}  // namespace

TEST_F(Facing, SingleSidedQuadIsSeenFromItsFrontAlone) {
    EXPECT_EQ(Seen(SingleSided(glm::vec3(0.5f))), kFront);
}

TEST_F(Facing, DoubleSidedQuadIsSeenFromBothSides) {
    EXPECT_EQ(Seen(Lambert(glm::vec3(0.5f))), kBoth);
}

TEST_F(Facing, MirroringTransformKeepsTheFront) {
    for (const glm::vec3 mirror : {glm::vec3(-1, 1, 1), glm::vec3(2, -0.5f, 1), glm::vec3(-1, -1, 1)}) {
        EXPECT_EQ(Seen(SingleSided(glm::vec3(0.5f)), Scaling(mirror)), kFront);
        EXPECT_EQ(Seen(Lambert(glm::vec3(0.5f)), Scaling(mirror)), kBoth);
    }
    // Mirrored along the normal, and turned round: what was the front faces -z
    EXPECT_EQ(Seen(SingleSided(glm::vec3(0.5f)), Scaling({1, 1, -1})), kBack);
    EXPECT_EQ(Seen(SingleSided(glm::vec3(0.5f)), Scaling({-1, 1, -1})), kBack);
}

TEST_F(Facing, TransformThatComesToMirrorKeepsTheFront) {
    ASSERT_EQ(Seen(SingleSided(glm::vec3(0.5f))), kFront);
    for (int frame = 0; frame < 8; ++frame) Seen();  // past compaction: the next change is an update
    render.scene.SetTransform(0, Scaling({-1, 1, 1}));
    EXPECT_EQ(Seen(), kFront);
    render.scene.SetTransform(0, Scaling({1, 1, -1}));
    EXPECT_EQ(Seen(), kBack);
}

// The edit takes a note; what it needs on the device belongs to the frame, which is dropped without it.
TEST_F(Facing, SidesThatChangeWhileMemoryIsSpent_AreThoseOfTheNextFrame) {
    ASSERT_EQ(Seen(SingleSided(glm::vec3(0.5f))), kFront);
    for (int frame = 0; frame < 8; ++frame) Seen();
    Device().WaitIdle();
    Device().LimitMemory(1);
    EXPECT_NO_THROW(render.scene.SetMaterial(0, Lambert(glm::vec3(0.5f))));
    EXPECT_EQ(ErrorOf([&] { Seen(); }).Kind(), ErrorKind::OutOfMemory);
    Device().LimitMemory(0);
    EXPECT_EQ(Seen(), kBoth);
}

TEST_F(Facing, SingleSidedMaskAndBlendAreCulledToo) {
    for (const scene::AlphaMode mode : {scene::AlphaMode::Mask, scene::AlphaMode::Blend}) {
        scene::Material material = SingleSided(glm::vec3(0.5f));
        material.alphaMode = mode;
        EXPECT_EQ(Seen(material), kFront);
        material.isDoubleSided = true;
        EXPECT_EQ(Seen(material), kBoth);
    }
}

TEST_F(Facing, MaterialsThatLightPassesHaveBothSides) {
    scene::Material glass = SingleSided(glm::vec3(1.0f));
    glass.transmissionFactor = 1.0f;
    EXPECT_EQ(Seen(glass), kBoth);
    glass.thicknessFactor = 1.0f;
    EXPECT_EQ(Seen(glass), kBoth);
    scene::Material opaque = SingleSided(glm::vec3(1.0f));
    opaque.thicknessFactor = 1.0f;
    EXPECT_EQ(Seen(opaque), kFront) << "a volume that no light enters";
}

TEST_F(Facing, BackOfASingleSidedSurfaceDoesNotShadow) {
    const double open = FloorBelow(SingleSided(glm::vec3(0.0f)), true, 1.0f).x;
    EXPECT_NEAR(open, 0.5, 1e-3) << "the floor sees the quad's back, which is not there";
    EXPECT_LT(FloorBelow(SingleSided(glm::vec3(0.0f)), false, 1.0f).x, 0.4) << "its front does shadow";
    EXPECT_LT(FloorBelow(Lambert(glm::vec3(0.0f)), true, 1.0f).x, 0.4) << "and so does a double-sided back";
}

TEST_F(Facing, BackOfASingleSidedSurfaceDoesNotEmit) {
    const glm::vec3 radiance(2.0f);
    EXPECT_EQ(FloorBelow(SingleSided(glm::vec3(0.0f), radiance), true, 0.0f).x, 0.0);
    const double lit = FloorBelow(SingleSided(glm::vec3(0.0f), radiance), false, 0.0f).x;
    EXPECT_GT(lit, 0.3);
    EXPECT_NEAR(FloorBelow(Lambert(glm::vec3(0.0f), radiance), true, 0.0f).x, lit, 0.05 * lit);
}

TEST_F(Facing, PrimitivesOfOneMeshAreGroupedByHowRaysTreatThem) {
    // Two of each kind, opaque or not, culled or not
    scene::Mesh mesh;
    std::vector<scene::Material> materials;
    for (uint32_t i = 0; i < 8; ++i) {
        scene::Material material = SingleSided(glm::vec3(0.1f * float(i + 1)));
        material.isDoubleSided = (i & 1) != 0;
        material.alphaMode = (i & 2) != 0 ? scene::AlphaMode::Mask : scene::AlphaMode::Opaque;
        materials.push_back(material);
        mesh.primitives.push_back(QuadMesh(0.4f, i).primitives[0]);
        if (i & 2) {  // alpha has to be looked at: a corner is a hole
            mesh.primitives.back().colors.assign(4, glm::vec4(1.0f));
            mesh.primitives.back().colors[3].a = 0.0f;
        }
        for (glm::vec3& position : mesh.primitives.back().positions) position.x += float(i);
        mesh.primitives.back().bounds.min.x += float(i);
        mesh.primitives.back().bounds.max.x += float(i);
    }
    render.scene.SetScene(SceneOf({mesh}, materials));
    for (uint32_t i = 0; i < 8; ++i)
        for (const float side : {1.0f, -1.0f}) {
            const glm::vec3 center(float(i), 0, 0);
            const SceneRender::Hits hits =
                render.PrimaryHits(LookAt(center + glm::vec3(0, 0, side), center, 0.1f, 1));
            const bool isSeen = side > 0.0f || (i & 1) != 0;
            EXPECT_EQ(hits.ids[0].y, isSeen ? i : 0xFFFFFFFFu) << "material " << i << " from " << side;
        }
    EXPECT_EQ(render.scene.Statistics().blasCount, 4u);
}

TEST_F(Facing, AlphaThatLetsNothingThroughCostsNoGroup) {
    const auto groups = [this](const scene::Material& second, float vertexAlpha = 1.0f) {
        scene::Mesh mesh = QuadMesh(0.3f, 0);
        mesh.primitives.push_back(QuadMesh(0.5f, 1).primitives[0]);
        mesh.primitives[1].colors.assign(4, glm::vec4(1.0f, 0.5f, 1.0f, vertexAlpha));
        render.scene.SetScene(SceneOf({mesh}, {SingleSided(glm::vec3(0.5f)), second}));
        Seen();
        return render.scene.Statistics().blasCount;
    };
    scene::Material material = SingleSided(glm::vec3(0.5f));
    material.alphaMode = scene::AlphaMode::Blend;
    EXPECT_EQ(groups(material), 1u);
    EXPECT_EQ(groups(material, 0.99f), 2u) << "vertices have alpha";
    material.baseColorFactor.a = 0.99f;
    EXPECT_EQ(groups(material), 2u);
    material.alphaMode = scene::AlphaMode::Mask;
    EXPECT_EQ(groups(material), 1u) << "above the cutoff of 0.5";
    material.baseColorFactor.a = 0.5f;
    EXPECT_EQ(groups(material), 1u) << "at the cutoff";
    material.baseColorFactor.a = 0.49f;
    EXPECT_EQ(groups(material), 2u);
}

}  // namespace raygraph::testing::facing_test
