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
    // Returns the bytes of the regular file at `path` (absolute, no symbolic links in it). Throws Error{Io}
    // if it cannot be read, is no regular file (device, pipe, socket, folder) or has more than `maxBytes`.
    virtual std::vector<std::byte> Read(const std::filesystem::path& path, uint64_t maxBytes) = 0;
};

class RAYGRAPH_API DiskFileReader final : public FileReader {
  public:
    std::vector<std::byte> Read(const std::filesystem::path& path, uint64_t maxBytes) override;
};

// Returns the relative path that a URI names, percent-decoded, with "." and ".." resolved as in RFC 3986: the
// path leads out of its base folder if and only if it begins with "..". Throws Error{BadInput}, which quotes
// the URI and gives the reason, if the URI has a scheme or is absolute.
RAYGRAPH_API std::filesystem::path RelativePath(std::string_view uri);

// The folder of a scene file. Relative URIs are resolved from there, and reach only files below it or below
// the root.
class RAYGRAPH_API ConfinedFolder {
  public:
    // `reader` must outlive this object. `root` is LoadOptions::root, usually a folder above `folder`; if it
    // is empty, `folder` is the root. Throws Error{Io} if one of them is no folder.
    ConfinedFolder(const std::filesystem::path& folder, FileReader& reader,
                   const std::filesystem::path& root = {});

    // The bytes of the file that `uri` names (percent-encoded, relative). Throws Error{BadInput} when the URI
    // has a scheme, is absolute or leads out of the folder and the root, by ".." or through a symbolic link,
    // and when the file cannot be read. A path that leads out by ".." is refused without a look at the file
    // system. The message is the quoted URI and the reason; the caller puts its place before it.
    std::vector<std::byte> Read(std::string_view uri, uint64_t maxBytes) const;

  private:
    void RequireInside(std::string_view uri, const std::filesystem::path& path) const;

    std::filesystem::path m_folder, m_root;  // canonical
    FileReader* m_reader;
};

}  // namespace raygraph::scene
