#include "editor/viewport/view_settings.h"

namespace raygraph::viewport {

bool ShowsPathTraced(View view) {
    return view != View::Raster && view != View::Surface;
}

bool ShowsRaster(View view) {
    return view != View::PathTraced && view != View::Surface && view != View::RealTime;
}

bool IsMeasured(View view) {
    return view == View::Difference || view == View::RelativeError || view == View::Flip;
}

}  // namespace raygraph::viewport
