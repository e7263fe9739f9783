#include "passes/tonemap.h"

#include <string>

#include "base/error.h"
#include "base/text.h"

namespace raygraph::passes {

namespace {

// These are flags of shaders/post/tonemap.comp.
constexpr uint32_t kOpaque = 1, kUnassociated = 2, kBalanced = 4, kBacked = 8, kColored = 16, kMapped = 32;

// This is the uniform block of shaders/post/tonemap.comp.
struct BackdropConstants {
    glm::vec3 right{0.0f}, up{0.0f}, forward{0.0f};
    uint32_t isOrthographic = 0;
    glm::vec3 radiance{0.0f};
    float rotation = 0.0f;
    glm::vec3 color{0.0f};
    glm::vec2 offset{0.0f}, scale{1.0f};
};

BackdropConstants ConstantsOf(const Backdrop& backdrop) {
    const glm::vec2 picture(backdrop.picture.width, backdrop.picture.height);
    const Region& part = backdrop.part;
    return {.right = backdrop.camera.right,
            .up = backdrop.camera.up,
            .forward = backdrop.camera.forward,
            .isOrthographic = backdrop.camera.orthographic,
            .radiance = backdrop.environment.radiance,
            .rotation = backdrop.environment.rotation,
            .color = backdrop.settings.color.value_or(glm::vec3(0.0f)),
            .offset = glm::vec2(part.x, part.y) / picture,
            .scale = glm::vec2(part.width, part.height) / picture};
}

uint32_t FlagsOf(const TonemapSettings& settings, const std::optional<Backdrop>& backdrop) {
    uint32_t flags = settings.whiteBalance != glm::mat3(1.0f) ? kBalanced : 0u;
    if (!backdrop) {
        if (settings.isOpaque) flags |= kOpaque;
        return settings.isUnassociated ? flags | kUnassociated : flags;
    }
    flags |= kBacked | kUnassociated;
    if (backdrop->settings.color) flags |= kColored;
    return backdrop->environment.hasMap != 0u ? flags | kMapped : flags;
}

// The contents of `display` outside of the region stay if it is `kept`.
TextureId TonemapTo(Renderer& renderer, TextureId radiance, TextureId display, bool isKept,
                    const Region& region, const TonemapSettings& settings, std::function<void()> onSubmitted,
                    const std::optional<Backdrop>& backdrop) {
    struct Constants {
        uint32_t offset[2], size[2];
        float exposureEv;
        uint32_t tonemapOperator;
        uint32_t flags;
        glm::vec4 whiteBalance[3];  // columns
    };
    const glm::mat3& balance = settings.whiteBalance;
    renderer.AddPass(
        "Tonemap", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("post/tonemap.comp");
            pass.Reads("radiance", radiance,
                       {.magFilter = rhi::Filter::Nearest, .minFilter = rhi::Filter::Nearest});
            pass.Reads("backdropMap", backdrop ? backdrop->map : radiance,
                       {.addressV = rhi::AddressMode::ClampToEdge});
            pass.Uniform("backdrop", backdrop ? ConstantsOf(*backdrop) : BackdropConstants{});
            pass.Constants(Constants{
                {region.x, region.y},
                {region.width, region.height},
                settings.exposureEv,
                static_cast<uint32_t>(settings.tonemapOperator),
                FlagsOf(settings, backdrop),
                {glm::vec4(balance[0], 0.0f), glm::vec4(balance[1], 0.0f), glm::vec4(balance[2], 0.0f)}});
            display = isKept ? pass.Updates("display", display) : pass.Writes("display", display);
        },
        [extent = region.Extent(), onSubmitted = std::move(onSubmitted)](CommandList& commands) {
            commands.DispatchOver(extent);
            if (onSubmitted) commands.OnSubmitted(onSubmitted);
        });
    return display;
}

}  // namespace

TextureId Tonemap(Renderer& renderer, TextureId radiance, const TonemapSettings& settings,
                  const std::optional<Backdrop>& backdrop) {
    const Extent2D extent = renderer.Desc(radiance).extent;
    const TextureId display = renderer.CreateTexture("display", {extent, Format::Rgba8Unorm});
    return TonemapTo(renderer, radiance, display, false, WholeOf(extent), settings, {}, backdrop);
}

TextureId TonemapInto(Renderer& renderer, TextureId radiance, TextureId display, const Region& region,
                      const TonemapSettings& settings, std::function<void()> onSubmitted,
                      const std::optional<Backdrop>& backdrop) {
    const GraphTextureDesc to = renderer.Desc(display);
    RequireWithin(to.extent, region);
    if (to.format != Format::Rgba8Unorm)
        throw MakeError(ErrorKind::Usage, "Tonemap: into {}, must be {}", rhi::Name(to.format),
                        rhi::Name(Format::Rgba8Unorm));
    const bool isKept = !(region == WholeOf(to.extent));
    return TonemapTo(renderer, radiance, display, isKept, region, settings, std::move(onSubmitted), backdrop);
}

// --- White balance ---

namespace {

// Returns the XYZ of unit luminance.
glm::dvec3 XyzOf(const glm::dvec2& chromaticity) {
    return {chromaticity.x / chromaticity.y, 1.0, (1.0 - chromaticity.x - chromaticity.y) / chromaticity.y};
}

glm::dvec2 DisplayWhite() {
    return {kDisplayWhite[0], kDisplayWhite[1]};
}

// Returns the matrix from linear Rec. 709 to XYZ: white has luminance 1.
glm::dmat3 ToXyz() {
    const glm::dmat3 primaries(XyzOf({0.64, 0.33}), XyzOf({0.30, 0.60}), XyzOf({0.15, 0.06}));
    const glm::dvec3 weights = glm::inverse(primaries) * XyzOf(DisplayWhite());
    return {primaries[0] * weights[0], primaries[1] * weights[1], primaries[2] * weights[2]};
}

// The rows of the literal are those of the matrix, from XYZ.
const glm::dmat3 kBradford = glm::transpose(
    glm::dmat3{{0.8951, 0.2664, -0.1614}, {-0.7502, 1.7135, 0.0367}, {0.0389, -0.0685, 1.0296}});

glm::dvec2 BlackBody(double t) {
    const double t2 = t * t;
    const double u = (0.860117757 + 1.54118254e-4 * t + 1.28641212e-7 * t2) /
                     (1.0 + 8.42420235e-4 * t + 7.08145163e-7 * t2);
    const double v = (0.317398726 + 4.22806245e-5 * t + 4.20481691e-8 * t2) /
                     (1.0 - 2.89741816e-5 * t + 1.61456053e-7 * t2);
    const double scale = 1.0 / (2.0 * u - 8.0 * v + 4.0);  // from the UCS of 1960
    return {3.0 * u * scale, 2.0 * v * scale};
}

glm::dvec2 Daylight(double t) {
    const double k = 1e3 / t;
    const double x = t <= 7000.0 ? ((-4.6070 * k + 2.9678) * k + 0.09911) * k + 0.244063
                                 : ((-2.0064 * k + 1.9018) * k + 0.24748) * k + 0.237040;
    return {x, (-3.0 * x + 2.870) * x - 0.275};
}

}  // namespace

glm::dvec2 WhitePointAt(double kelvin) {
    if (!(kelvin >= kMinWhitePoint && kelvin <= kMaxWhitePoint))
        throw MakeError(ErrorKind::Usage, "a white point of {} K, not {} to {}", kelvin, kMinWhitePoint,
                        kMaxWhitePoint);
    if (kelvin == kDisplayWhitePoint) return DisplayWhite();
    return kelvin < 4000.0 ? BlackBody(kelvin) : Daylight(kelvin);
}

glm::dvec2 ChromaticityOf(const glm::dvec3& color) {
    const glm::dvec3 xyz = ToXyz() * color;
    const double sum = xyz.x + xyz.y + xyz.z;
    return {xyz.x / sum, xyz.y / sum};
}

glm::mat3 WhiteBalance(const glm::dvec2& white) {
    if (white == DisplayWhite()) return glm::mat3(1.0f);
    const glm::dvec3 gains = (kBradford * XyzOf(DisplayWhite())) / (kBradford * XyzOf(white));
    glm::dmat3 scaled = kBradford;  // rows of the matrix times the gains
    for (int column = 0; column < 3; ++column) scaled[column] *= gains;
    const glm::dmat3 toXyz = ToXyz();
    return glm::mat3(glm::inverse(toXyz) * glm::inverse(kBradford) * scaled * toXyz);
}

}  // namespace raygraph::passes
