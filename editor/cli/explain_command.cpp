// Implements `raygraph explain`.
#include <cstdio>
#include <memory>

#include "editor/cli/command_files.h"
#include "editor/cli/commands.h"
#include "editor/cli/console.h"
#include "editor/cli/device_setup.h"
#include "editor/cli/explain_json.h"
#include "editor/cli/rendering.h"
#include "editor/session/explain/path_text.h"
#include "editor/session/settings/light_settings.h"

namespace raygraph::cli {

void ExplainCommand(const ExplainArguments& arguments, Console& console) {
    const Log log = console.log.ForLibraries();
    const PictureSettings settings = SettingsFrom(
        arguments.given,
        StoredSettings(arguments.settingsFrom, arguments.scene, arguments.environment, arguments.given, log));
    InputOptions options = InputOptionsFor(settings);
    options.root = arguments.root;
    options.environment = arguments.environment;
    options.log = log;
    SceneInput input = LoadInput(arguments.scene, options);
    RequireMapFor(arguments.given, input, ChooseLight(input, settings), "--env or --light studio");
    const std::unique_ptr<rhi::Device> device = OpenDevice({arguments.device, arguments.isValidating}, log);
    Explainer explainer(*device, std::move(input), settings, arguments.tracing);
    const Explanation explanation = explainer.Explain(arguments.request);
    const std::string text = arguments.isJson ? ExplanationJson(explanation) : Describe(explanation);
    std::fputs(text.c_str(), stdout);
}

}  // namespace raygraph::cli
