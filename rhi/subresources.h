// Mip levels and layers of a texture, and how a shader sees them. A subresource is one level of one layer.
// Threads: plain values and pure functions, for any thread.
#pragma once

#include <cstdint>
#include <string>

#include "base/api.h"

namespace raygraph::rhi {

// Describes a range of levels and layers; the default is all of both.
struct Subresources {
    static constexpr uint32_t kRest = ~0u;  // as a count: all from the first one on

    uint32_t level = 0;
    uint32_t levelCount = kRest;
    uint32_t layer = 0;
    uint32_t layerCount = kRest;

    bool operator==(const Subresources&) const = default;
};

// Return one level, or some, of all layers.
constexpr Subresources Levels(uint32_t first, uint32_t count) {
    return {.level = first, .levelCount = count};
}
constexpr Subresources Level(uint32_t level) {
    return Levels(level, 1);
}
// Return all levels of one layer, or of some.
constexpr Subresources Layers(uint32_t first, uint32_t count) {
    return {.layer = first, .layerCount = count};
}
constexpr Subresources Layer(uint32_t layer) {
    return Layers(layer, 1);
}
constexpr Subresources Subresource(uint32_t level, uint32_t layer) {
    return {.level = level, .levelCount = 1, .layer = layer, .layerCount = 1};
}

// The way in which a shader declares an image, and so the kind of its view.
enum class ImageShape : uint8_t {
    Plain,  // sampler2D, image2D: one layer
    Array,  // sampler2DArray, image2DArray: any number of layers
    Cube,   // samplerCube, imageCube: six square layers, +x -x +y -y +z -z
};
RAYGRAPH_API const char* Name(ImageShape shape);  // "2D image", "array of 2D images", "cube map"

// Returns the part with counts instead of kRest, for a texture with these numbers of levels and layers.
RAYGRAPH_API Subresources Resolved(const Subresources& part, uint32_t levels, uint32_t layers);
// Returns which part of a resolved range such a texture lacks, "level 7, there are 5", or an empty text if it
// lacks none.
RAYGRAPH_API std::string DescribeMissing(const Subresources& part, uint32_t levels, uint32_t layers);
// Returns " level 2", " levels 1-3 layer 4"; empty for all of the texture. `part` must be resolved.
RAYGRAPH_API std::string PartText(const Subresources& part, uint32_t levels, uint32_t layers);

// Both parts must be resolved.
constexpr bool Overlap(const Subresources& a, const Subresources& b) {
    return a.level < b.level + b.levelCount && b.level < a.level + a.levelCount &&
           a.layer < b.layer + b.layerCount && b.layer < a.layer + a.layerCount;
}

}  // namespace raygraph::rhi
