#include "editor/viewport/compare_view.h"

#include "editor/viewport/kept_display.h"
#include "passes/compare.h"
#include "passes/flip.h"

namespace raygraph::viewport {

namespace {

// Older requests are dropped, since a host may never ask for numbers.
constexpr size_t kMaxPending = 8;

}  // namespace

CompareView::Key CompareView::KeyOf(const Renderer& renderer, const ShowSettings& show,
                                    const Pictures& pictures) {
    Key key{.show = show,
            .pathTracedSamples = pictures.pathTracedSamples,
            .otherVersion = pictures.otherVersion,
            .coarseness = pictures.coarseness,
            .resetCount = pictures.resetCount,
            .extent = renderer.Desc(pictures.pathTraced).extent};
    // The map does not depend on these
    key.show.wipePosition = key.show.maxError = 0.0f;
    if (show.view != View::Flip) {
        key.show.tonemap = {};
        key.show.pixelsPerDegree = 0.0f;
    }
    return key;
}

void CompareView::Measure(Renderer& renderer, const Key& key, TextureId map) {
    const Pending pending{.numbers = {.view = key.show.view,
                                      .compared = key.show.compared,
                                      .numbers = {},
                                      .pathTracedSamples = key.pathTracedSamples,
                                      .otherVersion = key.otherVersion},
                          .extent = key.extent,
                          .groups = renderer.ReadBack(passes::ReduceBlocks(renderer, map))};
    // Readbacks of a dropped frame never arrive
    renderer.OnSubmitted([this, key, pending] {
        if (m_pending.size() >= kMaxPending) m_pending.pop_front();
        m_pending.push_back(pending);
        m_made = key;
    });
}

TextureId CompareView::DeclareMap(Renderer& renderer, const Key& key, const Pictures& pictures) {
    TextureId kept = renderer.Persist(MapName(), {key.extent, Format::R32Float});
    if (!renderer.IsFresh(kept) && m_made == key) return kept;
    TextureId map;
    if (key.show.view == View::Flip) {
        map = passes::Flip(renderer, pictures.pathTracedDisplay, pictures.otherDisplay,
                           {.pixelsPerDegree = key.show.pixelsPerDegree});
    } else {
        map = passes::RelativeError(renderer, pictures.pathTraced, pictures.other);
    }
    Measure(renderer, key, map);
    return Keep(renderer, map, kept);
}

TextureId CompareView::Declare(Renderer& renderer, const ShowSettings& show, const Pictures& pictures) {
    switch (show.view) {
        case View::PathTraced:
            return pictures.pathTracedDisplay;
        case View::Raster:
            return pictures.otherDisplay;
        case View::Wipe:
            return passes::Wipe(renderer, pictures.pathTracedDisplay, pictures.otherDisplay,
                                show.wipePosition);
        case View::SideBySide:
            return passes::SideBySide(renderer, pictures.pathTracedDisplay, pictures.otherDisplay);
        case View::Difference: {
            const passes::DifferenceIds ids =
                passes::Difference(renderer, pictures.pathTraced, pictures.other);
            const Key key = KeyOf(renderer, show, pictures);
            if (!(m_made == key)) Measure(renderer, key, ids.luminance);
            return passes::Tonemap(renderer, ids.difference, show.tonemap);
        }
        case View::RelativeError:
            return passes::Heat(renderer, DeclareMap(renderer, KeyOf(renderer, show, pictures), pictures),
                                show.maxError);
        case View::Flip:
            return passes::Heat(renderer, DeclareMap(renderer, KeyOf(renderer, show, pictures), pictures),
                                1.0f);
        case View::Surface:
        case View::RealTime:
            break;  // these views show one picture
    }
    return pictures.pathTracedDisplay;
}

std::optional<CompareNumbers> CompareView::Numbers() {
    while (!m_pending.empty() && m_pending.front().groups.IsReady()) {
        Pending& front = m_pending.front();
        front.numbers.numbers = passes::StatisticsOf(front.groups, front.extent);
        m_newest = front.numbers;
        m_pending.pop_front();
    }
    return m_newest;
}

}  // namespace raygraph::viewport
