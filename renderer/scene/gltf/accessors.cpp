#include "renderer/scene/gltf/accessors.h"

#include <string>

#include "base/check.h"
#include "base/printable.h"
#include "base/text.h"

namespace raygraph::scene {
namespace {

struct ElementShape {
    uint32_t columns;
    uint32_t rows;
};

ElementShape Shape(int type) {
    switch (type) {
        case TINYGLTF_TYPE_VEC2:
            return {1, 2};
        case TINYGLTF_TYPE_VEC3:
            return {1, 3};
        case TINYGLTF_TYPE_VEC4:
            return {1, 4};
        case TINYGLTF_TYPE_MAT2:
            return {2, 2};
        case TINYGLTF_TYPE_MAT3:
            return {3, 3};
        case TINYGLTF_TYPE_MAT4:
            return {4, 4};
        default:
            return {1, 1};
    }
}

ComponentType ReadComponentType(int type) {
    switch (type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
            return ComponentType::Int8;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return ComponentType::Uint8;
        case TINYGLTF_COMPONENT_TYPE_SHORT:
            return ComponentType::Int16;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return ComponentType::Uint16;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
            return ComponentType::Uint32;
        default:
            return ComponentType::Float;
    }
}

// Gives the bytes of an element. Matrix columns start at multiples of four bytes; the padding after the last
// one need not be there at the end of a buffer.
struct ElementSize {
    uint64_t stride = 0;  // the stride of tightly packed elements
    uint64_t used = 0;    // up to the end of the last component
};

ElementSize SizeOf(const ElementShape& shape, ComponentType type) {
    const uint64_t column = shape.rows * ByteSize(type);
    if (shape.columns == 1) return {column, column};
    const uint64_t padded = (column + 3) / 4 * 4;
    return {shape.columns * padded, (shape.columns - 1) * padded + column};
}

// Does `offset + stride * (count - 1) + element <= length` hold? In an order that cannot overflow.
bool Fits(uint64_t offset, uint64_t stride, uint64_t element, uint64_t count, uint64_t length) {
    if (element > length || offset > length - element) return false;
    return (count - 1) <= (length - element - offset) / stride;
}

class TableReader {
  public:
    TableReader(const GltfContext& context, const GltfDocument& document, AccessorTables& tables)
        : m_context(context), m_document(document), m_model(document.model), m_tables(tables) {
        for (const BufferSource& buffer : document.buffers)
            m_tables.bufferLengths.push_back(buffer.byteLength);
    }

    void Read() {
        // The count excludes the view that stands for none.
        m_placeholderView = m_model.bufferViews.size() - 1;
        for (size_t i = 0; i < m_placeholderView; ++i) m_tables.views.push_back(ReadView(i));
        for (size_t i = 0; i < m_model.accessors.size(); ++i) m_tables.accessors.push_back(ReadAccessor(i));
    }

  private:
    BufferView ReadView(size_t index) const {
        const gltf::BufferView& file = m_model.bufferViews[index];
        BufferView view{.buffer = static_cast<uint32_t>(file.buffer),
                        .byteOffset = file.byteOffset,
                        .byteLength = file.byteLength,
                        .byteStride = m_document.strides[index],
                        .meshopt = ReadMeshoptView(m_context, m_model, index, m_document.strides[index])};
        const Place where = Place("bufferViews")[index];
        RequireInside(where, view.buffer, view.byteOffset, view.byteLength);
        if (!view.meshopt) {
            RequireBytes(where, view.buffer);
        } else {
            const Place compressed = where["extensions"][view.meshopt->extension];
            RequireInside(compressed, view.meshopt->buffer, view.meshopt->byteOffset,
                          view.meshopt->byteLength);
            RequireBytes(compressed, view.meshopt->buffer);
        }
        return view;
    }

    void RequireInside(const Place& where, uint32_t buffer, uint64_t byteOffset, uint64_t byteLength) const {
        const uint64_t length = m_tables.bufferLengths[buffer];
        if (byteOffset > length || byteLength > length - byteOffset)
            m_context.Fail(where["byteLength"],
                           Text("{} from {} exceed{} buffers[{}] ({})", Counted(byteLength, "byte"),
                                byteOffset, byteLength == 1 ? "s" : "", buffer, Counted(length, "byte")));
    }

    void RequireBytes(const Place& where, uint32_t buffer) const {
        if (IsMeshoptFallback(m_model.buffers[buffer]))
            m_context.Fail(where["buffer"],
                           Text("buffers[{}] is a fallback, only compressed views may be in it", buffer));
    }

    Accessor ReadAccessor(size_t index) const {
        const gltf::Accessor& file = m_model.accessors[index];
        const Place where = Place("accessors")[index];
        const ElementShape shape = Shape(file.type);
        Accessor accessor;
        accessor.componentType = ReadComponentType(file.componentType);
        accessor.componentCount = shape.columns * shape.rows;
        accessor.isMatrix = shape.columns > 1;
        accessor.isNormalized = file.normalized;
        accessor.count = file.count;
        const ElementSize element = SizeOf(shape, accessor.componentType);
        if (static_cast<size_t>(file.bufferView) != m_placeholderView)
            accessor.run = ReadRun(where, where["count"], file.bufferView, file.byteOffset, element,
                                   accessor.count, true);
        // Vertex indices have 32 bits and the greatest is no index.
        if (accessor.count >= kNone)
            m_context.Fail(where["count"], Text("is {}, must be below 2^32 - 1", accessor.count));
        if (file.sparse.isSparse)
            accessor.sparse = ReadSparse(where["sparse"], file, m_document.sparse[index], element);
        return accessor;
    }

    // Returns the run of `count` elements that an accessor or a part of a sparse one covers.
    ElementRun ReadRun(const Place& where, const Place& countAt, int viewIndex, uint64_t byteOffset,
                       const ElementSize& element, uint64_t count, bool mayStride) const {
        ElementRun run{
            .view = static_cast<uint32_t>(viewIndex), .byteOffset = byteOffset, .byteStride = element.stride};
        const BufferView& view = m_tables.views[run.view];
        if (mayStride && view.byteStride != 0) {
            if (view.byteStride < element.used)
                m_context.Fail(where["bufferView"],
                               Text("bufferViews[{}].byteStride of {} is less than the element's {}",
                                    run.view, view.byteStride, Counted(element.used, "byte")));
            run.byteStride = view.byteStride;
        }
        if (!Fits(run.byteOffset, run.byteStride, element.used, count, view.byteLength)) {
            const std::string from = run.byteOffset ? Text(" from byte {}", run.byteOffset) : "";
            m_context.Fail(countAt,
                           Text("{}{} exceed{} bufferViews[{}] ({})", Counted(count, "element"), from,
                                count == 1 ? "s" : "", run.view, Counted(view.byteLength, "byte")));
        }
        return run;
    }

    SparseRun ReadSparse(const Place& where, const gltf::Accessor& file, const SparseNumbers& numbers,
                         const ElementSize& element) const {
        SparseRun sparse;
        sparse.count = numbers.count;
        if (sparse.count > file.count)
            m_context.Fail(where["count"], Text("is {}, more than the accessor's {}", sparse.count,
                                                Counted(file.count, "element")));
        const auto& indices = file.sparse.indices;
        const auto& values = file.sparse.values;
        sparse.indexType = ReadComponentType(indices.componentType);
        const uint64_t indexBytes = ByteSize(sparse.indexType);
        sparse.indices = ReadRun(where["indices"], where["count"], indices.bufferView, numbers.indicesOffset,
                                 {indexBytes, indexBytes}, sparse.count, false);
        sparse.values = ReadRun(where["values"], where["count"], values.bufferView, numbers.valuesOffset,
                                element, sparse.count, false);
        return sparse;
    }

    const GltfContext& m_context;
    const GltfDocument& m_document;
    const gltf::Model& m_model;
    AccessorTables& m_tables;
    size_t m_placeholderView = 0;
};

}  // namespace

size_t ByteSize(ComponentType type) {
    switch (type) {
        case ComponentType::Int8:
        case ComponentType::Uint8:
            return 1;
        case ComponentType::Int16:
        case ComponentType::Uint16:
            return 2;
        case ComponentType::Uint32:
        case ComponentType::Float:
            return 4;
    }
    RG_CHECK(false);
    return 1;
}

AccessorTables ReadAccessorTables(const GltfContext& context, const GltfDocument& document) {
    AccessorTables tables;
    TableReader(context, document, tables).Read();
    return tables;
}

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
