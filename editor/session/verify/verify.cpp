#include "editor/session/verify/verify.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <mutex>
#include <set>
#include <system_error>
#include <utility>

#include "base/os.h"
#include "base/text.h"
#include "editor/session/explain/path_names.h"
#include "editor/session/file/content_hasher.h"
#include "editor/session/session.h"
#include "editor/session/settings/light_settings.h"
#include "editor/session/settings/parse.h"
#include "editor/session/verify/alternatives.h"
#include "passes/views.h"
#include "renderer/graph/renderer.h"
#include "renderer/graph/shader_library.h"
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

// A reference of values has its variance from the means of so many batches of samples.
constexpr uint32_t kBatches = 16;

// Returns what is locked while a file of the cache is completed.
std::mutex& LockOf(const std::filesystem::path& file) {
    static std::mutex guard;
    static std::map<std::filesystem::path, std::mutex> locks;
    const std::scoped_lock lock(guard);
    return locks[file];
}

// Returns whether a .png of the view has its values, and not colors for people.
bool ShowsValues(View view) {
    return passes::ShowsLight(view) || view == View::Albedo || view == View::Emissive ||
           view == View::Normals || view == View::Roughness || view == View::Metallic;
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

// Gives lights and emitting materials without a name the ones by which `explain` and `info` call them, so
// that groups can be made of them.
static void NameLights(scene::SceneData& scene) {
    for (size_t i = 0; i < scene.lights.size(); ++i) {
        scene::Light& light = scene.lights[i];
        if (light.name.empty() && (light.node == scene::kNone || scene.nodes[light.node].name.empty()))
            light.name = NameOfUnnamed(light, i);
    }
    for (size_t i = 0; i < scene.materials.size(); ++i)
        if (scene.materials[i].name.empty() && scene.materials[i].EmittedRadiance() != glm::vec3(0.0f))
            scene.materials[i].name = Text("material {}", i);
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
        NameLights(input.data);
        if (isResumable && settings.lightGroups.empty()) settings.lightGroups = GroupsOfAllLights(input.data);
        aovs = AovsFor(settings);
        described = DescribeRender(input, settings, device.Info());
        // The key, by which differences are accepted, is without the shaders, whose SPIR-V depends on the
        // compiler
        if (!desc.cache.empty()) file = desc.cache / Text("{}-{:016x}.exr", Key(), HashOfEmbeddedShaders());
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

    // Returns the reference in the cache; none: there is none that is of use, or that is not known.
    std::optional<RenderFile> Read() const {
        std::error_code error;
        if (file.empty() || !std::filesystem::exists(file, error) ||
            std::filesystem::last_write_time(file, error) == knownAt)
            return std::nullopt;
        try {
            RenderFile read = ReadRenderFile(file, desc.log);
            if (isResumable) RequireResumable({file, read});
            if (FirstMismatch(read, described).empty() && AovsOf(read) == aovs) return read;
        } catch (const Error& failure) {
            desc.log.Send(LogLevel::Warning, log_category::kScene,
                          Text("a stored reference is rendered again: {}", failure.what()));
        }
        return std::nullopt;
    }

    void Know() {
        std::error_code error;
        if (!file.empty()) knownAt = std::filesystem::last_write_time(file, error);
    }

    // Takes what the cache has, if it is more.
    void Load() {
        std::optional<RenderFile> read = Read();
        Know();
        if (!read || SampleCount(read->samples) <= reference.samples) return;
        Take({file, std::move(*read)});
        session.reset();
    }

    void Take(ResumedRender render) {
        stored = std::move(render);
        reference = PictureOf(stored->render, "the reference of " + Printable(input.file));
        if (desc.settings.view != View::Normals) return;
        reference.radiance = AsCodes(reference.radiance);
        for (float& variance : reference.variance) variance *= 0.25f;
    }

    // Returns normals n as (n + coverage) / 2.
    Texels AsCodes(Texels normals) const {
        for (size_t i = 0; i < normals.size(); ++i)
            if (i % 4 != 3) normals[i] = 0.5f * (normals[i] + stored->render.radiance[i | 3]);
        return normals;
    }

    Extent2D Size() const {
        const passes::Region part = RenderedPart(desc.settings);
        return {part.width, part.height};
    }

    // Returns the part of a whole picture that the crop has; other pictures are as they were.
    Picture Cropped(const Picture& picture) const {
        if (picture.size == Size() || picture.size != desc.settings.size) return picture;
        const passes::Region part = RenderedPart(desc.settings);
        Picture cropped = picture;
        cropped.size = Size();
        for (Texels Picture::*plane : {&Picture::radiance, &Picture::variance}) {
            const Texels& from = picture.*plane;
            Texels& to = cropped.*plane;
            to.clear();
            for (uint32_t y = 0; y < part.height && !from.empty(); ++y) {
                const size_t first = size_t{part.y + y} * picture.size.width + part.x;
                const auto row = from.begin() + 4 * std::ptrdiff_t(first);
                to.insert(to.end(), row, row + 4 * std::ptrdiff_t(part.width));
            }
        }
        return cropped;
    }

    Picture AsJudged(const Picture& picture) const {
        Picture judged = Cropped(picture);
        if (desc.settings.view != View::Normals) return judged;
        judged.white = std::numeric_limits<float>::infinity();  // a code of 255 is a direction
        if (judged.transfer) return judged;
        judged.radiance = AsCodes(std::move(judged.radiance));
        for (float& variance : judged.variance) variance *= 0.25f;
        return judged;
    }

    // Adds the variance of one sample to a render of values, from the means of batches.
    void AddBatch(RenderFile& render) {
        const auto count = static_cast<double>(SampleCount(render.samples));
        if (batchSquares.empty()) {
            batchSquares.resize(render.radiance.size());
            sums.resize(render.radiance.size());
        }
        const double samples = count - batchedSamples;
        batchedSamples = count;
        ++batches;
        render.variance.assign(render.radiance.size(), 0.0f);
        for (size_t i = 0; i < sums.size(); ++i) {
            const double sum = count * double{render.radiance[i]}, ofBatch = sum - sums[i];
            sums[i] = sum;
            batchSquares[i] += ofBatch * ofBatch / samples;
            if (batches > 1.0)
                render.variance[i] = static_cast<float>(
                    std::max(batchSquares[i] - sum * double{render.radiance[i]}, 0.0) / (batches - 1.0));
        }
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
                begun.withSums = isResumable;
                batchSquares.clear();
                batchedSamples = batches = 0.0;
            }
            session = std::make_unique<Session>(device, input, begun);
        }
        const View view = desc.settings.view;
        const bool isBatched = !passes::ShowsLight(view) && passes::IsAverageable(view);
        const uint32_t step = isBatched ? std::max(samples / kBatches, 1u) : samples;
        uint32_t reached = session->SampleCount();
        while (reached < samples && !IsStopRequested()) {
            reached = std::min(reached + step, samples);
            session->Run({.samples = reached, .isStopRequested = desc.isStopRequested}, desc.progress);
            if (!session->HasResult()) break;
            RenderFile render = session->Result().render;
            if (isBatched) AddBatch(render);
            Take({file, std::move(render)});
        }
        if (stored && reference.samples > 0) Store();
        if (IsStopRequested()) throw Error(ErrorKind::Io, "stopped before the picture was judged");
    }

    // A reference that cannot be stored is rendered again the next time
    void Store() {
        if (file.empty()) return;
        try {
            // Another process may have stored more
            const std::optional<RenderFile> other = Read();
            if (other && SampleCount(other->samples) >= reference.samples) return;
            std::error_code error;
            std::filesystem::create_directories(desc.cache, error);
            WriteRenderFile(file, stored->render, desc.log);
            Know();
        } catch (const Error& failure) {
            desc.log.Send(LogLevel::Warning, log_category::kScene,
                          Text("the reference is not stored: {}", failure.what()));
        }
    }

    // Returns for each object, or each material, whether the rule is for it.
    std::vector<bool> IsIn(const RegionRule& rule, const SceneNames& names) const {
        const std::vector<std::string>& all = rule.isMaterial ? names.materials : names.instances;
        std::vector<bool> isIn(all.size());
        for (size_t i = 0; i < all.size(); ++i) isIn[i] = os::MatchesPattern(all[i], rule.pattern);
        if (std::ranges::find(isIn, true) == isIn.end())
            throw MakeError(ErrorKind::Usage, "region {}: no {} of the scene is called so",
                            Quoted(rule.pattern), rule.isMaterial ? "material" : "object");
        return isIn;
    }

    // Returns Tolerance::relative by pixel; empty: the same for all.
    std::vector<float> RelativeOf(const CheckOptions& options, const Picture& mask) const {
        const bool isOfSurfaces = desc.settings.view == View::Normals;
        if (options.regions.empty() && mask.radiance.empty() && !isOfSurfaces) return {};
        std::vector<float> relative(PixelCount(Size()), static_cast<float>(desc.tolerance.relative));
        const SceneNames names = NamesOf(input.data);
        for (const RegionRule& rule : options.regions) {
            const std::vector<uint32_t>& ids =
                rule.isMaterial ? stored->render.material : stored->render.instance;
            const std::vector<bool> isIn = IsIn(rule, names);
            for (size_t pixel = 0; pixel < ids.size(); ++pixel)
                if (ids[pixel] < isIn.size() && isIn[ids[pixel]]) relative[pixel] = rule.relative;
        }
        const float ignored = std::numeric_limits<float>::infinity();
        for (size_t pixel = 0; pixel < relative.size(); ++pixel) {
            if (!mask.radiance.empty() && !(LuminanceOf(&mask.radiance[4 * pixel]) > 0.0f))
                relative[pixel] = ignored;
            // Where there is no surface, there is no normal
            if (isOfSurfaces && !(stored->render.radiance[4 * pixel + 3] > 0.0f)) relative[pixel] = ignored;
        }
        return relative;
    }

    // Throws for what cannot be judged, before anything is rendered.
    void Require(const Picture& picture, const Picture& mask, const CheckOptions& options) const {
        if (picture.size != Size())
            throw MakeError(ErrorKind::BadInput, "{} has {} pixels, and the reference {}",
                            Printable(picture.name, 1024), ToText(picture.size), ToText(Size()));
        for (const auto& [what, other] :
             {std::pair("mask", &mask), std::pair("accepted difference", &options.accepted)})
            if (!other->radiance.empty() && other->size != picture.size)
                throw MakeError(ErrorKind::BadInput, "{}: its {} has {} pixels, and it has {}",
                                Printable(picture.name, 1024), what, ToText(other->size),
                                ToText(picture.size));
        const View view = desc.settings.view;
        if (picture.transfer && !ShowsValues(view))
            throw MakeError(ErrorKind::BadInput,
                            "{}: a .png shows {} in colors for people; give the values as an .exr",
                            Printable(picture.name, 1024), Name(view));
        if (options.regions.empty()) return;
        const SceneNames names = NamesOf(input.data);
        for (const RegionRule& rule : options.regions) IsIn(rule, names);
    }

    // Returns the reference with the difference that counts as right.
    Picture Expected(const CheckOptions& options) const {
        Picture expected = reference;
        const Texels& accepted = options.accepted.radiance;
        for (size_t i = 0; i < accepted.size(); ++i) expected.radiance[i] += accepted[i];
        return expected;
    }

    Diagnosis DiagnosisOf(const Picture& given, const Picture& expected, const std::vector<float>& relative,
                          std::optional<uint32_t> samples) const {
        const RenderFile& render = stored->render;
        const Picture picture = WithoutNonFinite(given);
        Texels noise = NoiseOf(picture, expected, relative, samples).variance;
        for (size_t i = 0; i < reference.variance.size(); ++i) noise[i] += reference.variance[i];
        const Residual residual(expected, picture, noise, desc.tolerance.relative, relative);
        Diagnosis diagnosis = Diagnose(residual, render, NamesOf(input.data), desc.exposureEv);
        if (desc.settings.view != View::PathTraced && desc.settings.view != View::Raster)
            std::erase_if(diagnosis.hypotheses, [](const Hypothesis& h) { return h.kind == "tone curve"; });
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
    std::filesystem::path file;               // "": none
    std::filesystem::file_time_type knownAt;  // when `file` was written as it was last read or written here
    bool isResumable = true;
    std::optional<ResumedRender> stored;
    std::unique_ptr<Session> session;
    Picture reference;
    // These sum the samples that the session has taken of a view of values.
    std::vector<double> sums, batchSquares;
    double batchedSamples = 0.0, batches = 0.0;
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

Picture Verify::AsJudged(const Picture& picture) const {
    return m_impl->AsJudged(picture);
}

VerifyResult Verify::Check(const Picture& picture, const CheckOptions& options) {
    Impl& impl = *m_impl;
    const Picture mask = impl.Cropped(options.mask);
    impl.Require(impl.Cropped(picture), mask, options);
    const View view = impl.desc.settings.view;
    const bool isAveraged = passes::IsAverageable(view);
    const uint32_t most = isAveraged ? impl.desc.maxSamples : 1,
                   least = std::min(isAveraged ? impl.desc.minSamples : 1, most);
    std::optional<std::scoped_lock<std::mutex>> lock;
    if (!impl.file.empty()) lock.emplace(LockOf(impl.file));
    impl.Load();
    const uint64_t before = impl.reference.samples;
    if (before < least) impl.RenderTo(least);
    VerifyResult result;
    const std::vector<float> relative = impl.RelativeOf(options, mask);
    const Picture judged = impl.AsJudged(picture);
    for (;;) {
        result.verdict = Judge(impl.renderer, judged,
                               {.reference = impl.Expected(options),
                                .tolerance = impl.desc.tolerance,
                                .relative = relative,
                                .exposureEv = impl.desc.exposureEv,
                                .pictureSamples = options.pictureSamples,
                                .scale = view == View::Normals ? 0.5 : 0.0,
                                .render = &impl.stored->render,
                                .names = NamesOf(impl.input.data)});
        const uint64_t samples = impl.reference.samples;
        if (result.verdict.isDecided || samples >= most) break;
        impl.RenderTo(static_cast<uint32_t>(std::min<uint64_t>(2 * samples, most)));
    }
    result.referenceSamples = impl.reference.samples;
    result.newSamples = result.referenceSamples - before;
    // Where most pixels are NaN, what is left of the picture explains nothing
    const auto isNonFinite = [&](const VerdictCheck& check) {
        return check.name == "nonfinite" && 2.0 * check.value > static_cast<double>(PixelCount(picture.size));
    };
    if (!result.verdict.isRight && std::ranges::none_of(result.verdict.checks, isNonFinite))
        result.diagnosis = impl.DiagnosisOf(judged, impl.Expected(options), relative, options.pictureSamples);
    return result;
}

}  // namespace raygraph::session
