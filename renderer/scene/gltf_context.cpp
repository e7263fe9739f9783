#include "renderer/scene/gltf_context.h"

#include <algorithm>

#include "base/error.h"
#include "renderer/scene/uri.h"

namespace raygraph::scene {

void Warnings::Add(std::string_view topic, std::string text) {
    const auto found =
        std::find_if(m_entries.begin(), m_entries.end(), [&](const Entry& e) { return e.topic == topic; });
    constexpr size_t kMaxTopics = 64;  // A file may name a million extensions.
    if (found == m_entries.end() && m_entries.size() == kMaxTopics) {
        m_entries.push_back({"", "further kinds of warnings are not shown", 1});
    } else if (found == m_entries.end() && m_entries.size() < kMaxTopics) {
        m_entries.push_back({std::string(topic), std::move(text), 1});
    } else if (found != m_entries.end()) {
        ++found->count;
    }
}

std::vector<std::string> Warnings::Take() {
    std::vector<std::string> lines;
    for (Entry& entry : m_entries) {
        if (entry.count > 1) entry.text += " (and " + std::to_string(entry.count - 1) + " more)";
        lines.push_back(std::move(entry.text));
    }
    m_entries.clear();
    return lines;
}

void GltfContext::Fail(const std::string& path, const std::string& why) const {
    throw Error(ErrorKind::BadInput, label + ": " + (path.empty() ? "" : path + ": ") + why);
}

void GltfContext::Warn(const JsonValue& where, std::string_view topic, const std::string& what) {
    Warn(where.Path(), topic, what);
}

void GltfContext::Warn(const std::string& path, std::string_view topic, const std::string& what) {
    warnings.Add(topic, label + ": " + (path.empty() ? "" : path + ": ") + what);
}

void GltfContext::ChargeGeometry(const JsonValue& where, uint64_t bytes) {
    const uint64_t limit = options.limits.maxGeometryBytes + 64 * bytesRead;
    if (bytes > limit || geometryBytes > limit - bytes)
        where.Fail("decoded geometry exceeds the limit of " + std::to_string(limit) +
                   " bytes for a file of " + std::to_string(bytesRead) + " bytes");
    geometryBytes += bytes;
}

void GltfContext::Progress(std::string_view stage, float fraction) const {
    if (options.progress) options.progress(stage, fraction);
}

std::vector<std::byte> GltfContext::ReadUri(const JsonValue& uri) {
    const std::string& text = uri.String();
    const uint64_t bytesLeft = options.limits.maxFileBytes - bytesRead;
    try {
        std::vector<std::byte> bytes =
            IsDataUri(text) ? DecodeDataUri(text, bytesLeft) : folder.Read(text, bytesLeft);
        bytesRead += bytes.size();
        return bytes;
    } catch (const Error& error) {
        uri.Fail(error.what());
    }
}

}  // namespace raygraph::scene
