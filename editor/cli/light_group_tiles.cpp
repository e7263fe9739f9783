#include "editor/cli/light_group_tiles.h"

#include <algorithm>

namespace raygraph::cli {

namespace {

// Calls copy(row of the picture, the same row in the tiles) with where these begin, in floats.
template <typename Copy>
void ForEachRow(ImageSize size, uint32_t groupCount, uint32_t group, const Copy& copy) {
    const uint32_t columns = passes::LightGroupTiles(groupCount).width;
    for (uint32_t y = 0; y < size.height; y++) {
        const size_t tileRow = size_t{group / columns} * size.height + y;
        copy(4 * size_t{y} * size.width, 4 * size_t{size.width} * (tileRow * columns + group % columns));
    }
}

}  // namespace

std::vector<Texels> FromTiles(const Texels& tiles, ImageSize size, uint32_t groupCount) {
    std::vector<Texels> pictures(groupCount, Texels(4 * size.PixelCount()));
    for (uint32_t group = 0; group < groupCount; group++)
        ForEachRow(size, groupCount, group, [&](size_t to, size_t from) {
            std::copy_n(tiles.data() + from, 4 * size_t{size.width}, pictures[group].data() + to);
        });
    return pictures;
}

Texels ToTiles(const std::vector<Texels>& pictures, ImageSize size) {
    const uint32_t count = static_cast<uint32_t>(pictures.size());
    const Extent2D across = passes::LightGroupTiles(count);
    Texels tiles(4 * size.PixelCount() * across.width * across.height, 0.0f);
    for (uint32_t group = 0; group < count; group++)
        ForEachRow(size, count, group, [&](size_t from, size_t to) {
            std::copy_n(pictures[group].data() + from, 4 * size_t{size.width}, tiles.data() + to);
        });
    return tiles;
}

}  // namespace raygraph::cli
