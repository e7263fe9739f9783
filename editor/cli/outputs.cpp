#include "editor/cli/outputs.h"

#include <algorithm>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "base/files.h"
#include "base/text.h"
#include "editor/cli/report.h"
#include "editor/cli/run_command.h"

namespace raygraph::cli {

namespace {

// Maps all names of a file to one text, whether it exists or not. A folder is looked up once, so that the
// names of a long sequence take little time.
class CanonicalNames {
  public:
    struct Name {
        std::string text;
        // Is the canonical folder of the file; "": unknown, or the path is no regular file.
        std::string folder;
        // Tells whether the file exists in that folder.
        bool exists = false;
    };
    Name Of(const std::filesystem::path& path) {
        const std::filesystem::path folder = path.parent_path(), name = path.filename();
        const auto [known, isNew] = m_folders.try_emplace(folder.native());
        std::error_code error;
        if (isNew) known->second = std::filesystem::canonical(folder.empty() ? "." : folder, error);
        const std::filesystem::file_type type = std::filesystem::symlink_status(path, error).type();
        const bool exists = type == std::filesystem::file_type::regular;
        // A plain path is no link, folder or pipe, so its folder has no other name for it.
        const bool isPlain = exists || type == std::filesystem::file_type::not_found;
        if (!known->second.empty() && !name.empty() && isPlain)
            return {(known->second / name).native(), known->second.native(), exists};
        const std::filesystem::path canonical = std::filesystem::weakly_canonical(path, error);
        return {(error ? path.lexically_normal() : canonical).native(), {}};
    }

  private:
    std::unordered_map<std::string, std::filesystem::path> m_folders;  // "": the folder does not exist
};

void CheckFolder(const std::filesystem::path& path) {
    const std::filesystem::path folder = path.parent_path();
    std::error_code error;
    if (!folder.empty() && !std::filesystem::is_directory(folder, error))
        throw MakeError(ErrorKind::Io, "{}: the folder {} does not exist; create it first", path, folder);
}

}  // namespace

OutputFile ParseOutput(const std::filesystem::path& path, std::span<const OutputKind> kinds) {
    const std::string extension = LowerExtension(path);
    std::error_code error;
    const bool isFolder = std::filesystem::is_directory(path, error);
    std::vector<std::string_view> texts;
    for (const OutputKind kind : kinds) {
        const bool isKind = extension == Name(kind) || (kind == OutputKind::Jpg && extension == ".jpeg");
        if (!isFolder && isKind) return {path, kind};
        texts.emplace_back(Name(kind));
    }
    const std::string endings =
        session::ListForHelp(texts, std::vector<std::string_view>(texts.size()), texts.size());
    if (isFolder)
        throw MakeError(ErrorKind::Usage, "\"{}\" is a folder; name a file that ends in {}", path, endings);
    throw MakeError(ErrorKind::Usage, "\"{}\" does not end in {}", path, endings);
}

std::vector<std::string> CheckOutputs(std::span<const std::filesystem::path> paths,
                                      std::span<const std::filesystem::path> inputs) {
    std::vector<std::string> warnings;
    CanonicalNames readNames, names;
    std::unordered_set<std::string> seen, read, foldersForNewFiles;
    for (const std::filesystem::path& input : inputs) read.insert(readNames.Of(input).text);
    for (const std::filesystem::path& path : paths) {
        const CanonicalNames::Name name = names.Of(path);
        if (!seen.insert(name.text).second)
            throw MakeError(ErrorKind::Usage, "{} is to be written twice", path);
        if (read.contains(name.text))
            throw MakeError(ErrorKind::Usage, "{} is to be read and to be written", path);
        // If one file can be created in a folder, the next one can, too.
        if (!name.exists && foldersForNewFiles.contains(name.folder)) continue;
        CheckFolder(path);
        const std::string note = InPlaceWarning(path);
        if (!note.empty())
            warnings.push_back(Text("{} is {}", path, note));
        else if (!name.folder.empty())
            foldersForNewFiles.insert(name.folder);
    }
    return warnings;
}

void CheckLogFile(const std::filesystem::path& log, std::span<const std::filesystem::path> outputs,
                  std::span<const std::filesystem::path> inputs) {
    if (AtomicFile::IsStream(log)) return;
    CanonicalNames names;
    const std::string itself = names.Of(log).text;
    for (const std::filesystem::path& output : outputs)
        if (names.Of(output).text == itself)
            throw MakeError(ErrorKind::Usage, "{} is to be written twice", log);
    CheckOutputs({&log, 1}, inputs);
}

void OutputWriter::Add(const std::filesystem::path& file, std::function<void()> write) {
    m_outputs.push_back({file, std::move(write)});
}

void OutputWriter::WriteAll() {
    std::ranges::stable_partition(m_outputs,
                                  [](const Output& output) { return !AtomicFile::IsStream(output.file); });
    for (const auto& [file, write] : std::exchange(m_outputs, {})) {
        const ExitCode code = Guarded([&](const char* why) { m_say(file, why); },
                                      [&] {
                                          try {
                                              write();
                                          } catch (const IncompleteFile&) {
                                              m_torn.push_back(file);
                                              throw;
                                          }
                                          return ExitCode::Done;
                                      });
        if (m_result == ExitCode::Done) m_result = code;
        if (code == ExitCode::Done) m_written.push_back(file);
    }
}

bool OutputWriter::HasWritten(const std::filesystem::path& file) const {
    return std::ranges::find(m_written, file) != m_written.end();
}

bool OutputWriter::IsTorn(const std::filesystem::path& file) const {
    return std::ranges::find(m_torn, file) != m_torn.end();
}

}  // namespace raygraph::cli
