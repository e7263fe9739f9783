#include "renderer/graph/plan_text.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>
#include <vector>

#include "base/printable.h"
#include "base/text.h"
#include "renderer/graph/text.h"

namespace raygraph {

namespace {

std::string Padded(std::string_view given, size_t width) {
    std::string text(given);
    text.append(text.size() < width ? width - text.size() : 1, ' ');
    return text;
}

// Returns text such as "ComputeShader write". Reads have no access if they need no write to be made
// available.
std::string SideText(VkPipelineStageFlags2 stages, VkAccessFlags2 access, const char* otherwise) {
    const std::string accessText = access == VK_ACCESS_2_NONE ? otherwise : AccessText(access);
    return accessText.empty() ? StagesText(stages) : StagesText(stages) + ' ' + accessText;
}

class PlanWriter {
  public:
    PlanWriter(const FrameGraph& graph, const Plan& plan) : m_graph(graph), m_plan(plan) {}

    std::string Write() {
        WriteSummary();
        WriteBarriers("before the first pass", m_plan.acquire);
        for (uint32_t batch = 0; batch < m_plan.batches.size(); ++batch) WriteBatch(batch);
        WriteFinish();
        WriteCulled();
        WriteResources();
        WriteBlocks();
        return std::move(m_text);
    }

  private:
    void WriteSummary();
    void WriteBarriers(const char* title, const BarrierRange& range);
    void WriteBarrier(const PlannedBarrier& barrier);
    void WriteBatch(uint32_t index);
    void WritePass(uint32_t position);
    void WriteFinish();
    void WriteCulled();
    void WriteResources();
    void WriteBlocks();
    std::string LifetimeText(const Lifetime& lifetime) const;
    uint64_t BlockBytes() const;

    const FrameGraph& m_graph;
    const Plan& m_plan;
    std::string m_text;
};

uint64_t PlanWriter::BlockBytes() const {
    const auto add = [](uint64_t sum, const rhi::MemoryRequirements& block) { return sum + block.size; };
    return std::accumulate(m_plan.blocks.begin(), m_plan.blocks.end(), uint64_t{0}, add);
}

void PlanWriter::WriteSummary() {
    m_text += Counted(m_plan.passes.size(), "pass", "passes");
    if (!m_plan.culled.empty()) m_text += Text(", {} culled", m_plan.culled.size());
    m_text += ", " + Counted(m_plan.barriers.size(), "barrier", "barriers");
    if (!m_plan.blocks.empty()) {
        m_text += ", " + BytesText(BlockBytes()) + " of transient memory";
        const uint64_t saved = m_plan.bytesWithoutAliasing - BlockBytes();
        if (saved > 0) m_text += " (" + BytesText(saved) + " saved by sharing)";
    }
    m_text += '\n';
}

void PlanWriter::WriteBarriers(const char* title, const BarrierRange& range) {
    if (range.count == 0) return;
    m_text += std::string("\n") + title + '\n';
    for (uint32_t b = 0; b < range.count; ++b) WriteBarrier(m_plan.barriers[range.first + b]);
}

void PlanWriter::WriteBarrier(const PlannedBarrier& barrier) {
    m_text += "    waits   " + BarrierText(m_graph, barrier) + '\n';
}

void PlanWriter::WriteBatch(uint32_t index) {
    const PlannedBatch& batch = m_plan.batches[index];
    if (m_plan.batches.size() > 1) {
        const char* queue = batch.queue == rhi::QueueKind::Compute ? "compute" : "main";
        m_text += Text("\nbatch {} on the {} queue", index + 1, queue);
        if (batch.waitsFor != kNone) m_text += Text(", after batch {}", batch.waitsFor + 1);
        m_text += '\n';
    }
    for (uint32_t position = batch.firstPass; position < batch.firstPass + batch.passCount; ++position)
        WritePass(position);
    for (uint32_t b = 0; b < batch.release.count; ++b)
        m_text += "    hands over " + BarrierText(m_graph, m_plan.barriers[batch.release.first + b]) + '\n';
}

void PlanWriter::WritePass(uint32_t position) {
    const PlannedPass& planned = m_plan.passes[position];
    const GraphPass& pass = m_graph.passes[planned.pass];
    m_text += Text("\n{} {} ({})\n", position + 1, pass.name, Name(pass.kind));
    for (uint32_t u = pass.firstUse; u < pass.firstUse + pass.useCount; ++u) {
        const ResourceUse& use = m_graph.uses[u];
        const bool isWrite = Writes(use.access);
        m_text += isWrite ? (NeedsContents(use.access) ? "    updates " : "    writes  ") : "    reads   ";
        m_text += UseText(m_graph, use) + '\n';
    }
    for (uint32_t b = 0; b < planned.barriers.count; ++b)
        WriteBarrier(m_plan.barriers[planned.barriers.first + b]);
}

void PlanWriter::WriteFinish() {
    if (m_graph.roots.empty() && m_plan.finish.count == 0 && m_plan.regain.count == 0) return;
    m_text += "\nend\n";
    for (const Root& root : m_graph.roots) {
        const char* verb = root.kind == RootKind::Presented  ? "    shows   "
                           : root.kind == RootKind::Exported ? "    exports "
                                                             : "    reads   ";
        m_text += Text("{}{} v{}", verb, m_graph.resources[root.resource].name, root.version);
        if (root.kind == RootKind::HostRead) m_text += " (on the host)";
        m_text += '\n';
    }
    for (uint32_t b = 0; b < m_plan.regain.count; ++b) WriteBarrier(m_plan.barriers[m_plan.regain.first + b]);
    for (uint32_t b = 0; b < m_plan.finish.count; ++b) WriteBarrier(m_plan.barriers[m_plan.finish.first + b]);
    for (uint32_t b = 0; b < m_plan.release.count; ++b)
        WriteBarrier(m_plan.barriers[m_plan.release.first + b]);
}

void PlanWriter::WriteCulled() {
    if (m_plan.culled.empty()) return;
    m_text += "\nculled\n";
    for (const uint32_t p : m_plan.culled) {
        const GraphPass& pass = m_graph.passes[p];
        m_text += Text("    {} ({}): {}\n", pass.name, Name(pass.kind), CullReason(m_graph, m_plan, p));
    }
}

std::string PlanWriter::LifetimeText(const Lifetime& lifetime) const {
    if (!lifetime.IsUsed()) return "unused";
    if (lifetime.last == m_plan.passes.size()) return Text("passes {}-end", lifetime.first + 1);
    if (lifetime.first == lifetime.last) return Text("pass {}", lifetime.first + 1);
    return Text("passes {}-{}", lifetime.first + 1, lifetime.last + 1);
}

void PlanWriter::WriteResources() {
    if (m_graph.resources.empty()) return;
    size_t width = 0;
    for (const GraphResource& resource : m_graph.resources) width = std::max(width, resource.name.size());
    m_text += "\nresources\n";
    for (size_t r = 0; r < m_graph.resources.size(); ++r) {
        const GraphResource& resource = m_graph.resources[r];
        m_text += "    " + Padded(resource.name, width + 2) + Padded(ResourceText(resource), 28) +
                  Padded(Name(resource.origin), 12) + LifetimeText(m_plan.lifetimes[r]) + '\n';
    }
}

void PlanWriter::WriteBlocks() {
    if (m_plan.blocks.empty()) return;
    m_text += "\nmemory\n";
    for (uint32_t block = 0; block < m_plan.blocks.size(); ++block) {
        std::vector<uint32_t> occupants;
        for (uint32_t r = 0; r < m_plan.lifetimes.size(); ++r)
            if (m_plan.lifetimes[r].block == block) occupants.push_back(r);
        std::sort(occupants.begin(), occupants.end(), [&](uint32_t a, uint32_t b) {
            return m_plan.lifetimes[a].first < m_plan.lifetimes[b].first;
        });
        m_text += Text("    block {}, {}:", block, BytesText(m_plan.blocks[block].size));
        for (size_t i = 0; i < occupants.size(); ++i)
            m_text.append(i == 0 ? " " : ", then ").append(m_graph.resources[occupants[i]].name);
        m_text += '\n';
    }
}

}  // namespace

std::string UseText(const FrameGraph& graph, const ResourceUse& use) {
    const GraphResource& resource = graph.resources[use.resource];
    return Text("{} v{}{} ({})", resource.name, use.versionOut,
                rhi::PartText(use.part, resource.levels, resource.layers), Name(use.access));
}

// Returns text such as "radiance: RayTracingShader write -> ComputeShader read, General".
std::string BarrierText(const FrameGraph& graph, const PlannedBarrier& barrier) {
    const GraphResource& resource = graph.resources[barrier.resource];
    const Dependency& dependency = barrier.dependency;
    std::string text =
        Text("{}{}: ", resource.name, rhi::PartText(barrier.part, resource.levels, resource.layers));
    if (barrier.predecessor != kNone)
        text += Text("memory of {}, ", graph.resources[barrier.predecessor].name);
    else if (barrier.followsLastFrame)
        text += "memory of the last frame, ";
    if (dependency.srcStages == VK_PIPELINE_STAGE_2_NONE)
        text += "first use";
    else
        text += SideText(dependency.srcStages, dependency.srcAccess & kWriteAccesses, "done");
    text += " -> " + SideText(dependency.dstStages, dependency.dstAccess, "");
    if (resource.kind == ResourceKind::Texture) {
        text += ", ";
        if (dependency.oldLayout != dependency.newLayout)
            text += std::string(LayoutText(dependency.oldLayout)) + " -> ";
        text += LayoutText(dependency.newLayout);
    }
    if (barrier.srcQueueFamily != barrier.dstQueueFamily)
        text += Text(", queue family {} -> {}", barrier.srcQueueFamily, barrier.dstQueueFamily);
    return text;
}

std::string ResourceText(const GraphResource& resource) {
    const char* const kind = Name(resource.kind);
    if (resource.kind == ResourceKind::Texture) {
        std::string text = Text("{} {}x{} {}", kind, resource.extent.width, resource.extent.height,
                                rhi::Name(resource.format));
        if (resource.levels > 1) text += Text(", {} levels", resource.levels);
        if (resource.layers > 1) text += Text(", {} layers", resource.layers);
        return text;
    }
    if (resource.kind == ResourceKind::Buffer) return Text("{} {}", kind, BytesText(resource.bytes));
    return kind;
}

std::string CullReason(const FrameGraph& graph, const Plan& plan, uint32_t culled) {
    const GraphPass& pass = graph.passes[culled];
    if (pass.waits) return "its series goes on with it in another frame";
    std::string unused;
    std::string culledReaders;
    const auto add = [](std::string& list, std::string_view name) {
        if (list.find(name) == std::string::npos) list.append(list.empty() ? "" : ", ").append(name);
    };
    for (uint32_t u = pass.firstUse; u < pass.firstUse + pass.useCount; ++u) {
        const ResourceUse& use = graph.uses[u];
        if (!Writes(use.access)) continue;
        // A write of a part leaves other parts, whose readers may follow after more writes.
        const GraphResource& resource = graph.resources[use.resource];
        const bool hasManySubresources = resource.SubresourceCount() > 1;
        bool isUsed = false;
        for (const uint32_t other : plan.culled) {
            const GraphPass& reader = graph.passes[other];
            if (&reader == &pass) continue;
            for (uint32_t v = reader.firstUse; v < reader.firstUse + reader.useCount; ++v) {
                const ResourceUse& read = graph.uses[v];
                if (read.resource != use.resource || !rhi::Overlap(read.part, use.part)) continue;
                if (hasManySubresources ? read.versionIn < use.versionOut : read.versionIn != use.versionOut)
                    continue;
                isUsed = true;
                add(culledReaders, reader.name);
            }
        }
        if (!isUsed)
            add(unused,
                Text("{}{}", resource.name, rhi::PartText(use.part, resource.levels, resource.layers)));
    }
    if (unused.empty() && culledReaders.empty()) return "it writes nothing";
    std::string why;
    if (!unused.empty()) why = "nothing needs " + unused;
    if (!culledReaders.empty())
        why += (why.empty() ? "" : "; ") + ("only culled " + culledReaders + " needs it");
    return why;
}

std::string DescribePlan(const FrameGraph& graph, const Plan& plan) {
    return PlanWriter(graph, plan).Write();
}

// --- The plan as a graph for Graphviz ---

namespace {

std::string Escaped(std::string_view text) {
    std::string escaped;
    for (const char c : text) {
        if (c == '"' || c == '\\') escaped += '\\';
        escaped += c;
    }
    return escaped;
}

std::string Node(const char* prefix, uint32_t index) {
    return Text("{}{}", prefix, index);
}

// Returns the attributes of an edge, with its part of the texture.
std::string EdgeStyle(const std::string& style, const std::string& part) {
    std::string attributes = style.empty() ? "" : "style=" + style;
    if (!part.empty()) attributes += (style.empty() ? "" : ", ") + Text("label=\"{}\"", part.substr(1));
    return attributes.empty() ? ";\n" : " [" + attributes + "];\n";
}

std::string VersionNode(uint32_t resource, uint32_t version) {
    return Node("r", resource) + Node("v", version);
}

}  // namespace

std::string DescribePlanDot(const FrameGraph& graph, const Plan& plan) {
    std::string dot = "digraph frame {\n    rankdir=LR;\n    node [fontname=\"sans-serif\"];\n";
    std::vector<uint8_t> isCulled(graph.passes.size(), 0);
    for (const uint32_t p : plan.culled) isCulled[p] = 1;
    std::vector<uint32_t> position(graph.passes.size(), 0);
    for (uint32_t i = 0; i < plan.passes.size(); ++i) position[plan.passes[i].pass] = i + 1;

    for (uint32_t p = 0; p < graph.passes.size(); ++p) {
        const GraphPass& pass = graph.passes[p];
        const std::string number = isCulled[p] ? "culled" : std::to_string(position[p]);
        dot += "    " + Node("p", p) + " [shape=box, style=" + (isCulled[p] ? "dashed" : "solid") +
               ", label=\"" + number + ' ' + Escaped(pass.name) + "\\n" + Name(pass.kind) + "\"];\n";
    }
    // Nodes are those versions that a pass accesses, or that are shown.
    std::vector<std::string> nodes;
    const auto addNode = [&](uint32_t resource, uint32_t version) {
        const std::string node = VersionNode(resource, version);
        if (std::find(nodes.begin(), nodes.end(), node) != nodes.end()) return;
        nodes.push_back(node);
        const GraphResource& info = graph.resources[resource];
        dot += Text("    {} [shape=ellipse, style={}, label=\"{} v{}\"];\n", node,
                    (info.origin == Origin::Transient ? "solid" : "bold"), Escaped(info.name), version);
    };
    const auto addEdge = [&](const std::string& from, const std::string& to, const std::string& style) {
        dot.append("    ").append(from).append(" -> ").append(to).append(style);
    };
    for (uint32_t p = 0; p < graph.passes.size(); ++p) {
        const GraphPass& pass = graph.passes[p];
        const std::string passNode = Node("p", p);
        for (uint32_t u = pass.firstUse; u < pass.firstUse + pass.useCount; ++u) {
            const ResourceUse& use = graph.uses[u];
            const GraphResource& resource = graph.resources[use.resource];
            const std::string part = rhi::PartText(use.part, resource.levels, resource.layers);
            const std::string style = EdgeStyle(isCulled[p] ? "dashed" : "", part);
            if (NeedsContents(use.access)) {
                addNode(use.resource, use.versionIn);
                addEdge(VersionNode(use.resource, use.versionIn), passNode, style);
            }
            if (!Writes(use.access)) continue;
            addNode(use.resource, use.versionOut);
            addEdge(passNode, VersionNode(use.resource, use.versionOut), style);
            // The other parts are those of the version before.
            if (part.empty() || (use.versionIn == 0 && resource.origin == Origin::Transient)) continue;
            addNode(use.resource, use.versionIn);
            addEdge(VersionNode(use.resource, use.versionIn), VersionNode(use.resource, use.versionOut),
                    EdgeStyle("dotted", ""));
        }
    }
    for (size_t i = 0; i < graph.roots.size(); ++i) {
        const Root& root = graph.roots[i];
        const char* label = root.kind == RootKind::Presented  ? "shown"
                            : root.kind == RootKind::Exported ? "exported"
                                                              : "read on the host";
        addNode(root.resource, root.version);
        dot += Text("    root{} [shape=plaintext, label=\"{}\"];\n", i, label);
        dot += Text("    {} -> root{};\n", VersionNode(root.resource, root.version), i);
    }
    return dot + "}\n";
}

// --- The plan as JSON ---

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

    Json Build() const {
        Json json;
        json["schema"] = 1;
        json["acquire"] = {{"barriers", Barriers(m_plan.acquire)}};
        json["passes"] = Json::array();
        for (const PlannedPass& planned : m_plan.passes) json["passes"].push_back(Pass(planned));
        json["batches"] = Json::array();
        for (const PlannedBatch& batch : m_plan.batches) json["batches"].push_back(Batch(batch));
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

    // Passes are counted among the executed ones.
    Json Batch(const PlannedBatch& batch) const {
        Json json{{"queue", batch.queue == rhi::QueueKind::Compute ? "compute" : "main"},
                  {"first_pass", batch.firstPass},
                  {"passes", batch.passCount},
                  {"release", Barriers(batch.release)}};
        if (batch.waitsFor != kNone) json["waits_for"] = batch.waitsFor;
        return json;
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
        Json barriers = Barriers(m_plan.regain);
        for (Json& barrier : Barriers(m_plan.finish)) barriers.push_back(std::move(barrier));
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
    return PlanJson(graph, plan).Build().dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace raygraph
