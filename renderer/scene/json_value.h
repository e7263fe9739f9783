// A JSON value that knows its place in the document, so that every check can say where it failed:
// "scene.gltf: accessors[3].count: is -1, must be a whole number of at least 1".
//
// Nothing here trusts the document: asking a string for a number is an Error{BadInput}, never undefined.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "renderer/scene/gltf_tree.h"

namespace raygraph::scene {

class JsonValue {
  public:
    // The root. `json` and `label` (the file's name, printable) must outlive this value and all made from it.
    JsonValue(const GltfTree& json, const std::string& label) : m_json(&json), m_label(&label) {}

    bool IsPresent() const { return m_json != nullptr; }
    bool IsObject() const;
    bool IsString() const;

    // A member of an object; an absent value if there is no such member or this value is itself absent. Fails
    // if this is no object. `key` must be a literal: it is kept for messages.
    JsonValue operator[](const char* key) const;
    // An element of an array; the index must be below Count().
    JsonValue At(size_t index) const;
    // Elements of an array; 0 if absent. Fails if this is no array.
    size_t Count() const;
    // Fails unless this is a present object. Returns *this.
    const JsonValue& RequireObject() const;

    // Each fails if the value is absent or of another type.
    const std::string& String() const;
    bool Bool() const;
    // Finite (JSON has no other numbers, and the parser refuses those that overflow).
    double Number() const;
    // Finite as a float.
    float Float() const;
    // A whole number, also when written 2.0 or 2e0, up to 2^53 in those forms.
    uint64_t Unsigned() const;
    // The same; nothing if the value is absent or no such number.
    std::optional<uint64_t> TryUnsigned() const;
    // An index below `count` of the array named `what`: "is 7, but there are 3 accessors".
    uint32_t Index(size_t count, const char* what) const;
    // An array of exactly out.size() floats.
    void Floats(std::span<float> out) const;

    // The same, with a value for when it is absent.
    std::string StringOr(std::string_view absent) const;
    bool BoolOr(bool absent) const;
    float FloatOr(float absent) const;
    uint64_t UnsignedOr(uint64_t absent) const;
    uint32_t IndexOr(uint32_t absent, size_t count, const char* what) const;
    // Leaves `out` as it is when absent.
    void FloatsIfPresent(std::span<float> out) const;

    // "accessors[3].count"; empty for the root.
    std::string Path() const;
    // The value as a message shows it: numbers and short strings themselves, else the type's name.
    std::string Shown() const;
    // Throws Error{BadInput} "label: path: why".
    [[noreturn]] void Fail(const std::string& why) const;

  private:
    struct Segment {
        const char* key = nullptr;  // nullptr: an array index.
        size_t index = 0;
    };
    // Deeper than anything that the importer reads; a deeper value keeps the path of its ancestor.
    static constexpr size_t kMaxSegments = 10;

    JsonValue Child(const GltfTree* json, Segment segment) const;

    const GltfTree* m_json = nullptr;
    const std::string* m_label = nullptr;
    uint32_t m_segmentCount = 0;
    std::array<Segment, kMaxSegments> m_segments;
};

}  // namespace raygraph::scene
