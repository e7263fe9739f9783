#include "editor/viewport/trace_programs.h"

#include "passes/scene_bindings.h"

namespace raygraph::viewport {

namespace {

// The passes of the program with those features more, declared in the open frame and culled. Others that
// settings choose are compiled in as well, so only the renderer can say whether a program is there.
class DeclaredProgram {
  public:
    DeclaredProgram(Renderer& renderer, const SceneIds& scene, const passes::TraceSettings& settings,
                    TraceFeatures more)
        : m_renderer(renderer), m_first(renderer.NextPass()) {
        static_cast<void>(passes::Trace(renderer, passes::WithFeatures(scene, more), settings));
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
    const TraceFeatures wanted = passes::ProgramFeatures(scene, settings);
    const TraceFeatures more = m_features & ~wanted;
    const DeclaredProgram own(renderer, scene, settings, {});
    if (!own.IsThere()) {
        const bool supportsAll = more != TraceFeatures{} && (wanted & ~m_features) == TraceFeatures{};
        const bool isFallbackReady =
            supportsAll && DeclaredProgram(renderer, scene, settings, more).IsThere();
        const bool makes = isFallbackReady ? samples >= kSettledSamples : mayMake;
        // A failure counts only where there is no other
        const bool isReady = makes && own.Prepare() && (own.IsThere() || !isFallbackReady);
        if (!isReady) return {isFallbackReady, isFallbackReady ? more : TraceFeatures{}};
    }
    m_features = wanted;
    m_isUsed = true;
    return {true, {}};
}

}  // namespace raygraph::viewport
