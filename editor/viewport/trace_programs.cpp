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
    if (m_used && m_used->paths == paths && (wanted & ~m_used->features) == 0) {
        const uint32_t more = m_used->features & ~wanted;
        const bool isSettled = more != 0 && samples >= kSettledSamples && m_own != wanted;
        if (isSettled && Prepare(renderer, scene, settings, 0)) m_own = wanted;
        // What no frame has declared for a while may be gone, of both
        const bool isReplaced =
            more != 0 && isAtStart && m_own == wanted && Prepare(renderer, scene, settings, 0);
        if (!isReplaced && Prepare(renderer, scene, settings, more)) return {true, more};
    }
    if (!mayMake || !Prepare(renderer, scene, settings, 0)) return {};
    m_used = {wanted, paths};
    return {true, 0};
}

}  // namespace raygraph::viewport
