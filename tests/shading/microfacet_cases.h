// Surfaces and viewers over which microfacet lobes are tested.
#pragma once

#include <array>
#include <ostream>
#include <vector>

#include "bxdf/microfacet.glsl"
#include "tests/shading/lobe_checks.h"

namespace raygraph::shading {

inline constexpr std::array kMaskingModels = {MaskingModel::Correlated, MaskingModel::Separable,
                                              MaskingModel::Shortcut};

// The models of this thread, for a scope.
class ScopedModels {
  public:
    explicit ScopedModels(MicrofacetModel distribution, MaskingModel masking = MaskingModel::Correlated,
                          FresnelModel fresnel = FresnelModel::Schlick) {
        threadMicrofacetModel = distribution;
        threadMaskingModel = masking;
        threadFresnelModel = fresnel;
    }
    ~ScopedModels() {
        threadMicrofacetModel = MicrofacetModel::Ggx;
        threadMaskingModel = MaskingModel::Correlated;
        threadFresnelModel = FresnelModel::Schlick;
    }
    ScopedModels(const ScopedModels&) = delete;
    ScopedModels& operator=(const ScopedModels&) = delete;
};

struct MicrofacetCase {
    MicrofacetModel distribution;
    vec2 alpha;
    vec3 wo;
};

inline std::ostream& operator<<(std::ostream& out, const MicrofacetCase& c) {
    return out << "distribution " << static_cast<int>(c.distribution) << ", alpha (" << c.alpha.x << ", "
               << c.alpha.y << "), cos " << c.wo.z;
}

// Alpha is the square of the roughness.
inline std::vector<MicrofacetCase> MicrofacetCases(bool isLong) {
    std::vector<MicrofacetCase> cases;
    const auto add = [&](MicrofacetModel distribution, float x, float y, float cosTheta, float phi) {
        cases.push_back({distribution, vec2(x, y), DirectionAt(cosTheta, phi)});
    };
    if (isLong) {
        for (auto distribution : {MicrofacetModel::Ggx, MicrofacetModel::Beckmann, MicrofacetModel::Phong}) {
            for (float roughness : {0.05f, 0.1f, 0.25f, 0.5f, 0.75f, 1.0f}) {
                const float alpha = roughness * roughness;
                for (float cosTheta : {1.0f, 0.7f, 0.3f, 0.05f, -0.5f})
                    add(distribution, alpha, alpha, cosTheta, 1.0f);
            }
            for (float cosTheta : {0.9f, 0.4f, -0.1f}) {
                add(distribution, 0.09f, 0.5f, cosTheta, 0.6f);
                add(distribution, 0.8f, 0.25f, cosTheta, 2.0f);
            }
        }
        return cases;
    }
    for (float roughness : {0.05f, 0.3f, 0.6f, 1.0f})
        for (float cosTheta : {0.8f, 0.05f})
            add(MicrofacetModel::Ggx, roughness * roughness, roughness * roughness, cosTheta, 1.0f);
    add(MicrofacetModel::Ggx, 0.25f, 0.25f, 1.0f, 0.0f);
    add(MicrofacetModel::Ggx, 0.25f, 0.25f, -0.4f, 4.0f);
    add(MicrofacetModel::Ggx, 0.1f, 0.5f, 0.6f, 0.6f);
    add(MicrofacetModel::Ggx, 0.8f, 0.25f, 0.1f, 2.0f);
    for (auto distribution : {MicrofacetModel::Beckmann, MicrofacetModel::Phong}) {
        add(distribution, 0.0025f, 0.0025f, 0.7f, 1.0f);
        add(distribution, 0.25f, 0.25f, 0.9f, 1.0f);
        add(distribution, 0.25f, 0.25f, 0.1f, 1.0f);
        add(distribution, 1.0f, 1.0f, 0.5f, 1.0f);
        add(distribution, 0.25f, 0.7f, -0.6f, 2.0f);
    }
    return cases;
}

}  // namespace raygraph::shading
