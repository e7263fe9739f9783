#include "editor/session/file/resume.h"

#include "base/text.h"
#include "editor/session/file/render_file_parts.h"
#include "editor/session/settings/error_goal.h"

namespace raygraph::session {

std::string NotResumableReason(const RenderFile& render) {
    if (std::string flaw = FirstFlaw(render); !flaw.empty()) return flaw;
    if (render.sceneHash.empty())
        return "it was saved by the editor, whose scene may have had edits that are in no file";
    const View view = SettingsFrom(render.settings).view;
    if (view != View::PathTraced) return std::string("it shows the view ") + Name(view);
    if (render.samples.size() != 1)
        return Text("it was merged from separate sample ranges, {}", ToText(render.samples));
    if (render.variance.empty()) return "it has no channel variance.R";
    if (render.adaptive && render.adaptive->wanted.empty())
        return "it lacks what its pixels are still to get: there is no channel samples.wanted";
    // If albedo and normals are of the pixels' centers, a session traces those of the samples again
    const AovSet retraced = render.adaptive ? AovSet{} : AovSet{Aov::Albedo, Aov::Normal};
    const std::string missing = FirstMissingChannel(render, retraced);
    if (!missing.empty())
        return Text("it lacks sums of samples: there is no channel {}{}", missing,
                    render.sums.radiance.IsEmpty() ? kHalfHint : "");
    return {};
}

void RequireResumable(const ResumedRender& resumed) {
    if (const std::string why = NotResumableReason(resumed.render); !why.empty())
        throw MakeError(ErrorKind::BadInput, "{} cannot be resumed: {}", resumed.path, why);
}

bool IsComplete(const RenderFile& render, const StopRule& rule) {
    const auto count = static_cast<uint32_t>(SampleCount(render.samples));
    if (rule.samples && count >= *rule.samples) return true;
    ErrorTarget goal(rule.relativeError);
    if (render.measuredError) goal.Measured(*render.measuredError);
    return goal.IsReachedAt(count);
}

ResumedRender ReadResumedRender(const std::filesystem::path& path, const Log& log) {
    ResumedRender resumed{path, ReadRenderFile(path, log)};
    RequireResumable(resumed);
    return resumed;
}

}  // namespace raygraph::session
