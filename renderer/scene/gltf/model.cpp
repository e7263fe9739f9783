// The one file that tinygltf is compiled in.
#include <fstream>  // used by tinygltf, which leaves it out with TINYGLTF_NO_FS

#define TINYGLTF_IMPLEMENTATION
#include "renderer/scene/gltf/model.h"

#include <utility>

#include "base/printable.h"
#include "base/text.h"

namespace raygraph::scene {

gltf::Model MakeModel(nlohmann::json&& checked, const std::string& label) {
    const std::string text = std::exchange(checked, nullptr).dump();
    gltf::Model model;
    std::string errors, warnings;
    if (!gltf::TinyGLTF().LoadASCIIFromString(&model, &errors, &warnings, text.data(),
                                              static_cast<unsigned int>(text.size()), ""))
        throw MakeError(ErrorKind::BadInput, "{}: tinygltf refuses the document: {}", label,
                        Printable(errors, 300));
    return model;
}

}  // namespace raygraph::scene
