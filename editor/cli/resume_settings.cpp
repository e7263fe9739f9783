#include "editor/cli/resume_settings.h"

#include "base/text.h"
#include "editor/cli/aov_request.h"
#include "editor/session/settings/session_checks.h"

namespace raygraph::cli {

PictureSettings SettingsOf(const ResumedRender& resumed, const RenderArguments& arguments) {
    const RenderFile& render = resumed.render;
    const PictureSettings settings = SettingsToResume(resumed, arguments.given);
    const SampleRange range = render.samples.front();
    if (arguments.shard && !arguments.frames && *arguments.sampleOffset != range.first)
        throw MakeError(ErrorKind::Usage, "--shard {}/{}: its first sample is {}; {} was rendered from {}",
                        arguments.shard->index, arguments.shard->count, *arguments.sampleOffset, resumed.path,
                        range.first);
    if (arguments.sampleOffset) RequireFirstSample(resumed, *arguments.sampleOffset);
    if (arguments.aovs) RequireAovs(resumed, AovsFor(*arguments.aovs, settings));
    if (arguments.checkpointMinutes) return settings;  // the same command may start a render and complete it
    if (arguments.samples && *arguments.samples <= range.count)
        throw MakeError(ErrorKind::Usage, "--spp {}: {} already holds {}; give the total to reach",
                        *arguments.samples, resumed.path, Counted(range.count, "sample"));
    if (!arguments.samples && !arguments.seconds && !arguments.error)
        throw MakeError(ErrorKind::Usage,
                        "--resume needs --spp (the total to reach; {} holds {}), --time or --error",
                        resumed.path, range.count);
    return settings;
}

}  // namespace raygraph::cli
