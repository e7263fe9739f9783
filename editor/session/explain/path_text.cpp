#include "editor/session/explain/path_text.h"

#include <algorithm>
#include <optional>

#include "base/printable.h"
#include "base/text.h"
#include "passes/trace.h"
#include "shaders/shared/bxdf_flags.h"

namespace raygraph::session {

namespace {

using Vertex = gpu::PathVertexRecord;

PathEvent EventOf(const Vertex& vertex) {
    return static_cast<PathEvent>(vertex.event);
}

bool IsBlack(const glm::vec3& value) {
    return value == glm::vec3(0.0f);
}

std::string Triple(const glm::vec3& v) {
    return Text("({:.4g} {:.4g} {:.4g})", v.x + 0.0f, v.y + 0.0f, v.z + 0.0f);  // -0 is 0
}

std::string Triple(const glm::dvec3& v) {
    return Text("({:.6g} {:.6g} {:.6g})", v.x, v.y, v.z);
}

// Returns what a bias has made of a contribution, for the end of its line; "" if it is as computed.
std::string ClampedTo(const glm::vec3& computed, const glm::vec3& value) {
    const glm::vec3 lost = computed - value;
    const bool isClamped =
        std::max({lost.x, lost.y, lost.z}) > 1e-3f * std::max({computed.x, computed.y, computed.z});
    return isClamped ? Text(", clamped to {} by --clamp-indirect", Triple(value)) : "";
}

std::string Percent(double share) {
    return Text("{:.3g} %", 100.0 * share);
}

// Returns, for example, "rough glass".
std::string LobeName(const Vertex& vertex) {
    if (EventOf(vertex) == PathEvent::Medium) return "medium";
    const uint32_t flags = vertex.scatterFlags;
    const char* width = (flags & kBxDFSpecular) != 0  ? "smooth "
                        : (flags & kBxDFDiffuse) != 0 ? ""
                                                      : "rough ";
    const std::string lobe = vertex.lobe > 0               ? Name(static_cast<PathLobe>(vertex.lobe))
                             : (flags & kBxDFDiffuse) != 0 ? "diffuse"
                                                           : "glossy";
    return width + lobe;
}

// Returns, for example, "the rough glass lobe of "bowl"".
std::string LobeOf(const Vertex& vertex, const PathNames& names) {
    if (EventOf(vertex) == PathEvent::Medium) return "the medium " + names.Material(vertex.medium);
    return Text("the {} lobe of {}", LobeName(vertex), names.Material(vertex.material));
}

// Returns what scatters light at the vertex.
const char* ScatteringOf(const Vertex& vertex) {
    return EventOf(vertex) == PathEvent::Medium ? "phase function" : "BSDF";
}

// Returns the vertex that gave the ray to `vertex` its direction; none: the camera.
std::optional<size_t> ScatteredBy(const ExplainedPath& path, size_t vertex) {
    while (vertex-- > 0)
        if (const PathEvent event = EventOf(path.vertices[vertex]);
            event == PathEvent::Surface || event == PathEvent::Medium)
            return vertex;
    return std::nullopt;
}

std::string PlaceOf(const Vertex& vertex, const PathNames& names) {
    switch (EventOf(vertex)) {
        case PathEvent::Environment:
            return "environment";
        case PathEvent::Medium:
            return "medium " + names.Material(vertex.medium);
        default:
            break;
    }
    return Text("{} of {}", names.Material(vertex.material), names.Instance(vertex.instance));
}

void AddPlace(const Vertex& vertex, const PathNames& names, const glm::dvec3& origin,
              std::vector<std::string>& lines) {
    const PathEvent event = EventOf(vertex);
    if (event == PathEvent::Medium)
        lines.push_back(Text("at {}, {:.4g} m along the ray", Triple(glm::dvec3(vertex.position) + origin),
                             vertex.mediumLength));
    if (event != PathEvent::Environment && event != PathEvent::Medium) {
        lines.push_back(
            Text("triangle {} of instance {}, {} side, at {}, distance {:.4g} m, uv ({:.4g} {:.4g})",
                 vertex.primitive, vertex.instance, vertex.isFront != 0 ? "front" : "back",
                 Triple(glm::dvec3(vertex.position) + origin), vertex.distance, vertex.uv0.x, vertex.uv0.y));
        const std::string shading = Triple(vertex.shadingNormal), triangle = Triple(vertex.geometricNormal);
        lines.push_back(
            Text("normal {}{}", shading, triangle == shading ? "" : ", of the triangle " + triangle));
        lines.push_back(Text("base color {}, metallic {:.4g}, roughness {:.4g}, transmission {:.4g}",
                             Triple(vertex.baseColor), vertex.metallic, vertex.roughness,
                             vertex.transmission));
    }
    if (vertex.medium != gpu::kNoRecord)
        lines.push_back(Text("medium {}: {:.4g} m, factor {}", names.Material(vertex.medium),
                             vertex.mediumLength, Triple(vertex.mediumWeight)));
    if (vertex.wavelength > 0.0f) lines.push_back(Text("wavelength {:.4g} nm", vertex.wavelength));
}

void AddEmission(const Vertex& vertex, const PathNames& names, std::vector<std::string>& lines) {
    if (IsBlack(vertex.emission)) return;
    std::string densities;
    if (vertex.scatterPDF > 0.0f && vertex.lightPDF > 0.0f)
        densities =
            Text(" of pdf {:.4g} against {:.4g} of light samples", vertex.scatterPDF, vertex.lightPDF);
    const glm::vec3 computed = vertex.emission * vertex.arriving * vertex.emissionWeight;
    lines.push_back(Text("finds {}: emission {} x throughput {} x MIS weight {:.4g}{} = {}{}",
                         names.Emitter(vertex), Triple(vertex.emission), Triple(vertex.arriving),
                         vertex.emissionWeight, densities, Triple(computed),
                         ClampedTo(computed, vertex.emitted)));
}

void AddLights(const Vertex& vertex, const PathNames& names, std::vector<std::string>& lines) {
    for (uint32_t i = 0; i < vertex.candidateCount; ++i) {
        const gpu::LightCandidateRecord& light = vertex.candidates[i];
        const char* mark = i == vertex.chosen ? "light sample, chosen" : "light sample";
        if (light.light == gpu::kNoRecord || !(light.pdf > 0.0f)) {
            lines.push_back(Text("{}: {}, no light from there", mark, names.Light(light)));
            continue;
        }
        // The density of a light without extent is its probability
        const std::string density =
            light.pdf == light.probability ? "" : Text(", pdf {:.4g} with it", light.pdf);
        const std::string scattering =
            Text("{} {} of pdf {:.4g}", ScatteringOf(vertex), Triple(light.bsdf), light.scatterPDF);
        lines.push_back(Text("{}: {}, probability {:.4g}{}, radiance {}, {}, MIS weight {:.4g}", mark,
                             names.Light(light), light.probability, density, Triple(light.radiance),
                             scattering, light.weight));
    }
    if (vertex.chosen == gpu::kNoRecord || IsBlack(vertex.unoccluded)) return;
    const std::string light = Triple(vertex.unoccluded);
    const glm::vec3 through = vertex.unoccluded * vertex.visibility;
    if (IsBlack(vertex.visibility))
        lines.push_back(Text("its shadow ray is occluded: {} is lost", light));
    else if (vertex.visibility == glm::vec3(1.0f))
        lines.push_back(
            Text("its shadow ray is unoccluded: {} arrives{}", light, ClampedTo(through, vertex.lit)));
    else
        lines.push_back(Text("its shadow ray lets {} of {} through: {} arrives{}", Triple(vertex.visibility),
                             light, Triple(through), ClampedTo(through, vertex.lit)));
}

void AddScattering(const Vertex& vertex, const PathNames& names, std::vector<std::string>& lines) {
    if (vertex.passProbability > 0.0f)
        lines.push_back(Text("goes straight on with probability {:.4g}", vertex.passProbability));
    if (vertex.pdf > 0.0f) {
        const std::string chance =
            vertex.lobe > 0 ? Text(", chosen with probability {:.4g}", vertex.lobeProbability) : "";
        const bool isMedium = EventOf(vertex) == PathEvent::Medium;
        const bool isTransmitted = !isMedium && (vertex.scatterFlags & kBxDFTransmission) != 0;
        lines.push_back(Text("scatters by {}{}: {}{} {}, pdf {:.4g}{}", LobeOf(vertex, names), chance,
                             isTransmitted ? "transmitted, " : "", ScatteringOf(vertex), Triple(vertex.bsdf),
                             vertex.pdf, isMedium ? "" : Text(", cosine {:.4g}", vertex.cosine)));
    }
    if (vertex.survival > 0.0f)
        lines.push_back(
            Text("roulette: survives with {:.4g}, drawn {:.4g}", vertex.survival, vertex.rouletteNumber));
    const PathEnd end = static_cast<PathEnd>(vertex.end);
    if (end == PathEnd::None)
        lines.push_back("throughput " + Triple(vertex.throughput));
    else
        lines.push_back(Text("ends: {}", Notes(end)[vertex.end]));
}

std::string CauseOfBlack(const ExplainedPath& path, const PathNames& names) {
    uint32_t samples = 0, occluded = 0;
    for (const Vertex& vertex : path.vertices) {
        if (vertex.chosen == gpu::kNoRecord) continue;
        ++samples;
        if (IsBlack(vertex.visibility)) ++occluded;
    }
    if (path.vertices.empty()) return "no ray";
    const Vertex& last = path.vertices.back();
    const PathEnd end = static_cast<PathEnd>(last.end);
    std::string text = Text("no light: the path ends at vertex {} ({}): {}", path.vertices.size(),
                            PlaceOf(last, names), Notes(end)[last.end]);
    if (samples > 0)
        text += Text("; {}, {} occluded", Counted(samples, "light sample"), occluded);
    else
        text += "; no light was sampled";
    return text;
}

}  // namespace

std::string CauseOf(const ExplainedPath& path, const PathNames& names) {
    if (const std::optional<size_t> at = NonFiniteVertex(path.vertices)) {
        const Vertex& vertex = path.vertices[*at];
        return Text(
            "discarded, black in the picture: it is not finite from vertex {} ({}) on, which adds {} and {}",
            *at + 1, PlaceOf(vertex, names), Triple(vertex.emitted), Triple(vertex.lit));
    }
    size_t at = 0;
    bool isEmitted = true;
    double most = 0.0;
    for (size_t i = 0; i < path.vertices.size(); ++i)
        for (const bool emitted : {true, false}) {
            const double luminance = LuminanceOf(emitted ? path.vertices[i].emitted : path.vertices[i].lit);
            if (!(luminance > most)) continue;
            most = luminance;
            at = i;
            isEmitted = emitted;
        }
    if (most == 0.0) return CauseOfBlack(path, names);
    const Vertex& vertex = path.vertices[at];
    std::string text;
    if (isEmitted) {
        const std::optional<size_t> by = ScatteredBy(path, at);
        text = names.Emitter(vertex);
        if (by)
            text += Text(" by {}, pdf {:.3g}", LobeOf(path.vertices[*by], names), path.vertices[*by].pdf);
        else
            text += ", seen by the camera";
    } else {
        const gpu::LightCandidateRecord& light = vertex.candidates[vertex.chosen];
        text =
            Text("{}, sampled from {} with pdf {:.3g}, {} {:.3g}", names.Light(light), PlaceOf(vertex, names),
                 light.pdf, ScatteringOf(vertex), std::max({light.bsdf.x, light.bsdf.y, light.bsdf.z}));
    }
    text += Text(" (vertex {})", at + 1);
    const double whole = LuminanceOf(path.value);
    if (most < 0.995 * whole) text += Text(", {} of the sample", Percent(most / whole));
    return text;
}

VertexRow RowOf(const gpu::PathVertexRecord& vertex, const PathNames& names) {
    VertexRow row{.place = PlaceOf(vertex, names), .next = {}, .light = {}};
    const PathEnd end = static_cast<PathEnd>(vertex.end);
    if (end != PathEnd::None)
        row.next = Text("ends: {}", Notes(end)[vertex.end]);
    else if (EventOf(vertex) == PathEvent::Straight || EventOf(vertex) == PathEvent::Ignored)
        row.next = "straight on";
    else
        row.next = LobeName(vertex) + (vertex.lobe > 0 ? ", " + Percent(vertex.lobeProbability) : "");
    if (!IsBlack(vertex.emitted)) row.light = Text("{} {}", Triple(vertex.emitted), names.Emitter(vertex));
    if (vertex.chosen == gpu::kNoRecord || IsBlack(vertex.unoccluded)) return row;
    if (!row.light.empty()) row.light += ", ";
    row.light += (IsBlack(vertex.visibility) ? "occluded: " : Triple(vertex.lit) + " ") +
                 names.Light(vertex.candidates[vertex.chosen]);
    return row;
}

std::vector<std::string> LinesOf(const ExplainedPath& path, size_t at, const PathNames& names,
                                 const glm::dvec3& origin) {
    const Vertex& vertex = path.vertices[at];
    std::vector<std::string> lines;
    const char* how = EventOf(vertex) == PathEvent::Straight  ? ", passed straight"
                      : EventOf(vertex) == PathEvent::Ignored ? ", inside another medium: ignored"
                                                              : "";
    lines.push_back(Text("vertex {}: {}{}", at + 1, PlaceOf(vertex, names), how));
    AddPlace(vertex, names, origin, lines);
    AddEmission(vertex, names, lines);
    AddLights(vertex, names, lines);
    AddScattering(vertex, names, lines);
    return lines;
}

std::string Describe(const Explanation& explanation) {
    const size_t count = explanation.values.size();
    std::string text = Text("pixel {},{}", explanation.pixel.x, explanation.pixel.y);
    if (count > 1) {
        const auto black = std::ranges::count(explanation.values, glm::vec3(0.0f));
        text += Text(": mean {} of {} samples", Triple(glm::vec3(explanation.mean)), count);
        if (explanation.relativeError > 0.0)
            text += Text(", relative error {:.3g}", explanation.relativeError);
        if (black > 0) text += Text(", {} black", black);
        if (const size_t discarded = explanation.discarded.size(); discarded > 0)
            text += Text(", {} of them because they are not finite", discarded);
    }
    text += '\n';
    for (const ExplainedPath& path : explanation.paths) {
        const std::string share =
            path.varianceShare > 0.0 ? Text(", {} of the pixel's variance", Percent(path.varianceShare)) : "";
        text += Text("sample {}: {}{}: {}\n", path.sample, Triple(path.value), share,
                     CauseOf(path, explanation.names));
    }
    for (const ExplainedPath& path : explanation.paths) {
        text += Text("\nsample {}: {}\n", path.sample, Triple(path.value));
        for (size_t i = 0; i < path.vertices.size(); ++i) {
            const std::vector<std::string> lines = LinesOf(path, i, explanation.names, explanation.origin);
            for (size_t line = 0; line < lines.size(); ++line)
                text += Text("{}{}\n", line == 0 ? "  " : "    ", lines[line]);
        }
        if (NonFiniteVertex(path.vertices)) continue;
        const glm::vec3 sum = passes::ValueOf(path.vertices);
        text += Text("  the contributions sum to {}{}\n", Triple(sum),
                     path.isExact ? ", the sample's value to the bit"
                                  : ": this device rounds the recorded path differently");
    }
    return text;
}

}  // namespace raygraph::session
