// The report of a render.
#pragma once

#include "editor/cli/arguments.h"
#include "editor/cli/device_scene.h"
#include "editor/cli/render_session.h"
#include "editor/cli/report.h"

namespace raygraph::cli {

struct RunSources {
    rhi::Device& device;
    DeviceScene& scene;
    RenderSession& session;
    const SceneInput& input;
};

// Scene, device, passes, acceleration structures, memory and their times. Renders one frame more, to count
// rays, where the picture shows light.
Report DescribeRun(const RunSources& sources);

// The picture settings and the other options that say what was rendered.
SettingTexts SettingsForReport(const RenderArguments& arguments, const RenderFile& render,
                               const std::optional<uint32_t>& samplesWanted);

}  // namespace raygraph::cli
