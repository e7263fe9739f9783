// The schema of a glTF document, as tables, and the check of a document against them. Internal to
// renderer/scene.
//
// Each property has a row, made by the builders below: its type, its range or what it points at, and what
// becomes of a value out of range. A property without a row is not read, and is taken out of the tree. To
// add an extension, add a line to document.cpp, and for each place in which it stands a table of its
// properties and a line of kOtherExtensions. The tables of a material's extensions follow from
// shaders/shared/material_list.h.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string_view>

#include "renderer/scene/gltf/context.h"
#include "renderer/scene/model/fields.h"

namespace raygraph::scene {

enum class PropertyType : uint8_t {
    Bool,
    String,
    Number,      // finite as a float
    Whole,       // At least 0; may be written 2.0 or 2e0.
    Index,       // a Whole below the length of an array of the document
    Numbers,     // an array of the row's count
    NumberList,  // an array of any count, with any values
    Indices,
    IndexLists,  // At least one list, each of as many as the row says.
    Object,
    Objects,             // an array of objects
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
    ClampToRange,  // a warning, and the nearest value of the range
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

namespace raygraph::scene::schema {

// --- Builders of the rows of gltf/schema_tables.cpp ---
// There is a class for each type of property, with what can be said of that type and nothing else. A
// statement that contradicts an earlier one is no constant expression, so a table that the checker would
// misunderstand does not compile.

template <typename Self>
struct RowOf : Property {
    constexpr RowOf(std::string_view ofName, PropertyType ofPropertyType) {
        name = ofName;
        type = ofPropertyType;
    }
    // Returns a changed copy. It comes first, because clang does not evaluate a call of a function that it
    // has not read yet.
    template <typename Change>
    constexpr Self With(const Change& change) const {
        Self row = static_cast<const Self&>(*this);
        change(row);
        if (row.isRequired && (row.misfit == Misfit::Omit || row.misfit == Misfit::OmitInvalid))
            throw "what is required cannot be left out";
        if (row.misfit == Misfit::ClampToRange && (row.excludesMin || row.excludesMax))
            throw "a range without its end has no nearest value";
        return row;
    }
    constexpr Self Required() const {
        return With([](Self& row) { row.isRequired = true; });
    }
};

struct Row : RowOf<Row> {
    using RowOf::RowOf;
};

template <typename Self>
struct RangeRow : RowOf<Self> {
    using RowOf<Self>::RowOf;
    constexpr Self AtLeast(float value) const {
        return this->With([&](Self& row) { row.min = value; });
    }
    constexpr Self Above(float value) const {
        return this->With([&](Self& row) { row.min = value, row.excludesMin = true; });
    }
    constexpr Self Below(float value) const {
        return this->With([&](Self& row) { row.max = value, row.excludesMax = true; });
    }
    constexpr Self Between(float low, float high) const {
        return this->With([&](Self& row) { row.min = low, row.max = high; });
    }
    constexpr Self OrZero() const {
        return this->With([](Self& row) { row.allowsZero = true; });
    }
    constexpr Self ClampToRange() const {
        return this->With([](Self& row) { row.misfit = Misfit::ClampToRange, row.topic = "factor"; });
    }
};

struct NumbersRow : RangeRow<NumbersRow> {
    constexpr NumbersRow(std::string_view ofName, size_t ofCount) : RangeRow(ofName, PropertyType::Numbers) {
        count = ofCount;
    }
};

struct NumberRow : RangeRow<NumberRow> {
    constexpr explicit NumberRow(std::string_view ofName) : RangeRow(ofName, PropertyType::Number) {}
    constexpr NumberRow OrOmitted(const char* warnAs, const char* instead) const {
        return With(
            [&](NumberRow& row) { row.misfit = Misfit::Omit, row.topic = warnAs, row.remedy = instead; });
    }
};

struct WholeRow : RowOf<WholeRow> {
    constexpr explicit WholeRow(std::string_view ofName) : RowOf(ofName, PropertyType::Whole) {}
    constexpr WholeRow Between(uint64_t low, uint64_t high) const {
        return With([&](WholeRow& row) { row.wholeMin = low, row.wholeMax = high; });
    }
    constexpr WholeRow AtLeast(uint64_t low) const {
        return With([&](WholeRow& row) { row.wholeMin = low; });
    }
    constexpr WholeRow OneOf(std::span<const uint64_t> values) const {
        return With([&](WholeRow& row) { row.numbers = values; });
    }
    constexpr WholeRow OrOmitted(const char* warnAs, const char* instead) const {
        return With(
            [&](WholeRow& row) { row.misfit = Misfit::Omit, row.topic = warnAs, row.remedy = instead; });
    }
    // A value is also left out if it is no whole number.
    constexpr WholeRow OrOmittedIfInvalid(const char* warnAs, const char* instead) const {
        return With([&](WholeRow& row) {
            row.misfit = Misfit::OmitInvalid, row.topic = warnAs, row.remedy = instead;
        });
    }
};

struct TextRow : RowOf<TextRow> {
    constexpr explicit TextRow(std::string_view ofName) : RowOf(ofName, PropertyType::String) {}
    constexpr TextRow OneOf(std::span<const std::string_view> values) const {
        return With([&](TextRow& row) { row.texts = values; });
    }
    // A value is also left out if it is no text.
    constexpr TextRow OrOmittedIfInvalid(const char* warnAs, const char* instead) const {
        return With([&](TextRow& row) {
            row.misfit = Misfit::OmitInvalid, row.topic = warnAs, row.remedy = instead;
        });
    }
    constexpr TextRow StartsWith(std::string_view text) const {
        return With([&](TextRow& row) { row.start = text; });
    }
};

struct ObjectRow : RowOf<ObjectRow> {
    constexpr ObjectRow(std::string_view ofName, std::span<const Property> objectRows)
        : RowOf(ofName, PropertyType::Object) {
        rows = objectRows.data();
        rowCount = objectRows.size();
    }
    constexpr ObjectRow OfType(std::string_view value) const {
        return With([&](ObjectRow& row) { row.ofType = value; });
    }
};

struct ObjectsRow : RowOf<ObjectsRow> {
    constexpr ObjectsRow(std::string_view ofName, std::span<const Property> objectRows)
        : RowOf(ofName, PropertyType::Objects) {
        rows = objectRows.data();
        rowCount = objectRows.size();
    }
    constexpr ObjectsRow ReferencedAs(Target what) const {
        return With([&](ObjectsRow& row) { row.target = what; });
    }
};

constexpr Row Flag(std::string_view name) {
    return {name, PropertyType::Bool};
}
constexpr TextRow Text(std::string_view name) {
    return TextRow(name);
}
constexpr NumberRow Number(std::string_view name) {
    return NumberRow(name);
}
constexpr NumbersRow Numbers(std::string_view name, size_t count) {
    return {name, count};
}
constexpr WholeRow Whole(std::string_view name) {
    return WholeRow(name);
}
constexpr Row Index(std::string_view name, Target target) {
    return Row(name, PropertyType::Index).With([&](Row& row) { row.target = target; });
}
constexpr Row Indices(std::string_view name, Target target) {
    return Row(name, PropertyType::Indices).With([&](Row& row) { row.target = target; });
}
constexpr Row NumberList(std::string_view name) {
    return {name, PropertyType::NumberList};
}
constexpr Row IndexLists(std::string_view name, Target target, size_t count) {
    return Row(name, PropertyType::IndexLists).With([&](Row& row) {
        row.target = target, row.count = count;
    });
}
constexpr ObjectRow Object(std::string_view name, std::span<const Property> rows) {
    return {name, rows};
}
constexpr ObjectsRow Objects(std::string_view name, std::span<const Property> rows) {
    return {name, rows};
}
constexpr Row Extensions(ExtensionPlace place) {
    return Row("extensions", PropertyType::Extensions).With([&](Row& row) { row.place = place; });
}
// Returns a row for the data of applications, of any type; of the properties of `rows`, only values of the
// right type are kept.
constexpr ObjectRow Extras(std::span<const Property> rows) {
    return Object("extras", rows).With([](ObjectRow& row) {
        row.misfit = Misfit::OmitInvalid;
        row.isStoredAsValue = true;
    });
}

// --- Rows of fields (fields.h) ---

template <typename RangedRow>
constexpr RangedRow InRange(const RangedRow& row, const FieldRange& range) {
    return range.mayBeZero ? row.Between(range.min, range.max).OrZero() : row.Between(range.min, range.max);
}
template <typename Owner>
constexpr NumberRow RowFor(const Field<Owner, float>& field) {
    // A value that is left out is 0.
    const NumberRow row(KeyPartsOf(field.key).key);
    return field.omitsZero ? InRange(row, field.range).Above(0.0f) : InRange(row, field.range);
}
template <typename Owner, int Length>
constexpr NumbersRow RowFor(const Field<Owner, glm::vec<Length, float>>& field) {
    return InRange(Numbers(field.key, Length), field.range);
}
template <typename Owner>
constexpr Row RowFor(const Field<Owner, bool>& field) {
    return Flag(field.key);
}

template <typename... Rows>
constexpr std::array<Property, sizeof...(Rows)> Table(const Rows&... rows) {
    return {rows...};
}

}  // namespace raygraph::scene::schema
