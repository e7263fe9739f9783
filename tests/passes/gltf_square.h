// A textured square of a glTF document, and a camera before it.
#pragma once

#include <gtest/gtest.h>

#include "tests/scene/gltf_document.h"
#include "tests/support/scene_render.h"

namespace raygraph::testing {

using test::GltfDocument;
using test::Json;

inline size_t AddTexture(GltfDocument& document, const test::Bytes& png, const Json& sampler = {}) {
    const size_t image = document.Add("images", {{"uri", test::DataUri(png)}});
    Json texture{{"source", image}};
    if (!sampler.is_null()) texture["sampler"] = document.Add("samplers", sampler);
    return document.Add("textures", texture);
}

// The square -1 ... 1 of the xy plane, facing +z. Corners go -x-y, +x-y, +x+y, -x+y.
inline Json Square(GltfDocument& document, const std::vector<float>& uv, size_t material) {
    const size_t positions = document.AddAccessor<float>({-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0}, 3);
    const size_t normals = document.AddAccessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
    const size_t indices = document.AddAccessor<uint16_t>({0, 1, 2, 0, 2, 3}, 1);
    Json primitive{{"attributes", {{"POSITION", positions}, {"NORMAL", normals}}},
                   {"indices", indices},
                   {"material", material}};
    if (!uv.empty()) primitive["attributes"]["TEXCOORD_0"] = document.AddAccessor(uv, 2);
    return primitive;
}

// (0, 0) is the image's upper left corner.
inline const std::vector<float> kUpright{0, 1, 1, 1, 1, 0, 0, 0};

inline passes::TraceSettings Facing(float height, uint32_t size) {
    scene::CameraView view = scene::CameraView::LookAt({0, 0, 4}, {0, 0, 0}, {0, 1, 0});
    view.projection = scene::Projection::Orthographic;
    view.height = height;
    passes::TraceSettings settings;
    settings.extent = {size, size};
    settings.camera = ToRecord(view);
    settings.scattering.brdf = BrdfModel::Lambert;
    return settings;
}

inline void ExpectNear(const glm::vec3& seen, const glm::vec3& expected, float tolerance, const char* what) {
    EXPECT_LT(glm::distance(seen, expected), tolerance)
        << what << ": " << seen.x << ' ' << seen.y << ' ' << seen.z << " for " << expected.x << ' '
        << expected.y << ' ' << expected.z;
}

}  // namespace raygraph::testing
