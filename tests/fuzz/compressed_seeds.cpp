// Makes seeds of compressed geometry: a small mesh by each of the codecs.
#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>
#include <meshoptimizer.h>

#include <array>
#include <cmath>
#include <cstring>

#include "tests/fuzz/seeds.h"
#include "tests/support/encode_exponentials.h"

namespace raygraph::fuzz {

namespace {

constexpr uint32_t kSide = 6, kVertices = kSide * kSide, kTriangles = 2 * (kSide - 1) * (kSide - 1);

// Makes a bumpy square.
struct Grid {
    std::vector<float> positions, normals;
    std::vector<uint32_t> indices;

    Grid() {
        for (uint32_t i = 0; i < kVertices; ++i) {
            const uint32_t x = i % kSide, y = i / kSide;
            positions.insert(positions.end(), {float(x), float(y), 0.25f * float(x * y % 3)});
            normals.insert(normals.end(), {0.6f * float(x % 2), 0.0f, x % 2 == 1 ? 0.8f : 1.0f});
            if (x + 1 < kSide && y + 1 < kSide)
                indices.insert(indices.end(), {i, i + 1, i + kSide, i + kSide, i + 1, i + kSide + 1});
        }
    }
};

Bytes BytesOf(const void* data, size_t size) {
    Bytes bytes(size);
    std::memcpy(bytes.data(), data, size);
    return bytes;
}

Bytes Attributes(const void* elements, size_t stride) {
    std::vector<unsigned char> out(meshopt_encodeVertexBufferBound(kVertices, stride));
    return BytesOf(out.data(),
                   meshopt_encodeVertexBuffer(out.data(), out.size(), elements, kVertices, stride));
}

// Expands three floats per vertex to four.
std::vector<float> WithFourth(const std::vector<float>& three) {
    std::vector<float> four;
    for (size_t i = 0; i < three.size(); i += 3)
        four.insert(four.end(), {three[i], three[i + 1], three[i + 2], 0.0f});
    return four;
}

Bytes Triangles(const Grid& grid) {
    std::vector<unsigned char> out(meshopt_encodeIndexBufferBound(grid.indices.size(), kVertices));
    return BytesOf(out.data(), meshopt_encodeIndexBuffer(out.data(), out.size(), grid.indices.data(),
                                                         grid.indices.size()));
}

Bytes Sequence(const Grid& grid) {
    std::vector<unsigned char> out(meshopt_encodeIndexSequenceBound(grid.indices.size(), kVertices));
    return BytesOf(out.data(), meshopt_encodeIndexSequence(out.data(), out.size(), grid.indices.data(),
                                                           grid.indices.size()));
}

Bytes Draco(const Grid& grid, int method, int submethod, int speed, int bits) {
    draco::Mesh mesh;
    mesh.set_num_points(kVertices);
    for (size_t i = 0; i < grid.indices.size(); i += 3)
        mesh.AddFace({draco::PointIndex(grid.indices[i]), draco::PointIndex(grid.indices[i + 1]),
                      draco::PointIndex(grid.indices[i + 2])});
    const auto add = [&](draco::GeometryAttribute::Type type, uint8_t components,
                         const std::vector<float>& values) {
        draco::GeometryAttribute attribute;
        attribute.Init(type, nullptr, components, draco::DT_FLOAT32, false, components * sizeof(float), 0);
        const int id = mesh.AddAttribute(attribute, true, kVertices);
        for (uint32_t i = 0; i < kVertices; ++i)
            mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i),
                                                  &values[size_t{components} * i]);
    };
    add(draco::GeometryAttribute::POSITION, 3, grid.positions);
    add(draco::GeometryAttribute::NORMAL, 3, grid.normals);
    // No primitive uses this attribute; it is decoded nevertheless, and predicted from the positions
    add(draco::GeometryAttribute::TEX_COORD, 2, grid.positions);
    draco::ExpertEncoder encoder(mesh);
    encoder.SetSpeedOptions(speed, speed);
    encoder.SetEncodingMethod(method);
    if (submethod >= 0) encoder.SetEncodingSubmethod(submethod);
    for (int attribute = 0; bits > 0 && attribute < 3; ++attribute)
        encoder.SetAttributeQuantization(attribute, bits);
    draco::EncoderBuffer buffer;
    return encoder.EncodeToBuffer(&buffer).ok() ? BytesOf(buffer.data(), buffer.size()) : Bytes();
}

}  // namespace

std::vector<Seed> CompressedSeeds() {
    const Grid grid;
    const std::vector<float> normals = WithFourth(grid.normals);
    std::vector<Seed> seeds;
    const auto add = [&](const char* name, uint8_t kind, Bytes bytes) {
        const std::array<std::byte, 3> head{std::byte{kind}, std::byte{kVertices - 1},
                                            std::byte{kTriangles - 1}};
        bytes.insert(bytes.begin(), head.begin(), head.end());
        seeds.push_back({name, std::move(bytes)});
    };
    using namespace draco;
    add("draco_plain", 0, Draco(grid, MESH_SEQUENTIAL_ENCODING, -1, 10, 0));
    add("draco_sequential", 0, Draco(grid, MESH_SEQUENTIAL_ENCODING, -1, 0, 8));
    add("draco_standard", 0,
        Draco(grid, MESH_EDGEBREAKER_ENCODING, MESH_EDGEBREAKER_STANDARD_ENCODING, 5, 8));
    add("draco_valence", 0, Draco(grid, MESH_EDGEBREAKER_ENCODING, MESH_EDGEBREAKER_VALENCE_ENCODING, 0, 8));
    add("draco_floats", 0, Draco(grid, MESH_EDGEBREAKER_ENCODING, -1, 3, 0));
    std::array<std::byte, size_t{kVertices} * 12> filtered{};
    add("attributes", 1, Attributes(grid.positions.data(), 12));
    test::EncodeExponentials(filtered.data(), kVertices, 12, 12, grid.positions.data());
    add("exponential", 2, Attributes(filtered.data(), 12));
    meshopt_encodeFilterOct(filtered.data(), kVertices, 4, 8, normals.data());
    add("octahedral_bytes", 3, Attributes(filtered.data(), 4));
    meshopt_encodeFilterOct(filtered.data(), kVertices, 8, 12, normals.data());
    add("octahedral_shorts", 4, Attributes(filtered.data(), 8));
    meshopt_encodeFilterQuat(filtered.data(), kVertices, 8, 12, normals.data());
    add("quaternions", 5, Attributes(filtered.data(), 8));
    add("triangles_short", 6, Triangles(grid));
    add("triangles", 7, Triangles(grid));
    add("sequence", 8, Sequence(grid));
    return seeds;
}

}  // namespace raygraph::fuzz
