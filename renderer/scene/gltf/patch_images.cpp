#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "base/base64.h"
#include "base/files.h"
#include "base/text.h"
#include "renderer/image/image.h"
#include "renderer/scene/gltf/container.h"
#include "renderer/scene/gltf/patch.h"

namespace raygraph::scene {
namespace {

using OrderedJson = nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr size_t kAlignment = 4;  // of what a .glb holds

// Where a texture names an image of a format: by an extension, or by its own "source".
struct FormatPlace {
    image::FileFormat format;
    const char* mimeType;
    const char* extension;  // "": none
};
// In the order in which an image is chosen (materials.cpp).
constexpr FormatPlace kPlaces[] = {
    {image::FileFormat::Webp, "image/webp", "EXT_texture_webp"},
    {image::FileFormat::Dds, "image/vnd-ms.dds", "MSFT_texture_dds"},
    {image::FileFormat::Ktx2, "image/ktx2", "KHR_texture_basisu"},
    {image::FileFormat::Png, "image/png", ""},
    {image::FileFormat::Jpeg, "image/jpeg", ""},
};

const FormatPlace& PlaceOf(const ReplacedImage& replaced) {
    const image::FileFormat format = image::SniffFormat(replaced.bytes);
    const auto place = std::ranges::find(kPlaces, format, &FormatPlace::format);
    if (place == std::end(kPlaces))
        throw MakeError(ErrorKind::Usage, "{}: is no PNG, JPEG, WebP, DDS or KTX2 file", replaced.file);
    return *place;
}

OrderedJson::json_pointer SourceIn(const char* extension) {
    return OrderedJson::json_pointer(*extension ? Text("/extensions/{}/source", extension) : "/source");
}

ImageChoice ChoiceOf(const OrderedJson& texture) {
    ImageChoice choice;
    for (const FormatPlace& place : kPlaces)
        if (const auto source = SourceIn(place.extension);
            place.format != image::FileFormat::Jpeg && texture.contains(source))
            choice.push_back(texture[source].get<uint32_t>());
    return choice;
}

void SetSource(OrderedJson& texture, uint32_t image, const char* extension) {
    texture.erase("source");
    if (const auto extensions = texture.find("extensions"); extensions != texture.end()) {
        for (const FormatPlace& place : kPlaces) extensions->erase(place.extension);
        if (extensions->empty()) texture.erase("extensions");
    }
    texture[SourceIn(extension)] = image;
}

// --- Files beside the scene ---

bool HasBytes(const fs::path& file, std::span<const std::byte> bytes) {
    std::error_code error;
    if (fs::file_size(file, error) != bytes.size() || error) return false;
    try {
        return std::ranges::equal(ReadFile(file, bytes.size()), bytes);
    } catch (const Error&) {
        return false;
    }
}

class FileNames {
  public:
    FileNames(const fs::path& folder, ImagePatch& patch)
        : m_folder(folder.empty() ? "." : folder), m_patch(patch) {}

    // Returns the path from the folder by which the scene names the file. One that is not below the folder
    // gets its name there, with a number if another file has that.
    fs::path Add(const ReplacedImage& replaced) {
        std::error_code error;
        const fs::path own = fs::relative(replaced.file, m_folder, error);
        if (!error && !own.empty() && *own.begin() != ".." && own.is_relative() &&
            HasBytes(m_folder / own, replaced.bytes))
            return own;
        const std::string name = replaced.file.filename().string();
        const fs::path plain = name.starts_with('.') ? "image" + name : name;
        fs::path free = plain;
        for (int number = 2; !IsFree(free, replaced.bytes); ++number)
            free = Text("{}-{}{}", plain.stem().string(), number, plain.extension().string());
        m_patch.files.emplace_back(free, replaced.bytes);
        return free;
    }

  private:
    // Returns whether there is no such file, or this one.
    bool IsFree(const fs::path& name, std::span<const std::byte> bytes) const {
        for (const auto& [other, content] : m_patch.files)
            if (other == name) return std::ranges::equal(content, bytes);
        std::error_code error;
        return !fs::exists(fs::symlink_status(m_folder / name, error)) || HasBytes(m_folder / name, bytes);
    }

    fs::path m_folder;
    ImagePatch& m_patch;
};

}  // namespace

ImagePatch PatchImages(OrderedJson& root, const GltfOutline& loaded, std::span<const ReplacedImage> images,
                       const fs::path& folder, std::optional<size_t> binarySize) {
    ImagePatch patch;
    FileNames names(folder, patch);
    for (const ReplacedImage& replaced : images) {
        const FormatPlace& place = PlaceOf(replaced);
        const ImageChoice& choice = loaded.images.at(replaced.image);
        uint32_t index = choice.front();
        std::vector<OrderedJson*> textures;
        // Neither may the light of an environment change
        bool isShared = loaded.imageLight && std::ranges::count(loaded.imageLight->faces, index) > 0;
        for (OrderedJson& texture : root["textures"]) {
            const ImageChoice other = ChoiceOf(texture);
            if (other == choice)
                textures.push_back(&texture);
            else
                isShared |= std::ranges::count(other, index) > 0;
        }
        OrderedJson image = root["images"][index];
        const bool isView = image.contains("bufferView");
        const bool isData = !isView && IsDataUri(image["uri"].get_ref<const std::string&>());
        for (const char* key : {"uri", "bufferView"}) image.erase(key);
        image["mimeType"] = place.mimeType;
        if (isData) {
            image["uri"] = Text("data:{};base64,{}", place.mimeType, EncodeBase64(replaced.bytes));
        } else if (isView && binarySize) {
            const auto pad = [&] {
                while ((*binarySize + patch.binary.size()) % kAlignment != 0) patch.binary.emplace_back();
            };
            pad();
            OrderedJson& views = root["bufferViews"];
            image["bufferView"] = views.size();
            views.push_back({{"buffer", 0},
                             {"byteOffset", *binarySize + patch.binary.size()},
                             {"byteLength", replaced.bytes.size()}});
            patch.binary.insert(patch.binary.end(), replaced.bytes.begin(), replaced.bytes.end());
            pad();
        } else {
            image["uri"] = PercentEncode(names.Add(replaced).generic_string());
        }
        if (isShared) {
            index = static_cast<uint32_t>(root["images"].size());
            root["images"].push_back(std::move(image));
        } else {
            root["images"][index] = std::move(image);
        }
        for (OrderedJson* const texture : textures) SetSource(*texture, index, place.extension);
        if (*place.extension && !textures.empty()) {
            Use(root, place.extension);  // moves members of `root`
            OrderedJson& required = root["extensionsRequired"];
            if (!required.is_array()) required = OrderedJson::array();
            if (std::ranges::find(required, OrderedJson(place.extension)) == required.end())
                required.push_back(place.extension);
        }
    }
    return patch;
}

}  // namespace raygraph::scene
