// Capsules: the points nearer to a segment than a radius; spheres, where the segment has no length. Where
// a ray enters and leaves one, and points of its surface by two numbers.
#ifndef RAYGRAPH_CORE_CAPSULE_GLSL
#define RAYGRAPH_CORE_CAPSULE_GLSL

#include "core/frame.glsl"
#include "core/math.glsl"
#include "shared/scene_records.h"

#ifdef __cplusplus
namespace raygraph::shading {
using gpu::CapsuleRecord;
}
#endif

SHADING_BEGIN

// Holds the part of a line that is inside of a convex shape; none: begin > end.
struct Chord {
    float begin;
    float end;
};

CONST float kNoChord = 3.0e38f;

INLINE Chord EmptyChord() {
    Chord chord;
    chord.begin = kNoChord;
    chord.end = -kNoChord;
    return chord;
}

// Returns the chord of the line of points `to` + t `unit`. The distance between line and center is computed
// from the vector between them, and not from a difference of squares, which loses a small sphere far away: E.
// Haines, J. Günther and T. Akenine-Möller 2019, "Precision Improvements for Ray/Sphere Intersection", Ray
// Tracing Gems, chapter 7.
INLINE Chord SphereChord(vec3 to, vec3 unit, vec3 center, float radius) {
    vec3 offset = center - to;
    float middle = dot(offset, unit);
    vec3 across = offset - middle * unit;
    float square = radius * radius - dot(across, across);
    if (square < 0.0f) return EmptyChord();
    Chord chord;
    chord.begin = middle - sqrt(square);
    chord.end = middle + sqrt(square);
    return chord;
}

// Returns the chord of the cylinder around the axis from 0, of that unit direction and length, without caps
// at its ends.
INLINE Chord CylinderChord(vec3 to, vec3 unit, vec3 axis, float len, float radius) {
    vec3 acrossUnit = unit - dot(unit, axis) * axis;
    vec3 acrossTo = to - dot(to, axis) * axis;
    float slope = dot(acrossUnit, acrossUnit);  // squared sine of the angle between line and axis
    Chord chord;
    chord.begin = -kNoChord;
    chord.end = kNoChord;
    if (slope > 1e-12f) {
        float nearest = -dot(acrossTo, acrossUnit) / slope;
        vec3 closest = acrossTo + nearest * acrossUnit;
        float square = radius * radius - dot(closest, closest);
        if (square < 0.0f) return EmptyChord();
        float halfChord = sqrt(square / slope);
        chord.begin = nearest - halfChord;
        chord.end = nearest + halfChord;
    } else if (dot(acrossTo, acrossTo) > radius * radius) {
        return EmptyChord();
    }
    // Between the planes of the ends
    float along = dot(unit, axis);
    float height = dot(to, axis);
    if (abs(along) > 1e-12f) {
        float atLow = -height / along;
        float atHigh = (len - height) / along;
        chord.begin = max(chord.begin, min(atLow, atHigh));
        chord.end = min(chord.end, max(atLow, atHigh));
    } else if (height < 0.0f || height > len) {
        return EmptyChord();
    }
    return chord;
}

// Holds the intersections of a ray with a capsule.
struct CapsuleHit {
    float enter;  // where it enters, in lengths of its direction; below 0: nowhere, it starts inside
    float leave;  // where it leaves; below 0: nowhere, it misses
};

// `direction` has any length. A ray whose origin is outside and that goes away from the nearest point of
// the surface misses, since the shape is convex: so no ray that leaves the surface meets it again,
// whatever rounding does to the distances. Likewise one that starts inside always leaves, even where
// rounding says that it misses.
INLINE CapsuleHit IntersectCapsule(CapsuleRecord capsule, vec3 origin, vec3 direction) {
    CapsuleHit hit;
    hit.enter = -1.0f;
    hit.leave = -1.0f;
    vec3 segment = capsule.p1 - capsule.p0;
    float segmentSquare = dot(segment, segment);
    vec3 from = origin - capsule.p0;
    float place = segmentSquare > 0.0f ? clamp(dot(from, segment) / segmentSquare, 0.0f, 1.0f) : 0.0f;
    vec3 away = from - place * segment;
    bool isInside = dot(away, away) < capsule.radius * capsule.radius;
    if (!isInside && dot(away, direction) >= 0.0f) return hit;
    // Distances count from the point of the line that is nearest to the capsule's middle
    float speed = length(direction);
    vec3 unit = direction / speed;
    float shift = dot(0.5f * segment - from, unit);
    vec3 to = from + shift * unit;
    Chord chord = SphereChord(to, unit, vec3(0.0f), capsule.radius);
    if (segmentSquare > 0.0f) {
        float len = sqrt(segmentSquare);
        Chord cap = SphereChord(to, unit, segment, capsule.radius);
        Chord body = CylinderChord(to, unit, segment / len, len, capsule.radius);
        // The shape is convex: its chord is the hull of the three, those that there are
        chord.begin = min(chord.begin, cap.begin);
        chord.end = max(chord.end, cap.end);
        if (body.begin <= body.end) {
            chord.begin = min(chord.begin, body.begin);
            chord.end = max(chord.end, body.end);
        }
    }
    bool isMissed = chord.begin > chord.end;
    if (isInside) {
        hit.leave = isMissed ? 0.0f : max((shift + chord.end) / speed, 0.0f);
    } else if (!isMissed && shift + chord.end > 0.0f) {
        hit.enter = max((shift + chord.begin) / speed, 0.0f);
        hit.leave = (shift + chord.end) / speed;
    }
    return hit;
}

// Describes a point of the surface, which two numbers say. x: the direction around the axis, 0 to 4, by the
// diamond |x| + |y| = 1, which needs no trigonometry. y: 0 to 1 along the segment; -1 to 0 from the first
// end's pole to its equator, 1 to 2 from the other equator to its pole, by a diamond too.
struct CapsulePoint {
    vec3 position;  // in the space of the capsule
    vec3 normal;    // unit length, outwards
    float along;    // 0 at the first vertex, 1 at the second
};

INLINE Frame CapsuleFrame(CapsuleRecord capsule) {
    vec3 segment = capsule.p1 - capsule.p0;
    float square = dot(segment, segment);
    if (square > 0.0f) return FrameFromZ(segment / sqrt(square));
    return FrameFromZ(vec3(0.0f, 0.0f, 1.0f));
}

// Returns the place of the surface point that is nearest to `point`: an error of the point goes along the
// surface, not off it.
INLINE vec2 CapsulePlaceOf(CapsuleRecord capsule, vec3 point) {
    Frame frame = CapsuleFrame(capsule);
    vec3 offset = ToLocal(frame, point - capsule.p0);
    float len = length(capsule.p1 - capsule.p0);
    float around = abs(offset.x) + abs(offset.y);
    float ratio = around > 0.0f ? offset.x / around : 1.0f;  // 1 to -1
    float turn = offset.y >= 0.0f ? 1.0f - ratio : 3.0f + ratio;
    float beyond = offset.z < 0.0f ? -offset.z : offset.z - len;
    float along = len > 0.0f ? clamp(offset.z / len, 0.0f, 1.0f) : 0.0f;
    if (beyond >= 0.0f) {
        float ring = sqrt(offset.x * offset.x + offset.y * offset.y);
        float polar = ring + beyond > 0.0f ? beyond / (ring + beyond) : 1.0f;
        along = offset.z < 0.0f ? -polar : 1.0f + polar;
    }
    return vec2(turn, along);
}

// Returns the mean curvature at a place: half of the sum of the principal ones, of which one is 0 along the
// segment.
INLINE float CapsuleCurvature(CapsuleRecord capsule, vec2 place) {
    vec3 segment = capsule.p1 - capsule.p0;
    bool isBody = place.y > 0.0f && place.y < 1.0f && dot(segment, segment) > 0.0f;
    return (isBody ? 0.5f : 1.0f) / capsule.radius;
}

INLINE CapsulePoint CapsulePointAt(CapsuleRecord capsule, vec2 place) {
    Frame frame = CapsuleFrame(capsule);
    bool isBack = place.x > 2.0f;
    float ratio = isBack ? place.x - 3.0f : 1.0f - place.x;
    vec3 normal = vec3(ratio, (1.0f - abs(ratio)) * (isBack ? -1.0f : 1.0f), 0.0f);
    normal = normal / sqrt(normal.x * normal.x + normal.y * normal.y);
    float polar = place.y < 0.0f ? -place.y : max(place.y - 1.0f, 0.0f);
    float ring = 1.0f - polar;
    normal = ring * normal + vec3(0.0f, 0.0f, place.y < 0.0f ? -polar : polar);
    CapsulePoint point;
    point.normal = FromLocal(frame, normal / length(normal));
    point.along = clamp(place.y, 0.0f, 1.0f);
    point.position = capsule.p0 + point.along * (capsule.p1 - capsule.p0) + capsule.radius * point.normal;
    return point;
}

SHADING_END

#endif
