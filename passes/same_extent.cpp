#include "passes/same_extent.h"

#include "base/text.h"

namespace raygraph::passes {

Extent2D RequireComparable(const Renderer& renderer, const char* pass, TextureId a, TextureId b,
                           Format format) {
    const GraphTextureDesc first = renderer.Desc(a), second = renderer.Desc(b);
    const auto text = [](const GraphTextureDesc& desc) {
        return Text("{}x{} {}", desc.extent.width, desc.extent.height, rhi::Name(desc.format));
    };
    if (!(first == second) || first.format != format)
        throw MakeError(ErrorKind::Usage, "{}: pictures of {} and {}; both must be {} of one extent", pass,
                        text(first), text(second), rhi::Name(format));
    return first.extent;
}

}  // namespace raygraph::passes
