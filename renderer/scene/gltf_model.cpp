// The one file that tinygltf is compiled in.
#include <algorithm>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string_view>
#include <utility>

namespace {

// The tree that the parser of this thread returns next, and how often it was asked.
struct Handover {
    nlohmann::json* tree = nullptr;
    int count = 0;
};
thread_local Handover handover;

nlohmann::json TakeTree() {
    nlohmann::json* const tree = std::exchange(handover.tree, nullptr);
    ++handover.count;
    return tree ? std::move(*tree) : nlohmann::json();
}

}  // namespace

// tinygltf begins with nlohmann::json::parse(text, end of text, ...), and reads the tree that this returns.
// The checked document is such a tree already: to write it as a text, for it to be parsed again, would take
// as long as all other loading. So what it calls for a parser hands the tree over, and the text is a dummy.
#define parse(...) value_type(TakeTree())
#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_INCLUDE_JSON
#include "renderer/scene/gltf_model.h"
#undef parse

#include "base/printable.h"
#include "base/text.h"

namespace raygraph::scene {

gltf::Model MakeModel(nlohmann::json&& checked, const std::string& label) {
    gltf::Model model;
    std::string errors, warnings;
    constexpr std::string_view kDummy = "{    }";
    handover = {&checked, 0};
    const bool isRead = gltf::TinyGLTF().LoadASCIIFromString(&model, &errors, &warnings, kDummy.data(),
                                                             static_cast<unsigned int>(kDummy.size()), "");
    const int count = std::exchange(handover, {}).count;
    if (!isRead)
        throw MakeError(ErrorKind::BadInput, "{}: tinygltf refuses the document: {}", label,
                        Printable(errors, 300));
    // Another version of it, which parses in another way
    if (count != 1)
        throw MakeError(ErrorKind::BadInput, "{}: tinygltf has parsed {} documents in place of one", label,
                        count);
    return model;
}

}  // namespace raygraph::scene
