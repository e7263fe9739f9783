#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>
#include <vector>

#include "renderer/graph/plan_text.h"
#include "renderer/graph/text.h"

namespace raygraph {

namespace {

using Json = nlohmann::ordered_json;

const char* Name(RootKind kind) {
    switch (kind) {
        case RootKind::Presented:
            return "presented";
        case RootKind::Exported:
            return "exported";
        case RootKind::HostRead:
            break;
    }
    return "read on the host";
}

class PlanJson {
  public:
    PlanJson(const FrameGraph& graph, const Plan& plan) : m_graph(graph), m_plan(plan) {}

    Json Make() const {
        Json json;
        json["schema"] = 1;
        json["acquire"] = {{"barriers", Barriers(m_plan.acquire)}};
        json["passes"] = Json::array();
        for (const PlannedPass& planned : m_plan.passes) json["passes"].push_back(Pass(planned));
        json["end"] = End();
        json["culled"] = Json::array();
        for (const uint32_t culled : m_plan.culled) {
            Json pass = Declared(m_graph.passes[culled]);
            pass["why"] = CullReason(m_graph, m_plan, culled);
            json["culled"].push_back(std::move(pass));
        }
        json["resources"] = Json::array();
        for (uint32_t r = 0; r < m_graph.resources.size(); ++r) json["resources"].push_back(Resource(r));
        json["memory"] = Memory();
        return json;
    }

  private:
    // Returns a resource, or a part of a texture.
    Json Named(uint32_t resource, const Subresources& part) const {
        const GraphResource& info = m_graph.resources[resource];
        Json json{{"resource", resource}, {"name", info.name}};
        if (part == info.Whole()) return json;
        json["first_level"] = part.level;
        json["levels"] = part.levelCount;
        json["first_layer"] = part.layer;
        json["layers"] = part.layerCount;
        return json;
    }

    Json Declared(const GraphPass& pass) const {
        Json reads = Json::array(), writes = Json::array();
        for (uint32_t u = pass.firstUse; u < pass.firstUse + pass.useCount; ++u) {
            const ResourceUse& use = m_graph.uses[u];
            const auto add = [&](Json& list, uint32_t version) {
                list.push_back(Named(use.resource, use.part));
                list.back()["version"] = version;
                list.back()["access"] = Name(use.access);
            };
            if (NeedsContents(use.access)) add(reads, use.versionIn);
            if (Writes(use.access)) add(writes, use.versionOut);
        }
        return {{"name", pass.name}, {"kind", Name(pass.kind)}, {"reads", reads}, {"writes", writes}};
    }

    Json Pass(const PlannedPass& planned) const {
        Json pass = Declared(m_graph.passes[planned.pass]);
        pass["barriers"] = Barriers(planned.barriers);
        return pass;
    }

    Json Barriers(const BarrierRange& range) const {
        Json list = Json::array();
        for (uint32_t b = range.first; b < range.first + range.count; ++b)
            list.push_back(Barrier(m_plan.barriers[b]));
        return list;
    }

    static Json Side(VkPipelineStageFlags2 stages, VkAccessFlags2 access) {
        Json names = Json::array();
        const std::string text = stages == VK_PIPELINE_STAGE_2_NONE ? "" : StagesText(stages);
        for (size_t begin = 0; begin < text.size();) {
            const size_t end = std::min(text.find('|', begin), text.size());
            names.push_back(text.substr(begin, end - begin));
            begin = end + 1;
        }
        return {{"stages", names}, {"access", AccessText(access)}};
    }

    Json Barrier(const PlannedBarrier& barrier) const {
        const Dependency& dependency = barrier.dependency;
        Json json = Named(barrier.resource, barrier.part);
        json["from"] = Side(dependency.srcStages, dependency.srcAccess & kWriteAccesses);
        json["to"] = Side(dependency.dstStages, dependency.dstAccess);
        if (m_graph.resources[barrier.resource].kind == ResourceKind::Texture) {
            json["from"]["layout"] = LayoutText(dependency.oldLayout);
            json["to"]["layout"] = LayoutText(dependency.newLayout);
        }
        if (barrier.srcQueueFamily != barrier.dstQueueFamily) {
            json["from"]["queue_family"] = barrier.srcQueueFamily;
            json["to"]["queue_family"] = barrier.dstQueueFamily;
        }
        // The resource whose memory it takes over
        if (barrier.predecessor != kNone)
            json["memory_of"] = barrier.predecessor;
        else if (barrier.followsLastFrame)
            json["follows_last_frame"] = true;
        return json;
    }

    Json End() const {
        Json roots = Json::array();
        for (const Root& root : m_graph.roots) {
            Json json = Named(root.resource, m_graph.resources[root.resource].Whole());
            json["version"] = root.version;
            json["kind"] = Name(root.kind);
            roots.push_back(std::move(json));
        }
        Json barriers = Barriers(m_plan.finish);
        for (Json& barrier : Barriers(m_plan.release)) barriers.push_back(std::move(barrier));
        return {{"roots", roots}, {"barriers", barriers}};
    }

    Json Resource(uint32_t index) const {
        const GraphResource& resource = m_graph.resources[index];
        const Lifetime& lifetime = m_plan.lifetimes[index];
        Json json{{"name", resource.name}, {"kind", Name(resource.kind)}, {"origin", Name(resource.origin)}};
        if (resource.kind == ResourceKind::Texture) {
            json["width"] = resource.extent.width;
            json["height"] = resource.extent.height;
            json["format"] = rhi::Name(resource.format);
            json["levels"] = resource.levels;
            json["layers"] = resource.layers;
        }
        if (resource.kind == ResourceKind::Buffer) json["bytes"] = resource.bytes;
        json["first_pass"] = lifetime.IsUsed() ? Json(lifetime.first) : Json();
        json["last_pass"] = lifetime.IsUsed() ? Json(lifetime.last) : Json();
        json["block"] = lifetime.block == kNone ? Json() : Json(lifetime.block);
        return json;
    }

    Json Memory() const {
        Json blocks = Json::array();
        uint64_t bytes = 0;
        for (uint32_t block = 0; block < m_plan.blocks.size(); ++block) {
            std::vector<uint32_t> occupants;
            for (uint32_t r = 0; r < m_plan.lifetimes.size(); ++r)
                if (m_plan.lifetimes[r].block == block) occupants.push_back(r);
            std::ranges::stable_sort(occupants, {}, [&](uint32_t r) { return m_plan.lifetimes[r].first; });
            bytes += m_plan.blocks[block].size;
            blocks.push_back({{"bytes", m_plan.blocks[block].size}, {"resources", occupants}});
        }
        return {{"bytes", bytes},
                {"bytes_without_sharing", m_plan.bytesWithoutAliasing},
                {"blocks", std::move(blocks)}};
    }

    const FrameGraph& m_graph;
    const Plan& m_plan;
};

}  // namespace

std::string DescribePlanJson(const FrameGraph& graph, const Plan& plan) {
    return PlanJson(graph, plan).Make().dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace raygraph
