#include "editor/viewport/trace_programs.h"

#include "passes/scene_bindings.h"

namespace raygraph::viewport {

namespace {

// The passes of the program with those features more, declared in the open frame and culled. Others that
// settings choose are compiled in as well, so only the renderer can say whether a program is there.
class DeclaredProgram {
  public:
    DeclaredProgram(Renderer& renderer, const SceneIds& scene, const passes::TraceSettings& settings,
                    uint32_t moreFeatures)
        : m_renderer(renderer), m_first(renderer.NextPass()) {
        static_cast<void>(passes::Trace(renderer, passes::WithFeatures(scene, moreFeatures), settings));
        m_end = renderer.NextPass();
    }
    bool IsThere() const { return m_renderer.HasPipelines(m_first, m_end); }
    bool Prepare() const { return m_renderer.PreparePipelines(m_first, m_end); }

  private:
    Renderer& m_renderer;
    PassId m_first, m_end;
};

}  // namespace

TracePrograms::Choice TracePrograms::Choose(Renderer& renderer, const SceneIds& scene,
                                            const passes::TraceSettings& settings, uint32_t samples,
                                            bool mayMake) {
    if (!mayMake && !m_isUsed) return {};
    const uint32_t wanted = passes::TraceFeatures(scene, settings);
    const uint32_t more = m_features & ~wanted;
    const DeclaredProgram own(renderer, scene, settings, 0);
    if (!own.IsThere()) {
        const bool canDoAll = more != 0 && (wanted & ~m_features) == 0;
        const bool isOtherThere = canDoAll && DeclaredProgram(renderer, scene, settings, more).IsThere();
        const bool makes = isOtherThere ? samples >= kSettledSamples : mayMake;
        // A failure counts only where there is no other
        const bool isReady = makes && own.Prepare() && (own.IsThere() || !isOtherThere);
        if (!isReady) return {isOtherThere, isOtherThere ? more : 0};
    }
    m_features = wanted;
    m_isUsed = true;
    return {true, 0};
}

}  // namespace raygraph::viewport
