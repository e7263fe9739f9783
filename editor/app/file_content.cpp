#include "editor/app/file_content.h"

#include "base/error.h"
#include "editor/session/file/content_hash.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/model/variants.h"

namespace raygraph::editor {

std::optional<FileStamp> StampOf(const std::filesystem::path& file) {
    std::error_code error;
    const FileStamp stamp{std::filesystem::last_write_time(file, error),
                          std::filesystem::file_size(file, error)};
    return error ? std::nullopt : std::optional(stamp);
}

FileContent WithHash(FileContent content, const Log& log) {
    const auto isSame = [&] { return !content.file.empty() && StampOf(content.file) == content.stamp; };
    if (!isSame()) {
        content.hash.clear();
        return content;
    }
    if (!content.hash.empty()) return content;
    try {
        scene::SceneData scene = scene::LoadGltf(
            content.file, {.pointsAndLines = content.pointsAndLines, .root = content.root, .log = log});
        scene::SetVariant(scene, content.variant);
        content.hash = session::HashOf(scene);
    } catch (const Error&) {
        return content;  // the hash stays unknown
    }
    if (!isSame()) content.hash.clear();  // written while it was read
    return content;
}

}  // namespace raygraph::editor
