#include "tests/scene/motion_document.h"

namespace raygraph::test {

size_t AddMatrices(GltfDocument& document, const std::vector<float>& values) {
    const size_t view = document.AddBufferView(BytesOf(values));
    return document.Add(
        "accessors",
        {{"bufferView", view}, {"componentType", kFloat}, {"count", values.size() / 16}, {"type", "MAT4"}});
}

size_t AddAnimation(GltfDocument& document, size_t input, size_t output, const Json& target,
                    const char* interpolation) {
    const Json sampler{{"input", input}, {"output", output}, {"interpolation", interpolation}};
    return document.Add("animations", {{"samplers", Json::array({sampler})},
                                       {"channels", Json::array({{{"sampler", 0}, {"target", target}}})}});
}

Json Pointer(const std::string& pointer) {
    return {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", pointer}}}}}};
}

size_t Animate(GltfDocument& document, const Json& target, const std::vector<float>& times,
               const std::vector<float>& values, size_t components, const char* interpolation) {
    const size_t input = document.AddAccessor<float>(times, 1);
    const size_t output = document.AddAccessor<float>(values, components);
    return AddAnimation(document, input, output, target, interpolation);
}

GltfDocument SkinnedTriangle() {
    GltfDocument document;
    Json& primitive = document.AddTriangle();
    primitive["attributes"]["JOINTS_0"] =
        document.AddAccessor<uint8_t>({0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0}, 4);
    primitive["attributes"]["WEIGHTS_0"] =
        document.AddAccessor<float>({1, 0, 0, 0, 1, 0, 0, 0, 0.5f, 0.5f, 0, 0}, 4);
    document.AddNode({{"name", "first"}});
    document.AddNode({{"name", "second"}, {"translation", {1, 0, 0}}});
    const size_t binds = AddMatrices(document, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0,  0, 0, 1,
                                                1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 1});
    document.Add("skins", {{"name", "bones"}, {"joints", {1, 2}}, {"inverseBindMatrices", binds}});
    document.json["nodes"][0]["skin"] = 0;
    return document;
}

}  // namespace raygraph::test
