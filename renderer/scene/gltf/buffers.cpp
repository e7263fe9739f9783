#include "renderer/scene/gltf/buffers.h"

#include "base/text.h"

namespace raygraph::scene {

GltfBuffers::GltfBuffers(GltfContext& context, const std::vector<BufferSource>& sources,
                         const AccessorTables& tables, const GltfContainer& container)
    : m_context(context),
      m_sources(sources),
      m_tables(tables),
      m_container(container),
      m_files(tables.bufferLengths.size()),
      m_decoded(tables.views.size()) {}

std::span<const std::byte> GltfBuffers::View(uint32_t view) {
    const BufferView& info = m_tables.views[view];
    if (!info.meshopt) return Buffer(info.buffer).subspan(info.byteOffset, info.byteLength);
    const MeshoptView& source = *info.meshopt;
    if (!m_decoded[view])
        m_decoded[view] = DecodeMeshopt(m_context, source,
                                        Buffer(source.buffer).subspan(source.byteOffset, source.byteLength),
                                        Place("bufferViews")[view]);
    return *m_decoded[view];
}

std::span<const std::byte> GltfBuffers::Buffer(uint32_t buffer) {
    const Place where = Place("buffers")[buffer];
    const std::optional<std::string>& uri = m_sources[buffer].uri;
    const uint64_t length = m_tables.bufferLengths[buffer];
    std::span<const std::byte> bytes;
    if (uri) {
        if (!m_files[buffer]) m_files[buffer] = m_context.ReadUri(*uri, where["uri"]);
        bytes = *m_files[buffer];
    } else {
        if (buffer != 0 || !m_container.hasBinary)
            m_context.Fail(where, "has no uri, and the file no BIN chunk for it");
        bytes = m_container.binary;
    }
    if (bytes.size() < length)
        m_context.Fail(where["byteLength"], Text("is {}, but the buffer has {} bytes", length, bytes.size()));
    return bytes.first(length);
}

}  // namespace raygraph::scene
