// Lobes that no material of a scene has are left out of its pipelines (GLTF_LOBES, HasTraceFeature): nothing may
// read them then.
#include <gtest/gtest.h>

#include <bit>
#include <limits>

#include "tests/shading/gltf_lobe.h"

namespace raygraph::shading::lobe_features_test {
namespace {

class FeatureScope {
  public:
    explicit FeatureScope(TraceFeatures features) : m_before(threadTraceFeatures) {
        threadTraceFeatures = features;
    }
    ~FeatureScope() { threadTraceFeatures = m_before; }
    FeatureScope(const FeatureScope&) = delete;
    FeatureScope& operator=(const FeatureScope&) = delete;

  private:
    TraceFeatures m_before;
};

// Leaves NaN where the next function has its variables: a value that is read without having been set shows.
[[gnu::noinline]] void FillStack() {
    volatile float block[4096];
    for (volatile float& value : block) value = std::numeric_limits<float>::quiet_NaN();
}

struct Outcome {
    vec3 value{};
    float pdf = 0.0f;
    BSDFSample sample{};
};

[[gnu::noinline]] Outcome OutcomeOf(const GltfBxDF& lobe, vec3 wo, vec3 wi, float uc, vec2 u) {
    const GltfBSDF g = Prepare(lobe, wo);
    Outcome outcome;
    outcome.value = Evaluate(g, wi, outcome.pdf);
    outcome.sample = Sample_f(g, uc, u);
    return outcome;
}

void ExpectSame(const Outcome& a, const Outcome& b, const std::string& where) {
    EXPECT_EQ(std::bit_cast<uint>(a.pdf), std::bit_cast<uint>(b.pdf)) << where;
    EXPECT_EQ(std::bit_cast<uint>(a.sample.pdf), std::bit_cast<uint>(b.sample.pdf)) << where;
    EXPECT_EQ(a.sample.flags, b.sample.flags) << where;
    for (int i = 0; i < 3; ++i) {
        EXPECT_EQ(std::bit_cast<uint>(a.value[i]), std::bit_cast<uint>(b.value[i])) << where;
        EXPECT_EQ(std::bit_cast<uint>(a.sample.f[i]), std::bit_cast<uint>(b.sample.f[i])) << where;
        EXPECT_EQ(std::bit_cast<uint>(a.sample.wi[i]), std::bit_cast<uint>(b.sample.wi[i])) << where;
    }
}

struct Case {
    const char* name;
    GltfBxDF lobe;
    TraceFeatures features;  // required features
};

std::vector<Case> Cases() {
    GltfBxDF faint = GltfLobe(0.3f);  // reflects so little that its layer is hardly ever chosen
    faint.specular = 1e-5f;
    GltfBxDF green = GltfLobe(0.3f);
    green.specularColor = vec3(0.1f, 1.0f, 0.5f);
    GltfBxDF almostGlass = Glass(0.3f, 1.5f);
    almostGlass.transmission = 1.0f - 1e-6f;
    GltfBxDF coated = Metal(0.3f, vec3(1.0f, 0.7f, 0.3f));
    coated.clearcoat = 0.5f;
    coated.clearcoatRoughness = 0.4f;
    coated.coatAlpha = 0.16f;
    GltfBxDF lacquered = coated;
    lacquered.clearcoatRoughness = lacquered.coatAlpha = 0.0f;
    GltfBxDF bubble = ThinGlass(0.3f);
    bubble.iridescence = 0.8f;
    bubble.iridescenceIor = 1.4f;
    bubble.iridescenceThickness = 300.0f;
    GltfBxDF brushed = Metal(0.3f, vec3(1.0f, 0.7f, 0.3f));
    brushed.alpha.x = 0.7f;
    std::vector<Case> cases{{"metal", Metal(0.3f, vec3(1.0f, 0.7f, 0.3f)), kTraceMetals},
                            {"dielectric", GltfLobe(0.3f), kTraceOpaque},
                            {"faint dielectric", faint, kTraceOpaque},
                            {"green dielectric", green, kTraceOpaque},
                            {"glass", Glass(0.3f, 1.5f), kTraceGlass},
                            {"almost glass", almostGlass, kTraceGlass | kTraceOpaque},
                            {"thin wall", ThinGlass(0.3f), kTraceGlass},
                            {"smooth thin wall", ThinGlass(0.0f), kTraceGlass | kTraceSmooth},
                            {"smooth metal", Metal(0.0f, vec3(0.9f)), kTraceMetals | kTraceSmooth},
                            {"coated metal", coated, kTraceMetals | kTraceClearcoat},
                            {"lacquered metal", lacquered, kTraceMetals | kTraceClearcoat | kTraceSmooth},
                            {"brushed metal", brushed, kTraceMetals | kTraceAnisotropy},
                            {"bubble", bubble, kTraceGlass | kTraceIridescence}};
    // Something of each lobe that has a feature of its own, over metal, glass and plastic
    GltfBxDF blend = Blend(0.3f);
    blend.coatAlpha = 0.16f;
    blend.iridescenceIor = 1.4f;
    blend.iridescenceThickness = 300.0f;
    const TraceFeatures base = kTraceMetals | kTraceGlass | kTraceOpaque;
    const auto lobeOf = [&](TraceFeatures feature) -> GltfBxDF& {
        for (Case& test : cases)
            if (test.features == (base | feature)) return test.lobe;
        return cases.emplace_back(Case{"blend", blend, base | feature}).lobe;
    };
#define RAYGRAPH_MATERIAL_FACTOR(type, name, object, key, channels, space, feature, quantity) \
    lobeOf(kTrace##feature).name = type(0.4f);
#include "shared/material_list.h"
    return cases;
}

TEST(LobeFeatures, LobesThatNoMaterialHasMayBeOff) {
    const TraceFeatures all = threadTraceFeatures;
    const TraceFeatures lobes = FeaturesOfKind(TraceFeatureKind::Lobes);
    std::vector<TraceFeatures> alsoOn{TraceFeatures{}};
    for (const TraceFeatureRow& row : kTraceFeatureRows)
        if (row.kind == TraceFeatureKind::Lobes) alsoOn.push_back(row.feature);
    for (const MultiscatterKind kind :
         {MultiscatterKind::Off, MultiscatterKind::Lut, MultiscatterKind::Walk}) {
        const MultiscatterScope scope(kind);
        for (const Case& test : Cases()) {
            for (const float cosine : {1.0f, 0.7f, 0.05f}) {
                const vec3 wo = DirectionAt(cosine, 0.8f);
                for (const float uc : {0.0f, 0.3f, 0.9f, 0.99999994f}) {
                    const vec3 wi = DirectionAt(uc < 0.5f ? 0.6f : -0.6f, 2.0f + uc);
                    const vec2 u(0.4f, 0.3f);
                    const Outcome whole = OutcomeOf(test.lobe, wo, wi, uc, u);
                    for (const TraceFeatures others : alsoOn) {
                        const FeatureScope features((all & ~lobes) | test.features | others);
                        FillStack();
                        ExpectSame(OutcomeOf(test.lobe, wo, wi, uc, u), whole,
                                   std::string(test.name) + ", multiscatter " + std::to_string(int(kind)) +
                                       ", cos " + std::to_string(cosine) + ", uc " + std::to_string(uc));
                    }
                }
            }
        }
    }
}

}  // namespace
}  // namespace raygraph::shading::lobe_features_test
