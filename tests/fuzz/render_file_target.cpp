// Fuzzes stored renders as they are resumed and merged. The input chooses which channels and attributes of a
// valid one are changed, and to what.
#include <algorithm>
#include <cstring>

#include "editor/cli/resume_settings.h"
#include "editor/session/file/merge.h"
#include "editor/session/file/render_file.h"
#include "editor/session/frames/adaptive_frames.h"
#include "renderer/image/exr.h"
#include "tests/fuzz/choices.h"
#include "tests/support/format_of_words.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::fuzz {

namespace {

constexpr uint32_t kWidth = 3, kHeight = 2;
constexpr size_t kPixels = kWidth * kHeight;

// Makes the state of a render whose pixels have different numbers of samples.
session::AdaptiveState MakeCounts() {
    session::AdaptiveState state{.counts = std::vector<uint32_t>(kPixels, 20), .stages = {128, 128}};
    state.counts[0] = 40;
    state.wanted = std::vector<uint32_t>(kPixels, 128);
    state.noted[32] = {std::vector<float>(kPixels, 1.0f), std::vector<float>(kPixels, 1.0f)};
    return state;
}

// Makes a render of four samples from `first` on, with everything or only with what must be stored.
session::RenderFile MakeRender(bool isFull, uint32_t first, bool isAdaptive = false) {
    session::RenderFile render;
    render.size = {kWidth, kHeight};
    render.samples = {{first, 4}};
    session::PictureSettings settings;
    settings.size = render.size;
    const auto means = [] { return session::Texels(4 * kPixels, 0.5f); };
    const auto sums = [](bool withSquares) {
        passes::ExactSums made = passes::MakeExactSums(kPixels, withSquares);
        for (int i = 0; i < 4; ++i) passes::AddSample(made, session::Texels(4 * kPixels, 0.5f));
        return made;
    };
    render.radiance = render.variance = means();
    render.sums.radiance = sums(true);
    render.sceneFile = "a.gltf";
    render.sceneHash = "1234";
    if (isFull) {
        settings.lightGroups = session::ParseLightGroups("lamps=lamp*,bulb;sky=*");
        for (const session::Aov aov : session::kAovs) {
            session::Texels* mean = MeanOf(render, aov);
            if (mean == nullptr) continue;
            *mean = means();
            *SumsOf(render.sums, aov) = sums(aov >= session::Aov::RemovedMaxDepth);
        }
        for (session::Texels& variance : render.removedVariance) variance = means();
        render.removedSamples = 4;
        for (size_t i = 0; i < session::LightGroupNames(settings.lightGroups).size(); ++i) {
            render.lightGroups.push_back(means());
            render.sums.lightGroups.push_back(sums(false));
        }
        render.denoising = {means(), means(), means(), 1, means(), means(), means()};
        render.depth.assign(kPixels, 1.0f);
        render.motion.assign(2 * kPixels, 1.0f);
        render.instance.assign(kPixels, 1);
        render.material.assign(kPixels, 1);
    }
    if (isAdaptive) {
        settings.isAdaptive = true;
        render.adaptive = MakeCounts();
        render.samples = {{first, render.adaptive->Average()}};
    }
    render.settings = session::Texts(settings);
    return render;
}

// Holds valid renders, and a path for others.
struct Renders {
    Renders() {
        for (const bool isFull : {false, true}) {
            const std::filesystem::path path = folder / "valid.exr";
            session::WriteRenderFile(path, MakeRender(isFull, 0));
            (isFull ? full : small) = image::ReadExr(path);
            // Its sums have no digest, so that changed ones can be resumed
            if (isFull) full = test::WithWordChannels(std::move(full), MakeRender(isFull, 0));
            (isFull ? laterFull : laterSmall) = MakeRender(isFull, 1000);
        }
        session::WriteRenderFile(folder / "valid.exr", MakeRender(false, 0, true));
        adaptive = image::ReadExr(folder / "valid.exr");
    }
    test::TemporaryFolder folder;
    image::ExrImage small, full, adaptive;
    session::RenderFile laterSmall, laterFull;  // with later samples
};

std::string Line(std::string_view& text) {
    const size_t end = std::min(text.find('\n'), text.size());
    std::string line(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    std::erase(line, '\0');  // ends a text in a header
    return line;
}

// Each change takes four bytes; the rest of the input is lines for attributes.
void Change(image::ExrImage& file, Choices& choices) {
    struct Edit {
        uint8_t kind, at, with, value;
    };
    std::vector<Edit> edits(choices.Byte() % 6);
    for (Edit& edit : edits) edit = {choices.Byte(), choices.Byte(), choices.Byte(), choices.Byte()};
    std::string_view lines = AsText(choices.Rest());
    for (const Edit& edit : edits) {
        const size_t of = size_t{edit.at} | size_t{edit.with} << 8;
        image::ExrChannel& channel = file.channels[of % file.channels.size()];
        auto attribute = file.attributes.begin();
        std::advance(attribute, file.attributes.empty() ? 0 : of % file.attributes.size());
        const bool hasAttribute = attribute != file.attributes.end();
        switch (edit.kind % 8) {
            case 0:
                if (file.channels.size() > 1)
                    file.channels.erase(file.channels.begin() +
                                        static_cast<ptrdiff_t>(of % file.channels.size()));
                break;
            case 1: {
                const bool isFloat = std::holds_alternative<std::vector<float>>(channel.samples);
                const size_t size =
                    std::visit([](const auto& samples) { return samples.size(); }, channel.samples);
                if (isFloat)
                    channel.samples = std::vector<uint32_t>(size, edit.value);
                else
                    channel.samples = std::vector<float>(size, edit.value);
                break;
            }
            case 2:
                // All numbers become equal: all ones, a small one, or a sign
                std::visit(
                    [&](auto& samples) {
                        using T = typename std::decay_t<decltype(samples)>::value_type;
                        for (T& sample : samples) {
                            const uint32_t bits = edit.value == 255 ? ~0u : uint32_t{edit.value} << 23;
                            std::memcpy(&sample, &bits, sizeof bits);
                        }
                    },
                    channel.samples);
                break;
            case 3:
                if (hasAttribute) file.attributes.erase(attribute);
                break;
            case 4:
                if (hasAttribute) attribute->second = int32_t{edit.value};
                break;
            default:
                if (hasAttribute) attribute->second = Line(lines);
        }
    }
}

// Whatever a file claims about its pixels, more samples are added.
void GoOn(const session::RenderFile& render) {
    using NextKind = session::AdaptiveCounts::Next::Kind;
    session::AdaptiveCounts counts({render.size.width, render.size.height}, *render.adaptive);
    const session::PixelVariances noted{std::vector<float>(kPixels, 1.0f), std::vector<float>(kPixels, 1.0f)};
    const uint32_t average = counts.Average() + counts.Average() / 2 + 1;
    uint64_t before = counts.Total();
    for (auto next = counts.NextTo(average); next.kind != NextKind::Nothing; next = counts.NextTo(average)) {
        if (next.kind == NextKind::Decision) {
            counts.AllocateStage(next.color, noted);
            continue;
        }
        counts.Advance(next, next.length);
        Require(counts.Total() > before, "a step without a sample");
        before = counts.Total();
    }
    Require(counts.Average() >= average, "it ends before its average");
}

void ReadAndMerge(const std::filesystem::path& path, const session::RenderFile& later,
                  const std::filesystem::path& other) {
    const std::string subject = path.string();
    session::RenderFile render, merged;
    if (!Succeeds(subject, {ErrorKind::BadInput}, [&] { render = session::ReadRenderFile(path); })) return;
    session::ResumedRender resumed;
    if (Succeeds(subject, {ErrorKind::BadInput}, [&] { resumed = session::ReadResumedRender(path); }))
        Succeeds("", {ErrorKind::Usage}, [&] { cli::SettingsOf(resumed, {.samples = 1u << 20}); });
    if (render.adaptive && !render.adaptive->wanted.empty())
        Succeeds("", {ErrorKind::Usage}, [&] { GoOn(render); });
    // A render that was read can be written, and read again
    Require(Succeeds("", {},
                     [&] {
                         session::WriteRenderFile(other, render);
                         Require(session::ReadRenderFile(other).settings == render.settings,
                                 "settings are lost");
                     }),
            "");
    if (!Succeeds("", {ErrorKind::BadInput}, [&] {
            merged = session::Merge({{"a", std::move(render)}, {"b", later}});
        }))
        return;
    Require(Succeeds("", {}, [&] { session::WriteRenderFile(other, merged); }), "");
}

}  // namespace

void RunRenderFile(Input input) {
    static const Renders renders;
    Choices choices(input);
    const bool isFull = choices.Flag();
    const bool isAdaptive = !isFull && choices.Flag();
    image::ExrImage file = isFull ? renders.full : isAdaptive ? renders.adaptive : renders.small;
    Change(file, choices);
    const std::filesystem::path path = renders.folder / "render.exr";
    // Writing refuses two channels of one name, and reserved names of attributes
    if (!Succeeds("", {ErrorKind::Usage}, [&] { image::WriteExr(path, file); })) return;
    ReadAndMerge(path, isFull ? renders.laterFull : renders.laterSmall, renders.folder / "other.exr");
}

}  // namespace raygraph::fuzz
