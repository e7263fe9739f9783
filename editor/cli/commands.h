// What the program can be told to do. Each throws Error, or returns having done it.
#pragma once

#include "editor/cli/arguments.h"
#include "editor/cli/console.h"
#include "editor/cli/exit_code.h"
#include "editor/session/process_group.h"
#include "editor/session/scene_input.h"

namespace raygraph::cli {

// Error{Usage} for options of an environment map where neither --env nor the scene has one, and `light`, as
// it was decided, is not the studio. The line names `needs`, the options that give one.
void RequireMapFor(const SettingTexts& given, const SceneInput& input, DefaultLight light, const char* needs);
// Renders to arguments.outputs: if there is none, to the file that is resumed, else to render.png. In a group
// of processes each calls it with the same arguments, and the root writes. Returns TryAgain if it was asked
// to end by more than Ctrl-C and has saved what there is, Failure (in a group, on the root) if an output of a
// picture could not be written.
ExitCode RenderCommand(RenderArguments arguments, Console& console, ProcessGroup* group = nullptr);
// Returns Slower if there is a stored run to compare with and it was faster, Failure if this one could not be
// stored.
ExitCode BenchCommand(const BenchArguments& arguments, Console& console);
void InfoCommand(const InfoArguments& arguments, Console& console);
void GraphCommand(const GraphArguments& arguments, Console& console);
// Returns Failure if one of its files could not be written.
ExitCode MergeCommand(const MergeArguments& arguments, Console& console);
// Error{Usage} where the program was built without the editor.
void EditCommand(const EditArguments& arguments, Console& console);

}  // namespace raygraph::cli
