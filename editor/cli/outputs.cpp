#include "editor/cli/outputs.h"

#include <set>
#include <string>

#include "base/atomic_file.h"
#include "base/extension.h"
#include "base/printable.h"
#include "base/text.h"
#include "editor/session/parse.h"

namespace raygraph::cli {

namespace {

// One text for all names of a file, whether it exists or not.
std::filesystem::path Canonical(const std::filesystem::path& path) {
    std::error_code error;
    std::filesystem::path canonical = std::filesystem::weakly_canonical(path, error);
    return error ? path.lexically_normal() : canonical;
}

void CheckFolder(const std::filesystem::path& path) {
    const std::filesystem::path folder = path.parent_path();
    std::error_code error;
    if (!folder.empty() && !std::filesystem::is_directory(folder, error))
        throw MakeError(ErrorKind::Io, "{}: there is no folder {}", path.string(), folder.string());
}

}  // namespace

OutputFile ParseOutput(const std::filesystem::path& path) {
    const std::string extension = LowerExtension(path);
    for (const OutputKind kind : Values<OutputKind>())
        if (extension == Name(kind)) return {path, kind};
    constexpr auto kTexts = Texts(OutputKind{});
    throw MakeError(ErrorKind::Usage, "{} does not end in {}", Quoted(path.string(), 1024),
                    session::ListForHelp({kTexts.begin(), kTexts.end()},
                                         std::vector<std::string_view>(kTexts.size()), kTexts.size()));
}

void CheckWritable(std::span<const std::filesystem::path> paths,
                   std::span<const std::filesystem::path> inputs) {
    std::set<std::filesystem::path> seen, read;
    for (const std::filesystem::path& input : inputs) read.insert(Canonical(input));
    for (const std::filesystem::path& path : paths) {
        const std::filesystem::path canonical = Canonical(path);
        if (!seen.insert(canonical).second)
            throw MakeError(ErrorKind::Usage, "{} is to be written twice", path.string());
        if (read.contains(canonical))
            throw MakeError(ErrorKind::Usage, "{} is to be read and to be written", path.string());
        CheckFolder(path);
        AtomicFile probe(path);  // dropped without Commit
    }
}

void CheckLogFile(const std::filesystem::path& log, std::span<const std::filesystem::path> outputs,
                  std::span<const std::filesystem::path> inputs) {
    std::error_code ignored;  // a file that does not exist is one to be created
    if (std::filesystem::is_character_file(log, ignored) || std::filesystem::is_fifo(log, ignored)) return;
    for (const std::filesystem::path& output : outputs)
        if (Canonical(output) == Canonical(log))
            throw MakeError(ErrorKind::Usage, "{} is to be written twice", log.string());
    CheckWritable({&log, 1}, inputs);
}

}  // namespace raygraph::cli
