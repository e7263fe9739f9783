#include "editor/cli/resume.h"

#include "base/printable.h"
#include "base/text.h"

namespace raygraph::cli {

ResumedRender ReadResumedRender(const std::filesystem::path& path) {
    ResumedRender resumed{path, ReadRenderFile(path)};
    const RenderFile& render = resumed.render;
    const auto refuse = [&](const std::string& why) {
        throw MakeError(ErrorKind::BadInput, "{} cannot be resumed: {}", path.string(), why);
    };
    if (render.sceneHash.empty())
        refuse("it was saved by the editor, whose scene may have had edits that are in no file");
    const View view = SettingsFrom(render.settings).view;
    if (view != View::PathTraced) refuse(std::string("it shows the view ") + Name(view));
    if (render.samples.size() != 1)
        refuse("it was merged from separate sample ranges, " + ToText(render.samples));
    if (render.variance.empty()) refuse("it has no channel variance.R");
    if (!HasSums(render)) refuse("it lacks sums of samples, the channels sum0.R and so on");
    return resumed;
}

PictureSettings SettingsOf(const ResumedRender& resumed, const RenderArguments& arguments) {
    const RenderFile& render = resumed.render;
    const auto refuse = [&](const std::string& option, const std::string& given, const std::string& has) {
        throw MakeError(ErrorKind::Usage, "--{} {}: {} was rendered with {}", option, given,
                        resumed.path.string(), Printable(has));
    };
    const SettingTexts inFile = Texts(SettingsFrom(render.settings));
    for (const auto& [name, text] : arguments.given)
        if (const std::string& has = inFile.at(name); has != text)
            refuse(name, text, has.empty() ? "the default" : has);

    const SampleRange range = render.samples.front();
    if (arguments.sampleOffset && *arguments.sampleOffset != range.first)
        refuse("sample-offset", std::to_string(*arguments.sampleOffset), std::to_string(range.first));
    const PictureSettings settings = SettingsFrom(inFile);
    if (arguments.aovs)
        if (const AovSet asked = AovsFor(*arguments.aovs, settings), has = AovsOf(render); asked != has)
            refuse("aov", ListOf(asked), ListOf(has));
    if (arguments.samples && *arguments.samples <= range.count)
        throw MakeError(ErrorKind::Usage, "--spp {}: {} already holds {} samples; give the total to reach",
                        *arguments.samples, resumed.path.string(), range.count);
    if (!arguments.samples && !arguments.seconds && !arguments.error)
        throw MakeError(ErrorKind::Usage,
                        "--resume needs --spp (the total to reach; {} holds {}), --time or --error",
                        resumed.path.string(), range.count);
    return settings;
}

}  // namespace raygraph::cli
