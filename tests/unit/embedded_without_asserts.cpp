// Ends with 0 if the shaders can be unpacked in a build without RAYGRAPH_ASSERTS, which hosts may make.
#include "shaders/embedded.h"

int main() {
    constexpr uint32_t kSpirvMagic = 0x07230203;
    for (const raygraph::EmbeddedShader& shader : raygraph::EmbeddedShaders())
        if (shader.Words().empty() || shader.Words()[0] != kSpirvMagic) return 1;
    return raygraph::EmbeddedShaders().empty() ? 1 : 0;
}
