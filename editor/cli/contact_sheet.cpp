#include "editor/cli/contact_sheet.h"

#include <algorithm>
#include <cmath>

#include "base/check.h"

namespace raygraph::cli {

image::Image8 ContactSheet(std::span<const image::Image8> pictures) {
    const image::Image8& first = pictures.front();
    const auto count = static_cast<uint32_t>(pictures.size());
    const auto columns = static_cast<uint32_t>(std::ceil(std::sqrt(static_cast<double>(count))));
    const uint32_t rows = (count + columns - 1) / columns;
    image::Image8 sheet{.width = columns * first.width, .height = rows * first.height, .rgba = {}};
    sheet.rgba.resize(size_t{4} * sheet.width * sheet.height);
    for (uint32_t i = 0; i < count; ++i) {
        const image::Image8& picture = pictures[i];
        RG_CHECK(picture.width == first.width && picture.height == first.height);
        for (uint32_t y = 0; y < picture.height; ++y) {
            const size_t row = size_t{i / columns} * first.height + y;
            const auto* from = picture.rgba.data() + size_t{4} * y * picture.width;
            std::copy_n(from, size_t{4} * picture.width,
                        sheet.rgba.data() + 4 * (row * sheet.width + size_t{i % columns} * first.width));
        }
    }
    return sheet;
}

}  // namespace raygraph::cli
