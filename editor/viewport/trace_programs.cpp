#include "editor/viewport/trace_programs.h"

#include "passes/scene_bindings.h"
#include "renderer/graph/pipelines.h"

namespace raygraph::viewport {

namespace {

// Whether that program's pipelines are there; else they are being made. The passes are culled.
bool Prepare(Renderer& renderer, const SceneIds& scene, const passes::TraceSettings& settings,
             uint32_t moreFeatures) {
    const PassId first = renderer.NextPass();
    static_cast<void>(passes::Trace(renderer, passes::WithFeatures(scene, moreFeatures), settings));
    return PreparePipelines(renderer, first, renderer.NextPass());
}

}  // namespace

TracePrograms::Choice TracePrograms::Choose(Renderer& renderer, const SceneIds& scene,
                                            const passes::TraceSettings& settings, uint32_t samples,
                                            bool isAtStart, bool mayMake) {
    const uint32_t wanted = passes::TraceFeatures(scene, settings);
    const passes::PathSettings& paths = settings;
    const uint64_t frame = renderer.FrameNumber();
    if (m_used && m_used->paths == paths && (wanted & ~m_used->features) == 0) {
        const uint32_t more = m_used->features & ~wanted;
        const bool isSettled = more != 0 && samples >= kSettledSamples && m_own != wanted;
        if (isSettled && Prepare(renderer, scene, settings, 0)) m_own = wanted;
        const bool isReplaced = more != 0 && isAtStart && m_own == wanted;
        // What no frame has used for a while may be gone
        if (!isReplaced && (m_used->frame + 1 >= frame || Prepare(renderer, scene, settings, more))) {
            m_used->frame = frame;
            return {true, more};
        }
    }
    if (!mayMake || !Prepare(renderer, scene, settings, 0)) return {};
    m_used = {wanted, paths, frame};
    return {true, 0};
}

}  // namespace raygraph::viewport
