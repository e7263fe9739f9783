// Draco's decoder believes the counts of a header, and makes room for them before it reads on. Between its
// steps, which are virtual functions, the counts are compared with those of the accessors and their memory is
// charged.
#include "renderer/scene/gltf/draco.h"

#include <draco/compression/config/compression_shared.h>
#include <draco/compression/config/decoder_options.h>
#include <draco/compression/entropy/symbol_decoding.h>
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/decoder_buffer.h>
#include <draco/core/varint_decoding.h>
#include <draco/mesh/mesh.h>

#include <exception>
#include <optional>
#include <string>

#include "base/check.h"
#include "base/printable.h"
#include "base/text.h"

namespace raygraph::scene {
namespace {

constexpr const char* kDracoExtension = "KHR_draco_mesh_compression";

// Gives the numbers of a primitive, by its accessors.
struct Expected {
    GltfContext& context;
    const Place& where;
    uint64_t vertexCount = 0;
    std::optional<uint64_t> indexCount = {};  // None: the accessors do not say.

    void RequireFaces(uint64_t faces) const {
        if (indexCount && faces * 3 != *indexCount)
            context.Fail(where,
                         Text("{} compressed, indices has {}", Counted(faces, "triangle is", "triangles are"),
                              Counted(*indexCount, "element")));
    }
    void RequireVertices(uint64_t vertices) const {
        if (vertices != vertexCount)
            context.Fail(
                where, Text("{} compressed, POSITION has {}", Counted(vertices, "vertex is", "vertices are"),
                            Counted(vertexCount, "element")));
    }
    // Attributes that the primitive does not use are decoded all the same.
    void RequireAttributes(int attributes) const {
        constexpr int kMaxAttributes = 64;
        if (attributes > kMaxAttributes)
            context.Fail(
                where, Text("{} attributes are compressed, at most {} are read", attributes, kMaxAttributes));
    }
    void Charge(uint64_t bytes) const { context.ChargeGeometry(where, bytes); }
};

// Reads ahead what the decoder is going to read.
struct Numbers {
    draco::DecoderBuffer copy;  // of the position, not of the bytes
    bool isComplete = true;

    explicit Numbers(const draco::DecoderBuffer& buffer) : copy(buffer) {}
    uint64_t Varint() {
        uint32_t value = 0;
        isComplete = isComplete && draco::DecodeVarint(&value, &copy);
        return value;
    }
    uint64_t Byte() {
        uint8_t value = 0;
        isComplete = isComplete && copy.Decode(&value);
        return value;
    }
    int32_t Int() {
        int32_t value = 0;
        isComplete = isComplete && copy.Decode(&value);
        return value;
    }
    // The integers of an attribute, of which there are so many; what they are is nobody's concern here.
    void SkipIntegers(uint64_t entries, uint64_t components, const Expected& expected) {
        const uint64_t count = entries * components;
        if (Byte() > 0) {
            expected.Charge(count * sizeof(uint32_t));
            std::vector<uint32_t> values(count);
            isComplete =
                isComplete && draco::DecodeSymbols(static_cast<uint32_t>(count), static_cast<int>(components),
                                                   &copy, values.data());
            return;
        }
        const uint64_t bytes = Byte() * count;
        isComplete = isComplete && bytes <= static_cast<uint64_t>(copy.remaining_size());
        if (isComplete) copy.Advance(static_cast<int64_t>(bytes));
    }
};

// Bytes that decoding takes, about twice what was measured: of connectivity, also where an attribute has
// seams of its own; of attributes, for the order that a decoder has and for the forms that values pass
// through.
constexpr uint64_t kBytesPerFace = 96, kBytesPerSeamFace = 48, kDracoBytesPerVertex = 24;
constexpr uint64_t kBytesPerOrder = 16, kBytesPerAttribute = 8, kBytesPerComponent = 8;

void CheckConnectivity(const draco::MeshEdgebreakerDecoder&, Numbers numbers, const Expected& expected) {
    const uint64_t vertices = numbers.Varint(), faces = numbers.Varint(), seamed = numbers.Byte();
    numbers.Varint();
    const uint64_t splits = numbers.Varint();
    if (!numbers.isComplete) return;  // the decoder says so
    expected.RequireFaces(faces);
    expected.Charge(faces * (kBytesPerFace + seamed * kBytesPerSeamFace) +
                    (vertices + splits) * kDracoBytesPerVertex);
}

void CheckConnectivity(const draco::MeshSequentialDecoder&, Numbers numbers, const Expected& expected) {
    const uint64_t faces = numbers.Varint(), vertices = numbers.Varint();
    if (!numbers.isComplete) return;
    expected.RequireFaces(faces);
    expected.RequireVertices(vertices);
    expected.Charge(faces * kBytesPerFace);
}

// In front of an attribute's integers, where the last two bytes read are the method that predicts them and
// its transform. Texture coordinates are predicted with a bit for each, whose number follows the integers:
// the decoder makes room for as many as two billion, and reads them all from a few bytes.
void CheckPrediction(const draco::DecoderBuffer& buffer, uint64_t entries, uint64_t components,
                     const Expected& expected) {
    if (buffer.decoded_size() < 2) return;
    const auto method = static_cast<int8_t>(buffer.data_head()[-2]);
    const auto transform = static_cast<int8_t>(buffer.data_head()[-1]);
    if (method == draco::MESH_PREDICTION_TEX_COORDS_DEPRECATED)
        expected.context.Fail(expected.where, "is predicted by a method of older versions of the format");
    if (method != draco::MESH_PREDICTION_TEX_COORDS_PORTABLE || transform != draco::PREDICTION_TRANSFORM_WRAP)
        return;
    Numbers numbers(buffer);
    numbers.SkipIntegers(entries, components, expected);
    const int32_t orientations = numbers.Int();
    if (numbers.isComplete && orientations > 0 && static_cast<uint64_t>(orientations) > entries)
        expected.context.Fail(expected.where, Text("{} compressed, of {}",
                                                   Counted(static_cast<uint64_t>(orientations),
                                                           "orientation is", "orientations are"),
                                                   Counted(entries, "value")));
}

// Adapts one of Draco's decoders. An Error does not pass through it: it is kept, and the decoder told to
// stop.
template <typename Decoder>
class CheckedDecoder final : public Decoder {
  public:
    explicit CheckedDecoder(const Expected& expected) : m_expected(expected) {}

    bool DecodesTo(draco::DecoderBuffer& buffer, draco::Mesh& mesh) {
        const draco::DecoderOptions options;
        m_buffer = &buffer;
        const bool isDecoded = this->Decode(options, &buffer, &mesh).ok();
        if (m_error) std::rethrow_exception(m_error);
        return isDecoded;
    }

    // Called when a prediction has been chosen and its data has not been read. Without this data another
    // prediction takes its place, which has none.
    const draco::MeshAttributeIndicesEncodingData* GetAttributeEncodingData(int attribute) const override {
        const auto* const data = Decoder::GetAttributeEncodingData(attribute);
        if (!data) return nullptr;
        const auto components =
            static_cast<uint64_t>(this->point_cloud()->attribute(attribute)->num_components());
        return Passes([&] {
            CheckPrediction(*m_buffer, data->encoded_attribute_value_index_to_corner_map.size(), components,
                            m_expected);
        })
                   ? data
                   : nullptr;
    }

  protected:
    bool DecodeConnectivity() override {
        return Passes([&] { CheckConnectivity(*this, Numbers(*this->buffer()), m_expected); }) &&
               Decoder::DecodeConnectivity();
    }

    // Their headers have been read, their values have not.
    bool DecodeAllAttributes() override {
        return Passes([&] {
                   const uint64_t vertices = this->mesh()->num_points();
                   m_expected.RequireVertices(vertices);
                   m_expected.RequireAttributes(this->mesh()->num_attributes());
                   uint64_t bytesPerVertex =
                       static_cast<uint64_t>(this->num_attributes_decoders()) * kBytesPerOrder;
                   for (int i = 0; i < this->mesh()->num_attributes(); ++i) {
                       const draco::PointAttribute& attribute = *this->mesh()->attribute(i);
                       const auto valueBytes =
                           static_cast<uint64_t>(draco::DataTypeLength(attribute.data_type()));
                       bytesPerVertex += attribute.num_components() * (valueBytes + kBytesPerComponent);
                       bytesPerVertex += kBytesPerAttribute;
                   }
                   m_expected.Charge(vertices * bytesPerVertex);
               }) &&
               Decoder::DecodeAllAttributes();
    }

  private:
    template <typename Check>
    bool Passes(const Check& check) const {
        try {
            check();
            return true;
        } catch (...) {
            m_error = std::current_exception();
            return false;
        }
    }

    const Expected& m_expected;
    const draco::DecoderBuffer* m_buffer = nullptr;
    mutable std::exception_ptr m_error;
};

bool Decode(const draco::DracoHeader& header, const Expected& expected, draco::DecoderBuffer& buffer,
            draco::Mesh& mesh) {
    if (header.encoder_method == draco::MESH_SEQUENTIAL_ENCODING)
        return CheckedDecoder<draco::MeshSequentialDecoder>(expected).DecodesTo(buffer, mesh);
    if (header.encoder_method == draco::MESH_EDGEBREAKER_ENCODING)
        return CheckedDecoder<draco::MeshEdgebreakerDecoder>(expected).DecodesTo(buffer, mesh);
    return false;
}

void CheckHeader(const draco::DracoHeader& header, const Expected& expected) {
    if (header.encoder_type != draco::TRIANGULAR_MESH)
        expected.context.Fail(expected.where, "holds no mesh of triangles");
    if (header.version_major != 2 || header.version_minor != 2)
        expected.context.Fail(expected.where, Text("is of version {}.{} of the format, 2.2 is read",
                                                   int{header.version_major}, int{header.version_minor}));
    // A few bytes of metadata can make the decoder allocate gigabytes.
    if (header.flags & METADATA_FLAG_MASK)
        expected.context.Fail(expected.where, "has metadata, which is not read");
}

draco::DataType TypeOf(ComponentType type) {
    switch (type) {
        case ComponentType::Int8:
            return draco::DT_INT8;
        case ComponentType::Uint8:
            return draco::DT_UINT8;
        case ComponentType::Int16:
            return draco::DT_INT16;
        case ComponentType::Uint16:
            return draco::DT_UINT16;
        case ComponentType::Uint32:
            return draco::DT_UINT32;
        case ComponentType::Float:
            return draco::DT_FLOAT32;
    }
    RG_CHECK(false);
    return draco::DT_INVALID;
}

// Returns the values of each vertex, in their order.
std::vector<std::byte> ValuesOf(const draco::PointAttribute& attribute, const Expected& expected,
                                size_t bytes, const std::string& name) {
    const auto damaged = [&] {
        expected.context.Fail(expected.where, Text("the values of {} are damaged", name));
    };
    const auto stride = static_cast<size_t>(attribute.byte_stride());
    const auto offset = static_cast<size_t>(attribute.byte_offset());
    if (stride < bytes || !attribute.buffer() ||
        attribute.buffer()->data_size() < offset + attribute.size() * stride)
        damaged();
    expected.Charge(expected.vertexCount * bytes);
    std::vector<std::byte> values(expected.vertexCount * bytes);
    for (uint32_t i = 0; i < expected.vertexCount; ++i) {
        const draco::AttributeValueIndex value = attribute.mapped_index(draco::PointIndex(i));
        if (value.value() >= attribute.size()) damaged();
        attribute.buffer()->Read(static_cast<int64_t>(offset + value.value() * stride), &values[i * bytes],
                                 bytes);
    }
    return values;
}

}  // namespace

DracoPrimitive DecodeDraco(GltfContext& context, const PrimitiveLayout& layout, const AccessorTables& tables,
                           std::span<const std::byte> compressed) {
    const Place where = layout.where["extensions"][kDracoExtension];
    Expected expected{.context = context, .where = where, .vertexCount = layout.vertexCount};
    // The accessor of a strip may count the indices of the strip, so only that of a list is expected.
    if (layout.indices != kNone && layout.mode == PrimitiveMode::Triangles)
        expected.indexCount = tables.accessors[layout.indices].count;
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(compressed.data()), compressed.size());
    draco::DecoderBuffer start = buffer;
    draco::DracoHeader header;
    if (!draco::PointCloudDecoder::DecodeHeader(&start, &header).ok())
        context.Fail(where, "its bytes are not those of Draco");
    CheckHeader(header, expected);
    context.ChargeCompressed(where, compressed.size());
    const uint64_t chargedBefore = context.geometryBytes;
    draco::Mesh mesh;
    if (!Decode(header, expected, buffer, mesh)) context.Fail(where, "its bytes are damaged");

    DracoPrimitive primitive;
    primitive.indices.reserve(size_t{3} * mesh.num_faces());
    for (uint32_t face = 0; face < mesh.num_faces(); ++face)
        for (const draco::PointIndex& vertex : mesh.face(draco::FaceIndex(face))) {
            if (vertex.value() >= layout.vertexCount)
                context.Fail(where, Text("triangle {} has vertex {}, there are {}", face, vertex.value(),
                                         layout.vertexCount));
            primitive.indices.push_back(vertex.value());
        }
    for (size_t i = 0; i < kAttributeCount; ++i) {
        const uint32_t id = layout.draco->ids[i];
        if (id == kNone) continue;
        const std::string name = AttributeName(static_cast<Attribute>(i));
        const draco::PointAttribute* const attribute = mesh.GetAttributeByUniqueId(id);
        if (!attribute)
            context.Fail(where["attributes"][AttributeName(static_cast<Attribute>(i))],
                         Text("is {}, no attribute has this id", id));
        const Accessor& accessor = tables.accessors[layout.accessors[i]];
        if (attribute->num_components() != accessor.componentCount ||
            attribute->data_type() != TypeOf(accessor.componentType))
            context.Fail(where["attributes"][AttributeName(static_cast<Attribute>(i))],
                         Text("is of another type than accessors[{}]", layout.accessors[i]));
        primitive.attributes[i] =
            ValuesOf(*attribute, expected, accessor.componentCount * ByteSize(accessor.componentType), name);
    }
    // The decoder's memory is free again, and what is left is the caller's to charge. An eighth stays
    // charged, about what a mesh takes that is used as a whole: it bounds the time of many that are not.
    context.geometryBytes = chargedBefore + (context.geometryBytes - chargedBefore) / 8;
    return primitive;
}

}  // namespace raygraph::scene
