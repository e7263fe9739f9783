#include "base/version.h"

namespace raygraph {

Version LibraryVersion() {
    return kHeaderVersion;
}

}  // namespace raygraph
