// Nested dielectrics: which medium a path is in, where closed volumes overlap or touch.
//
// A path carries the volumes it is inside of. Where several overlap, the one of highest priority is present;
// of equal ones, the one entered last. A surface of any other changes nothing and is passed through. Schmidt
// and Budge 2002, "Simple Nested Dielectrics in Ray Traced Images", JGT 7(2).
//
// Bridge, declared beforehand by the including file:
//     Medium MediumAt(uint material)
#ifndef RAYGRAPH_INTEGRATOR_MEDIA_GLSL
#define RAYGRAPH_INTEGRATOR_MEDIA_GLSL

#include "bxdf/dispersion.glsl"
#include "core/trace_options.glsl"
#include "scene/ray.glsl"

SHADING_BEGIN

// Materials of the volumes around a point, last entered first, kVacuum after them. A path in more than these
// forgets those of lowest precedence. (A vector would need a dynamic index.)
struct MediumStack {
    uint m0, m1, m2, m3;
};

INLINE MediumStack NoMedia() {
    MediumStack media;
    media.m0 = kVacuum;
    media.m1 = kVacuum;
    media.m2 = kVacuum;
    media.m3 = kVacuum;
    return media;
}

INLINE MediumStack EnterMedium(MediumStack media, uint material) {
    media.m3 = media.m2;
    media.m2 = media.m1;
    media.m1 = media.m0;
    media.m0 = material;
    return media;
}

// Removes the last entry of `material`; leaving a volume that was never entered is no error: its mesh
// is open.
INLINE MediumStack LeaveMedium(MediumStack media, uint material) {
    bool isFound = media.m0 == material;
    if (isFound) media.m0 = media.m1;
    isFound = isFound || media.m1 == material;
    if (isFound) media.m1 = media.m2;
    isFound = isFound || media.m2 == material;
    if (isFound) media.m2 = media.m3;
    isFound = isFound || media.m3 == material;
    if (isFound) media.m3 = kVacuum;
    return media;
}

INLINE bool IsInMedium(MediumStack media, uint material) {
    return media.m0 == material || media.m1 == material || media.m2 == material || media.m3 == material;
}

// Adds a volume around all of those listed.
INLINE MediumStack AppendOuterMedium(MediumStack media, uint material) {
    if (media.m0 == kVacuum)
        media.m0 = material;
    else if (media.m1 == kVacuum)
        media.m1 = material;
    else if (media.m2 == kVacuum)
        media.m2 = material;
    else if (media.m3 == kVacuum)
        media.m3 = material;
    return media;
}

INLINE uint PreferredMedium(uint first, uint second) {
    if (second == kVacuum) return first;
    if (first == kVacuum) return second;
    return MediumAt(second).priority > MediumAt(first).priority ? second : first;
}

// Returns the present medium: a material, or kVacuum.
INLINE uint CurrentMedium(MediumStack media) {
    if (media.m1 == kVacuum) return media.m0;
    return PreferredMedium(PreferredMedium(PreferredMedium(media.m0, media.m1), media.m2), media.m3);
}

// Returns the index at a wavelength in nm, or at kNoWavelength.
INLINE float MediumIor(uint material, float wavelength) {
    if (material == kVacuum) return 1.0f;
    Medium medium = MediumAt(material);
    if (!HasTraceFeature(kTraceDispersion)) return medium.ior;
    return DispersedIor(medium.ior, medium.dispersion, wavelength);
}

INLINE float DispersionOf(uint material) {
    return material == kVacuum ? 0.0f : MediumAt(material).dispersion;
}

INLINE bool IsDispersive(uint material) { return DispersionOf(material) > 0.0f; }

CONST float kFarInMedium = 1.0e18f;

// Returns the share of light that passes `distance` meters of the medium, however long. Beer-Lambert law. The
// distance is limited because a device may first multiply it by the constant of its exp: a distance near the
// range of float would become infinite, and the result of a medium that absorbs nothing NaN.
INLINE vec3 Transmittance(Medium medium, float distance) {
    vec3 opticalDepth = medium.extinction * min(distance, kFarInMedium);
    return vec3(exp(-opticalDepth.x), exp(-opticalDepth.y), exp(-opticalDepth.z));
}

INLINE vec3 Transmittance(uint material, float distance) {
    return material == kVacuum ? vec3(1.0f) : Transmittance(MediumAt(material), distance);
}

// Holds the media on both sides of a surface, for a path that crosses it.
struct Boundary {
    MediumStack beyond;  // the volumes on the other side
    bool isReal;         // false: the medium does not change, and the path ignores the surface
    uint here, there;    // the media: materials, or kVacuum
};

INLINE Boundary CrossBoundary(MediumStack media, uint material, bool isEntering) {
    Boundary boundary;
    boundary.beyond = isEntering ? EnterMedium(media, material) : LeaveMedium(media, material);
    uint here = CurrentMedium(media);
    uint there = CurrentMedium(boundary.beyond);
    // Leaving a volume that was never entered: its inside must have been here
    if (!isEntering && here == kVacuum && there == kVacuum) here = material;
    boundary.isReal = here != there;
    boundary.here = here;
    boundary.there = there;
    return boundary;
}

// Returns whether the media on both sides refract alike all light of a path of that wavelength.
INLINE bool AreAlike(Boundary boundary, float wavelength) {
    if (MediumIor(boundary.here, wavelength) != MediumIor(boundary.there, wavelength)) return false;
    if (!HasTraceFeature(kTraceDispersion) || wavelength != kNoWavelength) return true;
    return DispersionOf(boundary.here) == DispersionOf(boundary.there);
}

// Returns the index beyond over that on this side.
INLINE float RelativeIor(Boundary boundary, float wavelength) {
    return MediumIor(boundary.there, wavelength) / MediumIor(boundary.here, wavelength);
}

SHADING_END

#endif
