// The schema of a glTF document, as tables, and the check of a document against them. Internal to
// renderer/scene.
//
// A row a property, made by gltf/schema_rows.h: its type, its range or what it points at, and what becomes of
// a value out of range. What has no row is not read, and taken out of the tree. An extension is a line of
// extensions.cpp, and for each place that it stands in a table of its properties and a line of
// kOtherExtensions; those of a material follow from shaders/shared/material_list.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string_view>

#include "renderer/scene/gltf/context.h"

namespace raygraph::scene {

enum class PropertyType : uint8_t {
    Bool,
    String,
    Number,      // Finite as a float.
    Whole,       // At least 0; may be written 2.0 or 2e0.
    Index,       // A Whole below the length of an array of the document.
    Numbers,     // an array of the row's count
    NumberList,  // an array of any count, with any values
    Indices,
    IndexLists,  // At least one list, each of as many as the row says.
    Object,
    Objects,             // An array of objects.
    Extensions,          // An object of extensions, which are objects.
    UsedExtensions,      // An array of strings; a warning for each that is not supported.
    RequiredExtensions,  // An array of strings; all must be supported.
};

// The array into which an index points.
enum class Target : uint8_t {
    None,
    Accessors,
    BufferViews,
    Buffers,
    Cameras,
    ImageLights,
    Images,
    LightProfiles,
    Lights,
    Materials,
    Meshes,
    Nodes,
    Samplers,
    Scenes,
    Skins,
    Textures,
    Variants,
    AnimationSamplers,  // those of the animation that holds the index
    Count,
};

enum class Misfit : uint8_t {
    Refuse,        // The file is bad.
    ClampToRange,  // A warning, and the nearest value of the range.
    Omit,          // A warning that ends in the row's remedy, and the property is absent.
    OmitInvalid,   // like Omit, also for a value of another type: it belongs to an application
};

// The object that holds an extension.
enum class ExtensionPlace : uint8_t {
    Nowhere,
    Root,
    Buffer,
    BufferView,
    Primitive,
    Node,
    Scene,
    Material,
    Texture,
    TextureInfo,
};

struct Property {
    std::string_view name;
    PropertyType type = PropertyType::Bool;
    bool isRequired = false;
    Misfit misfit = Misfit::Refuse;
    const char* topic = nullptr;   // the warning's topic: warnings of one topic are one line
    const char* remedy = nullptr;  // the text for what is done instead: "taken as 0"
    // for Number and Numbers: the range of each
    float min = std::numeric_limits<float>::lowest();
    float max = std::numeric_limits<float>::max();
    bool excludesMin = false;
    bool excludesMax = false;
    bool allowsZero = false;  // Which is out of the range.
    // for Numbers and IndexLists: the number of elements
    size_t count = 0;
    // for Whole: the range
    uint64_t wholeMin = 0;
    uint64_t wholeMax = std::numeric_limits<uint64_t>::max();
    // For Whole and String: the allowed values, if there are any. For String: the text with which it starts.
    std::span<const uint64_t> numbers;
    std::span<const std::string_view> texts;
    std::string_view start;
    // For Index and Indices: the array into which they point. For Objects: the target by which indices point
    // into them.
    Target target = Target::None;
    // For Object and Objects: their properties.
    const Property* rows = nullptr;
    size_t rowCount = 0;
    // For Object: it is read, and required, only if the property "type" beside it has this value.
    std::string_view ofType;
    // True where tinygltf keeps the content as values, as it does in extensions.
    bool isStoredAsValue = false;
    ExtensionPlace place = ExtensionPlace::Nowhere;

    std::span<const Property> Rows() const { return {rows, rowCount}; }
};

struct Extension {
    std::string_view name;
    ExtensionPlace place = ExtensionPlace::Nowhere;
    std::span<const Property> rows;
};

// Returns the table of gltf/schema_tables.cpp for the root.
std::span<const Property> RootProperties();
std::span<const Extension> SupportedExtensions();

// Checks all of the document, the root's properties in the order of their rows. Afterwards the tree holds
// what has a row and nothing else, values in their range, whole numbers as unsigned ones, and all indices
// point at something. Fails at the first value that is refused.
void CheckSchema(GltfContext& context, nlohmann::json& root);

}  // namespace raygraph::scene
