#include "renderer/scene/gltf/context.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <thread>

#include "base/printable.h"
#include "base/text.h"
#include "renderer/scene/gltf/container.h"

namespace raygraph::scene {

bool Warnings::IsNew(std::string_view topic, std::string_view text) {
    constexpr size_t kMaxRemembered = 100'000;  // A file may give any number of warnings.
    const std::hash<std::string_view> hash;
    const uint64_t line = hash(text) + 31 * uint64_t{hash(topic)};
    return m_said.size() < kMaxRemembered ? m_said.insert(line).second : !m_said.contains(line);
}

void Warnings::Add(std::string_view topic, std::string text) {
    if (!IsNew(topic, text)) return;
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
        if (entry.count > 1) entry.text += Text(" (and {} more)", entry.count - 1);
        lines.push_back(std::move(entry.text));
    }
    m_entries.clear();
    m_said.clear();
    return lines;
}

std::string CountPhrase(uint64_t count, std::string_view one, std::string_view many) {
    return (count == 1 ? "there is " : "there are ") + Counted(count, one, many);
}

std::string GltfContext::Line(const std::string& path, const std::string& what) const {
    return Text("{}: {}{}{}", label, path, path.empty() ? "" : ": ", what);
}

void GltfContext::Fail(const std::string& path, const std::string& why) const {
    throw Error(ErrorKind::BadInput, Line(path, why));
}

void GltfContext::Warn(const std::string& path, std::string_view topic, const std::string& what) {
    warnings.Add(topic, Line(path, what));
}

uint64_t GltfContext::MemoryLimit(uint64_t sourceBytes) const {
    constexpr uint64_t kMax = std::numeric_limits<uint64_t>::max(), kPerByte = 64;
    const uint64_t always = options.limits.maxGeometryBytes;
    return sourceBytes > (kMax - always) / kPerByte ? kMax : always + kPerByte * sourceBytes;
}

void GltfContext::ChargeGeometry(const Place& where, uint64_t bytes) {
    const uint64_t limit = MemoryLimit(bytesRead);
    if (bytes > limit || geometryBytes > limit - bytes)
        Fail(where,
             Text("decoded geometry exceeds the limit of {} bytes for files of {} bytes", limit, bytesRead));
    geometryBytes += bytes;
}

void GltfContext::ChargeCompressed(const Place& where, uint64_t bytes) {
    compressedBytes += bytes;
    if (compressedBytes / 16 > bytesRead)
        Fail(where, Text("{} compressed bytes to decode so far, of files of {} bytes: too many primitives "
                         "share their compressed data",
                         compressedBytes, bytesRead));
}

void GltfContext::CheckModelBytes(uint64_t bytes, uint64_t jsonBytes) const {
    const uint64_t limit = MemoryLimit(jsonBytes);
    if (bytes > limit)
        Fail("", Text("a model of its objects exceeds the limit of {} bytes for a JSON text of {} bytes",
                      limit, jsonBytes));
}

void GltfContext::Progress(std::string_view stage, float fraction) const {
    if (options.progress) options.progress(stage, fraction);
}

unsigned GltfContext::ThreadCount() const {
    constexpr unsigned kMaxThreads = 256;
    const unsigned wanted = options.maxThreads;
    return std::clamp(wanted != 0 ? wanted : std::thread::hardware_concurrency(), 1u, kMaxThreads);
}

std::vector<std::byte> GltfContext::ReadUri(const std::string& uri, const Place& where) {
    const uint64_t bytesLeft = options.limits.maxFileBytes - bytesRead;
    try {
        std::vector<std::byte> bytes =
            IsDataUri(uri) ? DecodeDataUri(uri, bytesLeft) : folder.Read(uri, bytesLeft);
        bytesRead += bytes.size();
        return bytes;
    } catch (const Error& error) {
        Fail(where, error.what());
    }
}

}  // namespace raygraph::scene
