#include <algorithm>

#include <vector>
#include "base/text.h"

#include "renderer/graph/plan_text.h"

namespace raygraph {

namespace {

std::string Escaped(const std::string& text) {
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

}  // namespace raygraph
