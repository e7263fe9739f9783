#include "renderer/scene/gltf/schema.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "base/check.h"
#include "base/printable.h"
#include "base/text.h"
#include "renderer/scene/gltf/document.h"

namespace raygraph::scene {
namespace {

using Json = nlohmann::json;

// Returns what one of them is called.
const char* Name(Target target) {
    constexpr std::array<const char*, static_cast<size_t>(Target::Count)> kNames{
        "",         "accessor", "bufferView", "buffer",  "camera", "light", "image",   "light",   "light",
        "material", "mesh",     "node",       "sampler", "scene",  "skin",  "texture", "variant", "sampler"};
    return kNames[static_cast<size_t>(target)];
}

// Returns a value as a message shows it: numbers and short strings themselves, else the type's name.
std::string Shown(const Json& value) {
    switch (value.type()) {
        case Json::value_t::object:
            return "an object";
        case Json::value_t::array:
            return "an array";
        case Json::value_t::string:
            return Quoted(value.get_ref<const std::string&>(), 40);
        default:
            return value.dump();
    }
}

std::string Shown(float limit) {
    if (limit == static_cast<float>(M_PI)) return "pi";
    return limit == std::floor(limit) ? Text("{}", static_cast<int64_t>(limit)) : Text("{:f}", limit);
}

// Returns a text such as "1, 2 or 3".
template <typename Values>
std::string Listed(const Values& values) {
    std::string list;
    for (size_t i = 0; i < values.size(); ++i)
        list += Text("{}{}", i == 0 ? "" : i + 1 < values.size() ? ", " : " or ", values[i]);
    return list;
}

const char* TypeRequirement(PropertyType type) {
    switch (type) {
        case PropertyType::Bool:
            return "must be true or false";
        case PropertyType::String:
            return "must be a string";
        case PropertyType::Number:
            return "must be a number";
        case PropertyType::Whole:
        case PropertyType::Index:
            return "must be a whole number of at least 0";
        case PropertyType::Object:
        case PropertyType::Extensions:
            return "must be an object";
        default:
            return "must be an array";
    }
}

std::string IntegerRequirement(const Property& row) {
    if (row.wholeMax == std::numeric_limits<uint64_t>::max())
        return Text("must be at least {}", row.wholeMin);
    const char* kind = row.misfit == Misfit::OmitInvalid ? "a whole number of " : "";
    return Text("must be {}{} to {}", kind, row.wholeMin, row.wholeMax);
}

std::string NumberRequirement(const Property& row, float value) {
    const bool isLow = value < row.min || (row.excludesMin && value == row.min);
    if (!isLow) return (row.excludesMax ? "must be below " : "must be at most ") + Shown(row.max);
    if (row.excludesMin) return "must be above " + Shown(row.min);
    return row.min == 0.0f ? "must not be negative" : "must be at least " + Shown(row.min);
}

bool IsInRange(const Property& row, float value) {
    if (row.allowsZero && value == 0.0f) return true;
    return (row.excludesMin ? value > row.min : value >= row.min) &&
           (row.excludesMax ? value < row.max : value <= row.max);
}

std::optional<uint64_t> ToWhole(const Json& value) {
    if (value.is_number_unsigned()) return value.get<uint64_t>();
    if (value.is_number_float()) {
        const double number = value.get<double>();
        constexpr double kMaxExactInteger = 9007199254740992.0;
        if (number >= 0.0 && number <= kMaxExactInteger && number == std::floor(number))
            return static_cast<uint64_t>(number);
    }
    return std::nullopt;
}

bool IsSupported(const std::string& name) {
    const bool isListed = std::ranges::any_of(KnownExtensions(), [&](const GltfExtension& extension) {
        return extension.isRead && extension.name == name;
    });
    return isListed || std::ranges::any_of(SupportedExtensions(), [&](const Extension& extension) {
               return extension.name == name;
           });
}

class Checker {
  public:
    explicit Checker(GltfContext& context) : m_context(context) {}

    void CheckRoot(Json& root) {
        for (const Property& row : RootProperties()) CountTargets(root, row);
        Json checked = Json::object();
        for (const Property& row : RootProperties()) {
            const Step step(*this, row.name);
            const auto found = root.find(row.name);
            if (found == root.end()) {
                if (row.isRequired) FailAbsent(row);
            } else if (CheckProperty(*found, row)) {
                checked[std::string(row.name)] = std::move(*found);
            }
        }
        root = std::move(checked);
    }

  private:
    // Describes a step of the path to the value that is looked at: a name, or an index if there is none.
    struct PathStep {
        std::string_view name;
        size_t index = 0;
    };
    class Step {
      public:
        Step(Checker& checker, std::string_view name) : m_checker(checker) {
            m_checker.m_path.push_back({name});
        }
        Step(Checker& checker, size_t index) : m_checker(checker) { m_checker.m_path.push_back({{}, index}); }
        ~Step() { m_checker.m_path.pop_back(); }
        Step(const Step&) = delete;
        Step& operator=(const Step&) = delete;

      private:
        Checker& m_checker;
    };

    size_t& Count(Target target) { return m_counts[static_cast<size_t>(target)]; }

    // The length of the array of `object` that indices will point into.
    void CountTargets(const Json& object, const Property& row) {
        if (row.type != PropertyType::Objects || row.target == Target::None) return;
        const auto found = object.find(row.name);
        Count(row.target) = found != object.end() && found->is_array() ? found->size() : 0;
    }

    void CheckObject(Json& object, std::span<const Property> rows) {
        uint64_t seen = 0;
        RG_CHECK_LE(rows.size(), size_t{64});
        for (const Property& row : rows) CountTargets(object, row);
        for (auto member = object.begin(); member != object.end();) {
            const std::string& name = member.key();
            const auto row = std::ranges::find(rows, name, &Property::name);
            bool isKept = row != rows.end() && IsOfType(object, *row);
            if (isKept) {
                const Step step(*this, row->name);
                isKept = CheckProperty(*member, *row);
                if (isKept || !row->isRequired) seen |= uint64_t{1} << (row - rows.begin());
            }
            member = isKept ? std::next(member) : object.erase(member);
        }
        for (size_t i = 0; i < rows.size(); ++i) {
            const bool isRequired =
                rows[i].isRequired || (!rows[i].ofType.empty() && IsOfType(object, rows[i]));
            if (!isRequired || (seen >> i & 1)) continue;
            const Step step(*this, rows[i].name);
            FailAbsent(rows[i]);
        }
    }

    // Returns whether the property is one of an object of this type.
    static bool IsOfType(const Json& object, const Property& row) {
        if (row.ofType.empty()) return true;
        const auto type = object.find("type");
        return type != object.end() && type->is_string() && type->get_ref<const std::string&>() == row.ofType;
    }

    // Returns false if the value must be left out.
    bool CheckProperty(Json& value, const Property& row) {
        switch (row.type) {
            case PropertyType::Bool:
                return value.is_boolean() || Reject(value, row);
            case PropertyType::String:
                return CheckString(value, row);
            case PropertyType::Number:
                return CheckNumber(value, row);
            case PropertyType::Whole:
                return CheckWhole(value, row);
            case PropertyType::Index:
                return CheckIndex(value, row);
            case PropertyType::Numbers:
                return CheckNumbers(value, row);
            case PropertyType::NumberList:
                return CheckEach(value, row, [&](Json& element) {
                    if (!element.is_number()) FailValue(element, "must be a number");
                    CheckNumber(element, row);
                });
            case PropertyType::Indices:
                return CheckEach(value, row, [&](Json& element) { CheckIndex(element, row); });
            case PropertyType::IndexLists:
                return CheckLists(value, row);
            case PropertyType::Object:
                if (!value.is_object()) return Reject(value, row);
                CheckMember(value, row);
                return true;
            case PropertyType::Objects:
                return CheckEach(value, row, [&](Json& element) {
                    if (!element.is_object()) FailValue(element, "must be an object");
                    CheckObject(element, row.Rows());
                });
            case PropertyType::Extensions:
                return CheckExtensions(value, row);
            case PropertyType::UsedExtensions:
            case PropertyType::RequiredExtensions:
                return CheckEach(value, row, [&](Json& element) { CheckExtensionName(element, row); });
        }
        return false;
    }

    void CheckMember(Json& object, const Property& row) {
        const bool wasStoredAsValue = m_isStoredAsValue;
        m_isStoredAsValue |= row.isStoredAsValue;
        CheckObject(object, row.Rows());
        m_isStoredAsValue = wasStoredAsValue;
    }

    template <typename CheckElement>
    bool CheckEach(Json& array, const Property& row, const CheckElement& check) {
        if (!array.is_array()) return Reject(array, row);
        for (size_t i = 0; i < array.size(); ++i) {
            const Step step(*this, i);
            check(array[i]);
        }
        return true;
    }

    bool CheckString(const Json& value, const Property& row) {
        if (!value.is_string()) return Reject(value, row);
        const auto& text = value.get_ref<const std::string&>();
        if (!text.starts_with(row.start)) FailValue(value, Text("must be {}x", row.start));
        if (!row.texts.empty() && std::ranges::find(row.texts, text) == row.texts.end())
            FailValue(value, Text("must be {}", Listed(row.texts)));
        return true;
    }

    bool CheckNumber(Json& value, const Property& row) {
        // Exporters write infinity as null
        if (value.is_null() && row.misfit == Misfit::Omit) return Omit(value, row, TypeRequirement(row.type));
        if (!value.is_number()) return Reject(value, row);
        constexpr double kMax = std::numeric_limits<float>::max();
        const double number = value.get<double>();
        if (!(std::abs(number) <= kMax)) {
            const float end = number < 0.0 ? row.min : row.max;
            const bool hasEnd = row.misfit == Misfit::ClampToRange && std::abs(double{end}) < kMax;
            if (!hasEnd) return Omit(value, row, "too large for a float");
        }
        const auto rounded = static_cast<float>(std::clamp(number, -kMax, kMax));
        if (!IsInRange(row, rounded)) {
            if (row.misfit != Misfit::ClampToRange) return Omit(value, row, NumberRequirement(row, rounded));
            m_context.Warn(Path(), row.topic, Text("is {}, out of range, put into it", Shown(value)));
            value = static_cast<double>(std::clamp(rounded, row.min, row.max));
        } else if (!value.is_number_float() && m_isStoredAsValue) {
            value = number;  // tinygltf makes an int of a whole one where it does not know the property
        }
        return true;
    }

    bool CheckNumbers(Json& value, const Property& row) {
        if (!value.is_array()) return Reject(value, row);
        if (value.size() != row.count)
            Fail(Text("has {}, must have {}", Counted(value.size(), "element"), row.count));
        return CheckEach(value, row, [&](Json& element) {
            if (!element.is_number()) FailValue(element, "must be a number");
            CheckNumber(element, row);
        });
    }

    bool CheckLists(Json& value, const Property& row) {
        if (!value.is_array()) return Reject(value, row);
        if (value.empty()) Fail("has no elements, must have at least one");
        return CheckEach(value, row, [&](Json& list) {
            if (!list.is_array()) FailValue(list, "must be an array");
            if (list.size() != row.count)
                Fail(Text("has {}, must have {}", Counted(list.size(), "element"), row.count));
            CheckEach(list, row, [&](Json& element) { CheckIndex(element, row); });
        });
    }

    bool CheckWhole(Json& value, const Property& row) {
        const std::optional<uint64_t> whole = ToWhole(value);
        if (!whole) return Reject(value, row);
        if (!row.numbers.empty() && std::ranges::find(row.numbers, *whole) == row.numbers.end())
            return Omit(value, row, Text("must be {}", Listed(row.numbers)));
        if (*whole < row.wholeMin || *whole > row.wholeMax) return Omit(value, row, IntegerRequirement(row));
        // A property that tinygltf does not know stays an int or a double in its model.
        value = m_isStoredAsValue ? Json(static_cast<double>(*whole)) : Json(*whole);
        return true;
    }

    bool CheckIndex(Json& value, const Property& row) {
        const std::optional<uint64_t> whole = ToWhole(value);
        if (!whole) FailValue(value, TypeRequirement(PropertyType::Index));
        if (*whole >= Count(row.target))
            Fail(Text("is {}, but {}", *whole,
                      CountPhrase(Count(row.target), Name(row.target),
                                  row.target == Target::Meshes ? "meshes" : "")));
        value = *whole;
        return true;
    }

    bool CheckExtensions(Json& value, const Property& row) {
        if (!value.is_object()) return Reject(value, row);
        const bool wasStoredAsValue = m_isStoredAsValue;
        m_isStoredAsValue = true;
        for (auto member = value.begin(); member != value.end();) {
            const auto extension =
                std::ranges::find_if(SupportedExtensions(), [&](const Extension& candidate) {
                    return candidate.place == row.place && candidate.name == member.key();
                });
            if (extension == SupportedExtensions().end()) {
                member = value.erase(member);
                continue;
            }
            const Step step(*this, extension->name);
            if (!member->is_object()) FailValue(*member, "must be an object");
            CheckObject(*member, extension->rows);
            ++member;
        }
        m_isStoredAsValue = wasStoredAsValue;
        return true;
    }

    void CheckExtensionName(const Json& value, const Property& row) {
        if (!value.is_string()) FailValue(value, "must be a string");
        const auto& name = value.get_ref<const std::string&>();
        if (IsSupported(name)) return;
        if (row.type == PropertyType::RequiredExtensions)
            Fail(Text("the file requires {}, which is not supported", Shown(value)));
        m_context.Warn(Path(), "extension " + name, Text("{} is not supported, ignored", Shown(value)));
    }

    // Handles a value of another type than the row's.
    bool Reject(const Json& value, const Property& row) {
        const bool isWhole = row.type == PropertyType::Whole && row.misfit == Misfit::OmitInvalid;
        const std::string needed = isWhole ? IntegerRequirement(row) : TypeRequirement(row.type);
        if (row.misfit != Misfit::OmitInvalid) FailValue(value, needed);
        return Omit(value, row, needed);
    }

    // Handles a value of the row's type that is out of its range.
    bool Omit(const Json& value, const Property& row, const std::string& needed) {
        if (row.misfit == Misfit::Refuse || row.misfit == Misfit::ClampToRange) FailValue(value, needed);
        if (row.topic)
            m_context.Warn(Path(), row.topic, Text("is {}, {}, {}", Shown(value), needed, row.remedy));
        return false;
    }

    std::string Path() const {
        std::string path;
        for (const PathStep& step : m_path) {
            if (step.name.empty())
                path += Text("[{}]", step.index);
            else
                path += Text("{}{}", path.empty() ? "" : ".", step.name);
        }
        return path;
    }

    [[noreturn]] void Fail(const std::string& why) const { m_context.Fail(Path(), why); }
    [[noreturn]] void FailValue(const Json& value, std::string_view needed) const {
        Fail(Text("is {}, {}", Shown(value), needed));
    }
    [[noreturn]] void FailAbsent(const Property& row) const {
        Fail(Text("is absent, {}", TypeRequirement(row.type)));
    }

    GltfContext& m_context;
    std::vector<PathStep> m_path;
    std::array<size_t, static_cast<size_t>(Target::Count)> m_counts{};
    bool m_isStoredAsValue = false;
};

}  // namespace

void CheckSchema(GltfContext& context, nlohmann::json& root) {
    Checker(context).CheckRoot(root);
}

}  // namespace raygraph::scene
