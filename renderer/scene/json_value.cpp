#include "renderer/scene/json_value.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/printable.h"

namespace raygraph::scene {

JsonValue JsonValue::Child(const GltfTree* json, Segment segment) const {
    JsonValue child = *this;
    child.m_json = json;
    if (child.m_segmentCount < kMaxSegments) child.m_segments[child.m_segmentCount++] = segment;
    return child;
}

bool JsonValue::IsObject() const {
    return m_json && m_json->is_object();
}
bool JsonValue::IsString() const {
    return m_json && m_json->is_string();
}

JsonValue JsonValue::operator[](const char* key) const {
    if (!m_json) return Child(nullptr, {key, 0});
    RequireObject();
    const auto found = m_json->find(key);
    return Child(found == m_json->end() ? nullptr : &*found, {key, 0});
}

JsonValue JsonValue::At(size_t index) const {
    return Child(&(*m_json)[index], {nullptr, index});
}

size_t JsonValue::Count() const {
    if (!m_json) return 0;
    if (!m_json->is_array()) Fail("is " + Shown() + ", must be an array");
    return m_json->size();
}

const JsonValue& JsonValue::RequireObject() const {
    if (!IsObject()) Fail("is " + Shown() + ", must be an object");
    return *this;
}

const std::string& JsonValue::String() const {
    if (!IsString()) Fail("is " + Shown() + ", must be a string");
    return m_json->get_ref<const std::string&>();
}

bool JsonValue::Bool() const {
    if (!m_json || !m_json->is_boolean()) Fail("is " + Shown() + ", must be true or false");
    return m_json->get<bool>();
}

double JsonValue::Number() const {
    if (!m_json || !m_json->is_number()) Fail("is " + Shown() + ", must be a number");
    const double value = m_json->get<double>();
    if (!std::isfinite(value)) Fail("is not finite");
    return value;
}

float JsonValue::Float() const {
    const double value = Number();
    if (std::abs(value) > static_cast<double>(std::numeric_limits<float>::max()))
        Fail("is " + Shown() + ", too large for a float");
    return static_cast<float>(value);
}

std::optional<uint64_t> JsonValue::TryUnsigned() const {
    if (m_json && m_json->is_number_unsigned()) return m_json->get<uint64_t>();
    if (m_json && m_json->is_number_float()) {
        const double value = m_json->get<double>();
        if (value >= 0.0 && value <= 9007199254740992.0 && value == std::floor(value))
            return static_cast<uint64_t>(value);
    }
    return std::nullopt;
}

uint64_t JsonValue::Unsigned() const {
    if (const std::optional<uint64_t> value = TryUnsigned()) return *value;
    Fail("is " + Shown() + ", must be a whole number of at least 0");
}

uint32_t JsonValue::Index(size_t count, const char* what) const {
    const uint64_t index = Unsigned();
    if (index >= count)
        Fail("is " + std::to_string(index) + ", but there are " + std::to_string(count) + " " + what);
    return static_cast<uint32_t>(index);
}

void JsonValue::Floats(std::span<float> out) const {
    if (!m_json) Fail("is absent, must be an array");
    if (Count() != out.size())
        Fail("has " + std::to_string(Count()) + " elements, must have " + std::to_string(out.size()));
    for (size_t i = 0; i < out.size(); ++i) out[i] = At(i).Float();
}

std::string JsonValue::StringOr(std::string_view absent) const {
    return m_json ? String() : std::string(absent);
}
bool JsonValue::BoolOr(bool absent) const {
    return m_json ? Bool() : absent;
}
float JsonValue::FloatOr(float absent) const {
    return m_json ? Float() : absent;
}
uint64_t JsonValue::UnsignedOr(uint64_t absent) const {
    return m_json ? Unsigned() : absent;
}
uint32_t JsonValue::IndexOr(uint32_t absent, size_t count, const char* what) const {
    return m_json ? Index(count, what) : absent;
}
void JsonValue::FloatsIfPresent(std::span<float> out) const {
    if (m_json) Floats(out);
}

std::string JsonValue::Path() const {
    std::string path;
    for (uint32_t i = 0; i < m_segmentCount; ++i) {
        const Segment& segment = m_segments[i];
        if (segment.key) {
            if (!path.empty()) path += '.';
            path += segment.key;
        } else {
            path += '[' + std::to_string(segment.index) + ']';
        }
    }
    return path;
}

std::string JsonValue::Shown() const {
    if (!m_json) return "absent";
    switch (m_json->type()) {
        case GltfTree::value_t::object:
            return "an object";
        case GltfTree::value_t::array:
            return "an array";
        case GltfTree::value_t::string:
            return Quoted(m_json->get_ref<const std::string&>(), 40);
        default:
            return m_json->dump();
    }
}

void JsonValue::Fail(const std::string& why) const {
    const std::string path = Path();
    throw Error(ErrorKind::BadInput, *m_label + ": " + (path.empty() ? "" : path + ": ") + why);
}

}  // namespace raygraph::scene
