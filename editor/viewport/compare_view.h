// CompareView declares the views that compare two pictures, and computes statistics of their difference.
#pragma once

#include <deque>
#include <optional>
#include <string>

#include "editor/viewport/viewport.h"

namespace raygraph::viewport {

class CompareView {
  public:
    explicit CompareView(std::string name) : m_name(std::move(name)) {}

    // Holds the two pictures, of one extent, and their states.
    struct Pictures {
        TextureId pathTraced, other;                // radiance, rgba32f
        TextureId pathTracedDisplay, otherDisplay;  // as shown, rgba8
        uint32_t pathTracedSamples = 0;
        uint32_t otherVersion = 0;  // samples of the raster view, or frames of the real-time one
        uint32_t coarseness = 0;
        uint64_t resetCount = 0;
    };
    // Returns display values of one of the views that show both. An error map is recomputed when a sample has
    // been completed or a setting has changed, and reused until then.
    TextureId Declare(Renderer& renderer, const ShowSettings& show, const Pictures& pictures);
    std::optional<CompareNumbers> Numbers();
    void Release(Renderer& renderer) { renderer.Release(MapName()); }

  private:
    // Holds the inputs of a map.
    struct Key {
        ShowSettings show;
        uint32_t pathTracedSamples = 0, otherVersion = 0, coarseness = 0;
        uint64_t resetCount = 0;
        Extent2D extent;
        bool operator==(const Key&) const = default;
    };
    struct Pending {
        CompareNumbers numbers;
        Extent2D extent;
        Readback groups;
    };
    std::string MapName() const { return m_name + ".error"; }
    static Key KeyOf(const Renderer& renderer, const ShowSettings& show, const Pictures& pictures);
    TextureId DeclareMap(Renderer& renderer, const Key& key, const Pictures& pictures);
    void Measure(Renderer& renderer, const Key& key, TextureId map);

    std::string m_name;
    std::optional<Key> m_made;  // the inputs of the stored map
    std::deque<Pending> m_pending;
    std::optional<CompareNumbers> m_newest;
};

}  // namespace raygraph::viewport
