#include "renderer/scene/animation/animation.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>

#include "base/check.h"

namespace raygraph::scene {
namespace {

// Returns the index of the last key at or before a time that lies between the first and the last one.
uint32_t FindInterval(const std::vector<float>& times, double seconds, uint32_t guess) {
    const auto contains = [&](size_t i) {
        return i + 1 < times.size() && double{times[i]} <= seconds && seconds < double{times[i + 1]};
    };
    // Most times follow the one before.
    if (contains(guess)) return guess;
    if (contains(size_t{guess} + 1)) return guess + 1;
    const auto after = std::upper_bound(times.begin(), times.end(), seconds,
                                        [](double at, float time) { return at < double{time}; });
    return static_cast<uint32_t>(after - times.begin() - 1);
}

glm::dquat ToQuaternion(const double* xyzw) {
    return glm::dquat(xyzw[3], xyzw[0], xyzw[1], xyzw[2]);
}
glm::dquat ToQuaternion(const float* xyzw) {
    return glm::dquat(double{xyzw[3]}, double{xyzw[0]}, double{xyzw[1]}, double{xyzw[2]});
}

// Stores the rotation with unit length; one of length 0 becomes `instead`.
void StoreRotation(const glm::dquat& rotation, const float* instead, double* value) {
    double length = glm::length(rotation);
    glm::dquat unit = rotation;
    if (!(length > 1e-12)) {
        unit = ToQuaternion(instead);
        length = glm::length(unit);
    }
    unit = unit / length;
    value[0] = unit.x, value[1] = unit.y, value[2] = unit.z, value[3] = unit.w;
}

// Follows appendix C.5 of glTF 2.0: `part` is the share of the interval that has passed, `length` its
// seconds, by which the tangents are scaled. `left` and `right` are the triples of the two keys.
double Hermite(const float* left, const float* right, size_t width, size_t i, double part, double length) {
    const double t = part, t2 = t * t, t3 = t2 * t;
    const double from = double{left[width + i]}, leaving = length * double{left[2 * width + i]};
    const double to = double{right[width + i]}, arriving = length * double{right[i]};
    return (2 * t3 - 3 * t2 + 1) * from + (t3 - 2 * t2 + t) * leaving + (-2 * t3 + 3 * t2) * to +
           (t3 - t2) * arriving;
}

}  // namespace

void SampleAnimation(const AnimationSampler& sampler, double seconds, bool isRotation, uint32_t& interval,
                     double* value) {
    const std::vector<float>& times = sampler.times;
    RG_CHECK(!times.empty());
    const size_t width = sampler.width;
    const bool isCubic = sampler.interpolation == Interpolation::CubicSpline;
    const size_t stride = isCubic ? 3 * width : width, offset = isCubic ? width : 0;
    const auto key = [&](size_t i) { return &sampler.values[stride * i]; };
    const auto hold = [&](size_t i) {
        const float* const held = key(i) + offset;
        if (isRotation) return StoreRotation(ToQuaternion(held), held, value);
        std::copy_n(held, width, value);
    };
    // The comparisons have this order so that a NaN time counts as the first one.
    if (!(seconds > double{times.front()})) return hold(0);
    if (seconds >= double{times.back()}) return hold(times.size() - 1);
    interval = FindInterval(times, seconds, interval);
    if (sampler.interpolation == Interpolation::Step) return hold(interval);

    const double length = double{times[interval + 1]} - double{times[interval]};
    const double part = (seconds - double{times[interval]}) / length;
    const float *const left = key(interval), *const right = key(interval + size_t{1});
    if (isCubic) {
        for (size_t i = 0; i < width; ++i) value[i] = Hermite(left, right, width, i, part, length);
        if (isRotation) StoreRotation(ToQuaternion(value), left + width, value);
    } else if (isRotation) {
        const glm::dquat from = glm::normalize(ToQuaternion(left)), to = glm::normalize(ToQuaternion(right));
        StoreRotation(glm::slerp(from, to, part), left, value);  // along the shorter arc
    } else {
        for (size_t i = 0; i < width; ++i)
            value[i] = double{left[i]} + part * (double{right[i]} - double{left[i]});
    }
}

}  // namespace raygraph::scene
