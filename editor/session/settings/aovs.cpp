#include "editor/session/settings/aovs.h"

namespace raygraph::session {

bool AovSet::NeedsParts() const {
    for (size_t i = 0; i < passes::kPathPartCount; ++i)
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

std::string NotDenoisedReason(const PictureSettings& settings) {
    if (settings.view != View::PathTraced)
        return std::string("the view ") + Name(settings.view) + " is not denoised";
    return settings.isAdaptive ? "an adaptive picture has different numbers of samples in its pixels" : "";
}

bool CanHave(Aov aov, const PictureSettings& settings) {
    if (aov == Aov::Motion) return settings.shutter.has_value();
    if (aov == Aov::Denoising) return NotDenoisedReason(settings).empty();
    if (aov >= Aov::Denoising && settings.view != View::PathTraced) return false;
    for (const Bias bias : kBiases)
        if (aov == AovOf(bias) && !IsOn(settings.paths.biases, bias)) return false;
    return true;
}

}  // namespace raygraph::session
