// Fuzzes accessors: the input chooses types, counts, strides, offsets and sparse parts in an otherwise valid
// file, and then the bytes of its buffer.
#include <nlohmann/json.hpp>

#include "tests/fuzz/choices.h"
#include "tests/fuzz/gltf_files.h"

namespace raygraph::fuzz {

namespace {

using Json = nlohmann::json;

struct Attribute {
    const char* name;  // "": indices
    int componentType;
    size_t shape;  // index into kShapes
    size_t elementBytes;
};
constexpr std::array kShapes{"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4", "VEC5"};
constexpr std::array<Attribute, 7> kAttributes{{{"POSITION", 5126, 2, 12},
                                                {"", 5123, 0, 2},
                                                {"NORMAL", 5126, 2, 12},
                                                {"TEXCOORD_0", 5126, 1, 8},
                                                {"TANGENT", 5126, 3, 16},
                                                {"COLOR_0", 5121, 3, 4},
                                                {"TEXCOORD_1", 5123, 1, 4}}};
constexpr uint64_t kVertices = 12, kIndices = 18, kSparse = 3;

// Fills a buffer with numbers for vertices, which bytes of the input choose.
class Buffer {
  public:
    size_t Size() const { return m_bytes.size(); }
    const Bytes& All() const { return m_bytes; }
    void Put(size_t value, size_t bytes) {
        for (size_t i = 0; i < bytes; ++i) m_bytes.push_back(static_cast<std::byte>(value >> (8 * i)));
    }
    void Align() {
        while (m_bytes.size() % 4 != 0) m_bytes.emplace_back();
    }
    // Overwrites the end of the buffer with raw bytes of the input.
    void Overlay(Input input) {
        for (size_t i = 0; i < std::min(input.size(), m_bytes.size()); ++i) m_bytes[i] ^= input[i];
    }

  private:
    Bytes m_bytes;
};

// Appends typical elements of an attribute: small whole numbers as floats, indices below the count.
void PutElements(const Attribute& attribute, uint64_t count, Buffer& buffer) {
    buffer.Align();
    for (uint64_t i = 0; i < count; ++i) {
        if (attribute.componentType != 5126) {
            const bool isIndex = attribute.name[0] == 0;
            for (size_t b = 0; b < attribute.elementBytes; b += 2)
                buffer.Put(isIndex ? i % kVertices : i * 17, 2);
            continue;
        }
        for (size_t c = 0; c < attribute.elementBytes / 4; ++c) {
            const auto value = static_cast<float>((i * 7 + c * 5) % 4);
            uint32_t bits = 0;
            std::memcpy(&bits, &value, 4);
            // Normals and tangents are unit vectors along an axis, with a last component of 1
            if (attribute.shape >= 2 && attribute.name[0] != 'P')
                bits = c == i % 3 || c == 3 ? 0x3F800000 : 0;
            buffer.Put(bits, 4);
        }
    }
}

int ComponentType(Choices& choices, int usual) {
    constexpr std::array<int, 8> kTypes{5120, 5121, 5122, 5123, 5125, 5126, 5124, 0};
    const uint8_t choice = choices.Byte();
    return choice < 128 ? usual : kTypes[choice % kTypes.size()];
}

class FileMaker {
  public:
    explicit FileMaker(Input input) : m_choices(input) {}

    Bytes Make() {
        Json& primitive = m_json["meshes"][0]["primitives"][0];
        primitive["attributes"] = Json::object();
        const uint8_t present = m_choices.Byte();
        for (size_t i = 0; i < kAttributes.size(); ++i) {
            if (i > 0 && !(present >> i & 1)) continue;
            const size_t accessor = AddAccessor(kAttributes[i], i == 1 ? kIndices : kVertices);
            if (i == 1)
                primitive["indices"] = accessor;
            else
                primitive["attributes"][kAttributes[i].name] = accessor;
        }
        primitive["mode"] = m_choices.Number(4);
        if (present & 1) {
            primitive["material"] = 0;
            m_json["materials"][0]["normalTexture"] = {{"index", 0}, {"texCoord", m_choices.Byte() % 3}};
            m_json["textures"][0]["source"] = 0;
            m_json["images"][0]["uri"] = kImageName;
        }
        m_buffer.Overlay(m_choices.Rest());
        m_json["buffers"][0]["byteLength"] = m_buffer.Size();
        m_json["asset"]["version"] = "2.0";
        m_json["nodes"][0]["mesh"] = 0;
        m_json["scenes"][0]["nodes"] = {0};
        m_json["extensionsRequired"] = {"KHR_mesh_quantization"};
        return MakeGlb(m_json.dump(), m_buffer.All());
    }

  private:
    // Returns the index of the new view.
    size_t AddView(size_t from, bool mayStride) {
        Json view{{"buffer", 0}};
        view["byteOffset"] = m_choices.Number(from);
        view["byteLength"] = m_choices.Number(m_buffer.Size() - from);
        if (const uint64_t stride = m_choices.Number(0); mayStride && stride != 0)
            view["byteStride"] = stride;
        m_json["bufferViews"].push_back(view);
        return m_json["bufferViews"].size() - 1;
    }
    Json Run(size_t from, bool mayStride) {
        Json run{{"bufferView", AddView(from, mayStride)}};
        if (const uint64_t offset = m_choices.Number(0); offset != 0) run["byteOffset"] = offset;
        return run;
    }
    size_t AddAccessor(const Attribute& attribute, uint64_t count) {
        m_buffer.Align();
        size_t from = m_buffer.Size();
        PutElements(attribute, count, m_buffer);
        const uint8_t kinds = m_choices.Byte();
        Json accessor = kinds & 1 ? Json::object() : Run(from, true);
        accessor["componentType"] = ComponentType(m_choices, attribute.componentType);
        accessor["type"] = m_choices.OneOf(kShapes, attribute.shape);
        accessor["count"] = m_choices.Number(count);
        if (kinds & 2 || attribute.name[0] == 'C') accessor["normalized"] = true;
        if (kinds & 4) {
            from = m_buffer.Size();
            for (uint64_t i = 0; i < kSparse; ++i) m_buffer.Put(2 * i + 1, 2);
            Json indices = Run(from, kinds & 8);
            indices["componentType"] = ComponentType(m_choices, 5123);
            m_buffer.Align();
            from = m_buffer.Size();
            PutElements(attribute, kSparse, m_buffer);
            accessor["sparse"] = {
                {"count", m_choices.Number(kSparse)}, {"indices", indices}, {"values", Run(from, kinds & 8)}};
        }
        m_json["accessors"].push_back(accessor);
        return m_json["accessors"].size() - 1;
    }

    Choices m_choices;
    Buffer m_buffer;
    Json m_json;
};

}  // namespace

Bytes AccessorFile(Input input) {
    return FileMaker(input).Make();
}

void RunGltfAccessors(Input input) {
    const Bytes file = AccessorFile(input);
    SharedSceneFolder().Load(file);
}

}  // namespace raygraph::fuzz
