// Lists the pictures beside the radiance that a render may hold. Sample count and variance are always in it,
// and are no AOVs. Threads: plain values and pure functions, for any thread.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <initializer_list>
#include <string>

#include "base/api.h"
#include "editor/session/settings/bias.h"
#include "editor/session/settings/picture_settings.h"

namespace raygraph::session {

#define RAYGRAPH_SURFACE_AOVS(X, Of)   \
    X(Of, Albedo, 0, "albedo", "")     \
    X(Of, Normal, 1, "normal", "")     \
    X(Of, Depth, 2, "depth", "")       \
    X(Of, Instance, 3, "instance", "") \
    X(Of, Material, 4, "material", "") \
    X(Of, Motion, 5, "motion", "")     \
    X(Of, Denoising, 6, "denoising", "")

// Denoising is what the denoiser takes beside radiance and variance (DenoisingPlanes).
//
// The order is: surfaces, then passes::PathPart, then what each Bias removed ("removed_max_depth" to
// "removed_shadow_terminator" and "removed_texture_lod").
#define RAYGRAPH_DECLARE(Of, name, value, text, note)         name,
#define RAYGRAPH_DECLARE_REMOVED(Of, name, value, text, note) Removed##name,
enum class Aov : uint8_t {
    RAYGRAPH_SURFACE_AOVS(RAYGRAPH_DECLARE, Aov) RAYGRAPH_PATH_PARTS(RAYGRAPH_DECLARE, Aov)
        RAYGRAPH_BIASES(RAYGRAPH_DECLARE_REMOVED, Aov)
};
#undef RAYGRAPH_DECLARE_REMOVED
#undef RAYGRAPH_DECLARE
#define RAYGRAPH_REMOVED_TEXT(Of, name, value, text, note) "removed_" text,
constexpr auto Texts(Aov) {
    return std::to_array<const char*>({RAYGRAPH_SURFACE_AOVS(RAYGRAPH_CHOICE_TEXT_, Aov) RAYGRAPH_PATH_PARTS(
        RAYGRAPH_CHOICE_TEXT_, Aov) RAYGRAPH_BIASES(RAYGRAPH_REMOVED_TEXT, Aov)});
}
#undef RAYGRAPH_REMOVED_TEXT
constexpr const char* Name(Aov aov) {  // e.g. "albedo"
    return Texts(aov)[static_cast<size_t>(aov)];
}
inline constexpr std::array kAovs = Values<Aov>();
inline constexpr size_t kAovCount = kAovs.size();

constexpr Aov AovOf(passes::PathPart part) {
    return static_cast<Aov>(static_cast<size_t>(Aov::Emission) + static_cast<size_t>(part));
}

constexpr Aov AovOf(Bias bias) {
    return static_cast<Aov>(static_cast<size_t>(Aov::RemovedMaxDepth) + static_cast<size_t>(bias));
}
static_assert(AovOf(passes::PathPart::Transmission) == Aov::Transmission &&
              AovOf(Bias::TextureLod) == Aov::RemovedTextureLod);

class RAYGRAPH_API AovSet {
  public:
    AovSet() = default;
    AovSet(std::initializer_list<Aov> aovs) {
        for (const Aov aov : aovs) Set(aov);
    }

    void Set(Aov aov, bool isIncluded = true) { m_bits.set(static_cast<size_t>(aov), isIncluded); }
    bool Has(Aov aov) const { return m_bits.test(static_cast<size_t>(aov)); }
    bool IsEmpty() const { return m_bits.none(); }
    bool NeedsCenterRay() const { return Has(Aov::Depth) || Has(Aov::Instance) || Has(Aov::Material); }
    bool NeedsParts() const;
    bool operator==(const AovSet&) const = default;

  private:
    std::bitset<kAovCount> m_bits;
};

// Returns the names in their order, separated by commas: "albedo,depth"; "none" without any.
RAYGRAPH_API std::string ListOf(const AovSet& aovs);

// Returns why a picture with these settings cannot be denoised; "" if it can.
RAYGRAPH_API std::string NotDenoisedReason(const PictureSettings& settings);

// Returns whether a picture with these settings can have it.
RAYGRAPH_API bool CanHave(Aov aov, const PictureSettings& settings);

}  // namespace raygraph::session
