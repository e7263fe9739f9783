// raygraph: renders, inspects and times glTF scenes without a window. See docs/cli.md.
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <new>
#include <vector>

#include "base/overloaded.h"
#include "editor/cli/commands.h"
#include "editor/cli/exit_code.h"
#include "editor/cli/outputs.h"

namespace raygraph::cli {

namespace {

// What goes wrong is said by the console, once there is one.
template <typename SayIt, typename Body>
ExitCode Guarded(SayIt&& sayIt, Body&& body) {
    try {
        const ExitCode code = body();
        if (std::fflush(stdout) != 0) throw Error(ErrorKind::Io, "stdout cannot be written");
        return code;
    } catch (const Error& error) {
        sayIt(error.what());
        return ExitCodeFor(error.Kind());
    } catch (const std::bad_alloc&) {
        sayIt("out of memory");
        return ExitCode::DeviceFailure;
    } catch (const std::exception& exception) {
        sayIt(exception.what());
        return ExitCode::Failure;
    }
}

// The files of a command, but for its log and those that its scene names. "": none.
struct CommandFiles {
    std::vector<std::filesystem::path> inputs, outputs;
};

CommandFiles FilesOf(const RenderArguments& arguments) {
    CommandFiles files{{arguments.scene, arguments.environment, arguments.resume}, {arguments.report}};
    for (const OutputFile& output : arguments.outputs) files.outputs.push_back(output.path);
    if (arguments.outputs.empty()) files.outputs.push_back(kDefaultPicture);
    return files;
}
CommandFiles FilesOf(const BenchArguments& arguments) {
    return {{arguments.scene, arguments.environment, arguments.compare}, {arguments.json}};
}
CommandFiles FilesOf(const InfoArguments& arguments) {
    return {{arguments.scene}, {}};
}
CommandFiles FilesOf(const GraphArguments& arguments) {
    return {{arguments.scene}, {}};
}
CommandFiles FilesOf(const MergeArguments& arguments) {
    return {arguments.inputs, {arguments.output}};
}
CommandFiles FilesOf(const EditArguments& arguments) {
    return {{arguments.scene, arguments.script}, {}};
}

template <typename CommandArguments, typename Command>
ExitCode RunCommand(const CommandArguments& arguments, Command&& command) {
    if (!arguments.logFile.empty()) {
        const CommandFiles files = FilesOf(arguments);
        CheckLogFile(arguments.logFile, files.outputs, files.inputs);
    }
    Console console(arguments, std::getenv("RAYGRAPH_LOG"));
    return Guarded([&](const char* text) { console.log.Fail(text); },
                   [&] { return command(arguments, console); });
}

// A command that is done whenever it returns.
template <typename CommandArguments>
auto Plain(void (*command)(CommandArguments, Console&)) {
    return [command](const auto& arguments) {
        return RunCommand(arguments, [command](const auto& its, Console& console) {
            command(its, console);
            return ExitCode::Done;
        });
    };
}

ExitCode Run(int argc, const char* const* argv) {
    return std::visit(Overloaded{
                          [](const RenderArguments& arguments) { return Plain(RenderCommand)(arguments); },
                          [](const BenchArguments& arguments) { return RunCommand(arguments, BenchCommand); },
                          [](const InfoArguments& arguments) { return Plain(InfoCommand)(arguments); },
                          [](const GraphArguments& arguments) { return Plain(GraphCommand)(arguments); },
                          [](const MergeArguments& arguments) { return Plain(MergeCommand)(arguments); },
                          [](const EditArguments& arguments) { return Plain(EditCommand)(arguments); },
                          [](const ShowText& text) {
                              std::fputs(text.text.c_str(), stdout);
                              return ExitCode::Done;
                          },
                      },
                      ParseArguments(argc, argv));
}

ExitCode Main(int argc, const char* const* argv) {
    return Guarded([](const char* text) { std::fprintf(stderr, "raygraph: %s\n", text); },
                   [&] { return Run(argc, argv); });
}

}  // namespace

}  // namespace raygraph::cli

int main(int argc, char** argv) {
    return static_cast<int>(raygraph::cli::Main(argc, argv));
}
