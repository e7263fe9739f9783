#include "renderer/graph/culling.h"

namespace raygraph {

namespace {

class Culler {
  public:
    explicit Culler(const FrameGraph& graph)
        : m_graph(graph), m_isKept(graph.passes.size(), 0), m_needsHistory(graph.SubresourceCount(), 0) {}

    std::vector<uint8_t> Run() {
        while (MarkKept()) {
        }
        return std::move(m_isKept);
    }

  private:
    bool MarkKept();

    const ResourceUse* UsesBegin(const GraphPass& pass) const { return m_graph.uses.data() + pass.firstUse; }
    const ResourceUse* UsesEnd(const GraphPass& pass) const { return UsesBegin(pass) + pass.useCount; }
    void SetNeeded(const ResourceUse& use, uint8_t isNeeded) {
        m_graph.ForEachSubresource(use.resource, use.part,
                                   [&](uint32_t s, auto&&) { m_isNeeded[s] = isNeeded; });
    }
    bool IsNeeded(const ResourceUse& use) const {
        bool isNeeded = false;
        m_graph.ForEachSubresource(use.resource, use.part,
                                   [&](uint32_t s, auto&&) { isNeeded = isNeeded || m_isNeeded[s]; });
        return isNeeded;
    }

    const FrameGraph& m_graph;
    std::vector<uint8_t> m_isKept;  // by pass
    // By subresource: m_isNeeded tells whether its contents are needed after the current pass, and
    // m_needsHistory whether those from before the frame are needed.
    std::vector<uint8_t> m_isNeeded;
    std::vector<uint8_t> m_needsHistory;
};

// Goes from the last pass to the first. Returns true if it has found a persistent resource whose earlier
// contents a kept pass needs: then its last write is needed, too, and the traversal has to be repeated.
bool Culler::MarkKept() {
    m_isNeeded.assign(m_graph.SubresourceCount(), 0);
    for (const Root& root : m_graph.roots)
        m_graph.ForEachSubresource(root.resource, [&](uint32_t s, auto&&) { m_isNeeded[s] = 1; });
    const auto forEachPersistent = [&](auto&& visit) {
        for (uint32_t r = 0; r < m_graph.resources.size(); ++r)
            if (m_graph.resources[r].origin == Origin::Persistent)
                m_graph.ForEachSubresource(
                    r, [&](uint32_t s, auto&&) { visit(m_graph.resources[r].persistence, s); });
    };
    forEachPersistent([&](Persistence persistence, uint32_t s) {
        if (persistence == Persistence::Always || m_needsHistory[s]) m_isNeeded[s] = 1;
    });
    for (size_t p = m_graph.passes.size(); p-- > 0;) {
        const GraphPass& pass = m_graph.passes[p];
        bool isKept = pass.keepAlive;
        for (auto use = UsesBegin(pass); use != UsesEnd(pass); ++use)
            isKept = isKept || (Writes(use->access) && IsNeeded(*use));
        m_isKept[p] = isKept;
        if (!isKept) continue;
        for (auto use = UsesBegin(pass); use != UsesEnd(pass); ++use) SetNeeded(*use, 0);
        for (auto use = UsesBegin(pass); use != UsesEnd(pass); ++use)
            if (PreservesContents(m_graph.resources[use->resource].kind, use->access)) SetNeeded(*use, 1);
    }
    bool isChanged = false;
    forEachPersistent([&](Persistence, uint32_t s) {
        if (!m_isNeeded[s] || m_needsHistory[s]) return;
        m_needsHistory[s] = 1;
        isChanged = true;
    });
    return isChanged;
}

}  // namespace

std::vector<uint8_t> LivePasses(const FrameGraph& graph) {
    return Culler(graph).Run();
}

}  // namespace raygraph
