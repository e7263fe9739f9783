#include "editor/cli/bias_text.h"

#include <algorithm>

#include "base/text.h"

namespace raygraph::cli {

namespace {

std::string Percent(double share) {
    return Text("{:.3g} %", 100.0 * share);
}

}  // namespace

std::string Option(session::Bias bias) {
    std::string option = std::string("--") + Name(bias);
    std::ranges::replace(option, '_', '-');
    return option;
}

std::string Describe(session::Bias bias, const session::RemovedLight& removed) {
    std::string text = Option(bias) + " removed ";
    if (!removed.share) return text + "nothing of no light";
    text += Percent(*removed.share);
    if (removed.shareStandardError) text += " +- " + Percent(*removed.shareStandardError);
    return text + " of the light";
}

}  // namespace raygraph::cli
