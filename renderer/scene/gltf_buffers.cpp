#include "renderer/scene/gltf_buffers.h"

namespace raygraph::scene {

GltfBuffers::GltfBuffers(GltfContext& context, const JsonValue& root, const AccessorTables& tables,
                         const GltfContainer& container)
    : m_context(context),
      m_buffers(root["buffers"]),
      m_tables(tables),
      m_container(container),
      m_files(tables.bufferLengths.size()) {}

std::span<const std::byte> GltfBuffers::View(uint32_t view) {
    const BufferView& info = m_tables.views[view];
    return Buffer(info.buffer).subspan(info.byteOffset, info.byteLength);
}

std::span<const std::byte> GltfBuffers::Buffer(uint32_t buffer) {
    const JsonValue value = m_buffers.At(buffer);
    const JsonValue uri = value["uri"];
    const uint64_t length = m_tables.bufferLengths[buffer];
    std::span<const std::byte> bytes;
    if (uri.IsPresent()) {
        if (!m_files[buffer]) m_files[buffer] = m_context.ReadUri(uri);
        bytes = *m_files[buffer];
    } else {
        if (buffer != 0 || !m_container.hasBinary) value.Fail("has no uri, and the file no BIN chunk for it");
        bytes = m_container.binary;
    }
    if (bytes.size() < length)
        value["byteLength"].Fail("is " + std::to_string(length) + ", but the buffer has " +
                                 std::to_string(bytes.size()) + " bytes");
    return bytes.first(length);
}

}  // namespace raygraph::scene
