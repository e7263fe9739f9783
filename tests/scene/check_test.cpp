// Check rejects scenes that break its contract; lists of a material's fields.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <glm/gtc/constants.hpp>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <type_traits>
#include <vector>

#include "base/error.h"
#include "renderer/scene/animation/deform.h"
#include "renderer/scene/geometry/round_primitives.h"
#include "renderer/scene/gltf/choice_names.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/gltf/save_gltf.h"
#include "renderer/scene/model/check.h"
#include "renderer/scene/model/scene_fields.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/error_of.h"
#include "tests/support/source_file.h"
#include "tests/support/temporary_folder.h"

// Check: which scenes are valid, and the messages for those that are not.
namespace raygraph::scene::check_test {
namespace {

using testing::ErrorTextOf;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

// One of everything.
SceneData Whole() {
    SceneData scene;
    Primitive triangle;
    triangle.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    triangle.normals = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
    triangle.uv0 = {{0, 0}, {1, 0}, {0, 1}};
    triangle.indices = {0, 1, 2};
    triangle.bounds = BoundsOf(triangle.positions);
    scene.meshes.push_back({.name = "triangle", .primitives = {triangle}});
    scene.images.push_back({.name = "texel", .width = 1, .height = 1, .rgba = {1, 2, 3, 4}});
    scene.textures.emplace_back();
    scene.materials.emplace_back().baseColorTexture.texture = 0;
    scene.nodes.resize(2);
    scene.nodes[0].mesh = 0;
    scene.nodes[1].parent = 0;
    scene.nodeOrder = {0, 1};
    scene.instances.push_back({.mesh = 0, .node = 0});
    scene.cameras.emplace_back().node = 1;
    scene.lights.emplace_back().node = 1;
    scene.lights.back().type = LightType::Spot;
    UpdateWorldTransforms(scene);
    return scene;
}

// Makes a scene with a joint, a morph target and an animation of the second node.
SceneData Moving() {
    SceneData scene = Whole();
    Primitive& primitive = scene.meshes[0].primitives[0];
    primitive.influences = {2, {0, 1, 0, 0, 1, 0}, {0.5f, 0.5f, 1, 0, 1, 0}, {}};
    primitive.targets.resize(1);
    primitive.targets[0].positions = {{0, 0, 1}, {0, 0, 2}, {0, 0, 3}};
    UpdateDeformationBounds(primitive);
    scene.meshes[0].weights = {0.5f};
    scene.skins.push_back({.name = "", .joints = {1, 0}, .inverseBinds = {2, glm::mat4x3(1.0f)}});
    scene.nodes[0].skin = 0;
    Animation& animation = scene.animations.emplace_back();
    animation.samplers.push_back({.width = 4, .times = {0, 2}, .values = {0, 0, 0, 1, 1, 0, 0, 0}});
    animation.channels.push_back({0, {.property = AnimatedProperty::Rotation, .object = 1}});
    animation.duration = 2.0f;
    return scene;
}

// One capsule of this radius, within the bounds if it is small.
void MakeRound(SceneData& scene, float radius) {
    Primitive& primitive = scene.meshes[0].primitives[0];
    primitive.normals.clear();
    primitive.indices = {0, 1};
    primitive.radii = {radius};
    if (radius < 1.0f) primitive.bounds = {glm::vec3(-1.0f), glm::vec3(2.0f)};
}

TEST(Check, AcceptsWhatIsWholeAndWhatIsEmpty) {
    SceneData round = Whole();
    MakeRound(round, 0.5f);
    EXPECT_NO_THROW(Check(round));
    EXPECT_NO_THROW(Check(Whole()));
    EXPECT_NO_THROW(Check(Moving()));
    EXPECT_NO_THROW(Check(SceneData{}));
    EXPECT_NO_THROW(Check(LoadGltf(test::SourceFile("scenes/cornell.gltf"))));
}

TEST(Check, NamesTheObjectAndWhatItHolds) {
    const struct {
        void (*change)(SceneData&);
        const char* message;
    } rows[] = {
        {[](SceneData& s) { s.meshes[0].primitives[0].positions[1].y = kNan; },
         "meshes[0].primitives[0]: positions[1] is not finite"},
        {[](SceneData& s) { s.meshes[0].primitives[0].normals.pop_back(); },
         "meshes[0].primitives[0]: normals has 2 elements for 3 positions"},
        {[](SceneData& s) { s.meshes[0].primitives[0].indices[2] = 3; },
         "meshes[0].primitives[0]: indices[2] is 3, but positions has 3 elements"},
        {[](SceneData& s) { s.meshes[0].primitives[0].indices.push_back(0); },
         "meshes[0].primitives[0]: 4 indices are no whole triangles"},
        {[](SceneData& s) { s.meshes[0].primitives[0].radii = {1.0f}; },
         "meshes[0].primitives[0]: 3 indices of 1 round primitive, must be two each"},
        {[](SceneData& s) { MakeRound(s, 0.0f); },
         "meshes[0].primitives[0]: radii[0] is 0, must be 1e-09 to 1e+09"},
        {[](SceneData& s) { MakeRound(s, std::numeric_limits<float>::quiet_NaN()); },
         "meshes[0].primitives[0]: radii[0] is nan, must be 1e-09 to 1e+09"},
        {[](SceneData& s) { MakeRound(s, 10.0f); },
         "meshes[0].primitives[0]: bounds are not around its positions"},
        {[](SceneData& s) {
             MakeRound(s, 1e-3f);
             s.meshes[0].primitives[0].normals.assign(3, {0, 0, 1});
         },
         "meshes[0].primitives[0]: round primitives have normals or tangents"},
        {[](SceneData& s) { s.meshes[0].primitives[0].tangentTexCoord = 2; },
         "meshes[0].primitives[0]: texture coordinates of the tangents is 2, there are 2"},
        {[](SceneData& s) { s.meshes[0].primitives[0].material = 1; },
         "meshes[0].primitives[0]: material is 1, there are 1"},
        {[](SceneData& s) { s.meshes[0].primitives[0].bounds = {}; },
         "meshes[0].primitives[0]: bounds are not around its positions"},
        {[](SceneData& s) { s.images[0].width = 2; }, "images[0]: 4 bytes of 2x1 texels"},
        {[](SceneData& s) { s.images[0].blocks.levels.resize(1); }, "images[0]: has blocks of no coding"},
        {[](SceneData& s) {
             s.images[0].blocks = {image::BlockCoding::Bc7, {std::vector<std::byte>(8)}};
         },
         "images[0]: level 0: 8 bytes of blocks for 1x1 texels"},
        {[](SceneData& s) {
             s.images[0].blocks = {image::BlockCoding::Bc4, {2, std::vector<std::byte>(8)}};
         },
         "images[0]: 2 levels of blocks, possible are 1"},
        {[](SceneData& s) { s.textures[0].image = 1; }, "textures[0]: image is 1, there are 1"},
        {[](SceneData& s) { s.materials[0].normalTexture.texture = 7; },
         "materials[0]: a texture is 7, there are 1"},
        {[](SceneData& s) { s.materials[0].roughnessFactor = 1.5f; },
         "materials[0]: roughnessFactor is 1.5, must be 0 to 1"},
        {[](SceneData& s) { s.materials[0].emissiveStrength = kInfinity; },
         "materials[0]: emissiveStrength is inf, must be finite and at least 0"},
        {[](SceneData& s) { s.materials[0].ior = 0.5f; }, "materials[0]: ior is 0.5, must be 1 to 10000"},
        {[](SceneData& s) { s.instances[0].mesh = 4; }, "instances[0]: mesh is 4, there are 1"},
        {[](SceneData& s) { s.instances[0].objectToWorld[3].x = kNan; },
         "instances[0]: its transform is not finite"},
        {[](SceneData& s) { s.instances[0].objectToWorld[1] = s.instances[0].objectToWorld[2] = {}; },
         "instances[0]: its transform is scaled to nothing or to a line"},
        {[](SceneData& s) { s.instances[0].translationResidual.z = kNan; },
         "instances[0]: its transform is not finite"},
        {[](SceneData& s) { s.nodes[0].parent = 9; }, "nodes[0]: parent is 9, there are 2"},
        {[](SceneData& s) {
             s.nodeOrder = {1, 0};
         },
         "nodeOrder[0]: its node comes before its parent"},
        {[](SceneData& s) {
             s.nodeOrder = {0, 0};
         },
         "nodeOrder[1]: its node is listed twice"},
        {[](SceneData& s) { s.cameras[0].yFov = kNan; },
         "cameras[0]: yFov is nan, must be 1e-06 to 3.1415925"},
        {[](SceneData& s) { s.lights[0].intensity = -1.0f; },
         "lights[0]: intensity is -1, must be finite and at least 0"},
        {[](SceneData& s) { s.lights[0].innerConeAngle = 1.0f; },
         "lights[0]: innerConeAngle must be below outerConeAngle"},
        {[](SceneData& s) { s.lights[0].outerConeAngle = 2.0f; },
         "lights[0]: outerConeAngle is 2, must be 0 to 1.5708064"},
        {[](SceneData& s) { s.bounds.max.z = kInfinity; }, "its bounds are not finite"},
    };
    for (const auto& [change, message] : rows) {
        SceneData scene = Whole();
        change(scene);
        EXPECT_EQ(ErrorTextOf([&] { Check(scene); }), std::string("scene: ") + message);
    }
}

TEST(Check, NamesWhatCannotMove) {
    const struct {
        void (*change)(SceneData&);
        const char* message;
    } rows[] = {
        {[](SceneData& s) { s.meshes[0].primitives[0].influences.joints.pop_back(); },
         "meshes[0].primitives[0]: 5 joints and 6 weights of 3 positions with 2 each"},
        {[](SceneData& s) { s.meshes[0].primitives[0].influences.weights[0] = 0.25f; },
         "meshes[0].primitives[0]: the weights of vertex 0 sum to 0.75, must be 1"},
        {[](SceneData& s) { s.meshes[0].primitives[0].influences.weights[1] = -0.5f; },
         "meshes[0].primitives[0]: weights[1] is -0.5, must not be negative"},
        {[](SceneData& s) { s.meshes[0].primitives[0].influences.weights[1] = kNan; },
         "meshes[0].primitives[0]: weights[1] is nan, must not be negative"},
        {[](SceneData& s) { s.meshes[0].primitives[0].influences.joints[4] = 7; },
         "meshes[0].primitives[0]: the bounds of joint 7 are not around what it moves"},
        {[](SceneData& s) { s.meshes[0].primitives[0].influences.joints[5] = 7; },
         "meshes[0].primitives[0]: joints[5] is 7, there are bounds of 2"},
        {[](SceneData& s) { s.meshes[0].primitives[0].influences.bounds[1].max.x = -1; },
         "meshes[0].primitives[0]: the bounds of joint 1 are not around what it moves"},
        {[](SceneData& s) { s.meshes[0].primitives[0].targets.emplace_back(); },
         "meshes[0].primitives[0]: 2 morph targets, its mesh has 1 weight"},
        {[](SceneData& s) { s.meshes[0].primitives[0].targets[0].positions.pop_back(); },
         "meshes[0].primitives[0]: positions of a target has 2 elements for 3 positions"},
        {[](SceneData& s) { s.meshes[0].primitives[0].targets[0].tangents.resize(3); },
         "meshes[0].primitives[0]: tangents of a target has 3 elements for 0 positions"},
        {[](SceneData& s) { s.meshes[0].primitives[0].targets[0].bounds.max.z = 1; },
         "meshes[0].primitives[0]: the bounds of a target are not around its positions"},
        {[](SceneData& s) { s.meshes[0].weights[0] = kNan; }, "meshes[0]: weights[0] is not finite"},
        {[](SceneData& s) {
             s.nodes[0].weights = {1, 2};
         },
         "nodes[0]: 2 weights, its mesh has 1"},
        {[](SceneData& s) { s.nodes[1].weights = {1}; }, "nodes[1]: 1 weight, its mesh has 0"},
        {[](SceneData& s) { s.nodes[0].skin = 1; }, "nodes[0]: skin is 1, there are 1"},
        {[](SceneData& s) { s.skins[0].joints[1] = 2; }, "skins[0]: a joint is 2, there are 2"},
        {[](SceneData& s) { s.skins[0].joints.clear(); }, "skins[0]: it has no joints, or too many"},
        {[](SceneData& s) { s.skins[0].inverseBinds.pop_back(); },
         "skins[0]: 1 inverse bind matrix of 2 joints"},
        {[](SceneData& s) { s.skins[0].inverseBinds[1][3].x = kInfinity; },
         "skins[0]: an inverse bind matrix is not finite"},
        {[](SceneData& s) {
             s.skins[0].joints.pop_back();
             s.skins[0].inverseBinds.pop_back();
         },
         "nodes[0]: its mesh has 2 joints, its skin 1"},
        {[](SceneData& s) { s.nodeOrder = {0}; }, "nodes[0]: a joint of its skin is not in nodeOrder"},
        {[](SceneData& s) {
             s.animations[0].samplers[0].times = {1, 1};
         },
         "animations[0].samplers[0]: its times do not ascend"},
        {[](SceneData& s) { s.animations[0].samplers[0].times = {}; },
         "animations[0].samplers[0]: it has no keys"},
        {[](SceneData& s) { s.animations[0].samplers[0].times[1] = kInfinity; },
         "animations[0].samplers[0]: times[1] is not finite"},
        {[](SceneData& s) { s.animations[0].samplers[0].values[6] = kNan; },
         "animations[0].samplers[0]: values[6] is not finite"},
        {[](SceneData& s) { s.animations[0].samplers[0].interpolation = Interpolation::CubicSpline; },
         "animations[0].samplers[0]: 8 values of 2 keys, 4 wide"},
        {[](SceneData& s) { s.animations[0].samplers[0].values[3] = 0; },
         "animations[0].channels[0]: a rotation of its sampler is a quaternion of length 0"},
        {[](SceneData& s) { s.animations[0].duration = 1; },
         "animations[0]: its duration is not its last time"},
        {[](SceneData& s) { s.animations[0].channels[0].sampler = 1; },
         "animations[0].channels[0]: sampler is 1, there are 1"},
        {[](SceneData& s) { s.animations[0].channels[0].target.object = 2; },
         "animations[0].channels[0]: its target is nothing that the scene has"},
        {[](SceneData& s) { s.animations[0].channels[0].target.property = AnimatedProperty::Scale; },
         "animations[0].channels[0]: its sampler is 4 wide, its target 3"},
        {[](SceneData& s) { s.animations[0].channels.push_back(s.animations[0].channels[0]); },
         "animations[0]: two channels have one target"},
    };
    for (const auto& [change, message] : rows) {
        SceneData scene = Moving();
        change(scene);
        EXPECT_EQ(ErrorTextOf([&] { Check(scene); }), std::string("scene: ") + message);
    }
}

TEST(Check, SaysItAsTheCallerWants) {
    SceneData scene = Whole();
    scene.instances[0].mesh = 4;
    EXPECT_EQ(ErrorTextOf([&] { Check(scene, "box.gltf", ErrorKind::BadInput); }, ErrorKind::BadInput),
              "box.gltf: instances[0]: mesh is 4, there are 1");
    EXPECT_EQ(ErrorTextOf([] { Check(Material{.metallicFactor = -1.0f}, "a material"); }),
              "a material: metallicFactor is -1, must be 0 to 1");
    EXPECT_EQ(ErrorTextOf([] { CheckTransform({glm::mat4x3(0.0f)}, "a door"); }),
              "a door: its transform is scaled to nothing or flat, it has no inverse");
}

// A host's instance may have another mesh than its node; the node's skin and weights deform it.
TEST(Check, InstancesFitTheSkinAndTheWeightsOfTheirNode) {
    SceneData joints = Moving();
    joints.meshes.push_back(joints.meshes[0]);
    Primitive& primitive = joints.meshes[1].primitives[0];
    primitive.influences.joints[1] = 2;
    UpdateDeformationBounds(primitive);
    EXPECT_NO_THROW(Check(joints));
    for (Instance& instance : joints.instances) instance = {.mesh = 1, .node = 0};
    EXPECT_EQ(ErrorTextOf([&] { Check(joints, "scene"); }),
              "scene: instances[0]: its mesh has 3 joints, its skin 2");
    SceneData weights = Moving();
    weights.nodes[0].weights = {1};
    weights.meshes.push_back(weights.meshes[0]);
    weights.meshes[1].weights = {1, 2};
    weights.meshes[1].primitives[0].targets.resize(2);
    EXPECT_NO_THROW(Check(weights));
    for (Instance& instance : weights.instances) instance = {.mesh = 1, .node = 0};
    EXPECT_EQ(ErrorTextOf([&] { Check(weights, "scene"); }),
              "scene: instances[0]: its node has 1 weight, its mesh 2");
}

// Joint matrices go to one object space.
TEST(Check, DeformedInstancesOfASkinAreAtOnePlace) {
    SceneData scene = Moving();
    scene.instances.push_back(scene.instances[0]);
    DeformInstances(scene);
    EXPECT_NO_THROW(Check(scene));
    const char* const message =
        "scene: instances[1]: its transform is not that of instances[0], which has the same skin";
    scene.instances[1].objectToWorld[3].x += 1.0f;
    EXPECT_EQ(ErrorTextOf([&] { Check(scene); }), message);
    scene.instances[1].isCollapsed = true;  // its transform is of another time, and is not compared
    EXPECT_NO_THROW(Check(scene));
    scene.instances[1] = scene.instances[0];
    scene.instances[1].translationResidual.y = 1e-3f;
    EXPECT_EQ(ErrorTextOf([&] { Check(scene); }), message);
    scene.instances[1].isDeformed = false;
    EXPECT_NO_THROW(Check(scene));
}

TEST(Check, LightsOfFlatNodesMayStay) {
    SceneData scene = Whole();
    scene.lights[0].lightToWorld = glm::mat4x3(0.0f);
    EXPECT_NO_THROW(Check(scene)) << "a light has a place and a direction, no size";
}

TEST(Check, InstancesMayBeFlatAndHaveAnAreaLeft) {
    SceneData scene = Whole();
    scene.instances[0].objectToWorld[1] = glm::vec3(0.0f);
    EXPECT_NO_THROW(Check(scene));
}

TEST(Check, InverseIsOfFloats) {
    EXPECT_TRUE(CanInvert(glm::mat4x3(1.0f)));
    EXPECT_FALSE(CanInvert(glm::mat4x3(glm::mat3(1e-15f)))) << "the determinant is below the floats";
    EXPECT_FALSE(CanInvert(glm::mat4x3(glm::mat3(1e15f)))) << "and here above";
}

TEST(Check, WhatIsNotFiniteHasNoInverse) {
    for (int column = 0; column < 4; ++column)
        for (const float value : {kInfinity, kNan}) {
            glm::mat4x3 transform(1.0f);
            transform[column].y = value;
            EXPECT_FALSE(CanInvert(transform)) << value << " in column " << column;
        }
}

TEST(Check, TransformsHaveAnInverseIfItsNumbersAreFloats) {
    std::mt19937 engine(3);
    std::uniform_real_distribution<float> random(-1.0f, 1.0f);
    const auto vector = [&] { return glm::vec3(random(engine), random(engine), random(engine)); };
    int invertible = 0;
    constexpr int kCount = 20000;
    for (int i = 0; i < kCount; ++i) {
        glm::mat3 linear(vector(), vector(), vector());
        for (int axis = 0; axis < 3; ++axis) linear[axis] *= std::exp2(60.0f * random(engine));
        if (i % 7 == 0) linear[2] = linear[0] + linear[1];
        const bool expected =
            std::isnormal(glm::determinant(linear)) && IsFinite(glm::mat4x3(glm::inverse(linear)));
        EXPECT_EQ(CanInvert(glm::mat4x3(linear)), expected) << i;
        invertible += expected ? 1 : 0;
    }
    EXPECT_GT(invertible, kCount / 4);
    EXPECT_LT(invertible, kCount);
}

}  // namespace
}  // namespace raygraph::scene::check_test

// The lists of a material's and a light's fields, and that importer, saver and Check go by them.
namespace raygraph::scene::material_fields_test {
namespace {

template <typename Field>
constexpr bool kIsNumber =
    std::is_same_v<Field, MaterialField<float>> || std::is_same_v<Field, MaterialField<glm::vec3>> ||
    std::is_same_v<Field, MaterialField<glm::vec4>>;

std::string Refusal(const Material& material) {
    return testing::ErrorTextOf([&] { Check(material, "paint"); });
}

// The hash of a scene goes over the fields in this order: another one would have old renders not be resumed. Fields
// that have come since may stand between them.
TEST(MaterialFields, EachHasANameAndAPlaceOfItsOwnAndTheirOrderStays) {
    std::vector<std::string> names;
    std::set<std::string> places;
    ForEachMaterialField([&](const auto& field) {
        names.emplace_back(field.name);
        places.insert(std::string(field.object) + "/" + field.key);
    });
    EXPECT_EQ(places.size(), names.size());
    std::istringstream first(
        R"(baseColorFactor baseColorTexture metallicFactor roughnessFactor metallicRoughnessTexture
normalTexture normalScale occlusionTexture occlusionStrength emissiveFactor emissiveStrength
emissiveTexture alphaMode alphaCutoff isDoubleSided ior specularFactor specularTexture
specularColorFactor specularColorTexture transmissionFactor transmissionTexture thicknessFactor
attenuationColor attenuationDistance isUnlit clearcoatFactor clearcoatTexture
clearcoatRoughnessFactor clearcoatRoughnessTexture clearcoatNormalTexture clearcoatNormalScale
sheenColorFactor sheenColorTexture sheenRoughnessFactor sheenRoughnessTexture anisotropyStrength
anisotropyRotation anisotropyTexture iridescenceFactor iridescenceTexture iridescenceIor
iridescenceThicknessMinimum iridescenceThicknessMaximum iridescenceThicknessTexture dispersion
diffuseTransmissionFactor diffuseTransmissionTexture diffuseTransmissionColorFactor
diffuseTransmissionColorTexture retroreflectionFactor retroreflectionTexture multiscatterColorFactor
scatterAnisotropy isSpecularGlossiness priority)");
    const std::vector<std::string> expected{std::istream_iterator<std::string>(first), {}};
    std::erase_if(names, [&](const std::string& name) { return std::ranges::count(expected, name) == 0; });
    EXPECT_EQ(names, expected);
    constexpr auto kThickness = FieldOf(&Material::thicknessFactor);
    EXPECT_STREQ(kThickness.unit, "m");
    constexpr auto kSpecularColor = FieldOf(&Material::specularColorFactor);
    EXPECT_STREQ(kSpecularColor.name, "specularColorFactor");
}

TEST(MaterialFields, CheckRefusesWhatIsOutOfTheRangeOfEachAndNamesIt) {
    EXPECT_EQ(Refusal({}), "accepted") << "the defaults";
    ForEachMaterialField([&](const auto& field) {
        if constexpr (kIsNumber<std::decay_t<decltype(field)>>) {
            const auto refused = [&](float value) {
                Material material;
                material.*field.member = std::decay_t<decltype(material.*field.member)>(value);
                const std::string message = Refusal(material);
                EXPECT_TRUE(message.starts_with("paint: " + std::string(field.name) + " is "))
                    << value << ": " << message;
            };
            refused(std::nanf(""));
            refused(std::numeric_limits<float>::infinity());
            if (field.range.max < kUnboundedField) refused(std::nextafter(field.range.max, kUnboundedField));
            if (field.range.min > -kUnboundedField)
                refused(std::nextafter(field.range.min, -kUnboundedField));
        }
    });
}

// A value that is neither the default nor what `other` has, and that it may have.
void Change(float& value) {
    value = 0.625f;
}
void Change(glm::vec3& value) {
    value = {0.25f, 0.5f, 0.75f};
}
void Change(glm::vec4& value) {
    value = {0.25f, 0.5f, 0.75f, 0.875f};
}
void Change(bool& value) {
    value = !value;
}
void Change(AlphaMode& value) {
    value = AlphaMode::Mask;
}
void Change(uint32_t& value) {
    value = 7;
}
void Change(TextureRef&) {}  // only its transform is edited, see below
template <typename Field>
void Change(Material& material, const Field& field) {
    Change(material.*field.member);
    if constexpr (std::is_same_v<typename Field::Value, float>)
        material.*field.member = std::max(material.*field.member, field.range.min);
}

// A file with a triangle of one material.
void Write(const std::filesystem::path& path, const nlohmann::json& material) {
    nlohmann::json document =
        nlohmann::json::parse(R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
"nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
"min": [0, 0, 0], "max": [1, 1, 0]}], "bufferViews": [{"buffer": 0, "byteLength": 36}],
"buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
"images": [{"uri": "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR4nGNoaPj/HwAGggL/s75RMwAAAABJRU5ErkJggg=="}],
"textures": [{"source": 0}]})");
    document["materials"] = nlohmann::json::array({material});
    if (material.contains("extensions"))
        for (const auto& [name, extension] : material["extensions"].items())
            document["extensionsUsed"].push_back(name);
    std::ofstream(path) << document;
}

// Has the textures that some fields require.
const nlohmann::json kTextured = {
    {"normalTexture", {{"index", 0}}},
    {"occlusionTexture", {{"index", 0}}},
    {"extensions", {{"KHR_materials_clearcoat", {{"clearcoatNormalTexture", {{"index", 0}}}}}}}};

// Every field of a material goes to its place in the file and comes back from there.
TEST(MaterialFields, EachComesBackFromAFile) {
    const test::TemporaryFolder folder;
    const std::filesystem::path source = folder.Path() / "source.gltf", target = folder.Path() / "saved.gltf";
    Write(source, kTextured);
    const SceneData loaded = LoadGltf(source);
    ForEachMaterialField([&](const auto& field) {
        SCOPED_TRACE(field.name);
        // A material stays what it is: import_glossiness_test.cpp
        if (std::string(field.name) == "isSpecularGlossiness") return;
        SceneData edited = loaded;
        Change(edited.materials.at(0), field);
        SaveGltf(source, edited, target);
        test::ExpectSame(edited, LoadGltf(target));
    });
}

std::string TextOf(const std::filesystem::path& path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
}

// The JSON of a material with one thing in the place of a field.
template <typename Field, typename Value>
nlohmann::json With(const Field& field, const Value& value) {
    nlohmann::json material = kTextured;
    const std::string object = field.object;
    nlohmann::json& place = object.empty()               ? material
                            : object.starts_with("KHR_") ? material["extensions"][object]
                                                         : material[object];
    if (place.is_null()) place = nlohmann::json::object();
    const KeyParts parts = KeyPartsOf(field.key);
    if (!parts.object.empty())
        place[parts.object][parts.key] = value;
    else if (*field.key != 0)
        place[field.key] = value;
    return material;
}

// A file with nothing in a place has the default of Material, whatever the importer does with it.
TEST(MaterialFields, DefaultsAreThoseOfTheStruct) {
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder.Path() / "scene.gltf";
    nlohmann::json bare = nlohmann::json::object();
    for (const bool hasObjects : {false, true}) {
        if (hasObjects)
            ForEachMaterialField([&](const auto& field) {
                const std::string object = field.object;
                if (object.starts_with("KHR_") && *field.key != 0)
                    bare["extensions"][object] = nlohmann::json::object();
                else if (object == "pbrMetallicRoughness" || object == "extras")
                    bare[object] = nlohmann::json::object();
            });
        Write(path, bare);
        const Material material = LoadGltf(path).materials.at(0);
        ForEachMaterialField([&](const auto& field) {
            if constexpr (std::is_same_v<decltype(field.member), TextureRef Material::*>)
                EXPECT_EQ((material.*field.member).texture, -1) << field.name;
            else
                EXPECT_EQ(material.*field.member, Material().*field.member) << field.name;
        });
    }
}

// Sets each mode by its glTF name, from any other mode.
TEST(MaterialFields, EachAlphaModeIsReadAndSaved) {
    EXPECT_EQ(std::vector(kGltfNames<AlphaMode>.begin(), kGltfNames<AlphaMode>.end()),
              (std::vector<std::string_view>{"OPAQUE", "MASK", "BLEND"}));
    const test::TemporaryFolder folder;
    const std::filesystem::path source = folder.Path() / "source.gltf", target = folder.Path() / "saved.gltf";
    for (const AlphaMode mode : Values<AlphaMode>()) {
        Write(source, {{"alphaMode", GltfName(mode)}});
        SceneData edited = LoadGltf(source);
        EXPECT_EQ(edited.materials.at(0).alphaMode, mode) << Name(mode);
        for (const AlphaMode other : Values<AlphaMode>()) {
            edited.materials[0].alphaMode = other;
            SaveGltf(source, edited, target);
            EXPECT_EQ(LoadGltf(target).materials.at(0).alphaMode, other) << Name(mode) << ", " << Name(other);
        }
    }
}

// A value within the range is read; one outside of it is clamped to the range.
TEST(MaterialFields, EachIsReadFromItsPlaceAndPutIntoItsRange) {
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder.Path() / "scene.gltf";
    ForEachMaterialField([&](const auto& field) {
        using FieldType = std::decay_t<decltype(field)>;
        if constexpr (kIsNumber<FieldType>) {
            SCOPED_TRACE(field.name);
            using Value = typename FieldType::Value;
            const auto read = [&](float number) {
                if constexpr (std::is_same_v<Value, float>)
                    Write(path, With(field, number));
                else
                    Write(path, With(field, std::vector<float>(size_t{Value::length()}, number)));
                return LoadGltf(path).materials.at(0).*field.member;
            };
            const FieldRange& range = field.range;
            const float within = range.min > 0.625f ? range.min + 0.25f : 0.625f;
            EXPECT_EQ(read(within), Value(within));
            if (range.HasMin()) {
                EXPECT_EQ(read(range.min), Value(range.min));
                EXPECT_EQ(read(range.min - 0.5f), Value(range.min));
            }
            if (range.HasMax()) {
                EXPECT_EQ(read(range.max), Value(range.max));
                EXPECT_EQ(read(1.5f * range.max), Value(range.max));
            }
            if (range.mayBeZero) {
                EXPECT_EQ(read(0.0f), Value(0.0f));
            }
        }
    });
}

TEST(MaterialFields, EachTextureIsReadFromItsPlaceInItsColorSpace) {
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder.Path() / "scene.gltf";
    ForEachMaterialField([&](const auto& field) {
        if constexpr (std::is_same_v<decltype(field.member), TextureRef Material::*>) {
            SCOPED_TRACE(field.name);
            nlohmann::json file = With(field, nlohmann::json{{"index", 0}, {"texCoord", 1}});
            for (const char* other : {"normalTexture", "occlusionTexture"})
                if (std::string(field.key) != other) file.erase(other);
            if (std::string(field.key) != "clearcoatNormalTexture")
                file["extensions"]["KHR_materials_clearcoat"].erase("clearcoatNormalTexture");
            Write(path, file);
            const SceneData scene = LoadGltf(path);
            const TextureRef read = scene.materials.at(0).*field.member;
            ASSERT_EQ(read.texture, 0);
            EXPECT_EQ(read.texCoord, 1);
            ASSERT_EQ(scene.textures.size(), 1u) << "and no other of its textures";
            EXPECT_EQ(scene.textures[0].colorSpace, field.colorSpace);
        }
    });
    constexpr auto kBaseColor = FieldOf(&Material::baseColorTexture);
    EXPECT_EQ(kBaseColor.colorSpace, ColorSpace::Srgb);
    constexpr auto kSpecular = FieldOf(&Material::specularTexture);
    EXPECT_EQ(kSpecular.colorSpace, ColorSpace::Linear);
}

// --- Texture transforms ---

void Change(glm::vec2& value) {
    value = {-0.25f, 1.5f};
}

// The name of each texture of a material, with what the file has there.
template <typename Visit>
void ForEachTexture(Visit&& visit) {
    ForEachMaterialField([&](const auto& field) {
        if constexpr (std::is_same_v<decltype(field.member), TextureRef Material::*>) visit(field);
    });
}

// The textures of every place in the file: those of glTF itself and those in extensions.
TEST(TextureTransforms, AreReadFromEveryTextureWithTheirSetOfCoordinates) {
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder.Path() / "scene.gltf";
    ForEachTexture([&](const auto& field) {
        SCOPED_TRACE(field.name);
        const nlohmann::json transform = {
            {"offset", {0.25, -3}}, {"rotation", 0.5}, {"scale", {2, -0.5}}, {"texCoord", 1}};
        Write(path, With(field, nlohmann::json{{"index", 0},
                                               {"extensions", {{"KHR_texture_transform", transform}}}}));
        const SceneData scene = LoadGltf(path);
        const TextureRef& read = scene.materials.at(0).*field.member;
        EXPECT_EQ(read.transform.offset, glm::vec2(0.25f, -3.0f));
        EXPECT_EQ(read.transform.rotation, 0.5f);
        EXPECT_EQ(read.transform.scale, glm::vec2(2.0f, -0.5f));
        EXPECT_EQ(read.texCoord, 1) << "the extension's comes before the texture's own";
        for (const std::string& warning : scene.warnings)
            EXPECT_EQ(warning.find("KHR_texture_transform"), std::string::npos) << warning;
        Write(path, With(field, nlohmann::json{
                                    {"index", 0},
                                    {"texCoord", 1},
                                    {"extensions", {{"KHR_texture_transform", nlohmann::json::object()}}}}));
        const SceneData bare = LoadGltf(path);
        EXPECT_EQ((bare.materials.at(0).*field.member).texCoord, 1);
        EXPECT_EQ((bare.materials.at(0).*field.member).transform, TextureTransform{});
    });
}

TEST(TextureTransforms, AreSavedWhereTheFileHasThemAndWhereItHasNone) {
    const test::TemporaryFolder folder;
    const std::filesystem::path source = folder.Path() / "source.gltf", target = folder.Path() / "saved.gltf";
    ForEachTexture([&](const auto& field) {
        for (const bool isThere : {true, false}) {
            nlohmann::json info = {{"index", 0}, {"extras", "kept"}};
            if (isThere) info["extensions"]["KHR_texture_transform"] = {{"rotation", 0.25}, {"other", 1}};
            Write(source, With(field, info));
            const SceneData loaded = LoadGltf(source);
            ForEachTransformField([&](const auto& part) {
                SCOPED_TRACE(std::string(field.name) + ", " + part.name);
                SceneData edited = loaded;
                Change((edited.materials.at(0).*field.member).transform.*part.member);
                SaveGltf(source, edited, target);
                const SceneData saved = LoadGltf(target);
                test::ExpectSame(edited, saved);
                EXPECT_EQ((saved.materials.at(0).*field.member), (edited.materials.at(0).*field.member));
                const std::string text = TextOf(target);
                EXPECT_NE(text.find("\"kept\""), std::string::npos);
                EXPECT_EQ(text.find("\"other\"") != std::string::npos, isThere);
                const nlohmann::json used = nlohmann::json::parse(text).at("extensionsUsed");
                EXPECT_NE(std::find(used.begin(), used.end(), "KHR_texture_transform"), used.end());
            });
        }
    });
}

// Edits of what has no texture in the file leave the file as it is.
TEST(TextureTransforms, AndScalesOfAbsentTexturesAreNotSaved) {
    const test::TemporaryFolder folder;
    const std::filesystem::path source = folder.Path() / "source.gltf", target = folder.Path() / "saved.gltf";
    Write(source, {{"name", "bare"}});
    SceneData edited = LoadGltf(source);
    Material& material = edited.materials.at(0);
    ForEachTexture([&](const auto& field) { (material.*field.member).transform.rotation = 0.5f; });
    material.normalScale = material.clearcoatNormalScale = 0.25f;
    SaveGltf(source, edited, target);
    const nlohmann::json saved = nlohmann::json::parse(TextOf(target));
    EXPECT_EQ(saved.at("materials").at(0), (nlohmann::json{{"name", "bare"}}));
    EXPECT_FALSE(saved.contains("extensionsUsed"));
    EXPECT_NO_THROW(LoadGltf(target));
}

TEST(TextureTransforms, NumbersThatAreNoneAreRefused) {
    for (const float value : {std::nanf(""), std::numeric_limits<float>::infinity()})
        ForEachTransformField([&](const auto& part) {
            SceneData scene;
            scene.images = {{.name = "one", .width = 1, .height = 1, .rgba = {0, 0, 0, 255}}};
            scene.textures.resize(1);
            scene.materials.resize(1);
            TextureRef& texture = scene.materials[0].emissiveTexture;
            texture.texture = 0;
            texture.transform.*part.member = std::decay_t<decltype(texture.transform.*part.member)>(value);
            const std::string message = testing::ErrorTextOf([&] { Check(scene, "scene"); });
            EXPECT_TRUE(message.starts_with("scene: materials[0]: " + std::string(part.name) + " is "))
                << message;
            EXPECT_EQ(Refusal(scene.materials[0]).find("paint: " + std::string(part.name) + " is "), 0u)
                << "a material that is edited";
        });
}

TEST(TextureTransforms, TakeAQuarterOfTheImageAsTheExtensionsExampleSays) {
    // "Only the lower left quadrant of the source image, rotated clockwise 90 degrees"; v points down
    const TextureTransform transform{
        .offset = {0.0f, 1.0f}, .rotation = glm::half_pi<float>(), .scale = glm::vec2(0.5f)};
    const auto expect = [&](const glm::vec2& uv, const glm::vec2& expected) {
        EXPECT_LT(glm::distance(transform.Matrix() * glm::vec3(uv, 1.0f), expected), 1e-6f)
            << uv.x << ", " << uv.y;
    };
    expect({0, 0}, {0, 1});  // the lower left corner of before is at the upper left
    expect({1, 0}, {0, 0.5});
    expect({0, 1}, {0.5, 1});
    expect({1, 1}, {0.5, 0.5});
    // Scaled before it is rotated
    const TextureTransform stretched{.offset = {}, .rotation = glm::half_pi<float>(), .scale = {3.0f, 1.0f}};
    EXPECT_LT(glm::distance(stretched.Matrix() * glm::vec3(1, 0, 1), glm::vec2(0, -3)), 1e-6f);
}

}  // namespace
}  // namespace raygraph::scene::material_fields_test
