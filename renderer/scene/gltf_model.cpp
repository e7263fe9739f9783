// The one file that tinygltf is compiled in.
#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "renderer/scene/gltf_tree.h"

// tinygltf reads a tree of the type nlohmann::json, which it has parsed from a text. The checked document is
// such a tree already; to write it as a text and parse that again would take as long as all other loading. So
// the tree type that tinygltf sees is ours, and its parser takes "text" that is the tree itself. A version of
// tinygltf that calls another function would find no JSON there, and MakeModel fail.
namespace raygraph_tinygltf_json {
using json = raygraph::scene::GltfTree;
}

namespace nlohmann {
using raygraph::scene::GltfTree;
template <>
template <>
GltfTree GltfTree::parse<const char*>(const char* first, const char*, const GltfTree::parser_callback_t,
                                      const bool, const bool) {
    return std::move(*const_cast<GltfTree*>(reinterpret_cast<const GltfTree*>(first)));
}
}  // namespace nlohmann

#define nlohmann raygraph_tinygltf_json
#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_INCLUDE_JSON
#include "renderer/scene/gltf_model.h"
#undef nlohmann

#include "base/error.h"
#include "base/printable.h"

namespace raygraph::scene {

gltf::Model MakeModel(GltfTree&& checked, const std::string& label) {
    gltf::Model model;
    std::string errors, warnings;
    const auto* const tree = reinterpret_cast<const char*>(&checked);
    if (!gltf::TinyGLTF().LoadASCIIFromString(&model, &errors, &warnings, tree, sizeof checked, ""))
        throw Error(ErrorKind::BadInput,
                    label + ": tinygltf refuses the document: " + Printable(errors, 300));
    return model;
}

}  // namespace raygraph::scene
