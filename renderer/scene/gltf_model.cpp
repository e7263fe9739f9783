// The one file that tinygltf is compiled in.
#include <algorithm>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

namespace {

nlohmann::json TakeTree(const char* bytes) {
    return std::move(*const_cast<nlohmann::json*>(reinterpret_cast<const nlohmann::json*>(bytes)));
}

}  // namespace

// tinygltf begins with nlohmann::json::parse(text, end of text, ...), and reads the tree that this returns.
// The checked document is such a tree already: to write it as a text, for it to be parsed again, would take
// as long as all other loading. So the text that tinygltf is given is the tree itself, and what it calls for
// a parser takes it.
#define parse(text, ...) value_type(TakeTree(text))
#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_INCLUDE_JSON
#include "renderer/scene/gltf_model.h"
#undef parse

#include "base/error.h"
#include "base/printable.h"

namespace raygraph::scene {

gltf::Model MakeModel(nlohmann::json&& checked, const std::string& label) {
    gltf::Model model;
    std::string errors, warnings;
    const auto* const text = reinterpret_cast<const char*>(&checked);
    if (!gltf::TinyGLTF().LoadASCIIFromString(&model, &errors, &warnings, text, sizeof checked, ""))
        throw Error(ErrorKind::BadInput,
                    label + ": tinygltf refuses the document: " + Printable(errors, 300));
    return model;
}

}  // namespace raygraph::scene
