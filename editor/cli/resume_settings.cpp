#include "editor/cli/resume_settings.h"

#include "base/printable.h"
#include "base/text.h"
#include "editor/cli/aov_request.h"

namespace raygraph::cli {

PictureSettings SettingsOf(const ResumedRender& resumed, const RenderArguments& arguments) {
    const RenderFile& render = resumed.render;
    const auto refuse = [&](const std::string& option, const std::string& given, const std::string& has) {
        throw MakeError(ErrorKind::Usage, "--{} {}: {} was rendered with {}", option, given, resumed.path,
                        Printable(has));
    };
    SettingTexts inFile = Texts(SettingsFrom(render.settings));
    for (const auto& [name, text] : arguments.given) {
        std::string& has = inFile.at(name);
        // An open setting stands for the value that was chosen for the render
        if (has == text || IsOpen(name, text)) continue;
        if (!IsOpen(name, has)) refuse(name, text, has.empty() ? "the default" : has);
        has = text;
    }

    const SampleRange range = render.samples.front();
    if (arguments.shard && !arguments.frames && *arguments.sampleOffset != range.first)
        throw MakeError(ErrorKind::Usage, "--shard {}/{}: its first sample is {}; {} was rendered from {}",
                        arguments.shard->index, arguments.shard->count, *arguments.sampleOffset, resumed.path,
                        range.first);
    if (arguments.sampleOffset && *arguments.sampleOffset != range.first)
        refuse("sample-offset", std::to_string(*arguments.sampleOffset), std::to_string(range.first));
    const PictureSettings settings = SettingsFrom(inFile);
    if (arguments.aovs)
        if (const AovSet requested = AovsFor(*arguments.aovs, settings), has = AovsOf(render);
            requested != has)
            refuse("aov", ListOf(requested), ListOf(has));
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
