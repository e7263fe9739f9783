// Helpers that the parts of Check share. Internal to renderer/scene. Threads: pure functions.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/printable.h"
#include "base/text.h"
#include "renderer/scene/model/fields.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

inline constexpr float kUnbounded = kUnboundedField;

inline bool AllFinite(float value) {
    return std::isfinite(value);
}
template <typename Vector>
bool AllFinite(const Vector& v) {
    for (int i = 0; i < int(Vector::length()); ++i)
        if (!std::isfinite(v[i])) return false;
    return true;
}

// Holds the object that is being checked. Its name is built only for a message.
struct Subject {
    const std::string& text;
    ErrorKind kind;
    const char* list = nullptr;  // null: the whole
    size_t index = 0;
    const char* innerList = nullptr;
    size_t innerIndex = 0;

    Subject In(const char* name, size_t at) const {
        Subject inner = *this;
        (list ? inner.innerList : inner.list) = name;
        (list ? inner.innerIndex : inner.index) = at;
        return inner;
    }
    [[noreturn]] void Fail(const std::string& what) const {
        if (!list) throw MakeError(kind, "{}: {}", text, what);
        if (!innerList) throw MakeError(kind, "{}: {}[{}]: {}", text, list, index, what);
        throw MakeError(kind, "{}: {}[{}].{}[{}]: {}", text, list, index, innerList, innerIndex, what);
    }
    void Require(bool isGood, const char* what) const {
        if (!isGood) Fail(what);
    }
    void RequireIndex(const char* what, uint32_t value, size_t count, bool allowsNone = false) const {
        if (value < count || (allowsNone && value == kNone)) return;
        Fail(Text("{} is {}, there are {}", what, value, count));
    }
    void RequireRange(const char* what, float value, float min, float max) const {
        if (value >= min && value <= max) return;
        if (min == -kUnbounded) Fail(Text("{} is not finite", what));
        if (max < kUnbounded) Fail(Text("{} is {}, must be {} to {}", what, value, min, max));
        Fail(Text("{} is {}, must be finite and at least {}", what, value, min));
    }
    template <typename T>
    void RequireFinite(const char* what, const std::vector<T>& values) const {
        for (size_t i = 0; i < values.size(); ++i)
            if (!AllFinite(values[i])) Fail(Text("{}[{}] is not finite", what, i));
    }
    template <typename T>
    void RequireStream(const char* what, const std::vector<T>& values, size_t vertexCount) const {
        if (!values.empty() && values.size() != vertexCount)
            Fail(Text("{} has {} for {}", what, Counted(values.size(), "element"),
                      Counted(vertexCount, "position")));
        RequireFinite(what, values);
    }
};

// check.cpp: joints, morph targets, weights and skins; and animations.
void CheckDeformation(const SceneData& scene, const Subject& subject);
void CheckAnimations(const SceneData& scene, const Subject& subject);

}  // namespace raygraph::scene
