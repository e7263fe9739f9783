#include <algorithm>

#include "base/printable.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "renderer/image/image.h"
#include "renderer/scene/gltf_materials.h"
#include "renderer/scene/uri.h"

namespace raygraph::scene {
namespace {

// Of those that DecodeImage8 takes.
const char* FormatName(std::span<const std::byte> bytes) {
    switch (image::SniffFormat(bytes)) {
        case image::FileFormat::Png:
            return "PNG";
        case image::FileFormat::Jpeg:
            return "JPEG";
        case image::FileFormat::Webp:
            return "WebP";
        case image::FileFormat::Dds:
            return "DDS";
        default:
            return "KTX2";
    }
}

}  // namespace

ImageData DecodeImage(GltfContext& context, const ImageSource& source, uint32_t image, GltfBuffers& buffers) {
    const Place where = Place("images")[image];
    ImageData data;
    data.name = source.name;
    if (data.name.empty() && source.uri && !IsDataUri(*source.uri)) data.name = PercentDecode(*source.uri);
    std::vector<std::byte> file;
    if (source.uri) file = context.ReadUri(*source.uri, where["uri"]);
    const std::span<const std::byte> bytes =
        source.uri ? std::span<const std::byte>(file) : buffers.View(source.view);

    const LoadLimits& limits = context.options.limits;
    const uint64_t texelsLeft = limits.maxAllImageTexels - context.imageTexels;
    const image::DecodeLimits decodeLimits{.maxWidth = limits.maxImageExtent,
                                           .maxHeight = limits.maxImageExtent,
                                           .maxPixels = std::min(limits.maxImageTexels, texelsLeft)};
    std::string label = Text("{}: {}", context.label, where.Path());
    if (!data.name.empty()) label += Text(" {}", Quoted(data.name, 60));
    const Stopwatch watch;
    image::Image8 decoded = image::DecodeImage8(bytes, label, decodeLimits);
    Say(context.options.log, LogLevel::Debug, log_category::kScene, "{}: {} x {} {} of {} decoded in {}",
        label, decoded.width, decoded.height, FormatName(bytes), BytesText(bytes.size()),
        DurationText(watch.Seconds()));
    data.width = decoded.width;
    data.height = decoded.height;
    data.rgba = std::move(decoded.rgba);
    context.imageTexels += uint64_t{data.width} * data.height;
    return data;
}

}  // namespace raygraph::scene
