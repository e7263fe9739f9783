#include "rhi/subresources.h"

#include "base/text.h"

namespace raygraph::rhi {
namespace {

// Returns text such as "level 2" or "levels 1-3".
std::string RangeText(const char* noun, uint32_t first, uint32_t count) {
    return count == 1 ? Text("{} {}", noun, first) : Text("{}s {}-{}", noun, first, first + count - 1);
}

std::string MissingOf(const char* noun, uint32_t first, uint32_t count, uint32_t available) {
    if (count == 0) return Text("no {}", noun);
    if (first < available && count <= available - first) return {};
    return Text("{}, there {} {}", RangeText(noun, first, count), available == 1 ? "is" : "are", available);
}

}  // namespace

const char* Name(ImageShape shape) {
    switch (shape) {
        case ImageShape::Plain:
            return "2D image";
        case ImageShape::Array:
            return "array of 2D images";
        case ImageShape::Cube:
            return "cube map";
    }
    return "?";
}

Subresources Resolved(const Subresources& part, uint32_t levels, uint32_t layers) {
    // A first one that does not exist stays a range of one, for the message.
    const auto count = [](uint32_t first, uint32_t requested, uint32_t available) {
        if (requested != Subresources::kRest) return requested;
        return first < available ? available - first : 1;
    };
    return {.level = part.level,
            .levelCount = count(part.level, part.levelCount, levels),
            .layer = part.layer,
            .layerCount = count(part.layer, part.layerCount, layers)};
}

std::string DescribeMissing(const Subresources& part, uint32_t levels, uint32_t layers) {
    std::string missing = MissingOf("level", part.level, part.levelCount, levels);
    return missing.empty() ? MissingOf("layer", part.layer, part.layerCount, layers) : missing;
}

std::string PartText(const Subresources& part, uint32_t levels, uint32_t layers) {
    std::string text;
    if (part.levelCount != levels) text += ' ' + RangeText("level", part.level, part.levelCount);
    if (part.layerCount != layers) text += ' ' + RangeText("layer", part.layer, part.layerCount);
    return text;
}

}  // namespace raygraph::rhi
