#include "editor/session/file/render_flaws.h"

#include <algorithm>

#include "base/printable.h"
#include "base/text.h"
#include "editor/session/settings/parse.h"
#include "editor/session/settings/setting_table.h"

namespace raygraph::session {

namespace {

std::string FlawOf(const SampleRanges& samples) {
    if (samples.empty()) return "it has no samples";
    uint64_t end = 0;
    for (const SampleRange& range : samples) {
        if (range.count == 0) return "it has a range of no samples";
        if (range.first < end)
            return Text("its sample ranges are out of order or overlap: {}", ToText(samples));
        end = range.End();
    }
    if (end > uint64_t{1} << 32) return Text("its sample {} is beyond the last, 4294967295", end - 1);
    if (SampleCount(samples) > 0xFFFFFFFFu) return "it has more samples than can be counted";
    return {};
}

// Checks a plane that may be missing.
template <typename T>
std::string FlawOf(const std::string& name, const std::vector<T>& plane, uint64_t size) {
    if (plane.empty() || plane.size() == size) return {};
    return Text("its {} has {} values, not {}", name, plane.size(), size);
}

std::string FlawOf(const std::string& name, const passes::ExactSums& sums, uint64_t size) {
    const auto isOfSize = [&](uint64_t wanted) {
        return [wanted](const passes::ExactSums::Plane& plane) { return plane.size() == wanted; };
    };
    if (std::ranges::all_of(sums.sums, isOfSize(sums.IsEmpty() ? 0 : size)) &&
        std::ranges::all_of(sums.squares, isOfSize(sums.HasSquares() ? size : 0)))
        return {};
    return Text("its sums of {} are not of its pixels", name);
}

// Checks all planes and their sums.
std::string FlawOfPlanes(const RenderFile& render) {
    const uint64_t pixels = PixelCount(render.size), texels = 4 * pixels;
    std::string flaw;
    const auto check = [&](const std::string& name, const auto& plane, uint64_t size) {
        if (flaw.empty()) flaw = FlawOf(name, plane, size);
    };
    if (render.radiance.empty()) return "it has no radiance";
    check("radiance", render.radiance, texels);
    check("radiance", render.sums.radiance, texels);
    check("variance", render.variance, texels);
    for (const Aov aov : kAovs) {
        const Texels* mean = MeanOf(render, aov);
        if (mean == nullptr) continue;
        check(Name(aov), *mean, texels);
        check(Name(aov), *SumsOf(render.sums, aov), texels);
    }
    for (const Bias bias : kBiases) {
        const size_t i = static_cast<size_t>(bias);
        check(std::string(Name(AovOf(bias))) + ".variance", render.removedVariance[i], texels);
        if (flaw.empty() && render.removed[i].empty() != render.removedVariance[i].empty())
            flaw = Text("of {} it has one of mean and variance, not both", Name(AovOf(bias)));
    }
    for (const Texels& group : render.lightGroups) {
        if (flaw.empty() && group.empty()) flaw = "one of its groups of lights is empty";
        check("light of a group", group, texels);
    }
    for (const passes::ExactSums& sums : render.sums.lightGroups) check("groups of lights", sums, texels);
    check("depth", render.depth, pixels);
    check("instance", render.instance, pixels);
    check("material", render.material, pixels);
    check("motion", render.motion, 2 * pixels);
    return flaw;
}

}  // namespace

void RequireReadable(const PictureSettings& settings) {
    const PictureSettings reread = SettingsFrom(Texts(settings));
    if (reread.lightGroups != settings.lightGroups)
        throw SettingError(ErrorKind::Usage, Text("light-group: {}: a pattern holds a comma or a semicolon",
                                                  Printable(ToText(settings.lightGroups))));
}

std::string FirstFlaw(const RenderFile& render) {
    if (std::string flaw = FlawOf(render.samples); !flaw.empty()) return flaw;
    for (const auto& [name, text] : render.settings)
        if (!IsSetting(name)) return Text("its setting {} is not known", Printable(name));
    PictureSettings settings;
    try {
        settings = SettingsFrom(render.settings);
    } catch (const SettingError& error) {
        return std::string("its setting ") + error.what();
    }
    if (const Extent2D recorded = RenderedPart(settings).Extent(); recorded != render.size)
        return Text("its recorded size {} is not that of the picture, {}", ToText(recorded),
                    ToText(render.size));
    const size_t groups = LightGroupNames(settings.lightGroups).size();
    if (render.lightGroups.size() != groups ||
        (!render.sums.lightGroups.empty() && render.sums.lightGroups.size() != groups))
        return Text("it has {} groups of lights with {} sums; its settings name {}",
                    render.lightGroups.size(), render.sums.lightGroups.size(), groups);
    if (settings.isAdaptive != render.adaptive.has_value())
        return "its settings and its counts of samples do not agree on whether it is adaptive";
    if (std::string flaw = FlawOfCounts(render); !flaw.empty()) return flaw;
    return FlawOfPlanes(render);
}

std::string FlawOfCounts(const RenderFile& render) {
    if (!render.adaptive) return {};
    if (std::string flaw = FlawOf(*render.adaptive, {render.size.width, render.size.height}); !flaw.empty())
        return flaw;
    const uint32_t average = render.adaptive->Average();
    if (render.samples.size() == 1 && average == render.samples.front().count) return {};
    return Text("its pixels have {} samples on average, and it says {}", average, ToText(render.samples));
}

}  // namespace raygraph::session
