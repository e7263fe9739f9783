// tinygltf's model of a document, under a name of ours: a host that is linked with our static libraries may
// have a tinygltf of its own. Internal to renderer/scene; no header that is installed includes this one.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

// No files and no images: it is given a document that names neither.
#define TINYGLTF_NO_FS
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define tinygltf raygraph_tinygltf
#include <tiny_gltf.h>
#undef tinygltf

namespace raygraph::scene {

namespace gltf = raygraph_tinygltf;

// The model of a document that stands before tinygltf's own faults: it ignores optional properties of wrong
// types, leaves out primitives that it cannot read, cuts integers, and opens what it is told to open. It
// parses a text, which is written here: takes the tree, so that there is one tree at a time. Throws
// Error{BadInput} "label: ..." if tinygltf refuses the document nevertheless.
gltf::Model MakeModel(nlohmann::json&& checked, const std::string& label);

}  // namespace raygraph::scene
