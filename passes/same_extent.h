// Checks of passes over two pictures. Threads: that of the Renderer.
#pragma once

#include <string>

#include "base/error.h"
#include "renderer/graph/renderer.h"

namespace raygraph::passes {

// The extent of both. Error{Usage} naming the pass unless both have that format and one extent.
inline Extent2D RequireAlike(const Renderer& renderer, const char* pass, TextureId a, TextureId b,
                             Format format) {
    const GraphTextureDesc first = renderer.Desc(a), second = renderer.Desc(b);
    const auto text = [](const GraphTextureDesc& desc) {
        return std::to_string(desc.extent.width) + "x" + std::to_string(desc.extent.height) + " " +
               rhi::Name(desc.format);
    };
    if (!(first == second) || first.format != format)
        throw Error(ErrorKind::Usage, std::string(pass) + ": pictures of " + text(first) + " and " +
                                          text(second) + "; both must be " + rhi::Name(format) +
                                          " of one extent");
    return first.extent;
}

}  // namespace raygraph::passes
