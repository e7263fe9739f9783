// RealTimeView declares the real-time picture of a viewport: filtered frames of one sample while something
// changes, and the kept picture once nothing has for a while.
#pragma once

#include <optional>
#include <string>

#include "passes/accumulate.h"
#include "passes/real_time.h"

namespace raygraph::viewport {

class RealTimeView {
  public:
    explicit RealTimeView(const std::string& name) : m_history(name + ".real-time") {}

    // After this many frames without a change, the picture is kept and samples are accumulated instead.
    static constexpr uint32_t kSettledFrames = 16;

    struct Ids {
        TextureId picture;       // in its full extent
        bool isSettled = false;  // the picture is kept, and no sample is traced for it
        // The passes whose time depends on the traced pixels: from `first` to before `end`.
        PassId first, end;
        uint64_t pixels = 0;
    };
    // Declares a frame. With a limit (milliseconds, 0: none), samples have the resolution that fits it.
    // Without `maySettle`, frames are filtered however long nothing has changed.
    Ids Declare(Renderer& renderer, const SceneIds& scene, passes::TraceSettings settings, double limitMs,
                bool maySettle = true);
    uint32_t FrameCount() const { return m_history.FrameCount(); }
    // Reports a change since the last frame.
    void NoteChange(passes::ResetCause cause);
    // Records the GPU time that a frame took for so many pixels.
    void AddTiming(uint64_t pixels, double milliseconds);
    // Returns the expected GPU milliseconds of a frame at full resolution; nullopt before any AddTiming.
    std::optional<double> ExpectedMs(rhi::Extent2D extent) const;
    // Forgets these times, for other geometry or settings. The resolution stays until there are new ones.
    void ResetTimings() { m_msPerPixel = 0.0; }
    // Returns the factor by which samples are coarser than the picture.
    uint32_t Scale() const { return m_scale; }
    void Release(Renderer& renderer) { passes::Release(renderer, m_history); }

  private:
    void ChooseScale(rhi::Extent2D extent, double limitMs);

    passes::RealTimeHistory m_history;
    uint32_t m_scale = 1;
    bool m_isScaleFound = false;  // by times, which may be forgotten by now
    double m_msPerPixel = 0.0;    // 0: unknown
};

}  // namespace raygraph::viewport
