// TracePrograms: which of the path tracer's programs a frame uses, where frames do not wait for pipelines.
#pragma once

#include <cstdint>

#include "passes/trace.h"

namespace raygraph::viewport {

// A program has the features of a scene compiled in. One that has more gives the right picture, only slower:
// it goes on being used when the scene comes to need less, so that no pipeline is made for a light that is
// off for a moment. Once the picture has kSettledSamples, the scene's own program is made on another thread,
// and takes over when it is there.
class TracePrograms {
  public:
    static constexpr uint32_t kSettledSamples = 64;

    struct Choice {
        bool isThere = false;  // else it is being made, and no other program does
        TraceFeatures more;    // of the program (passes::WithFeatures)
    };
    // Of the open frame. `samples`: of the picture so far. Without `mayMake` none is made: others come first.
    Choice Choose(Renderer& renderer, const SceneIds& scene, const passes::TraceSettings& settings,
                  uint32_t samples, bool mayMake);

    // A frame uses one without asking.
    void NoteUsed() { m_isUsed = true; }

  private:
    TraceFeatures m_features;  // of the program that was used last
    bool m_isUsed = false;     // else none is there: reading its shaders takes longer than a preview's do
};

}  // namespace raygraph::viewport
