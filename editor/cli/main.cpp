// raygraph: renders, inspects and times glTF scenes without a window. See docs/cli.md.
#include <cstdio>

#include "base/os.h"
#include "base/overloaded.h"
#include "editor/cli/commands.h"
#include "editor/cli/run_command.h"

namespace raygraph::cli {

namespace {

// Adapts a command without an exit code of its own: it is done when it returns.
template <typename CommandArguments>
auto Plain(void (*command)(CommandArguments, Console&)) {
    return [command](const auto& arguments) {
        return RunCommand(arguments, [command](const auto& parsed, Console& console) {
            command(parsed, console);
            return ExitCode::Done;
        });
    };
}

ExitCode Run(int argc, const char* const* argv) {
    return std::visit(
        Overloaded{
            [](const RenderArguments& arguments) {
                return RunCommand(arguments, [](const auto& parsed, Console& console) {
                    return RenderCommand(parsed, console);
                });
            },
            [](const BenchArguments& arguments) { return RunCommand(arguments, BenchCommand); },
            [](const InfoArguments& arguments) { return Plain(InfoCommand)(arguments); },
            [](const GraphArguments& arguments) { return Plain(GraphCommand)(arguments); },
            [](const GraphRunArguments& arguments) { return RunCommand(arguments, GraphRunCommand); },
            [](const ExplainArguments& arguments) { return RunCommand(arguments, ExplainCommand); },
            [](const MergeArguments& arguments) { return RunCommand(arguments, MergeCommand); },
            [](const DenoiseArguments& arguments) { return RunCommand(arguments, DenoiseCommand); },
            [](const CompareArguments& arguments) { return RunCommand(arguments, CompareCommand); },
            [](const VerifyArguments& arguments) { return RunCommand(arguments, VerifyCommand); },
            [](const EditArguments& arguments) { return Plain(EditCommand)(arguments); },
            [](const ShowText& text) {
                std::fputs(text.text.c_str(), stdout);
                RequirePrinted();
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
    raygraph::os::IgnoreWriteSignals();
    return static_cast<int>(raygraph::cli::Main(argc, argv));
}
