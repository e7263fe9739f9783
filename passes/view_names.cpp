// What is known of views without drawing them.
#include <array>
#include <cctype>

#include "passes/views.h"

namespace raygraph::passes {

namespace {

// "PathTraced" to "path-traced".
std::string KebabCase(const char* name) {
    std::string text;
    for (const char* c = name; *c != 0; c++) {
        if (std::isupper(static_cast<unsigned char>(*c)) != 0 && !text.empty()) text += '-';
        text += static_cast<char>(std::tolower(static_cast<unsigned char>(*c)));
    }
    return text;
}

}  // namespace

const char* Name(View view) {
#define RAYGRAPH_NAME_VIEW(name, value) KebabCase(#name),
    static const std::array<std::string, kViewCount> kNames{RAYGRAPH_VIEWS(RAYGRAPH_NAME_VIEW)};
#undef RAYGRAPH_NAME_VIEW
    return kNames[static_cast<size_t>(view)].c_str();
}

bool ShowsLight(View view) {
    return view == View::PathTraced || view == View::Raster;
}

bool ShowsSurface(View view) {
    return !ShowsLight(view) && view != View::Overdraw && view != View::RayCost;
}

bool IsMeanMeaningful(View view) {
    return view != View::Depth && view != View::Instance && view != View::Material;
}

}  // namespace raygraph::passes
