#include "renderer/scene/gltf_accessors.h"

#include <array>
#include <string_view>

#include "base/check.h"

namespace raygraph::scene {
namespace {

struct ElementShape {
    std::string_view name;
    uint32_t columns;
    uint32_t rows;
};
constexpr std::array<ElementShape, 7> kShapes{{{"SCALAR", 1, 1},
                                               {"VEC2", 1, 2},
                                               {"VEC3", 1, 3},
                                               {"VEC4", 1, 4},
                                               {"MAT2", 2, 2},
                                               {"MAT3", 3, 3},
                                               {"MAT4", 4, 4}}};

const ElementShape& ReadShape(const JsonValue& type) {
    const std::string& name = type.String();
    for (const ElementShape& shape : kShapes)
        if (shape.name == name) return shape;
    type.Fail("is " + type.Shown() + ", must be SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3 or MAT4");
}

ComponentType ReadComponentType(const JsonValue& value) {
    switch (value.Unsigned()) {
        case 5120:
            return ComponentType::Int8;
        case 5121:
            return ComponentType::Uint8;
        case 5122:
            return ComponentType::Int16;
        case 5123:
            return ComponentType::Uint16;
        case 5125:
            return ComponentType::Uint32;
        case 5126:
            return ComponentType::Float;
        default:
            value.Fail("is " + value.Shown() + ", must be 5120, 5121, 5122, 5123, 5125 or 5126");
    }
}

uint64_t ReadPositive(const JsonValue& value) {
    const uint64_t number = value.Unsigned();
    if (number == 0) value.Fail("is 0, must be at least 1");
    return number;
}

// Bytes of an element. Matrix columns start at multiples of four bytes; the padding after the last one need
// not be there at the end of a buffer.
struct ElementSize {
    uint64_t stride = 0;  // Of tightly packed elements.
    uint64_t used = 0;    // Up to the end of the last component.
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

std::string ViewName(uint32_t view, const BufferView& info) {
    return "bufferViews[" + std::to_string(view) + "] (" + std::to_string(info.byteLength) + " bytes)";
}

std::vector<uint64_t> ReadBufferLengths(const JsonValue& buffers) {
    std::vector<uint64_t> lengths;
    for (size_t i = 0; i < buffers.Count(); ++i)
        lengths.push_back(ReadPositive(buffers.At(i).RequireObject()["byteLength"]));
    return lengths;
}

BufferView ReadView(const JsonValue& value, const std::vector<uint64_t>& bufferLengths) {
    BufferView view;
    view.buffer = value.RequireObject()["buffer"].Index(bufferLengths.size(), "buffers");
    view.byteOffset = value["byteOffset"].UnsignedOr(0);
    view.byteLength = ReadPositive(value["byteLength"]);
    const uint64_t length = bufferLengths[view.buffer];
    if (view.byteOffset > length || view.byteLength > length - view.byteOffset)
        value["byteLength"].Fail(std::to_string(view.byteLength) + " bytes from " +
                                 std::to_string(view.byteOffset) + " exceed buffers[" +
                                 std::to_string(view.buffer) + "] (" + std::to_string(length) + " bytes)");
    const JsonValue stride = value["byteStride"];
    if (stride.IsPresent()) {
        const uint64_t bytes = stride.Unsigned();
        if (bytes < 4 || bytes > 252) stride.Fail("is " + std::to_string(bytes) + ", must be 4 to 252");
        view.byteStride = static_cast<uint32_t>(bytes);
    }
    return view;
}

class AccessorParser {
  public:
    explicit AccessorParser(const std::vector<BufferView>& views) : m_views(views) {}

    Accessor Read(const JsonValue& value) const {
        Accessor accessor;
        const ElementShape& shape = ReadShape(value.RequireObject()["type"]);
        accessor.componentType = ReadComponentType(value["componentType"]);
        accessor.componentCount = shape.columns * shape.rows;
        accessor.isMatrix = shape.columns > 1;
        accessor.isNormalized = value["normalized"].BoolOr(false);
        accessor.count = ReadPositive(value["count"]);
        const ElementSize element = SizeOf(shape, accessor.componentType);
        if (value["bufferView"].IsPresent())
            accessor.run = ReadRun(value, value["count"], element, accessor.count, true);
        // Vertex indices have 32 bits and the greatest is no index.
        if (accessor.count >= kNone)
            value["count"].Fail("is " + value["count"].Shown() + ", must be below 2^32 - 1");
        if (value["sparse"].IsPresent())
            accessor.sparse = ReadSparse(value["sparse"].RequireObject(), element, accessor.count);
        return accessor;
    }

  private:
    // The run of `count` elements that `value` (an accessor or a part of a sparse one) covers.
    ElementRun ReadRun(const JsonValue& value, const JsonValue& countAt, const ElementSize& element,
                       uint64_t count, bool mayStride) const {
        ElementRun run;
        run.view = value["bufferView"].Index(m_views.size(), "bufferViews");
        const BufferView& view = m_views[run.view];
        run.byteOffset = value["byteOffset"].UnsignedOr(0);
        run.byteStride = element.stride;
        if (mayStride && view.byteStride != 0) {
            if (view.byteStride < element.used)
                value["bufferView"].Fail("bufferViews[" + std::to_string(run.view) + "].byteStride of " +
                                         std::to_string(view.byteStride) + " is less than the element's " +
                                         std::to_string(element.used) + " bytes");
            run.byteStride = view.byteStride;
        }
        if (!Fits(run.byteOffset, run.byteStride, element.used, count, view.byteLength)) {
            std::string from = run.byteOffset ? " from byte " + std::to_string(run.byteOffset) : "";
            countAt.Fail(std::to_string(count) + " elements" + from + " exceed " + ViewName(run.view, view));
        }
        return run;
    }

    SparseRun ReadSparse(const JsonValue& value, const ElementSize& element, uint64_t elementCount) const {
        SparseRun sparse;
        sparse.count = ReadPositive(value["count"]);
        if (sparse.count > elementCount)
            value["count"].Fail("is " + std::to_string(sparse.count) + ", more than the accessor's " +
                                std::to_string(elementCount) + " elements");
        const JsonValue indices = value["indices"].RequireObject();
        sparse.indexType = ReadComponentType(indices["componentType"]);
        if (sparse.indexType != ComponentType::Uint8 && sparse.indexType != ComponentType::Uint16 &&
            sparse.indexType != ComponentType::Uint32)
            indices["componentType"].Fail("is " + indices["componentType"].Shown() +
                                          ", must be 5121, 5123 or 5125");
        const uint64_t indexBytes = ByteSize(sparse.indexType);
        sparse.indices = ReadRun(indices, value["count"], {indexBytes, indexBytes}, sparse.count, false);
        sparse.values =
            ReadRun(value["values"].RequireObject(), value["count"], element, sparse.count, false);
        return sparse;
    }

    const std::vector<BufferView>& m_views;
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

AccessorTables ReadAccessorTables(const JsonValue& root) {
    AccessorTables tables;
    tables.bufferLengths = ReadBufferLengths(root["buffers"]);
    const JsonValue views = root["bufferViews"];
    for (size_t i = 0; i < views.Count(); ++i)
        tables.views.push_back(ReadView(views.At(i), tables.bufferLengths));
    const JsonValue accessors = root["accessors"];
    const AccessorParser parser(tables.views);
    for (size_t i = 0; i < accessors.Count(); ++i) tables.accessors.push_back(parser.Read(accessors.At(i)));
    return tables;
}

}  // namespace raygraph::scene
