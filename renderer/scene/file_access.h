// Reading the files of a scene, and nothing else: a scene names its buffers and images by text that may be
// hostile. Threads: one object for one thread at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/api.h"

namespace raygraph::scene {

// Reads whole files. Implement it to watch, cache or alter what is read. Calls come from the thread that
// loads the scene.
class RAYGRAPH_API FileReader {
  public:
    virtual ~FileReader() = default;
    // The bytes of the regular file at `path` (absolute, no symbolic links in it). Throws Error{Io} if it
    // cannot be read, is no regular file (device, pipe, socket, folder) or has more than `maxBytes`.
    virtual std::vector<std::byte> Read(const std::filesystem::path& path, uint64_t maxBytes) = 0;
};

class RAYGRAPH_API DiskFileReader final : public FileReader {
  public:
    std::vector<std::byte> Read(const std::filesystem::path& path, uint64_t maxBytes) override;
};

// The relative path that a URI names, percent-decoded, with "." and ".." resolved as in RFC 3986: what begins
// with "..", and nothing else, leads out of the folder that it is relative to. Throws Error{BadInput} when
// the URI has a scheme or is absolute: the URI, quoted, and the reason.
RAYGRAPH_API std::filesystem::path RelativePath(std::string_view uri);

// The folder that a scene file stands in: relative URIs are looked up from there, and lead to files below it
// or below the root and nowhere else.
class RAYGRAPH_API ConfinedFolder {
  public:
    // `reader` must outlive this object. `root`, usually a folder above: LoadOptions::root; "": the folder
    // itself. Throws Error{Io} if one of them is no folder.
    ConfinedFolder(const std::filesystem::path& folder, FileReader& reader,
                   const std::filesystem::path& root = {});

    // The bytes of the file that `uri` names (percent-encoded, relative). Throws Error{BadInput} when the URI
    // has a scheme, is absolute or leads out of the folder and the root, by ".." or through a symbolic link,
    // and when the file cannot be read. What a ".." leads out to is not looked at. Message: the URI, quoted,
    // and the reason; the caller puts its place before it.
    std::vector<std::byte> Read(std::string_view uri, uint64_t maxBytes) const;

  private:
    void RequireInside(std::string_view uri, const std::filesystem::path& path) const;

    std::filesystem::path m_folder, m_root;  // Canonical.
    FileReader* m_reader;
};

}  // namespace raygraph::scene
