// The intensity of a light by direction, as a goniometer measures it (IES LM-63). Threads: plain values; pure
// functions, for any thread.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/api.h"

namespace raygraph::scene {

// How the two angles are a direction d of the light's own space, where it shines along -z and +x is in the
// vertical plane. Planes of type C contain the axis z, those of type B the axis y, and those of type A the
// axis x:
//   A  d = (sin v, -cos v sin h, -cos v cos h)
//   B  d = (cos h sin v, -sin h, -cos h cos v)
//   C  d = (sin v cos h, sin v sin h, -cos v)
enum class PhotometricType : uint8_t { A, B, C };

// Intensities at all pairs of angles; linear in both between them, and 0 beyond them.
struct RAYGRAPH_API LightProfile {
    std::string name;
    PhotometricType type = PhotometricType::C;
    // Radians, increasing, at least two. For type C from 0 to at most pi, for the others from -pi to pi.
    std::vector<float> vertical;
    // Radians, increasing. Of type C all around, the first and the last one turn apart; or one, for a profile
    // that is the same all around. Of the others at least two, from -pi to pi at most.
    std::vector<float> horizontal;
    // Not negative, one for each pair of angles: candela[h * vertical.size() + v].
    std::vector<float> candela;

    float MaxIntensity() const;
    // Returns the mean over all directions.
    double MeanIntensity() const;

    bool operator==(const LightProfile&) const = default;
};

}  // namespace raygraph::scene
