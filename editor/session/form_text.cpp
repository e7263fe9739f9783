#include "editor/session/form_text.h"

#include "base/text.h"
#include "editor/session/parse.h"

namespace raygraph::session {

passes::FormSettings ParseForm(std::string_view text) {
    const size_t colon = text.find(':');
    passes::FormSettings form;
    form.kind = ParseChoice<passes::IntegratorForm>(std::string(text.substr(0, colon)));
    if (colon == std::string_view::npos) return form;
    if (form.kind != passes::IntegratorForm::Wavefront)
        throw MakeError(ErrorKind::Usage, "\"{}\": only a wavefront has steps, as in wavefront:4", text);
    form.steps = ParseCount(text.substr(colon + 1), 1, passes::kMaxWaveSteps);
    return form;
}

std::string FormText(const passes::FormSettings& form) {
    const std::string name = Name(form.kind);
    return form.kind == passes::IntegratorForm::Wavefront ? Text("{}:{}", name, form.steps) : name;
}

}  // namespace raygraph::session
