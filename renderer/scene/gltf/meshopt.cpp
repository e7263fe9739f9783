#include "renderer/scene/gltf/meshopt.h"

#include <meshoptimizer.h>

#include <array>
#include <string>
#include <utility>

#include "base/check.h"
#include "base/printable.h"
#include "base/text.h"

namespace raygraph::scene {
namespace {

constexpr const char* kExt = "EXT_meshopt_compression";
constexpr const char* kKhr = "KHR_meshopt_compression";

// The names that the schema allows, by enumerator.
constexpr std::array<const char*, 3> kModes{"ATTRIBUTES", "TRIANGLES", "INDICES"};
constexpr std::array<const char*, 4> kFilters{"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"};

template <typename Choice, size_t Count>
std::optional<Choice> Chosen(const std::string& name, const std::array<const char*, Count>& names) {
    for (size_t i = 0; i < Count; ++i)
        if (name == names[i]) return static_cast<Choice>(i);
    return std::nullopt;
}

uint64_t Number(const gltf::Value& extension, const char* name) {
    return extension.Has(name) ? static_cast<uint64_t>(extension.Get(name).GetNumberAsDouble()) : 0;
}

// Returns which rule of the extensions on strides and counts is broken; "" if none is.
std::string BrokenRule(const MeshoptView& view) {
    const uint32_t stride = view.byteStride;
    if (view.mode == MeshoptMode::Attributes) {
        if (stride % 4 != 0 || stride < 4 || stride > 256)
            return Text("byteStride is {}, must be a multiple of 4 up to 256 for ATTRIBUTES", stride);
    } else {
        const char* const mode = kModes[static_cast<size_t>(view.mode)];
        if (stride != 2 && stride != 4) return Text("byteStride is {}, must be 2 or 4 for {}", stride, mode);
        if (view.filter != MeshoptFilter::None) return Text("{} cannot have a filter", mode);
        if (view.mode == MeshoptMode::Triangles && view.count % 3 != 0)
            return Text("count is {}, must be a multiple of 3 for TRIANGLES", view.count);
    }
    if (view.filter == MeshoptFilter::Octahedral && stride != 4 && stride != 8)
        return Text("byteStride is {}, must be 4 or 8 for OCTAHEDRAL", stride);
    if (view.filter == MeshoptFilter::Quaternion && stride != 8)
        return Text("byteStride is {}, must be 8 for QUATERNION", stride);
    return "";
}

bool Decode(const MeshoptView& view, std::span<const std::byte> compressed, std::byte* out) {
    const auto* const bytes = reinterpret_cast<const unsigned char*>(compressed.data());
    switch (view.mode) {
        case MeshoptMode::Attributes:
            return meshopt_decodeVertexBuffer(out, view.count, view.byteStride, bytes, compressed.size()) ==
                   0;
        case MeshoptMode::Triangles:
            return meshopt_decodeIndexBuffer(out, view.count, view.byteStride, bytes, compressed.size()) == 0;
        case MeshoptMode::Indices:
            return meshopt_decodeIndexSequence(out, view.count, view.byteStride, bytes, compressed.size()) ==
                   0;
    }
    RG_CHECK(false);
    return false;
}

void Unfilter(const MeshoptView& view, std::byte* bytes) {
    switch (view.filter) {
        case MeshoptFilter::None:
            return;
        case MeshoptFilter::Octahedral:
            return meshopt_decodeFilterOct(bytes, view.count, view.byteStride);
        case MeshoptFilter::Quaternion:
            return meshopt_decodeFilterQuat(bytes, view.count, view.byteStride);
        case MeshoptFilter::Exponential:
            return meshopt_decodeFilterExp(bytes, view.count, view.byteStride);
    }
}

}  // namespace

std::optional<MeshoptView> ReadMeshoptView(const GltfContext& context, const gltf::Model& model, size_t index,
                                           uint32_t byteStride) {
    const gltf::BufferView& file = model.bufferViews[index];
    const auto ext = file.extensions.find(kExt), khr = file.extensions.find(kKhr),
               none = file.extensions.end();
    if (ext == none && khr == none) return std::nullopt;
    const Place extensions = Place("bufferViews")[index]["extensions"];
    if (ext != none && khr != none) context.Fail(extensions, Text("has both {} and {}", kExt, kKhr));
    const auto& [name, value] = ext != none ? *ext : *khr;
    MeshoptView view{.extension = ext != none ? kExt : kKhr};
    const Place where = extensions[view.extension];
    view.buffer = static_cast<uint32_t>(value.Get("buffer").GetNumberAsInt());
    view.byteOffset = Number(value, "byteOffset");
    view.byteLength = Number(value, "byteLength");
    view.count = Number(value, "count");
    view.byteStride = static_cast<uint32_t>(Number(value, "byteStride"));
    view.mode = *Chosen<MeshoptMode>(value.Get("mode").Get<std::string>(), kModes);
    if (value.Has("filter")) {
        const std::string filter = value.Get("filter").Get<std::string>();
        const std::optional<MeshoptFilter> known = Chosen<MeshoptFilter>(filter, kFilters);
        if (!known) context.Fail(where["filter"], Text("is \"{}\", which is not decoded", filter));
        view.filter = *known;
    }
    if (const std::string broken = BrokenRule(view); !broken.empty()) context.Fail(where, broken);
    if (view.extension == std::string_view(kExt) && byteStride != 0 && byteStride != view.byteStride)
        context.Fail(where["byteStride"],
                     Text("is {}, but the view's byteStride is {}", view.byteStride, byteStride));
    if (file.byteLength != view.DecodedBytes())
        context.Fail(where["count"], Text("{} of {} not the view's {}", Counted(view.count, "element"),
                                          Counted(view.byteStride, view.count == 1 ? "byte is" : "byte are",
                                                  view.count == 1 ? "bytes is" : "bytes are"),
                                          Counted(file.byteLength, "byte")));
    return view;
}

bool IsMeshoptFallback(const gltf::Buffer& buffer) {
    for (const char* name : {kExt, kKhr})
        if (const auto found = buffer.extensions.find(name); found != buffer.extensions.end())
            if (found->second.Has("fallback") && found->second.Get("fallback").Get<bool>()) return true;
    return false;
}

std::vector<std::byte> DecodeMeshopt(GltfContext& context, const MeshoptView& view,
                                     std::span<const std::byte> compressed, const Place& where) {
    const Place here = where["extensions"][view.extension];
    context.ChargeGeometry(here, view.DecodedBytes());
    std::vector<std::byte> bytes(view.DecodedBytes());
    if (!Decode(view, compressed, bytes.data())) {
        // The codec of attributes has a second version, which KHR_meshopt_compression allows
        const bool isNewer = view.mode == MeshoptMode::Attributes && !compressed.empty() &&
                             (compressed[0] & std::byte{0xF0}) == std::byte{0xA0} &&
                             compressed[0] != std::byte{0xA0};
        context.Fail(
            here, isNewer ? Text("is of version {} of the codec, which meshoptimizer {}.{} does not decode",
                                 std::to_integer<int>(compressed[0] & std::byte{0x0F}),
                                 MESHOPTIMIZER_VERSION / 1000, MESHOPTIMIZER_VERSION % 1000 / 10)
                          : Text("{} no {} of {} of {}", Counted(compressed.size(), "byte is", "bytes are"),
                                 kModes[static_cast<size_t>(view.mode)], Counted(view.count, "element"),
                                 Counted(view.byteStride, "byte")));
    }
    Unfilter(view, bytes.data());
    return bytes;
}

}  // namespace raygraph::scene
