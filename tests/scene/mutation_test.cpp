// Valid files with a few bytes changed: each loads or ends with one line, and nothing is read outside the
// folder. Worth most under AddressSanitizer and UndefinedBehaviorSanitizer.
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <random>

#include "renderer/scene/animation/deform.h"
#include "renderer/scene/animation/pose.h"
#include "renderer/scene/model/check.h"
#include "tests/image/texture_files.h"
#include "tests/scene/motion_document.h"
#include "tests/support/ies_text.h"
#include "tests/support/material_extensions.h"

namespace raygraph::test::mutation_test {
namespace {

using Random = std::mt19937;

uint32_t Below(Random& random, size_t bound) {
    return static_cast<uint32_t>(random() % bound);
}

// A skin, morph targets and animations of the first node and others.
void AddMotion(GltfDocument& document) {
    const size_t joints = document.AddAccessor<uint8_t>({0, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 0}, 4);
    const size_t weights =
        document.AddAccessor<uint8_t>({155, 100, 0, 0, 255, 0, 0, 0, 200, 55, 0, 0}, 4, true);
    const size_t binds = AddMatrices(document, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0,  0, 0, 1,
                                                1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 1});
    const size_t shifts = document.AddAccessor<int16_t>({1, 2, 3, 0, 0, 0, -4, 5, -6}, 3);
    for (Json& primitive : document.json["meshes"][0]["primitives"]) {
        primitive["attributes"].update({{"JOINTS_0", joints}, {"WEIGHTS_0", weights}});
        primitive["targets"] = {{{"POSITION", shifts}},
                                {{"POSITION", shifts}, {"NORMAL", 1}, {"TANGENT", 1}}};
    }
    document.json["meshes"][0]["weights"] = {0.5, -1};
    document.json["nodes"][0].update({{"skin", 0}, {"weights", {1, 0}}});
    document.Add("skins", {{"joints", {1, 3}}, {"inverseBindMatrices", binds}, {"skeleton", 1}});
    const size_t times = document.AddAccessor<float>({0, 0.5, 2}, 1);
    const size_t vectors = document.AddAccessor<float>({1, 2, 3, 0, 0, 0, -1, 1, 1}, 3);
    const size_t turns = document.AddAccessor<int8_t>({0, 0, 0, 127, 127, 0, 0, 0, 0, 90, 90, 0}, 4, true);
    const size_t numbers = document.AddAccessor<uint8_t>({0, 1, 2}, 1);
    const size_t pairs = document.AddAccessor<float>({0, 1, 1, 0, 0.5f, 0.5f}, 1);
    const size_t splines = document.AddAccessor<float>(std::vector<float>(27, 0.25f), 3);
    const auto sampler = [&](size_t output, const char* interpolation) {
        return Json{{"input", times}, {"output", output}, {"interpolation", interpolation}};
    };
    const auto channel = [](size_t of, const Json& target) {
        return Json{{"sampler", of}, {"target", target}};
    };
    document.Add(
        "animations",
        {{"name", "all"},
         {"samplers",
          {sampler(vectors, "LINEAR"), sampler(turns, "LINEAR"), sampler(numbers, "STEP"),
           sampler(pairs, "LINEAR"), sampler(splines, "CUBICSPLINE")}},
         {"channels",
          {channel(0, {{"node", 1}, {"path", "translation"}}),
           channel(1, {{"node", 3}, {"path", "rotation"}}), channel(4, {{"node", 3}, {"path", "scale"}}),
           channel(3, {{"node", 0}, {"path", "weights"}}),
           channel(2, Pointer("/nodes/3/extensions/KHR_node_visibility/visible")),
           channel(2, Pointer("/materials/0/pbrMetallicRoughness/metallicFactor")),
           channel(2,
                   Pointer("/materials/1/extensions/KHR_materials_pbrSpecularGlossiness/glossinessFactor")),
           channel(2, Pointer("/cameras/0/perspective/yfov")),
           channel(0, Pointer("/extensions/KHR_lights_punctual/lights/0/color")),
           channel(2, Pointer("/materials/0/normalTexture/extensions/KHR_texture_transform/rotation"))}}});
}

// A file that uses a bit of everything.
GltfDocument RichDocument() {
    GltfDocument document;
    Json& primitive = document.AddTriangle();
    primitive["attributes"]["TEXCOORD_0"] =
        document.AddAccessor<uint16_t>({0, 0, 65535, 0, 0, 65535}, 2, true);
    primitive["attributes"]["COLOR_0"] =
        document.AddAccessor<uint8_t>({9, 8, 7, 255, 0, 1, 2, 255, 3, 4, 5, 255}, 4, true);
    primitive["attributes"]["TANGENT"] =
        document.AddAccessor<float>({1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, -1}, 4);
    primitive["indices"] = document.AddAccessor<uint16_t>({0, 1, 2}, 1);
    primitive["mode"] = 5;
    primitive["material"] = document.AddMaterial(
        {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}, {"metallicFactor", 0.5}}},
         {"normalTexture",
          {{"index", 0},
           {"scale", 2},
           {"extensions",
            {{"KHR_texture_transform", {{"offset", {0, 1}}, {"rotation", 1}, {"scale", {1, 2}}}}}}}},
         {"alphaMode", "MASK"},
         {"extensions", MaterialExtensions()},
         {"extras", {{"priority", 3}}}});
    document.AddMaterial({{"extensions",
                           {{"KHR_materials_pbrSpecularGlossiness",
                             {{"diffuseFactor", {1, 0.5, 0.25, 1}},
                              {"glossinessFactor", 0.5},
                              {"specularGlossinessTexture", {{"index", 0}}}}},
                            {"KHR_materials_unlit", Json::object()}}}});
    document.Add("images", {{"uri", DataUri(MakePng(3, 3, {1, 2, 3, 4}))}});
    document.Add("samplers", {{"minFilter", 9987}, {"wrapS", 33071}});
    document.Add("textures", {{"source", 0}, {"sampler", 0}});
    document.Add("images", {{"uri", DataUri(MakePlainDds(2, 2, {1, 2, 3, 4}))}});
    document.Add("textures", {{"extensions", {{"MSFT_texture_dds", {{"source", 1}}}}}, {"source", 0}});
    const size_t indexView = document.AddBufferView(BytesOf<uint8_t>({0, 2}));
    const size_t valueView = document.AddBufferView(BytesOf<float>({1, 2, 3, 4, 5, 6}));
    document.json["accessors"][0]["sparse"] = {
        {"count", 2},
        {"indices", {{"bufferView", indexView}, {"componentType", kUint8}}},
        {"values", {{"bufferView", valueView}}}};
    document.Add("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 0.1}}}});
    document.json["extensions"]["KHR_lights_punctual"]["lights"] = {
        {{"type", "spot"}, {"spot", Json::object()}}};
    document.json["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "a"}}, {{"name", "b"}}};
    primitive["extensions"]["KHR_materials_variants"]["mappings"] = {{{"material", 0}, {"variants", {1, 0}}}};
    document.json["extensions"]["EXT_lights_ies"]["lights"] = Json::array(
        {{{"uri", DataUri(ToBytes(IesText{.vertical = {0, 30, 90}, .horizontal = {0, 90}}.Text()))},
          {"mimeType", "application/x-ies-lm-63"}}});
    document.json["extensions"]["EXT_lights_image_based"]["lights"] =
        Json::array({{{"intensity", 2},
                      {"rotation", {0, 1, 0, 0}},
                      {"irradianceCoefficients", Json(9, Json{1, 0.5, 0})},
                      {"specularImageSize", 2},
                      {"specularImages", Json::array({Json(6, 0), Json(6, 0)})}}});
    document.json["scenes"][0]["extensions"]["EXT_lights_image_based"]["light"] = 0;
    Json line = primitive;
    line["mode"] = 3;
    document.json["meshes"][0]["primitives"].push_back(line);
    document.AddNode({{"camera", 0}, {"children", {2, 3}}, {"rotation", {0, 0, 0, 1}}});
    document.Add("nodes", {{"mesh", 0}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}});
    document.Add("nodes", {{"extensions",
                            {{"KHR_lights_punctual", {{"light", 0}}},
                             {"EXT_lights_ies", {{"light", 0}, {"multiplier", 2}, {"color", {1, 0.5, 0}}}},
                             {"KHR_node_visibility", {{"visible", false}}}}},
                           {"scale", {1, 2, -3}}});
    AddMotion(document);
    const size_t places = document.AddAccessor<float>({1, 2, 3, 4, 5, 6}, 3);
    const size_t turns = document.AddAccessor<int8_t>({0, 0, 0, 127, 127, 0, 0, 0}, 4, true);
    document.AddNode(
        {{"mesh", 0},
         {"extensions",
          {{"EXT_mesh_gpu_instancing",
            {{"attributes", {{"TRANSLATION", places}, {"ROTATION", turns}, {"SCALE", places}}}}}}}});
    return document;
}

// Collects all values of the tree, containers included.
void Collect(Json& value, std::vector<Json*>& out) {
    out.push_back(&value);
    if (value.is_structured())
        for (Json& child : value) Collect(child, out);
}

Json HostileValue(Random& random) {
    switch (Below(random, 14)) {
        case 0:
            return nullptr;
        case 1:
            return -1;
        case 2:
            return 0;
        case 3:
            return 1;
        case 4:
            return 4294967295u;
        case 5:
            return 18446744073709551615u;
        case 6:
            return 9223372036854775807;
        case 7:
            return 1e308;
        case 8:
            return 0.5;
        case 9:
            return "..";
        case 10:
            return Json::array();
        case 11:
            return Json::object();
        case 12:
            return true;
        default:
            return Below(random, 12);
    }
}

class Mutations : public ::testing::Test {
  protected:
    void LoadMutant(const Bytes& file) {
        scene::LoadOptions options;
        // Small, so that a mutant that claims much costs little time.
        options.limits.maxGeometryBytes = 1 << 20;
        options.limits.maxAllImageTexels = 1 << 20;
        options.limits.maxImageTexels = 1 << 20;
        options.pointsAndLines = {.points = {.value = 0.1f}, .lines = {.value = 0.1f, .isRelative = true}};
        options.reader = &m_folder;
        m_folder.replacements[m_path] = file;
        try {
            scene::SceneData scene = scene::LoadGltf(m_path, options);
            Play(scene);
            for (const scene::Instance& instance : scene.instances) {
                for (const scene::Primitive& primitive : scene.meshes.at(instance.mesh).primitives) {
                    const bool isRound = primitive.IsRound();
                    ASSERT_EQ(primitive.indices.size() % (isRound ? 2 : 3), 0u);
                    ASSERT_TRUE(!isRound || primitive.indices.size() == 2 * primitive.radii.size());
                    ASSERT_LT(primitive.material, scene.materials.size());
                    ASSERT_EQ(primitive.normals.size(), isRound ? 0 : primitive.positions.size());
                    for (const uint32_t index : primitive.indices)
                        ASSERT_LT(index, primitive.positions.size());
                }
            }
            ++m_loadedCount;
        } catch (const Error& error) {
            ASSERT_TRUE(error.Kind() == ErrorKind::BadInput) << error.what();
            const std::string message = error.what();
            ASSERT_EQ(message.find("scene.gltf: "), 0u) << message;
            ASSERT_EQ(message.find_first_of("\n\r\x1b"), std::string::npos) << message;
            ++m_refusedCount;
        }
        for (const std::filesystem::path& read : m_folder.reads)
            ASSERT_EQ(read.parent_path(), m_folder.Path());
        m_folder.reads.clear();
    }

    // Whatever the values of an animation are, the scene must stay drawable.
    static void Play(scene::SceneData& scene) {
        scene::PoseEvaluator evaluator(scene);
        scene::PoseApplier applier(scene);
        for (uint32_t i = 0; i < scene.animations.size(); ++i)
            for (const double share : {0.0, 0.3, 1.0}) {
                const std::array clips{
                    scene::ClipState{i, share * double{scene.animations[i].duration}, 0.75f}};
                if (!scene.animations[i].defect.empty()) {
                    EXPECT_THROW(evaluator.Evaluate(scene, clips), Error);
                    continue;
                }
                applier.Apply(scene, evaluator.Evaluate(scene, clips));
                scene::Check(scene, "scene.gltf", ErrorKind::Usage);
            }
        scene::DeformedStreams streams;
        for (const scene::Instance& instance : scene.instances)
            for (const scene::Primitive& primitive : scene.meshes.at(instance.mesh).primitives)
                scene::DeformPrimitive(primitive, scene::MorphWeights(scene, instance),
                                       applier.JointMatricesOf(scene.nodes.at(instance.node).skin), streams);
    }

    // Both outcomes must occur: otherwise the mutations test nothing.
    void ExpectBothOutcomes() {
        EXPECT_GT(m_loadedCount, 0u);
        EXPECT_GT(m_refusedCount, 0u);
    }

    SceneFolder m_folder;
    const std::filesystem::path m_path = m_folder.Write("scene.gltf", "");
    size_t m_loadedCount = 0;
    size_t m_refusedCount = 0;
};

constexpr int kRounds = 3000;

// Otherwise animations and skins would not be mutated.
TEST(RichDocument, NothingThatMovesIsLeftOut) {
    const scene::SceneData scene = Load(RichDocument());
    EXPECT_EQ(scene.nodes[0].skin, 0u);
    EXPECT_EQ(scene.meshes[0].primitives[0].influences.perVertex, 2u);
    EXPECT_EQ(scene.meshes[0].primitives[0].targets.size(), 2u);
    ASSERT_EQ(scene.animations.size(), 1u);
    EXPECT_EQ(scene.animations[0].channels.size(), 10u);
}

TEST_F(Mutations, ChangedBytesOfAGlbNeverCrash) {
    GltfDocument document = RichDocument();
    const Bytes binary = BytesOf<float>({0, 0, 0, 1, 0, 0, 0, 1, 0});
    document.json["buffers"][0].erase("uri");
    const Bytes original = MakeGlb(document.Text(), &binary);
    LoadMutant(original);
    ASSERT_EQ(m_loadedCount, 1u);
    Random random(1);
    for (int round = 0; round < kRounds; ++round) {
        Bytes mutant = original;
        for (uint32_t i = 0; i < 1 + Below(random, 4); ++i)
            mutant[Below(random, mutant.size())] = static_cast<std::byte>(random());
        if (Below(random, 8) == 0) mutant.resize(Below(random, mutant.size()));
        ASSERT_NO_FATAL_FAILURE(LoadMutant(mutant)) << "round " << round;
    }
    ExpectBothOutcomes();
}

TEST_F(Mutations, ChangedValuesOfTheJsonNeverCrash) {
    const GltfDocument original = RichDocument();
    Random random(2);
    for (int round = 0; round < kRounds; ++round) {
        Json mutant = original.json;
        for (uint32_t i = 0; i < 1 + Below(random, 2); ++i) {
            std::vector<Json*> values;
            Collect(mutant, values);
            *values[1 + Below(random, values.size() - 1)] = HostileValue(random);
        }
        ASSERT_NO_FATAL_FAILURE(LoadMutant(ToBytes(mutant.dump())))
            << "round " << round << ": " << mutant.dump();
    }
    ExpectBothOutcomes();
}

TEST_F(Mutations, ExchangedDigitsOfTheTextNeverCrash) {
    const std::string original = RichDocument().Text();
    Random random(3);
    for (int round = 0; round < kRounds; ++round) {
        std::string mutant = original;
        for (int i = 0; i < 3;) {
            char& c = mutant[Below(random, mutant.size())];
            if (c < '0' || c > '9') continue;
            c = "0123456789.-e"[Below(random, 13)];
            ++i;
        }
        ASSERT_NO_FATAL_FAILURE(LoadMutant(ToBytes(mutant))) << "round " << round << ": " << mutant;
    }
    ExpectBothOutcomes();
}

}  // namespace
}  // namespace raygraph::test::mutation_test
