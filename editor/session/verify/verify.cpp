#include "editor/session/verify/verify.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <system_error>
#include <utility>

#include "base/os.h"
#include "base/text.h"
#include "editor/session/file/content_hasher.h"
#include "editor/session/session.h"
#include "editor/session/settings/light_settings.h"
#include "editor/session/settings/parse.h"
#include "editor/session/verify/alternatives.h"
#include "passes/views.h"
#include "renderer/graph/renderer.h"
#include "shaders/shared/light_records.h"

namespace raygraph::session {

namespace {

// Returns a group's name of letters, digits, '_' and '-' that no other group has.
std::string GroupName(const std::string& name, std::set<std::string>& taken) {
    std::string safe;
    for (const char c : name.substr(0, 40)) {
        const bool isPlain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
        safe += isPlain || c == '-' ? c : '_';
    }
    while (!taken.insert(safe).second) safe += '_';
    return safe;
}

// Returns a shell pattern that matches the name: what has a meaning in patterns or in lists of them becomes
// ?.
std::string PatternOf(std::string name) {
    for (char& c : name)
        if (std::string_view("*?[]\\,;=").find(c) != std::string_view::npos) c = '?';
    return name;
}

// A hypothesis with this score is so good that nothing is rendered to find a better one.
constexpr double kClearScore = 0.85;

AovSet AovsFor(const PictureSettings& settings) {
    AovSet aovs{Aov::Instance, Aov::Material, Aov::Depth};
    if (settings.view != View::PathTraced) return aovs;
    for (const passes::PathPart part : Values<passes::PathPart>()) aovs.Set(AovOf(part));
    return aovs;
}

}  // namespace

RegionRule ParseRegion(std::string_view text) {
    const size_t colon = text.find(':'), equals = text.rfind('=');
    const std::string_view kind = text.substr(0, colon);
    if (colon == text.npos || equals == text.npos || equals <= colon + 1 ||
        (kind != "object" && kind != "material"))
        throw MakeError(ErrorKind::Usage, "{} is neither object:PATTERN=X nor material:PATTERN=X",
                        Quoted(text));
    const std::string_view value = text.substr(equals + 1);
    return {.isMaterial = kind == "material",
            .pattern = std::string(text.substr(colon + 1, equals - colon - 1)),
            .relative = value == "ignore" ? std::numeric_limits<float>::infinity()
                                          : static_cast<float>(ParseNumber(value, 0.0, 1e6))};
}

std::vector<LightGroupPatterns> GroupsOfAllLights(const scene::SceneData& scene) {
    std::vector<LightGroupPatterns> groups;
    std::set<std::string> taken{"rest", "environment"}, named;
    const auto add = [&](const std::string& name) {
        if (name.empty() || groups.size() == gpu::kMaxNamedLightGroups || !named.insert(name).second) return;
        groups.push_back({GroupName(name, taken), {PatternOf(name)}});
    };
    for (const scene::Light& light : scene.lights)
        add(light.name.empty() && light.node != scene::kNone ? scene.nodes[light.node].name : light.name);
    std::vector<bool> isUsed(scene.materials.size(), false);
    for (const scene::Instance& instance : scene.instances)
        for (const scene::Primitive& primitive : scene.meshes[instance.mesh].primitives)
            isUsed[primitive.material] = true;
    for (size_t i = 0; i < scene.materials.size(); ++i)
        if (isUsed[i] && scene.materials[i].EmittedRadiance() != glm::vec3(0.0f))
            add(scene.materials[i].name);
    return groups;
}

struct Verify::Impl {
    Impl(rhi::Device& of, SceneInput&& taken, VerifyDesc&& given)
        : device(of), input(std::move(taken)), desc(std::move(given)), renderer(of) {
        PictureSettings& settings = desc.settings;
        isResumable = settings.view == View::PathTraced;
        if (settings.paths.seed == 0) settings.paths.seed = kReferenceSeed;
        settings.light = ChooseLight(input, settings);
        if (isResumable && settings.lightGroups.empty()) settings.lightGroups = GroupsOfAllLights(input.data);
        aovs = AovsFor(settings);
        described = DescribeRender(input, settings, device.Info());
        if (!desc.cache.empty()) file = desc.cache / (Key() + ".exr");
        Load();
    }

    // Returns a text that is another one for any other reference.
    std::string Key() const {
        ContentHasher hasher;
        hasher.Add(std::string_view(described.sceneHash));
        hasher.Add(std::string_view(described.environmentHash));
        hasher.Add(std::string_view(described.version));
        hasher.Add(std::string_view(ListOf(aovs)));
        for (const auto& [name, text] : described.settings) {
            hasher.Add(std::string_view(name));
            hasher.Add(std::string_view(text));
        }
        return hasher.Text();
    }

    void Load() {
        std::error_code error;
        if (file.empty() || !std::filesystem::exists(file, error)) return;
        try {
            RenderFile read = ReadRenderFile(file, desc.log);
            if (isResumable) RequireResumable({file, read});
            if (!FirstMismatch(read, described).empty() || AovsOf(read) != aovs) return;
            Take({file, std::move(read)});
        } catch (const Error& failure) {
            desc.log.Send(LogLevel::Warning, log_category::kScene,
                          Text("a stored reference is rendered again: {}", failure.what()));
        }
    }

    void Take(ResumedRender render) {
        stored = std::move(render);
        reference = PictureOf(stored->render, "the reference of " + Printable(input.file));
    }

    void RenderTo(uint32_t samples) {
        if (!session) {
            SessionDesc begun;
            if (stored && isResumable) {
                begun = Resuming(*stored);
            } else {
                begun.settings = desc.settings;
                begun.aovs = aovs;
                begun.withVariance = passes::ShowsLight(desc.settings.view);
            }
            session = std::make_unique<Session>(device, input, begun);
        }
        session->Run({.samples = samples, .isStopRequested = desc.isStopRequested}, desc.progress);
        if (!session->HasResult()) throw Error(ErrorKind::Io, "stopped before the reference had a sample");
        Take({file, session->Result().render});
    }

    // A reference that cannot be stored is rendered again the next time
    void Store() const {
        if (file.empty()) return;
        try {
            std::error_code error;
            std::filesystem::create_directories(desc.cache, error);
            WriteRenderFile(file, stored->render, desc.log);
        } catch (const Error& failure) {
            desc.log.Send(LogLevel::Warning, log_category::kScene,
                          Text("the reference is not stored: {}", failure.what()));
        }
    }

    // Returns Tolerance::relative by pixel; empty: the same for all.
    std::vector<float> RelativeOf(const Picture& picture, const CheckOptions& options) const {
        if (options.regions.empty() && options.mask.empty()) return {};
        const size_t pixels = PixelCount(picture.size);
        std::vector<float> relative(pixels, static_cast<float>(desc.tolerance.relative));
        const SceneNames names = NamesOf(input.data);
        for (const RegionRule& rule : options.regions) {
            const std::vector<std::string>& all = rule.isMaterial ? names.materials : names.instances;
            const std::vector<uint32_t>& ids =
                rule.isMaterial ? stored->render.material : stored->render.instance;
            std::vector<bool> isIn(all.size());
            for (size_t i = 0; i < all.size(); ++i) isIn[i] = os::MatchesPattern(all[i], rule.pattern);
            if (std::ranges::find(isIn, true) == isIn.end())
                throw MakeError(ErrorKind::Usage, "region {}: no {} of the scene is called so",
                                Quoted(rule.pattern), rule.isMaterial ? "material" : "object");
            for (size_t pixel = 0; pixel < ids.size(); ++pixel)
                if (ids[pixel] < isIn.size() && isIn[ids[pixel]]) relative[pixel] = rule.relative;
        }
        for (size_t pixel = 0; pixel < options.mask.size() / 4; ++pixel)
            if (!(LuminanceOf(&options.mask[4 * pixel]) > 0.0f))
                relative[pixel] = std::numeric_limits<float>::infinity();
        return relative;
    }

    // Returns the reference with the difference that counts as right.
    Picture Expected(const CheckOptions& options) const {
        Picture expected = reference;
        for (size_t i = 0; i < options.accepted.size(); ++i) expected.radiance[i] += options.accepted[i];
        return expected;
    }

    Diagnosis DiagnosisOf(const Picture& picture, const Picture& expected,
                          const std::vector<float>& relative) const {
        const RenderFile& render = stored->render;
        bool isEstimated = false;
        Texels noise = NoiseOf(picture, expected, isEstimated);
        for (size_t i = 0; i < reference.variance.size(); ++i) noise[i] += reference.variance[i];
        const Residual residual(expected, picture, noise, desc.tolerance.relative, relative);
        Diagnosis diagnosis = Diagnose(residual, render, NamesOf(input.data), desc.exposureEv);
        const bool isClear =
            !diagnosis.hypotheses.empty() && diagnosis.hypotheses.front().score > kClearScore;
        if (isClear || !isResumable || desc.settings.crop) return diagnosis;
        WeighAlternatives(diagnosis, device,
                          {.input = input,
                           .settings = desc.settings,
                           .render = render,
                           .reference = expected,
                           .picture = picture,
                           .noise = noise,
                           .tolerance = desc.tolerance.relative,
                           .relative = relative,
                           .isStopRequested = desc.isStopRequested});
        return diagnosis;
    }

    bool IsStopRequested() const { return desc.isStopRequested && desc.isStopRequested(); }

    rhi::Device& device;
    SceneInput input;
    VerifyDesc desc;
    Renderer renderer;
    AovSet aovs;
    RenderFile described;
    std::filesystem::path file;  // "": none
    bool isResumable = true;
    std::optional<ResumedRender> stored;
    std::unique_ptr<Session> session;
    Picture reference;
};

Verify::Verify(rhi::Device& device, SceneInput input, VerifyDesc desc)
    : m_impl(std::make_unique<Impl>(device, std::move(input), std::move(desc))) {}

Verify::~Verify() = default;

const Picture& Verify::Reference() const {
    return m_impl->reference;
}

std::string Verify::Key() const {
    return m_impl->Key();
}

VerifyResult Verify::Check(const Picture& picture, const CheckOptions& options) {
    Impl& impl = *m_impl;
    const Extent2D size{RenderedPart(impl.desc.settings).width, RenderedPart(impl.desc.settings).height};
    if (picture.size != size)
        throw MakeError(ErrorKind::BadInput, "{} has {} pixels, and the reference {}",
                        Printable(picture.name, 1024), ToText(picture.size), ToText(size));
    for (const auto& [what, texels] :
         {std::pair("mask", &options.mask), std::pair("accepted difference", &options.accepted)})
        if (!texels->empty() && texels->size() != picture.radiance.size())
            throw MakeError(ErrorKind::BadInput, "{}: its {} has another size", Printable(picture.name, 1024),
                            what);
    const bool isAveraged = passes::IsAverageable(impl.desc.settings.view);
    const uint32_t most = isAveraged ? impl.desc.maxSamples : 1,
                   least = std::min(isAveraged ? impl.desc.minSamples : 1, most);
    const uint64_t before = impl.reference.samples;
    if (before < least) impl.RenderTo(least);
    VerifyResult result;
    const std::vector<float> relative = impl.RelativeOf(picture, options);
    for (;;) {
        result.verdict = Judge(impl.renderer, picture,
                               {.reference = impl.Expected(options),
                                .tolerance = impl.desc.tolerance,
                                .relative = relative,
                                .exposureEv = impl.desc.exposureEv,
                                .render = &impl.stored->render,
                                .names = NamesOf(impl.input.data)});
        const uint64_t samples = impl.reference.samples;
        if (result.verdict.isDecided || samples >= most || !impl.isResumable || impl.IsStopRequested()) break;
        impl.RenderTo(static_cast<uint32_t>(std::min<uint64_t>(2 * samples, most)));
    }
    result.referenceSamples = impl.reference.samples;
    result.newSamples = result.referenceSamples - before;
    if (result.newSamples > 0) impl.Store();
    if (!result.verdict.isRight)
        result.diagnosis = impl.DiagnosisOf(picture, impl.Expected(options), relative);
    return result;
}

}  // namespace raygraph::session
