// Tests that the hash of a scene depends on every field of every struct, changed one by one.
#include "editor/session/file/content_hash.h"

#include <cmath>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "editor/session/file/content_hasher.h"
#include "renderer/scene/model/scene_fields.h"
#include "tests/cli/cli_test.h"

namespace raygraph::session::content_hash_test {
namespace {

using namespace scene;

// Sets every field that is hashed only if it differs from its default.
SceneData OneOfEach() {
    SceneData scene;
    scene.meshes.resize(1);
    Primitive& primitive = scene.meshes[0].primitives.emplace_back();
    primitive.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    primitive.indices = {0, 1, 2};
    scene.materials.resize(1);
    scene.textures.resize(1);
    scene.images.push_back({"", 1, 1, {1, 2, 3, 4}, {image::BlockCoding::Bc1, {{std::byte{1}}}}});
    scene.nodes.resize(1);
    scene.nodeOrder = {0};
    scene.instances.resize(1);
    scene.cameras.resize(1);
    scene.lights.resize(1);
    scene.profiles.resize(1);
    scene.environment.map = {1, 1, {1, 1, 1, 1}};
    primitive.influences = {1, {0, 0, 0}, {1, 1, 1}, {}};
    primitive.targets.resize(1);
    primitive.hasFlatNormals = true;
    scene.materials[0].transmissionTexture = {.texture = 0, .texCoord = 1, .transform = {.rotation = 1.0f}};
    scene.nodes[0].skin = 0;
    scene.nodes[0].weights = {0.5f};
    scene.lights[0].profile = 0;
    scene.skins.push_back({"", {0}, {glm::mat4x3(1.0f)}});
    Animation& animation = scene.animations.emplace_back();
    animation.samplers.push_back({Interpolation::Linear, 1, {0}, {1}});
    animation.channels.resize(1);
    return scene;
}

// Changes a value of each type in a scene by the least amount.
void Change(bool& value) {
    value = !value;
}
void Change(float& value) {
    value = std::nextafter(value, value > 0.0f ? 0.0f : 1.0f);
}
void Change(int32_t& value) {
    ++value;
}
void Change(uint32_t& value) {
    ++value;
}
void Change(uint8_t& value) {
    ++value;
}
void Change(JointInfluences& value) {
    ++value.perVertex;
}
void Change(std::string& value) {
    value += 'x';
}
template <typename T>
requires std::is_enum_v<T>
void Change(T& value) {
    value = static_cast<T>(static_cast<int>(value) + 1);
}
template <int N>
void Change(glm::vec<N, float>& value) {
    Change(value[N - 1]);
}
void Change(glm::quat& value) {
    Change(value.z);
}
void Change(glm::mat4x3& value) {
    Change(value[3][2]);
}
void Change(std::optional<glm::mat4x3>& value) {
    value.emplace(1.0f);
}
void Change(TextureTransform& value) {
    Change(value.rotation);
}
void Change(TextureRef& value) {
    Change(value.texture);
}
void Change(Sampler& value) {
    Change(value.wrapU);
}
void Change(image::BlockLevels& value) {
    value.levels.emplace_back();
}
void Change(EnvironmentLight& value) {
    Change(value.map.rgba[0]);
}
void Change(Bounds& value) {
    value.Extend(glm::vec3(1.0f));
}
template <typename T>
void Change(std::vector<T>& value) {
    value.emplace_back();
}
void Change(image::ImageF& value) {
    Change(value.rgba[0]);
}
void Change(AnimationTarget& value) {
    Change(value.object);
}
void Change(std::optional<uint8_t>& value) {
    value.emplace(uint8_t{1});
}

// Calls visit(select), where select(scene) is one of the structs of a scene, for each kind of struct.
template <typename Visit>
void ForEachStruct(Visit&& visit) {
    visit([](SceneData& s) -> SceneData& { return s; });
    visit([](SceneData& s) -> Bounds& { return s.bounds; });
    visit([](SceneData& s) -> Mesh& { return s.meshes[0]; });
    visit([](SceneData& s) -> Primitive& { return s.meshes[0].primitives[0]; });
    visit([](SceneData& s) -> JointInfluences& { return s.meshes[0].primitives[0].influences; });
    visit([](SceneData& s) -> MorphTarget& { return s.meshes[0].primitives[0].targets[0]; });
    visit([](SceneData& s) -> Material& { return s.materials[0]; });
    visit([](SceneData& s) -> TextureRef& { return s.materials[0].transmissionTexture; });
    visit([](SceneData& s) -> TextureTransform& { return s.materials[0].transmissionTexture.transform; });
    visit([](SceneData& s) -> Texture& { return s.textures[0]; });
    visit([](SceneData& s) -> Sampler& { return s.textures[0].sampler; });
    visit([](SceneData& s) -> ImageData& { return s.images[0]; });
    visit([](SceneData& s) -> image::BlockLevels& { return s.images[0].blocks; });
    visit([](SceneData& s) -> Node& { return s.nodes[0]; });
    visit([](SceneData& s) -> Instance& { return s.instances[0]; });
    visit([](SceneData& s) -> Camera& { return s.cameras[0]; });
    visit([](SceneData& s) -> Light& { return s.lights[0]; });
    visit([](SceneData& s) -> LightProfile& { return s.profiles[0]; });
    visit([](SceneData& s) -> EnvironmentLight& { return s.environment; });
    visit([](SceneData& s) -> image::ImageF& { return s.environment.map; });
    visit([](SceneData& s) -> Skin& { return s.skins[0]; });
    visit([](SceneData& s) -> Animation& { return s.animations[0]; });
    visit([](SceneData& s) -> AnimationSampler& { return s.animations[0].samplers[0]; });
    visit([](SceneData& s) -> AnimationChannel& { return s.animations[0].channels[0]; });
    visit([](SceneData& s) -> AnimationTarget& { return s.animations[0].channels[0].target; });
}

// Lists the fields that no picture depends on, or that follow from others, in the order of these structs:
// scene, mesh, primitive, its joints and target, texture, image, instance, environment, skin and animation.
const std::vector<std::string> kNotHashed{"name",     "otherScenes", "warnings", "variants",     "variant",
                                          "name",     "variants",    "bounds",   "bounds",       "name",
                                          "name",     "lowestAlpha", "file",     "objectToNode", "name",
                                          "faceSize", "name",        "duration", "defect"};

// Changes every field of every struct alone. Another order of a list, or another way of hashing a field,
// gives other hashes: their sum is that of the version before the lists. Fields hashed with their names are
// not in the sum, so that more can be added.
TEST(ContentHash, ChangesWithEveryFieldOfEveryStructOfAScene) {
    const std::string hash = HashOf(OneOfEach());
    ASSERT_EQ(HashOf(OneOfEach()), hash);
    EXPECT_EQ(hash.size(), 16u);
    std::vector<std::string> notHashed;
    std::set<std::string> sum;
    const auto look = [&](std::string_view name, std::string_view label,
                          const std::function<void(SceneData&)>& change) {
        SceneData scene = OneOfEach();
        change(scene);
        const std::string changed = HashOf(scene);
        if (changed == hash)
            notHashed.emplace_back(name);
        else if (label != name)
            sum.insert(std::string(name) + ' ' + changed);
    };
    ForEachStruct([&](auto select) {
        using Owner = std::decay_t<std::invoke_result_t<decltype(select), SceneData&>>;
        ForEachField<Owner>([&](const auto& field) {
            look(field.name, field.Label(), [&](SceneData& scene) { Change(select(scene).*field.member); });
        });
    });
    EXPECT_EQ(notHashed, kNotHashed);
    ContentHasher hasher;
    for (const std::string& line : sum) hasher.Add(line);
    EXPECT_EQ(hasher.Text(), "4838af2394f1b597");
}

template <typename Owner, typename... Fields>
std::string HashOfChanged(const Owner& owner, const std::tuple<Fields...>& fields) {
    ContentHasher hasher;
    hasher.AddChanged(owner, fields);
    return hasher.Text();
}

// Returns the hash by the list without its entry `left`, as a version without that field had it.
template <typename Owner, typename... Fields>
std::string HashWithout(const Owner& owner, const std::tuple<Fields...>& fields, size_t left) {
    ContentHasher hasher;
    size_t i = 0;
    const auto add = [&](const auto& field) {
        if (i++ != left) hasher.AddIfChanged(owner, field);
    };
    std::apply([&](const auto&... field) { (add(field), ...); }, fields);
    hasher.Add(std::string_view());
    return hasher.Text();
}

// Expects for each field of the list that a version without it has the same hash of objects that do not use
// it.
template <typename Owner, typename... Fields>
void ExpectEachMayBeAdded(const std::tuple<Fields...>& fields) {
    Owner changed;
    std::apply([&](const auto&... field) { (Change(changed.*field.member), ...); }, fields);
    size_t i = 0;
    const auto look = [&](const auto& field) {
        EXPECT_EQ(HashOfChanged(Owner{}, fields), HashWithout(Owner{}, fields, i)) << field.name;
        Owner owner = changed;
        owner.*field.member = Owner{}.*field.member;
        const std::string hash = HashWithout(changed, fields, i);
        EXPECT_EQ(HashOfChanged(owner, fields), hash) << field.name;
        EXPECT_NE(HashOfChanged(changed, fields), hash) << field.name;
        ++i;
    };
    std::apply([&](const auto&... field) { (look(field), ...); }, fields);
}

TEST(ContentHash, StaysWhenAFieldIsAddedThatTheSceneDoesNotUse) {
    ExpectEachMayBeAdded<Material>(material_fields::kAll);
    ExpectEachMayBeAdded<Light>(light_fields::kAll);
}

// A value in another field, of the same material or of the next, makes another scene.
TEST(ContentHash, KnowsWhoseValueItIs) {
    const auto hash = [](const Material& first, const Material& second) {
        SceneData scene;
        scene.materials = {first, second};
        return HashOf(scene);
    };
    Material cut;
    cut.alphaCutoff = 0.25f;
    Material rough;
    rough.roughnessFactor = 0.25f;
    EXPECT_NE(hash(cut, {}), hash(rough, {}));
    EXPECT_NE(hash(cut, {}), hash({}, cut));
}

// An .exr stores the hash of its scene, and is resumed and merged only with the same hash: the fields' names
// and the order in which they are hashed must not change, or kFormat of render_file.cpp must be increased.
TEST(ContentHash, IsTheOneOfEarlierVersions) {
    SceneData scene = OneOfEach();
    scene.profiles.clear();  // Scenes without profiles are hashed as before there were any.
    scene.images[0].blocks = {};
    scene.environment = {};
    scene.skins.clear();  // Earlier versions had no motion either.
    scene.animations.clear();
    scene.meshes[0].primitives[0].influences = {};
    scene.meshes[0].primitives[0].targets.clear();
    scene.nodes.assign(1, {});
    scene.lights.assign(1, {});
    Material& material = scene.materials[0];
    material.baseColorFactor = {0.01f, 0.02f, 0.03f, 0.04f};
    material.metallicFactor = 0.05f;
    material.roughnessFactor = 0.06f;
    material.normalScale = 0.07f;
    material.occlusionStrength = 0.08f;
    material.emissiveFactor = {0.09f, 0.10f, 0.11f};
    material.emissiveStrength = 0.12f;
    material.alphaCutoff = 0.13f;
    material.ior = 1.14f;
    material.specularFactor = 0.15f;
    material.specularColorFactor = {0.16f, 0.17f, 0.18f};
    material.transmissionFactor = 0.19f;
    material.thicknessFactor = 0.20f;
    material.attenuationColor = {0.21f, 0.22f, 0.23f};
    material.attenuationDistance = 0.24f;
    material.priority = 25;
    int32_t index = 0;
    for (TextureRef Material::*texture :
         {&Material::baseColorTexture, &Material::metallicRoughnessTexture, &Material::normalTexture,
          &Material::occlusionTexture, &Material::emissiveTexture, &Material::specularTexture,
          &Material::specularColorTexture, &Material::transmissionTexture})
        material.*texture = {.texture = ++index, .texCoord = 0};
    Light& light = scene.lights[0];
    light.color = {0.1f, 0.2f, 0.3f};
    light.intensity = 0.4f;
    light.range = 0.5f;
    light.innerConeAngle = 0.6f;
    light.outerConeAngle = 0.7f;
    EXPECT_EQ(HashOf(scene), "0642739f33f5d43d");
}

TEST(ContentHash, SeesWhatIsWithinAList) {
    const auto changed = [](auto change) {
        SceneData scene = OneOfEach();
        change(scene);
        return HashOf(scene) != HashOf(OneOfEach());
    };
    EXPECT_TRUE(changed([](SceneData& s) { s.meshes[0].primitives[0].positions[2].y = 1.0000001f; }));
    EXPECT_TRUE(changed([](SceneData& s) { s.meshes[0].primitives[0].indices = {0, 2, 1}; }));
    EXPECT_TRUE(changed([](SceneData& s) { s.images[0].rgba[3] = 5; }));
    EXPECT_TRUE(changed([](SceneData& s) { s.images[0].blocks.levels = {{std::byte{5}}}; }));
}

TEST(ContentHash, IgnoresNamesThatNoOptionChoosesBy) {
    SceneData renamed = OneOfEach();
    renamed.name = renamed.meshes[0].name = renamed.textures[0].name = renamed.images[0].name = "other";
    renamed.warnings = {"other"};
    EXPECT_EQ(HashOf(renamed), HashOf(OneOfEach()));
}

TEST(ContentHash, ChangesWithATexelOfTheEnvironment) {
    const image::ImageF sky{2, 1, std::vector<float>(8, 1.0f)};
    image::ImageF other = sky;
    other.rgba[5] = 1.5f;
    EXPECT_NE(HashOf(sky), HashOf(other));
    const image::ImageF tall{1, 2, sky.rgba};
    EXPECT_NE(HashOf(sky), HashOf(tall));
}

}  // namespace
}  // namespace raygraph::session::content_hash_test
