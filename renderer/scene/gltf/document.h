// A glTF document that has been checked, as tinygltf's model, and the list of known extensions. Internal to
// renderer/scene, except KnownExtensions. Threads: KnownExtensions: any.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/api.h"
#include "renderer/scene/gltf/context.h"
#include "renderer/scene/gltf/model.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

struct BufferSource {
    std::optional<std::string> uri;  // none: the BIN chunk
    uint64_t byteLength = 0;
};

struct ImageSource {
    std::string name;
    std::optional<std::string> uri;  // none: the buffer view
    uint32_t view = kNone;
};

// Holds the numbers of an accessor's "sparse"; zeros if it has none.
struct SparseNumbers {
    uint64_t count = 0;
    uint64_t indicesOffset = 0;
    uint64_t valuesOffset = 0;
};

inline constexpr const char* kAnimationPointer = "KHR_animation_pointer";

struct SkinSource {
    std::string name;
    std::vector<uint32_t> joints;
    uint32_t inverseBinds = kNone;  // an accessor
};

struct AnimationSource {
    struct Sampler {
        uint32_t input = 0, output = 0;  // accessors
        Interpolation interpolation = Interpolation::Linear;
    };
    struct Channel {
        uint32_t sampler = 0;
        uint32_t node = kNone;
        std::string path;
        std::optional<std::string> pointer;  // the pointer of KHR_animation_pointer
    };
    std::string name;
    std::vector<Sampler> samplers;
    std::vector<Channel> channels;
};

struct GltfDocument {
    // All indices are in range, but for an accessor's bufferView: views.size() - 1, one more than the file
    // has, is none. Buffers and images are placeholders.
    gltf::Model model;
    // The buffers and images, which tinygltf would open; it also keeps no length of a buffer.
    std::vector<BufferSource> buffers;
    std::vector<ImageSource> images;
    // Values that tinygltf refuses, or cuts to 31 bits. They are not in the model.
    std::vector<uint32_t> strides;      // by buffer view; 0: none
    std::vector<SparseNumbers> sparse;  // indexed by accessor
    // Objects that need none of tinygltf's checks.
    std::vector<SkinSource> skins;
    std::vector<AnimationSource> animations;
};

// Parses the text, checks all of it against the schema (gltf/schema.h) and makes the model. Opens nothing.
GltfDocument ReadDocument(GltfContext& context, std::string_view json);

// Describes a glTF extension that is known here: one of those that are read, or another with the reason why
// it is not. One that is not listed is unknown, and treated as one that is not read.
struct GltfExtension {
    std::string_view name;
    bool isRead = false;
    std::string_view note;  // how it is applied, or why it is not read
};

// Returns all known extensions, sorted by name.
RAYGRAPH_API std::span<const GltfExtension> KnownExtensions();

}  // namespace raygraph::scene
