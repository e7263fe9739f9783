#include <algorithm>

#include "base/printable.h"
#include "renderer/image/image.h"
#include "renderer/scene/gltf_materials.h"
#include "renderer/scene/uri.h"

namespace raygraph::scene {

ImageData DecodeImage(GltfContext& context, const JsonValue& root, uint32_t image, GltfBuffers& buffers) {
    const JsonValue value = root["images"].At(image);
    const JsonValue uri = value["uri"];
    ImageData data;
    data.name = value["name"].StringOr("");
    if (data.name.empty() && uri.IsPresent() && !IsDataUri(uri.String()))
        data.name = PercentDecode(uri.String());
    std::vector<std::byte> file;
    std::span<const std::byte> bytes;
    if (uri.IsPresent()) {
        file = context.ReadUri(uri);
        bytes = file;
    } else {
        bytes = buffers.View(value["bufferView"].Index(root["bufferViews"].Count(), "bufferViews"));
    }

    const LoadLimits& limits = context.options.limits;
    const uint64_t texelsLeft = limits.maxAllImageTexels - context.imageTexels;
    const image::DecodeLimits decodeLimits{.maxWidth = limits.maxImageExtent,
                                           .maxHeight = limits.maxImageExtent,
                                           .maxPixels = std::min(limits.maxImageTexels, texelsLeft)};
    std::string label = context.label + ": " + value.Path();
    if (!data.name.empty()) label.append(" ").append(Quoted(data.name, 60));
    image::Image8 decoded = image::DecodeImage8(bytes, label, decodeLimits);
    data.width = decoded.width;
    data.height = decoded.height;
    data.rgba = std::move(decoded.rgba);
    context.imageTexels += uint64_t{data.width} * data.height;
    return data;
}

}  // namespace raygraph::scene
