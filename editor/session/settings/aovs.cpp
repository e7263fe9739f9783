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

bool CanHave(Aov aov, const PictureSettings& settings) {
    if (aov == Aov::Motion) return settings.shutter.has_value();
    if (aov == Aov::Denoising && settings.isAdaptive) return false;
    if (aov >= Aov::Denoising && settings.view != View::PathTraced) return false;
    for (const Bias bias : kBiases)
        if (aov == AovOf(bias) && !IsOn(settings.paths.biases, bias)) return false;
    return true;
}

}  // namespace raygraph::session
