// Properties of views that need no drawing.
#include "passes/views.h"

namespace raygraph::passes {

bool ShowsLight(View view) {
    return view == View::PathTraced || view == View::Raster;
}

bool ShowsSurface(View view) {
    return !ShowsLight(view) && view != View::Overdraw && view != View::RayCost;
}

bool IsAverageable(View view) {
    return view != View::Depth && view != View::Instance && view != View::Material;
}

}  // namespace raygraph::passes
