#include "editor/session/frames/light_group_tiles.h"

#include <algorithm>

namespace raygraph::session {

namespace {

// Calls copy(row of the picture, the same row in the tiles) with where these begin, in floats.
template <typename Copy>
void ForEachRow(Extent2D size, uint32_t groupCount, uint32_t group, const Copy& copy) {
    const uint32_t columns = passes::LightGroupTiles(groupCount).width;
    for (uint32_t y = 0; y < size.height; ++y) {
        const size_t tileRow = size_t{group / columns} * size.height + y;
        copy(4 * size_t{y} * size.width, 4 * size_t{size.width} * (tileRow * columns + group % columns));
    }
}

}  // namespace

std::vector<Texels> FromTiles(const Texels& tiles, Extent2D size, uint32_t groupCount) {
    std::vector<Texels> pictures(groupCount, Texels(4 * PixelCount(size)));
    for (uint32_t group = 0; group < groupCount; ++group)
        ForEachRow(size, groupCount, group, [&](size_t to, size_t from) {
            std::copy_n(tiles.data() + from, 4 * size_t{size.width}, pictures[group].data() + to);
        });
    return pictures;
}

std::vector<passes::ExactSums> FromTiles(const passes::ExactSums& tiles, Extent2D size, uint32_t groupCount) {
    std::vector<passes::ExactSums> pictures(groupCount, passes::MakeExactSums(PixelCount(size), false));
    for (uint32_t group = 0; group < groupCount; ++group)
        for (size_t k = 0; k < passes::ExactSums::kPlanes; ++k)
            ForEachRow(size, groupCount, group, [&](size_t to, size_t from) {
                std::copy_n(tiles.sums[k].data() + from, 4 * size_t{size.width},
                            pictures[group].sums[k].data() + to);
            });
    return pictures;
}

passes::ExactSums ToTiles(const std::vector<passes::ExactSums>& pictures, Extent2D size) {
    const uint32_t count = static_cast<uint32_t>(pictures.size());
    const Extent2D across = passes::LightGroupTiles(count);
    passes::ExactSums tiles = passes::MakeExactSums(PixelCount(size) * across.width * across.height, false);
    for (uint32_t group = 0; group < count; ++group)
        for (size_t k = 0; k < passes::ExactSums::kPlanes; ++k)
            ForEachRow(size, count, group, [&](size_t from, size_t to) {
                std::copy_n(pictures[group].sums[k].data() + from, 4 * size_t{size.width},
                            tiles.sums[k].data() + to);
            });
    return tiles;
}

}  // namespace raygraph::session
