// raygraph: renders, inspects and times glTF scenes without a window. See docs/cli.md.
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>

#include "base/overloaded.h"
#include "editor/cli/commands.h"
#include "editor/cli/exit_code.h"

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

// Its messages must not end up in what it reads.
void CheckLogFile(const OutputArguments& arguments, std::filesystem::path scene) {
    if (arguments.logFile.empty()) return;
    std::error_code ignored;  // of what is not there, CheckWritable speaks
    const bool isOther = std::filesystem::is_character_file(arguments.logFile, ignored) ||
                         std::filesystem::is_fifo(arguments.logFile, ignored);
    if (!isOther) CheckWritable(std::vector{arguments.logFile}, std::vector{std::move(scene)});
}

template <typename CommandArguments, typename Command>
ExitCode RunCommand(const CommandArguments& arguments, Command&& command) {
    if constexpr (requires { arguments.scene; })
        CheckLogFile(arguments, arguments.scene);
    else
        CheckLogFile(arguments, {});
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
