// A local fit that is linear in albedo, normal and position (Bitterli et al. 2016), at the pixel that they
// are relative to. Sums are kept in vectors and matrices: arrays would be in memory.
#ifndef RAYGRAPH_DENOISE_REGRESSION_GLSL
#define RAYGRAPH_DENOISE_REGRESSION_GLSL

#include "denoise/denoise.glsl"

const int kRadius = 6;
const float kFeatureScale = 0.1f;
const float kFarthest = 12.0f;  // weights below exp(-12) are 0

// Weighted sums over pixels, of their terms u = (albedo, x) and v = (normal, y), and of the target.
struct Sums {
    float weight;
    vec4 u, v;
    mat4 uu, uv, vv;
    vec3 target;
    mat3x4 uTarget, vTarget;
};

Sums NoSums() {
    return Sums(0.0f, vec4(0.0f), vec4(0.0f), mat4(0.0f), mat4(0.0f), mat4(0.0f), vec3(0.0f), mat3x4(0.0f),
                mat3x4(0.0f));
}

void Add(inout Sums sums, float weight, vec4 u, vec4 v, vec3 target) {
    vec4 weightedU = weight * u, weightedV = weight * v;
    sums.weight += weight;
    sums.u += weightedU;
    sums.v += weightedV;
    sums.uu += outerProduct(weightedU, u);
    sums.uv += outerProduct(weightedU, v);
    sums.vv += outerProduct(weightedV, v);
    sums.target += weight * target;
    sums.uTarget += outerProduct(weightedU, target);
    sums.vTarget += outerProduct(weightedV, target);
}

// A ridge keeps slopes from following the noise, and the equations regular.
mat4 WithRidge(mat4 squares, float weight) {
    const float kRidge = 0.1f, kLeastSpread = 0.01f;
    vec4 ridge = kRidge * vec4(squares[0].x, squares[1].y, squares[2].z, squares[3].w) +
                 kRidge * kLeastSpread * weight + 1e-6f;
    squares[0].x += ridge.x;
    squares[1].y += ridge.y;
    squares[2].z += ridge.z;
    squares[3].w += ridge.w;
    return squares;
}

// Returns the value of the fit at the pixel itself, whose terms are 0, and in w the weight of the pixel's own
// target in it. The equations are solved about the mean terms, by the Schur complement of their first half.
vec4 Fit(Sums sums) {
    float perWeight = 1.0f / sums.weight;
    vec4 u = sums.u * perWeight, v = sums.v * perWeight;
    mat4 inverseOfUU = inverse(WithRidge(sums.uu, sums.weight) - outerProduct(sums.u, u));
    mat4 uv = sums.uv - outerProduct(sums.u, v);
    mat4 vv = WithRidge(sums.vv, sums.weight) - outerProduct(sums.v, v);
    vec4 solvedV = inverse(vv - transpose(uv) * inverseOfUU * uv) * (v - u * inverseOfUU * uv);
    vec4 solvedU = inverseOfUU * (u - uv * solvedV);
    vec3 mean = sums.target * perWeight;
    vec3 slope = solvedU * (sums.uTarget - outerProduct(sums.u, mean)) +
                 solvedV * (sums.vTarget - outerProduct(sums.v, mean));
    float share = perWeight + dot(u, solvedU) + dot(v, solvedV);
    return vec4(max(FiniteOr0(mean - slope), vec3(0.0f)), clamp(share, 0.0f, 1.0f));
}

#endif
