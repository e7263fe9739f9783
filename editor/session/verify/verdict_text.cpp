#include "editor/session/verify/verdict_text.h"

#include "base/text.h"

namespace raygraph::session {

namespace {

// Returns "tiles 12.50 %, at most 1.00 %".
std::string CheckText(const VerdictCheck& check) {
    if (check.name == "ssim")
        return Text("ssim {:.3f}, at least {:.3f} with this noise", check.value, check.limit);
    if (check.name == "flip")
        return Text("flip {:.3f}, at most {:.3f} with this noise", check.value, check.limit);
    if (check.name == "nonfinite")
        return Text("{} NaN or infinite: {}", Counted(static_cast<uint64_t>(check.value), "pixel"),
                    check.where);
    return Text("{} {:.2f} %, at most {:.2f} %{}{}", check.name, 100.0 * check.value, 100.0 * check.limit,
                check.where.empty()     ? ""
                : check.name == "parts" ? ": worst, "
                                        : ": ",
                check.where);
}

}  // namespace

std::string Describe(const VerifyResult& result, const std::string& name, const std::string& found) {
    const Verdict& verdict = result.verdict;
    std::string text = Text("{}: {} ({} of the reference{})", Printable(name, 1024),
                            !found.empty()    ? found
                            : verdict.isRight ? "right"
                                              : "NOT RIGHT",
                            Counted(result.referenceSamples, "sample"),
                            result.newSamples > 0 ? Text(", {} new", result.newSamples) : "");
    for (const VerdictCheck& check : verdict.checks)
        if (!check.isPassed) text += "\n  " + CheckText(check);
    if (!result.diagnosis.hypotheses.empty())
        text +=
            "\n  possible causes, best first, with the share of the difference that each explains (shares "
            "overlap):";
    for (const Hypothesis& hypothesis : result.diagnosis.hypotheses)
        text += Text("\n  {:3.0f} %: {}", 100.0 * hypothesis.explained, hypothesis.text);
    if (!verdict.isDecided) text += "\n  more samples of the reference could change this";
    return text;
}

}  // namespace raygraph::session
