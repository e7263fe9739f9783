#include "editor/viewport/view_settings.h"

namespace raygraph::viewport {

const char* Name(View view) {
    switch (view) {
        case View::PathTraced:
            return "path-traced";
        case View::Raster:
            return "raster";
        case View::Wipe:
            return "wipe";
        case View::SideBySide:
            return "side by side";
        case View::Difference:
            return "difference";
        case View::RelativeError:
            return "relative error";
        case View::Flip:
            return "FLIP";
        case View::Surface:
            return "surface";
    }
    return "unknown";
}

bool ShowsPathTraced(View view) {
    return view != View::Raster && view != View::Surface;
}

bool ShowsRaster(View view) {
    return view != View::PathTraced && view != View::Surface;
}

bool IsMeasured(View view) {
    return view == View::Difference || view == View::RelativeError || view == View::Flip;
}

}  // namespace raygraph::viewport
