#include "editor/cli/aov_request.h"

#include <string>
#include <vector>

#include "base/text.h"
#include "editor/cli/report.h"
#include "editor/session/settings/bias.h"
#include "editor/session/settings/parse.h"
#include "editor/session/settings/picture_settings.h"

namespace raygraph::cli {

using namespace session;  // NOLINT

namespace {

// Returns why a picture with these settings lacks the AOV; "" if it can have it.
std::string WhyNot(Aov aov, const PictureSettings& settings) {
    if (CanHave(aov, settings)) return {};
    if (aov == Aov::Motion) return "it is from when --shutter opens to when it closes, and there is none";
    if (aov == Aov::Denoising) return NotDenoisedReason(settings);
    if (settings.view != View::PathTraced) return "only path-traced pictures have light to tell apart";
    const auto bias =
        static_cast<Bias>(static_cast<size_t>(aov) - static_cast<size_t>(AovOf(kBiases.front())));
    return Option(bias) + " is off and removes nothing";
}

}  // namespace

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
        // It repeats what other channels say, and takes camera rays of its own
        const bool isInAll = request.isAll && aov != Aov::Denoising;
        if (whyNot.empty() && (isInAll || request.named.Has(aov))) aovs.Set(aov);
    }
    return aovs;
}

}  // namespace raygraph::cli
