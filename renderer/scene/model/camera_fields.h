// The fields of a Camera that an animation may change, as material_fields.h those of a Material. Threads:
// constants.
#pragma once

#include <string_view>

#include "renderer/scene/model/fields.h"

namespace raygraph::scene {

namespace camera_fields {

using C = Camera;
using Number = Field<C, float>;
inline constexpr const char* kPerspective = "perspective";
inline constexpr const char* kOrthographic = "orthographic";
// glTF has open intervals: these have the ends that a float can be at.
inline constexpr FieldRange kAngle{1e-6f, 3.1415925f};
inline constexpr FieldRange kExtent{1e-9f, kUnboundedField};

// Each is of cameras of one projection alone, whose object in the file it is in.
inline constexpr auto kAll = std::tuple{
    Number{{&C::yFov, "yFov", kPerspective, "yfov"}, kAngle, "rad"},
    Number{{&C::aspectRatio, "aspectRatio", kPerspective, "aspectRatio"}, kNotNegative},
    Number{{&C::zNear, "zNear", kPerspective, "znear"}, kNotNegative, "m"},
    Number{{&C::zFar, "zFar", kPerspective, "zfar"}, kNotNegative, "m", true},
    Number{{&C::xMag, "xMag", kOrthographic, "xmag"}, kExtent, "m"},
    Number{{&C::yMag, "yMag", kOrthographic, "ymag"}, kExtent, "m"},
    Number{{&C::zNear, "zNear", kOrthographic, "znear"}, kNotNegative, "m"},
    Number{{&C::zFar, "zFar", kOrthographic, "zfar"}, kNotNegative, "m"},
};

}  // namespace camera_fields

constexpr bool HasField(Projection projection, const Field<Camera, float>& field) {
    const bool isPerspective = std::string_view(field.object) == camera_fields::kPerspective;
    return isPerspective == (projection == Projection::Perspective);
}

// Calls visit(field) for each that a camera of this projection has.
template <typename Visit>
constexpr void ForEachCameraField(Projection projection, Visit&& visit) {
    const auto look = [&](const auto& field) {
        if (HasField(projection, field)) visit(field);
    };
    std::apply([&](const auto&... field) { (look(field), ...); }, camera_fields::kAll);
}

}  // namespace raygraph::scene
