#include "renderer/scene/gltf/light_profiles.h"

#include <utility>

#include "base/text.h"
#include "renderer/scene/formats/ies_file.h"
#include "renderer/scene/gltf/values.h"

namespace raygraph::scene {
namespace {

ProfileSource ReadSource(const gltf::Value& file, uint32_t index) {
    ProfileSource source{.index = index};
    if (file.Has("name")) source.name = file.Get("name").Get<std::string>();
    if (file.Has("uri")) source.uri = file.Get("uri").Get<std::string>();
    if (file.Has("bufferView")) source.view = static_cast<uint32_t>(file.Get("bufferView").GetNumberAsInt());
    return source;
}

LightProfile Decode(GltfContext& context, const ProfileSource& source, GltfBuffers& buffers) {
    const Place where = ProfilePlace(source.index)[source.uri ? "uri" : "bufferView"];
    std::vector<std::byte> file;
    if (source.uri) file = context.ReadUri(*source.uri, where);
    const std::span<const std::byte> bytes = source.uri ? file : buffers.View(source.view);
    IesFile ies;
    try {
        ies = ParseIes({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    } catch (const Error& error) {
        context.Fail(where, error.what());
    }
    for (const std::string& warning : ies.warnings) context.Warn(where, "light profile", warning);
    context.ChargeGeometry(where, uint64_t{ies.profile.candela.size()} * sizeof(float));
    ies.profile.name = source.name;
    return std::move(ies.profile);
}

}  // namespace

Place ProfilePlace(size_t profile) {
    return Place("extensions")[kProfileExtension]["lights"][profile];
}

std::vector<ProfileSource> ReadProfileSources(const gltf::Model& model,
                                              const std::vector<uint32_t>& profiles) {
    const auto extension = model.extensions.find(kProfileExtension);
    if (extension == model.extensions.end() || !extension->second.Has("lights")) return {};
    const gltf::Value& files = extension->second.Get("lights");
    std::vector<ProfileSource> all, used;
    for (uint32_t i = 0; i < files.ArrayLen(); ++i)
        all.push_back(ReadSource(files.Get(static_cast<int>(i)), i));
    for (const uint32_t profile : profiles) used.push_back(all[profile]);
    return used;
}

Light ReadProfileLight(const gltf::Model& model, uint32_t node) {
    const ValueReader file(model.nodes[node].extensions, kProfileExtension);
    int profile = 0;
    file.Read("light", profile);
    Light light;
    ValueReader(model.extensions, kProfileExtension)
        .In("lights")[static_cast<size_t>(profile)]
        .Read("name", light.name);
    file.Read("multiplier", light.intensity);
    file.Read("color", light.color);
    return light;
}

std::vector<LightProfile> DecodeProfiles(GltfContext& context, const std::vector<ProfileSource>& sources,
                                         GltfBuffers& buffers) {
    std::vector<LightProfile> profiles;
    for (const ProfileSource& source : sources) profiles.push_back(Decode(context, source, buffers));
    return profiles;
}

}  // namespace raygraph::scene
