// Scenes that frames copy to the device beside the one that is shown.
#include "renderer/gpu_scene/streaming/scene_upload.h"

#include "tests/passes/scene_parts.h"
#include "tests/support/error_of.h"

namespace raygraph::testing::scene_upload_test {
namespace {

// Frames of 64 KiB.
class SceneUploads : public SceneParts {
  protected:
    SceneUploads() : SceneParts({.textureLevels = true, .streamBudget = 64u << 10}) {}

    // A square with a texture, and a sphere that takes many frames.
    static scene::SceneData Next() {
        scene::SceneData data = SquareOf(1, 1, true);
        const scene::SceneData large = SceneOf({SphereMesh(0.4f, 160)}, {Lambert(ColorOf(2))});
        data.meshes.push_back(large.meshes[0]);
        data.meshes.back().primitives[0].material = 1;
        data.materials.push_back(large.materials[0]);
        data.instances.push_back({.mesh = 1, .objectToWorld = Translation(PartPlace(2))});
        return data;
    }
};

}  // namespace

TEST_F(SceneUploads, OldSceneIsShownUntilTheNewOneIsSet) {
    const std::shared_ptr<SceneUpload> upload = render.scene.Upload(PreparedScene(Next()));
    std::vector<Cell> before(kCells);
    before[0] = {0, ColorOf(0)};
    float fraction = 0.0f;
    uint32_t frames = 0;
    for (; !upload->IsReady(); ++frames) {
        ASSERT_LT(frames, 1000u);
        EXPECT_EQ(Seen(), before);
        EXPECT_GE(upload->Fraction(), fraction);
        fraction = upload->Fraction();
        EXPECT_FALSE(render.scene.IsSettled() && !upload->IsReady());
    }
    EXPECT_GT(frames, 20u);
    EXPECT_EQ(upload->Fraction(), 1.0f);
    Seen();  // and builds the last of its structures
    const uint64_t builds = render.scene.Statistics().blasBuilds;
    render.scene.SetScene(*upload);
    std::vector<Cell> after(kCells);
    after[1] = {0, ColorOf(1)};
    after[2] = {1, ColorOf(2)};
    EXPECT_EQ(Seen(), after);
    EXPECT_EQ(render.scene.Statistics().blasBuilds, builds) << "they were built before";
    EXPECT_EQ(ErrorTextOf([&] { render.scene.SetScene(*upload); }),
              "GpuScene: SetScene: the scene has been set before");
    EXPECT_EQ(Seen(), after);
}

TEST_F(SceneUploads, WhatIsLeftIsCopiedAtOnce) {
    for (const int frames : {0, 3}) {
        const std::shared_ptr<SceneUpload> upload = render.scene.Upload(PreparedScene(Next()));
        for (int frame = 0; frame < frames; ++frame) Seen();
        EXPECT_FALSE(upload->IsReady());
        render.scene.SetScene(*upload);
        EXPECT_EQ(Seen()[2], (Cell{1, ColorOf(2)}));
    }
}

TEST_F(SceneUploads, WithoutAnOwnerItStops) {
    Seen();
    Device().WaitIdle();
    const uint64_t before = Device().Memory().usedBytes;
    std::shared_ptr<SceneUpload> upload = render.scene.Upload(PreparedScene(Next()));
    const std::shared_ptr<SceneUpload> other = render.scene.Upload(PreparedScene(SquareOf(4, 4, true)));
    for (int frame = 0; frame < 1000 && upload->Fraction() == 0.0f; ++frame) Seen();
    EXPECT_FALSE(upload->IsReady());
    EXPECT_FALSE(other->IsReady()) << "one after the other";
    upload.reset();
    for (int frame = 0; frame < 10'000 && !other->IsReady(); ++frame) Seen();
    EXPECT_TRUE(other->IsReady());
    render.scene.SetScene(*other);
    EXPECT_EQ(Seen()[4], (Cell{0, ColorOf(4)}));
    Device().WaitIdle();
    Device().CollectGarbage();
    // Staging memory stays
    EXPECT_LT(Device().Memory().usedBytes, before + (1u << 20));
}

TEST_F(SceneUploads, OneThatDoesNotFitIsRefusedWhenItIsSet) {
    const std::shared_ptr<SceneUpload> upload = render.scene.Upload(PreparedScene(Next()));
    Seen();
    Device().WaitIdle();
    Device().LimitMemory(Device().Memory().usedBytes + (1u << 20));
    for (int frame = 0; frame < 10'000 && !upload->IsReady(); ++frame) EXPECT_NO_THROW(Seen());
    EXPECT_TRUE(upload->IsReady());
    Device().LimitMemory(0);
    EXPECT_NE(ErrorTextOf([&] { render.scene.SetScene(*upload); }, ErrorKind::OutOfMemory), "accepted");
    EXPECT_EQ(Seen()[0], (Cell{0, ColorOf(0)}));
}

}  // namespace raygraph::testing::scene_upload_test
