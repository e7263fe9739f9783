// raygraph: renders, inspects and times glTF scenes without a window. See docs/cli.md.
#include <cstdio>
#include <exception>
#include <new>

#include "base/overloaded.h"
#include "editor/cli/commands.h"
#include "editor/cli/exit_code.h"

namespace raygraph::cli {

namespace {

ExitCode Run(int argc, const char* const* argv) {
    ExitCode code = ExitCode::Done;
    std::visit(Overloaded{
                   [](const RenderArguments& arguments) { RenderCommand(arguments); },
                   [&](const BenchArguments& arguments) { code = BenchCommand(arguments); },
                   [](const InfoArguments& arguments) { InfoCommand(arguments); },
                   [](const GraphArguments& arguments) { GraphCommand(arguments); },
                   [](const MergeArguments& arguments) { MergeCommand(arguments); },
                   [](const EditArguments& arguments) { EditCommand(arguments); },
                   [](const ShowText& text) { std::fputs(text.text.c_str(), stdout); },
               },
               ParseArguments(argc, argv));
    if (std::fflush(stdout) != 0) throw Error(ErrorKind::Io, "stdout cannot be written");
    return code;
}

ExitCode Main(int argc, const char* const* argv) {
    try {
        return Run(argc, argv);
    } catch (const Error& error) {
        std::fprintf(stderr, "raygraph: %s\n", error.what());
        return ExitCodeFor(error.Kind());
    } catch (const std::bad_alloc&) {
        std::fputs("raygraph: out of memory\n", stderr);
        return ExitCode::DeviceFailure;
    } catch (const std::exception& exception) {
        std::fprintf(stderr, "raygraph: %s\n", exception.what());
        return ExitCode::Failure;
    }
}

}  // namespace

}  // namespace raygraph::cli

int main(int argc, char** argv) {
    return static_cast<int>(raygraph::cli::Main(argc, argv));
}
