#include "editor/session/resume.h"

#include "base/text.h"

namespace raygraph::session {

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
    // Where albedo and normals are of the pixels' centers, a session traces those of the samples again
    if (!HasSums(render, {Aov::Albedo, Aov::Normal}))
        refuse("it lacks sums of samples, the channels sum0.R and so on");
    return resumed;
}

}  // namespace raygraph::session
