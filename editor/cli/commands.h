// The commands of the program, each of which throws Error or returns after its work is done.
#pragma once

#include "editor/cli/arguments.h"
#include "editor/cli/console.h"
#include "editor/cli/exit_code.h"
#include "editor/session/process_group.h"
#include "editor/session/settings/scene_input.h"

namespace raygraph::cli {

// Throws Error{Usage} for options of an environment map if neither --env nor the scene has one, and if
// `light`, the effective default light, is not the studio. The message names `needs`, the options that
// provide a map.
void RequireMapFor(const SettingTexts& given, const SceneInput& input, DefaultLight light, const char* needs);
// Renders to arguments.outputs; if there are none, to the file that is resumed, else to render.png. Each
// process of a group calls it with the same arguments, and the root writes. Returns TryAgain if a signal
// other than Ctrl-C ended it and the samples are saved, and Failure (in a group, on the root) if an output of
// a picture could not be written.
ExitCode RenderCommand(RenderArguments arguments, Console& console, ProcessGroup* group = nullptr);
// Returns Slower if the stored run to compare with was faster, Failure if this run could not be stored.
ExitCode BenchCommand(const BenchArguments& arguments, Console& console);
void InfoCommand(const InfoArguments& arguments, Console& console);
void GraphCommand(const GraphArguments& arguments, Console& console);
// Returns Failure if one of the outputs could not be written.
ExitCode GraphRunCommand(const GraphRunArguments& arguments, Console& console);
// Returns Failure likewise.
ExitCode ExplainCommand(const ExplainArguments& arguments, Console& console);
// Returns Failure likewise.
ExitCode MergeCommand(const MergeArguments& arguments, Console& console);
// Returns Failure likewise.
ExitCode DenoiseCommand(const DenoiseArguments& arguments, Console& console);
// Returns Failure likewise.
ExitCode CompareCommand(const CompareArguments& arguments, Console& console);
// Returns Differs if a picture is not right, Failure likewise.
ExitCode VerifyCommand(const VerifyArguments& arguments, Console& console);
// Throws Error{Usage} if the program was built without the editor.
void EditCommand(const EditArguments& arguments, Console& console);

}  // namespace raygraph::cli
