// AddCompute: adds a compute pass that runs once for each pixel of an extent. BlocksOf: the extent of a
// picture of blocks. Threads: that of the Renderer.
#pragma once

#include <cstdint>
#include <string_view>

#include "renderer/graph/renderer.h"

namespace raygraph::passes {

// Returns the numbers of blocks of `side` x `side` pixels, those at the edges included.
inline Extent2D BlocksOf(Extent2D extent, uint32_t side) {
    return {(extent.width + side - 1) / side, (extent.height + side - 1) / side};
}

// `setup` takes a PassBuilder& and runs now; it declares everything but the shader.
template <typename Setup>
PassId AddCompute(Renderer& renderer, std::string_view name, std::string_view shader, Extent2D extent,
                  const Setup& setup) {
    return renderer.AddPass(
        name, PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute(shader);
            setup(pass);
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
}

}  // namespace raygraph::passes
