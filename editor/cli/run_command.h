// RunCommand runs a command from its arguments to its exit status.
#pragma once

#include <cstdlib>
#include <exception>
#include <new>
#include <string>
#include <utility>

#include "editor/cli/command_files.h"
#include "editor/cli/console.h"
#include "editor/cli/exit_code.h"
#include "editor/cli/outputs.h"
#include "editor/session/settings/parse.h"

namespace raygraph::cli {

// Returns the status of `body`; if it throws, the status of the error, whose message is passed to `sayIt`.
template <typename SayIt, typename Body>
ExitCode Guarded(SayIt&& sayIt, Body&& body) {
    try {
        return body();
    } catch (const session::SettingError& error) {
        sayIt((std::string("--") + error.what()).c_str());
        return ExitCodeFor(error.Kind());
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

// Runs `command` and reports its failure on the console. Validation messages are a failure of their own,
// including those during the destruction of the command's device.
template <typename CommandArguments, typename Command>
ExitCode RunOn(Console& console, const CommandArguments& arguments, Command&& command) {
    const auto sayIt = [&](const char* text) { console.log.Fail(text); };
    const ExitCode code = Guarded(sayIt, [&] { return command(arguments, console); });
    // Saved samples can be resumed even if the names of the files could not be printed
    const ExitCode printed = Guarded(sayIt, [&] {
        RequirePrinted();
        return code;
    });
    const ExitCode done = code == ExitCode::TryAgain ? code : printed;
    const ExitCode valid = Guarded(sayIt, [&] {
        console.log.RequireValid();
        return done;
    });
    const bool isEnd = code == ExitCode::Done || code == ExitCode::Slower || code == ExitCode::Differs ||
                       code == ExitCode::TryAgain;
    return isEnd ? valid : code;
}

// Does so with a console of its own. Throws Error if the log cannot be made.
template <typename CommandArguments, typename Command>
ExitCode RunCommand(const CommandArguments& arguments, Command&& command) {
    if (!arguments.logFile.empty()) {
        CommandFiles files = FilesOf(arguments);
        files.inputs.insert(files.inputs.end(), files.updated.begin(), files.updated.end());
        CheckLogFile(arguments.logFile, files.outputs, files.inputs);
    }
    Console console(arguments, std::getenv("RAYGRAPH_LOG"));
    return RunOn(console, arguments, std::forward<Command>(command));
}

}  // namespace raygraph::cli
