// A glTF document that has been checked, as tinygltf's model. Internal to renderer/scene.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/scene/gltf_context.h"
#include "renderer/scene/gltf_model.h"
#include "renderer/scene/scene_data.h"

namespace raygraph::scene {

struct BufferSource {
    std::optional<std::string> uri;  // None: the BIN chunk.
    uint64_t byteLength = 0;
};

struct ImageSource {
    std::string name;
    std::optional<std::string> uri;  // None: the buffer view.
    uint32_t view = kNone;
};

struct GltfDocument {
    // All indices are in range, but for an accessor's bufferView: views.size() - 1, one more than the file
    // has, is none. Buffers and images are placeholders.
    gltf::Model model;
    // What tinygltf would open; and it keeps no length of a buffer.
    std::vector<BufferSource> buffers;
    std::vector<ImageSource> images;
};

// Parses the text, checks all of it against the schema (gltf_schema.h) and makes the model. Opens nothing.
GltfDocument ReadDocument(GltfContext& context, std::string_view json);

}  // namespace raygraph::scene
