// Materials that change in a shown scene so that rays come to treat their surfaces in another way.
#include "tests/viewport/viewport_test.h"

namespace raygraph::testing::material_edit_test {

namespace {

class ViewportMaterialEdit : public VulkanTest {
  protected:
    // A floor with a box in the light of a sun and a bulb, and a mesh of two one-sided walls of which the
    // first is between the camera and the box, and between box and bulb, its back to the camera.
    static scene::SceneData Room(const scene::Material& wall) {
        scene::Material chalk = Lambert({0.8f, 0.7f, 0.5f}), other = chalk;
        chalk.metallicFactor = chalk.specularFactor = 0.0f;
        other.isDoubleSided = false;
        scene::Mesh walls = QuadMesh(0.6f, 1);
        scene::Primitive second = QuadMesh(0.6f, 2).primitives[0];
        for (glm::vec3& position : second.positions) position.z -= 0.5f;
        second.bounds.min.z -= 0.5f;
        second.bounds.max.z -= 0.5f;
        walls.primitives.push_back(std::move(second));
        const glm::mat4x3 flat({1, 0, 0}, {0, 0, -1}, {0, 1, 0}, {0, -1, 0});
        const glm::mat4x3 upright({0, 0, 1}, {0, 1, 0}, {1, 0, 0}, {-0.2f, -0.4f, 0});
        scene::SceneData data = SceneOf({QuadMesh(3.0f, 0), BoxMesh(0.3f, 0), std::move(walls)},
                                        {chalk, wall, other}, {flat, Translation({0.4f, -0.7f, 0}), upright});
        scene::Light sun, bulb;
        sun.type = scene::LightType::Directional;
        sun.lightToWorld = {{1, 0, 0}, {0, 0, -1}, {0, 1, 0}, {0, 0, 0}};
        bulb.intensity = 0.5f;
        bulb.lightToWorld = Translation({-0.7f, 0.3f, 0.2f});
        data.lights = {sun, bulb};
        return data;
    }
    static scene::Material Wall() {
        scene::Material wall = Lambert(glm::vec3(0.4f));
        wall.isDoubleSided = false;
        return wall;
    }
    static scene::Material Pane() {
        scene::Material pane;
        pane.baseColorFactor = {0.5f, 0.8f, 0.9f, 1.0f};
        pane.metallicFactor = pane.roughnessFactor = 0.0f;
        pane.transmissionFactor = 1.0f;
        return pane;
    }
    static scene::Material Veil() {
        scene::Material veil = Wall();
        veil.alphaMode = scene::AlphaMode::Blend;
        veil.baseColorFactor.a = 0.5f;
        return veil;
    }
    static void Prepare(ViewedScene& viewed, View view) {
        viewport::PathSettings paths = viewed.viewport.Paths();
        paths.scattering.brdf = BrdfModel::Gltf;
        viewed.viewport.SetPaths(paths);
        passes::RasterSettings raster = PlainRaster();
        raster.shadows = passes::RasterShadows::Rays;
        viewed.viewport.SetRaster(raster);
        viewed.viewport.SetBudget({});  // no limit, which compiling shaders on a CPU device could exceed
        viewed.viewport.SetView(view);
    }
};

}  // namespace

TEST_F(ViewportMaterialEdit, AnEditedWall_IsAsInASceneThatHasItSo) {
    for (const View view : {View::PathTraced, View::Raster}) {
        ViewedScene edited(Device(), {24, 16}, Room(Wall()));
        Prepare(edited, view);
        edited.RenderFrames(2);
        std::vector<uint8_t> last = edited.Picture();
        for (const scene::Material& material : {Veil(), Pane(), Wall()}) {
            SCOPED_TRACE(std::string(viewport::Name(view)) + ", alpha mode " +
                         std::to_string(int(material.alphaMode)) + ", transmission " +
                         std::to_string(material.transmissionFactor));
            edited.scene.SetMaterial(1, material);
            edited.RenderFrames(3);
            const std::vector<uint8_t> picture = edited.Picture();
            // Which rays a veil stops hangs on the numbers of its triangles
            if (material.alphaMode == scene::AlphaMode::Opaque) {
                ViewedScene fresh(Device(), {24, 16}, Room(material));
                Prepare(fresh, view);
                fresh.RenderFrames(3);
                EXPECT_EQ(picture, fresh.Picture());
            }
            EXPECT_NE(picture, last) << "the edit does not show";
            last = picture;
        }
    }
}

}  // namespace raygraph::testing::material_edit_test
