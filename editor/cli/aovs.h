// Pictures beside the radiance that an .exr may hold, each under its name of --aov. The count of samples and
// the variance are always in it and are none of these.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>

#include "editor/cli/bias.h"
#include "editor/cli/picture_settings.h"

namespace raygraph::cli {

enum class Aov : uint8_t {
    Albedo,
    Normal,
    Depth,
    Instance,
    Material,
    Emission,  // from here on in the order of passes::PathPart
    Direct,
    Indirect,
    Diffuse,
    Specular,
    Transmission,
    RemovedMaxDepth,  // from here on in the order of Bias
    RemovedClampIndirect,
    RemovedRegularize,
    RemovedShadowTerminator,
};
inline constexpr size_t kAovCount = 15;
inline constexpr std::array<Aov, kAovCount> kAovs = [] {  // in their order
    std::array<Aov, kAovCount> all{};
    for (size_t i = 0; i < kAovCount; i++) all[i] = static_cast<Aov>(i);
    return all;
}();
const char* Name(Aov aov);  // "albedo"

inline constexpr Aov AovOf(passes::PathPart part) {
    return static_cast<Aov>(static_cast<size_t>(Aov::Emission) + static_cast<size_t>(part));
}

inline constexpr Aov AovOf(Bias bias) {
    return static_cast<Aov>(static_cast<size_t>(Aov::RemovedMaxDepth) + static_cast<size_t>(bias));
}

class AovSet {
  public:
    AovSet() = default;
    AovSet(std::initializer_list<Aov> aovs) {
        for (const Aov aov : aovs) Set(aov);
    }

    void Set(Aov aov, bool isIn = true) { m_bits.set(static_cast<size_t>(aov), isIn); }
    bool Has(Aov aov) const { return m_bits.test(static_cast<size_t>(aov)); }
    bool IsEmpty() const { return m_bits.none(); }
    bool NeedsCenterRay() const { return Has(Aov::Depth) || Has(Aov::Instance) || Has(Aov::Material); }
    bool NeedsParts() const;
    bool operator==(const AovSet&) const = default;

  private:
    std::bitset<kAovCount> m_bits;
};

// The names in their order, with commas between: "albedo,depth"; "none".
std::string ListOf(const AovSet& aovs);

// What --aov asks for.
struct AovRequest {
    AovSet named;
    bool isAll = false;  // whatever the picture can have
};

// Names in any order, "samples" and "variance" among them, or "all".
AovRequest ParseAovs(std::string_view text);

// What a picture of these settings is to have. Error{Usage} naming an AOV that was asked for by name and that
// it cannot have.
AovSet AovsFor(const AovRequest& request, const PictureSettings& settings);

}  // namespace raygraph::cli
