#include "editor/cli/explain_json.h"

#include "editor/cli/json_values.h"
#include "editor/session/explain/path_text.h"

namespace raygraph::cli {

namespace {

using Json = nlohmann::ordered_json;
using session::Explanation;

// Functions by the types of path_vertex_list.h.
Json Json_uint(uint32_t value) {
    return value;
}
Json Json_PathIndex(uint32_t value) {
    return value == gpu::kNoRecord ? Json() : Json(value);
}
Json Json_float(float value) {
    return ValueJson(value);
}
Json Json_vec2(const glm::vec2& value) {
    return ValueJson(value);
}
Json Json_vec3(const glm::vec3& value) {
    return ValueJson(value);
}

// Returns a name as PathNames has it, without its quotes.
std::string Unquoted(std::string name) {
    return name.size() >= 2 && name.front() == '"' && name.back() == '"' &&
                   name.find('"', 1) == name.size() - 1
               ? name.substr(1, name.size() - 2)
               : name;
}

Json PlaceJson(const glm::dvec3& place) {
    return Json::array({place.x, place.y, place.z});
}

Json CandidateJson(const gpu::LightCandidateRecord& light, const session::PathNames& names) {
    Json json{{"name", Unquoted(names.Light(light))}};
#define RAYGRAPH_CANDIDATE_VALUE(type, name) json[#name] = Json_##type(light.name);
#include "shaders/shared/path_vertex_list.h"
    json["kind"] = Name(static_cast<PathLight>(light.kind));
    return json;
}

Json VertexJson(const gpu::PathVertexRecord& vertex, const Explanation& explanation) {
    const session::PathNames& names = explanation.names;
    Json json = Json::object();
#define RAYGRAPH_PATH_VALUE(type, name) json[#name] = Json_##type(vertex.name);
#include "shaders/shared/path_vertex_list.h"
    json["event"] = Name(static_cast<PathEvent>(vertex.event));
    json["lobe"] = Name(static_cast<PathLobe>(vertex.lobe));
    json["end"] = Name(static_cast<PathEnd>(vertex.end));
    for (const auto& [key, place] : {std::pair{"origin", vertex.origin},
                                     {"position", vertex.position},
                                     {"shadowOrigin", vertex.shadowOrigin}})
        json[key] = PlaceJson(glm::dvec3(place) + explanation.origin);
    if (vertex.instance != gpu::kNoRecord) {
        json["instanceName"] = Unquoted(names.Instance(vertex.instance));
        json["materialName"] = Unquoted(names.Material(vertex.material));
    }
    if (vertex.medium != gpu::kNoRecord) json["mediumName"] = Unquoted(names.Material(vertex.medium));
    json["candidates"] = Json::array();
    for (uint32_t i = 0; i < vertex.candidateCount; ++i)
        json["candidates"].push_back(CandidateJson(vertex.candidates[i], names));
    return json;
}

}  // namespace

std::string ExplanationJson(const Explanation& explanation) {
    Json json{{"schema", 1},
              {"pixel", {explanation.pixel.x, explanation.pixel.y}},
              {"firstSample", explanation.firstSample},
              {"samples", explanation.values.size()},
              {"mean", ValueJson(glm::vec3(explanation.mean))},
              {"relativeError", explanation.relativeError}};
    json["discarded"] = explanation.discarded;
    json["values"] = Json::array();
    for (const glm::vec3& value : explanation.values) json["values"].push_back(ValueJson(value));
    json["paths"] = Json::array();
    for (const session::ExplainedPath& path : explanation.paths) {
        Json& out = json["paths"].emplace_back();
        out["sample"] = path.sample;
        out["value"] = ValueJson(path.value);
        out["varianceShare"] = path.varianceShare;
        out["cause"] = CauseOf(path, explanation.names);
        out["isExact"] = path.isExact;
        out["vertices"] = Json::array();
        for (const gpu::PathVertexRecord& vertex : path.vertices)
            out["vertices"].push_back(VertexJson(vertex, explanation));
    }
    return json.dump(2) + '\n';
}

}  // namespace raygraph::cli
