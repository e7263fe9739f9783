#include "renderer/scene/gltf/save_gltf.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "base/error.h"
#include "base/files.h"
#include "base/printable.h"
#include "base/text.h"
#include "renderer/image/image.h"
#include "renderer/scene/formats/ies_file.h"
#include "renderer/scene/gltf/container.h"
#include "renderer/scene/gltf/patch.h"

namespace raygraph::scene {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

void WriteWhole(const fs::path& path, std::span<const std::byte> bytes) {
    AtomicFile file(path);
    file.Write(bytes);
    file.Commit();
}

void Require(const fs::path& path, const std::error_code& error) {
    if (error) throw MakeError(ErrorKind::Io, "{}: {}", path, error.message());
}

// Returns whether the file exists with this content. Throws Error{Io} if it has other content, as it is not
// ours to replace.
bool HasContent(const fs::path& path, std::span<const std::byte> bytes) {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    // A link to nothing is something
    if (!fs::exists(status) && !fs::is_symlink(fs::symlink_status(path, error))) {
        if (status.type() != fs::file_type::not_found) Require(path, error);
        return false;
    }
    const fs::path real = fs::canonical(path, error);
    Require(path, error);
    if (std::ranges::equal(DiskFileReader().Read(real, UINT64_MAX), bytes)) return true;
    throw MakeError(ErrorKind::Io, "{}: is there already, and is another file", path);
}

void WriteBeside(const fs::path& path, std::span<const std::byte> bytes) {
    if (HasContent(path, bytes)) return;
    std::error_code error;
    if (const fs::path parent = path.parent_path(); !parent.empty()) {
        fs::create_directories(parent, error);
        Require(parent, error);
    }
    WriteWhole(path, bytes);
}

bool IsSameFolder(const fs::path& a, const fs::path& b) {
    std::error_code error;
    return fs::equivalent(a.empty() ? "." : a, b.empty() ? "." : b, error) && !error;
}

// Holds the indentation of a JSON text, as Json::dump takes it; -1 for one in a single line.
struct Indentation {
    int width = -1;
    char character = ' ';
};
Indentation IndentationOf(std::string_view text) {
    const size_t line = text.find('\n');
    if (line == std::string_view::npos || line + 1 >= text.size()) return {};
    const char character = text[line + 1];
    if (character != ' ' && character != '\t') return {.width = 0};
    const size_t end = text.find_first_not_of(character, line + 1);
    return {static_cast<int>(std::min<size_t>(end == std::string_view::npos ? 2 : end - line - 1, 8)),
            character};
}

bool EscapesFolder(const std::string& uri) {
    return *RelativePath(uri).begin() == "..";
}

bool IsHidden(const fs::path& relative) {
    return std::ranges::any_of(
        relative, [](const fs::path& part) { return part != "." && part.native().starts_with('.'); });
}

// Writes `bytes`, a file that the scene names by `uri`, to `to / uri`. Hidden files are refused, as programs
// may read them without being asked. Outside of `to` nothing is written: a file there has to exist already.
void CopyTo(const std::string& uri, std::span<const std::byte> bytes, const fs::path& to) {
    const fs::path relative = RelativePath(uri);
    if (EscapesFolder(uri)) {
        if (HasContent(to / relative, bytes)) return;
        throw MakeError(ErrorKind::BadInput, "{}: leads out of the scene's folder, and is not copied to {}",
                        Quoted(uri), to / relative);
    }
    if (IsHidden(relative))
        throw MakeError(ErrorKind::BadInput, "{}: is the name of a hidden file, and not copied", Quoted(uri));
    WriteBeside(to / relative, bytes);
}

// Returns whether a buffer is for readers that do not decompress: it is not read, and may be missing.
bool IsFallback(const Json& buffer) {
    const auto isMarked = [&](const char* extension) {
        return buffer.value(Json::json_pointer(Text("/extensions/{}/fallback", extension)), false);
    };
    return isMarked("EXT_meshopt_compression") || isMarked("KHR_meshopt_compression");
}

bool IsIes(std::span<const std::byte> bytes) {
    try {
        ParseIes({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
        return true;
    } catch (const Error&) {
        return false;
    }
}

// Copies the files that the document names: buffers, images and light profiles, only some of which are read.
// An image that has a substitute may be missing. `renames`: those that CopyTo refuses get other names.
void CopyFiles(Json& root, const std::vector<ImageChoice>& choices,
               const std::vector<ProfileSource>& profilesRead, const ConfinedFolder& from, const fs::path& to,
               uint64_t maxBytes, bool renames) {
    size_t renamedCount = 0;
    const auto copy = [&](Json& thing, bool isRead) {
        const auto uri = thing.find("uri");
        if (uri == thing.end() || IsDataUri(uri->get_ref<const std::string&>())) return;
        const std::string text = uri->get<std::string>();
        std::vector<std::byte> bytes;
        try {
            bytes = from.Read(text, maxBytes);
        } catch (const Error&) {
            if (isRead) throw;
            return;  // nothing reads it: the scene was loaded without
        }
        if (!isRead && !IsFallback(thing) && image::SniffFormat(bytes) == image::FileFormat::Unknown &&
            !IsIes(bytes))
            return;
        const fs::path relative = RelativePath(text);
        if (renames && (EscapesFolder(text) || IsHidden(relative)))
            *uri = PercentEncode(Text("files/{}-{}", ++renamedCount, relative.filename().string()));
        else if (!isRead && EscapesFolder(text))
            return;
        CopyTo(uri->get_ref<const std::string&>(), bytes, to);
    };
    if (const auto buffers = root.find("buffers"); buffers != root.end())
        for (Json& buffer : *buffers) copy(buffer, !IsFallback(buffer));
    std::set<uint32_t> read;
    for (const ImageChoice& choice : choices)
        if (choice.size() == 1) read.insert(choice.front());
    if (const auto images = root.find("images"); images != root.end())
        for (uint32_t i = 0; i < images->size(); ++i) copy((*images)[i], read.contains(i));
    const Json::json_pointer profiles(Text("/extensions/{}/lights", kProfileExtension));
    if (!root.contains(profiles)) return;
    for (uint32_t i = 0; i < root[profiles].size(); ++i)
        copy(root[profiles][i],
             std::ranges::find(profilesRead, i, &ProfileSource::index) != profilesRead.end());
}

std::span<const std::byte> AsBytes(const std::string& text) {
    return std::as_bytes(std::span(text));
}

bool IsGlb(const fs::path& target) {
    const std::string extension = LowerExtension(target);
    if (extension != ".glb" && extension != ".gltf")
        throw MakeError(ErrorKind::Usage, "{}: must end in .gltf or .glb", target);
    return extension == ".glb";
}

// Returns whether the first buffer is the BIN chunk.
bool UsesBinary(const GltfContainer& container, const Json& root) {
    const auto buffers = root.find("buffers");
    return container.hasBinary && buffers != root.end() && !buffers->empty() &&
           !buffers->front().contains("uri");
}

// Returns the chunks after the JSON, with another BIN.
std::vector<std::byte> ChunksWith(const GltfContainer& container, std::span<const std::byte> binary) {
    constexpr size_t kHeader = 8;
    const size_t padded = (binary.size() + 3) / 4 * 4;
    std::vector<std::byte> chunks(container.rest.begin(), container.rest.begin() + kHeader);
    for (size_t i = 0; i < 4; ++i) chunks[i] = static_cast<std::byte>(padded >> (8 * i) & 0xFFu);
    const auto append = [&](std::span<const std::byte> bytes) {
        chunks.insert(chunks.end(), bytes.begin(), bytes.end());
    };
    append(binary);
    chunks.resize(kHeader + padded);
    append(container.rest.subspan(kHeader + container.binary.size()));
    return chunks;
}

void Write(const GltfContainer& container, Json& root, const fs::path& target, bool isGlb,
           std::span<const std::byte> chunks) {
    const Indentation indent =
        container.isGlb && !isGlb ? Indentation{2, ' '} : IndentationOf(container.json);
    if (isGlb) {
        WriteWhole(target, MakeGlb(root.dump(), chunks));
        return;
    }
    if (UsesBinary(container, root)) {
        Json& first = root["buffers"].front();
        const std::string name = target.stem().string() + ".bin";
        // The size excludes the padding of the chunk.
        const size_t size = std::min(container.binary.size(), first["byteLength"].get<size_t>());
        WriteBeside(target.parent_path() / name, container.binary.first(size));
        first["uri"] = PercentEncode(name);
    }
    WriteWhole(target, AsBytes(root.dump(indent.width, indent.character) + "\n"));
}

// Takes the buffers of the file as it is now: since `root` was read, the first may have left the .glb.
void TakeBuffers(Json& root, std::string_view current) {
    const std::optional<RepairedText> repaired = RepairStrings(current);
    const Json now = Json::parse(repaired ? std::string_view(repaired->text) : current);
    if (const auto buffers = now.find("buffers"); buffers != now.end()) root["buffers"] = *buffers;
}

void Save(const fs::path& source, const SceneData& edited, const fs::path& target, const LoadOptions& options,
          const SaveOrigin& origin) {
    const bool isGlb = IsGlb(target);
    const ScenePath located = Locate(source);
    DiskFileReader disk;
    FileReader& files = options.reader ? *options.reader : disk;
    const ConfinedFolder folder(located.folder, files, options.root);
    GltfContext context{.label = located.label, .options = options, .folder = folder, .warnings = {}};
    std::vector<std::byte> current;
    if (origin.file.empty()) current = files.Read(located.file, options.limits.maxFileBytes);
    const std::span<const std::byte> file = origin.file.empty() ? current : origin.file;
    context.bytesRead = file.size();
    const GltfContainer container = OpenContainer(file, context.label);
    const std::string_view json = origin.json.empty() ? container.json : origin.json;
    // Once to be checked, once with its order
    GltfOutline loaded = ReadOutline(context, json);
    if (edited.materials.size() > loaded.scene.materials.size()) {
        // The default material may be that of points or lines
        LoadOptions shown = options;
        shown.pointsAndLines = {.points = {.value = 1.0f}, .lines = {.value = 1.0f}};
        GltfContext all{.label = located.label, .options = shown, .folder = folder, .warnings = {}};
        all.bytesRead = context.bytesRead;
        loaded = ReadOutline(all, json);
    }
    const std::optional<RepairedText> repaired = RepairStrings(json);
    Json root = Json::parse(repaired ? std::string_view(repaired->text) : json);
    const fs::path to = target.parent_path();
    NewFiles newFiles;
    Json formerImages;
    std::vector<std::byte> changedChunks;
    std::span<const std::byte> chunks = container.rest;
    try {
        if (!origin.json.empty()) TakeBuffers(root, container.json);
        const bool usesBinary = isGlb && UsesBinary(container, root);
        if (!origin.images.empty()) {
            formerImages = root["images"];
            std::vector<std::byte> binary;
            if (usesBinary) {
                const auto length = root["buffers"][0]["byteLength"].get<size_t>();
                const auto bytes = container.binary.first(std::min(length, container.binary.size()));
                binary.assign(bytes.begin(), bytes.end());
            }
            newFiles = PatchImages(root, loaded, origin.images, to, usesBinary ? &binary : nullptr);
            if (usesBinary) {
                root["buffers"][0]["byteLength"] = binary.size();
                changedChunks = ChunksWith(container, binary);
                chunks = changedChunks;
            }
        }
        const NodeChanges changes = PatchNodeList(root, loaded, edited, origin.copiedFrom);
        PatchNodes(root, loaded.scene, edited);
        PatchMaterials(root, loaded, edited);
        PatchLights(root, loaded.scene, edited);
        PatchHierarchy(root, loaded, edited, changes);
    } catch (const Error& error) {
        throw MakeError(error.Kind(), "{}: {}", context.label, error.what());
    } catch (const Json::exception& error) {  // where reading does not look, something is of another type
        throw MakeError(ErrorKind::BadInput, "{}: {}", context.label, Printable(error.what(), 1024));
    }
    if (!IsSameFolder(located.folder, to)) {
        std::vector<ImageChoice> images;
        for (size_t i = 0; i < loaded.images.size(); ++i)
            if (loaded.isShown[i]) images.push_back(loaded.images[i]);
        if (loaded.imageLight)
            for (const uint32_t face : loaded.imageLight->faces) images.push_back({face});
        const auto copy = [&](const std::vector<ImageChoice>& read) {
            CopyFiles(root, read, loaded.profiles, folder, to, options.limits.maxFileBytes,
                      origin.isSelfContained);
        };
        // Also images that were replaced: a later save may name them again
        if (!origin.images.empty() && !origin.isSelfContained) std::swap(root["images"], formerImages);
        copy(images);
        if (!origin.images.empty() && !origin.isSelfContained) std::swap(root["images"], formerImages);
    }
    for (const auto& [name, bytes] : newFiles) WriteBeside(to / name, bytes);
    Write(container, root, target, isGlb, chunks);
}

}  // namespace

std::string PercentEncode(const std::string& path) {
    constexpr std::string_view kPlain = "/-._~!$&'()*+,;=@";
    std::string uri;
    for (const char character : path) {
        const auto byte = static_cast<unsigned char>(character);
        const bool isPlain = (byte >= '0' && byte <= '9') || (byte >= 'a' && byte <= 'z') ||
                             (byte >= 'A' && byte <= 'Z') || kPlain.find(character) != kPlain.npos;
        constexpr char kDigits[] = "0123456789ABCDEF";
        if (isPlain)
            uri += character;
        else
            uri.append({'%', kDigits[byte >> 4], kDigits[byte & 15]});
    }
    return uri;
}

void SaveGltf(const fs::path& source, const SceneData& edited, const fs::path& target,
              const LoadOptions& options, const SaveOrigin& origin) {
    WithMemoryErrors(Text("{}", target), [&] { Save(source, edited, target, options, origin); });
}

std::string ReadGltfJson(const fs::path& source, const LoadOptions& options) {
    const ScenePath located = Locate(source);
    DiskFileReader disk;
    FileReader& files = options.reader ? *options.reader : disk;
    return WithMemoryErrors(located.label, [&] {
        const std::vector<std::byte> file = files.Read(located.file, options.limits.maxFileBytes);
        return std::string(OpenContainer(file, located.label).json);
    });
}

}  // namespace raygraph::scene
