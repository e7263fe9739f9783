#include "tests/fuzz/seeds.h"

#include <filesystem>

#include "base/files.h"
#include "tests/support/reference_assets.h"

namespace raygraph::fuzz {

namespace {

bool EndsAs(std::string_view target, const std::filesystem::path& extension) {
    if (target == "gltf_text") return extension == ".gltf";
    if (target == "gltf_container") return extension == ".glb";
    if (target == "images") return extension == ".png" || extension == ".jpg";
    if (target == "environment") return extension == ".exr" || extension == ".hdr";
    if (target == "light_profiles") return extension == ".ies";
    return false;
}

}  // namespace

std::vector<Seed> Seeds(const Target& target, bool withAssets) {
    const std::string_view name = target.name;
    std::vector<Seed> seeds;
    if (name == "gltf_compressed")
        seeds = CompressedSeeds();
    else if (name.starts_with("gltf"))
        seeds = GltfSeeds(name);
    if (name == "images") seeds = ImageSeeds();
    if (name == "environment") seeds = EnvironmentSeeds();
    if (name == "light_profiles") seeds = ProfileSeeds();
    if (name == "render_file") seeds = RenderFileSeeds();
    if (name == "graph_files") seeds = GraphFileSeeds();
    if (name == "scripts") seeds = ScriptSeeds();
    if (name == "settings") seeds = SettingsSeeds();
    if (name == "texts") seeds = TextSeeds();
    const std::optional<std::filesystem::path> assets = withAssets ? test::ReferenceAssets() : std::nullopt;
    if (assets)
        for (const auto& file : std::filesystem::recursive_directory_iterator(*assets))
            if (file.is_regular_file() && file.file_size() <= target.maxBytes &&
                EndsAs(name, file.path().extension()))
                seeds.push_back({"asset" + std::to_string(seeds.size()), ReadFile(file.path())});
    std::erase_if(seeds, [&](const Seed& seed) { return seed.bytes.size() > target.maxBytes; });
    return seeds;
}

}  // namespace raygraph::fuzz
