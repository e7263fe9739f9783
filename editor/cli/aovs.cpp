#include "editor/cli/aovs.h"

#include <vector>

#include "base/text.h"
#include "editor/cli/parse.h"

namespace raygraph::cli {

namespace {

// Why a picture of these settings has none; "" if it can have it.
std::string WhyNot(Aov aov, const PictureSettings& settings) {
    if (aov >= Aov::Emission && settings.view != View::PathTraced)
        return "only path-traced pictures have light to tell apart";
    for (const Bias bias : kBiases)
        if (aov == AovOf(bias) && !IsOn(settings.paths.biases, bias))
            return Option(bias) + " is off and removes nothing";
    return {};
}

}  // namespace

bool AovSet::NeedsParts() const {
    for (size_t i = 0; i < passes::kPathPartCount; i++)
        if (Has(AovOf(static_cast<passes::PathPart>(i)))) return true;
    return false;
}

std::string ListOf(const AovSet& aovs) {
    std::string list;
    for (const Aov aov : kAovs) {
        if (!aovs.Has(aov)) continue;
        if (!list.empty()) list += ',';
        list += Name(aov);
    }
    return list.empty() ? "none" : list;
}

AovRequest ParseAovs(std::string_view text) {
    constexpr auto kNames = Texts(Aov{});
    std::vector<std::string_view> names(kNames.begin(), kNames.end());
    names.insert(names.end(), {"samples", "variance", "all"});
    AovRequest request;
    for (const std::string_view part : ParseList(text)) {
        const size_t choice = ParseChoice(part, names);
        if (choice < kAovCount) request.named.Set(static_cast<Aov>(choice));
        request.isAll |= names[choice] == "all";
    }
    return request;
}

AovSet AovsFor(const AovRequest& request, const PictureSettings& settings) {
    AovSet aovs;
    for (const Aov aov : kAovs) {
        const std::string whyNot = WhyNot(aov, settings);
        if (!whyNot.empty() && request.named.Has(aov))
            throw MakeError(ErrorKind::Usage, "--aov {}: {}", Name(aov), whyNot);
        if (whyNot.empty() && (request.isAll || request.named.Has(aov))) aovs.Set(aov);
    }
    return aovs;
}

}  // namespace raygraph::cli
