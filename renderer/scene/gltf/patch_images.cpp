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
    FileNames(const fs::path& folder, NewFiles& files)
        : m_folder(folder.empty() ? "." : folder), m_files(files) {}

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
        m_files.emplace_back(free, replaced.bytes);
        return free;
    }

  private:
    // Returns whether there is no such file, or this one.
    bool IsFree(const fs::path& name, std::span<const std::byte> bytes) const {
        for (const auto& [other, content] : m_files)
            if (other == name) return std::ranges::equal(content, bytes);
        std::error_code error;
        return !fs::exists(fs::symlink_status(m_folder / name, error)) || HasBytes(m_folder / name, bytes);
    }

    fs::path m_folder;
    NewFiles& m_files;
};

// --- The BIN chunk of a .glb ---

constexpr size_t kFirstBuffer = 0;  // the one of the chunk

// Describes what the document says about a part of the chunk: a buffer view, or its compressed bytes.
struct Part {
    OrderedJson* json;
    size_t offset, end;
};

std::vector<Part> PartsOf(OrderedJson& root) {
    std::vector<Part> parts;
    const auto add = [&](OrderedJson& json) {
        if (!json.is_object() || json.value("buffer", size_t{SIZE_MAX}) != kFirstBuffer) return;
        const size_t offset = json.value("byteOffset", size_t{0});
        parts.push_back({&json, offset, offset + json.value("byteLength", size_t{0})});
    };
    for (OrderedJson& view : root["bufferViews"]) {
        add(view);
        if (const auto extensions = view.find("extensions"); extensions != view.end())
            for (OrderedJson& extension : *extensions) add(extension);
    }
    return parts;
}

size_t CountUses(const OrderedJson& json, const OrderedJson& view) {
    if (!json.is_structured()) return 0;
    size_t count = json.is_object() && json.contains("bufferView") && json["bufferView"] == view ? 1 : 0;
    for (const OrderedJson& member : json) count += CountUses(member, view);
    return count;
}

// Puts the bytes in the place of those of a view that is an image's alone: what follows moves by a multiple
// of the alignment. Returns false, and changes nothing, if the view's bytes have another use.
bool ReplaceInBinary(OrderedJson& root, const OrderedJson& index, std::span<const std::byte> bytes,
                     std::vector<std::byte>& binary) {
    if (!AreExtensionsRead(root) || CountUses(root, index) != 1) return false;
    OrderedJson& view = root["bufferViews"][index.get<size_t>()];
    const std::vector<Part> parts = PartsOf(root);
    const auto own = std::ranges::find(parts, &view, &Part::json);
    if (own == parts.end() || view.contains("extensions") || own->end > binary.size()) return false;
    size_t end = std::min((own->end + kAlignment - 1) / kAlignment * kAlignment, binary.size());
    for (const Part& part : parts) {
        if (part.json == own->json || part.end <= own->offset) continue;
        if (part.offset < own->end) return false;
        end = std::min(end, part.offset);
    }
    std::vector<std::byte> put(bytes.begin(), bytes.end());
    while ((own->offset + put.size()) % kAlignment != end % kAlignment) put.emplace_back();
    const auto at = [&](size_t offset) { return binary.begin() + static_cast<std::ptrdiff_t>(offset); };
    binary.erase(at(own->offset), at(end));
    binary.insert(at(own->offset), put.begin(), put.end());
    for (const Part& part : parts)
        if (part.offset >= own->end)
            (*part.json)["byteOffset"] = part.offset - end + own->offset + put.size();
    view["byteLength"] = bytes.size();
    return true;
}

// Returns the index of a new view.
size_t AppendToBinary(OrderedJson& root, std::span<const std::byte> bytes, std::vector<std::byte>& binary) {
    const auto pad = [&] { binary.resize((binary.size() + kAlignment - 1) / kAlignment * kAlignment); };
    pad();
    OrderedJson& views = root["bufferViews"];
    views.push_back({{"buffer", kFirstBuffer}, {"byteOffset", binary.size()}, {"byteLength", bytes.size()}});
    binary.insert(binary.end(), bytes.begin(), bytes.end());
    pad();
    return views.size() - 1;
}

}  // namespace

NewFiles PatchImages(OrderedJson& root, const GltfOutline& loaded, std::span<const ReplacedImage> images,
                     const fs::path& folder, std::vector<std::byte>* binary) {
    NewFiles files;
    FileNames names(folder, files);
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
        const OrderedJson view = image.value("bufferView", OrderedJson());
        const bool isView = !view.is_null();
        const bool isData = !isView && IsDataUri(image["uri"].get_ref<const std::string&>());
        if (isView || isData || image.contains("name")) image["name"] = replaced.Name();
        image["mimeType"] = place.mimeType;
        if (isView && binary) {
            if (isShared || !ReplaceInBinary(root, view, replaced.bytes, *binary))
                image["bufferView"] = AppendToBinary(root, replaced.bytes, *binary);
        } else {
            image.erase("bufferView");
            image["uri"] = isData ? Text("data:{};base64,{}", place.mimeType, EncodeBase64(replaced.bytes))
                                  : PercentEncode(names.Add(replaced).generic_string());
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
    return files;
}

}  // namespace raygraph::scene
