#include "editor/viewport/view_settings.h"

namespace raygraph::viewport {

bool ShowsPathTraced(View view) {
    return view != View::Raster && view != View::Surface;
}

bool IsComparison(View view) {
    return view == View::Wipe || view == View::SideBySide || IsMeasured(view);
}

bool IsMeasured(View view) {
    return view == View::Difference || view == View::RelativeError || view == View::Flip;
}

bool ShowsRaster(const ShowSettings& show) {
    return show.view == View::Raster || (IsComparison(show.view) && show.compared == Compared::Raster);
}

bool ComparesRealTime(const ShowSettings& show) {
    return IsComparison(show.view) && show.compared == Compared::RealTime;
}

}  // namespace raygraph::viewport
