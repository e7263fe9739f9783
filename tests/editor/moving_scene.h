// Makes a small animated scene as a glTF document.
#pragma once

#include <cstdint>

#include "tests/scene/gltf_document.h"

namespace raygraph::editor::moving {

// Names its nodes: a triangle that two joints bend; a slider with a triangle that rides on it; a camera.
enum Node : uint32_t { Skinned, FirstJoint, SecondJoint, Slider, Rider, Eye };
// Names its animations. `Bend` lasts 2 s, all others 1 s.
enum Clip : uint32_t {
    Slide,  // The slider goes from x = 0 to x = 2, where it rests at x = 0.25.
    Bend,   // The second joint goes from z = 0 to z = 2.
    Pan,    // The camera goes from x = 0 to x = 1.
    Fade,   // The material goes from red to blue.
};

inline test::GltfDocument Document() {
    using test::Json;
    test::GltfDocument document = test::SkinnedTriangle();
    document.AddMaterial({{"pbrMetallicRoughness", {{"baseColorFactor", {1, 0, 0, 1}}}}});
    Json plain = document.json["meshes"][0]["primitives"][0];
    plain["attributes"].erase("JOINTS_0");
    plain["attributes"].erase("WEIGHTS_0");
    plain["material"] = 0;
    document.json["meshes"][0]["primitives"][0]["material"] = 0;
    document.json["nodes"][Skinned]["name"] = "skinned";
    const size_t mesh = document.AddMesh(plain);
    document.AddNode({{"name", "slider"}, {"translation", {0.25, 0, 0}}, {"children", {Rider}}});
    document.Add("nodes", {{"name", "rider"}, {"mesh", mesh}, {"translation", {0, 1, 0}}});
    document.Add("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 0.8}, {"znear", 0.01}}}});
    document.AddNode({{"name", "eye"}, {"camera", 0}, {"translation", {0, 0, 8}}});
    const auto move = [&](uint32_t node, const char* name, const std::vector<float>& times,
                          const std::vector<float>& places) {
        const size_t clip =
            test::Animate(document, {{"node", node}, {"path", "translation"}}, times, places, 3);
        document.json["animations"][clip]["name"] = name;
    };
    move(Slider, "slide", {0, 1}, {0, 0, 0, 2, 0, 0});
    move(SecondJoint, "bend", {0, 2}, {1, 0, 0, 1, 0, 2});
    move(Eye, "pan", {0, 1}, {0, 0, 8, 1, 0, 8});
    const size_t fade =
        test::Animate(document, test::Pointer("/materials/0/pbrMetallicRoughness/baseColorFactor"), {0, 1},
                      {1, 0, 0, 1, 0, 0, 1, 1}, 4);
    document.json["animations"][fade]["name"] = "fade";
    document.json["extensionsUsed"] = {"KHR_animation_pointer"};
    return document;
}

}  // namespace raygraph::editor::moving
