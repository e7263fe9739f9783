// TracePrograms chooses the path tracer's program for a frame that does not wait for pipelines.
#pragma once

#include <cstdint>

#include "passes/trace.h"

namespace raygraph::viewport {

// A program has the features of a scene compiled in. One with more features gives the right picture, only
// slower: it stays in use when the scene comes to need less, so that no pipeline is made for a light that is
// off for a moment. Once the picture has kSettledSamples, the scene's own program is made on another thread,
// and replaces it when it is ready.
class TracePrograms {
  public:
    static constexpr uint32_t kSettledSamples = 64;

    struct Choice {
        bool isThere = false;  // false: it is being made, and no other program fits
        TraceFeatures more;    // further features of the program (passes::WithFeatures)
    };
    // Chooses the program of the open frame. `samples` is the picture's count so far. Without `mayMake` none
    // is made, since other pipelines come first.
    Choice Choose(Renderer& renderer, const SceneIds& scene, const passes::TraceSettings& settings,
                  uint32_t samples, bool mayMake);

    // Records that a frame has used a program without asking.
    void MarkUsed() { m_isUsed = true; }

  private:
    TraceFeatures m_features;  // of the program that was used last
    bool m_isUsed =
        false;  // false: no program exists, and reading its shaders takes longer than reading a preview's
};

}  // namespace raygraph::viewport
