#include "editor/cli/device_setup.h"

namespace raygraph::cli {

std::unique_ptr<rhi::Device> OpenDevice(const DeviceChoice& choice, const Log& log) {
    return rhi::Device::Create({.select = choice.select,
                                .validation = choice.isValidating,
                                .log = log,
                                .surfaceExtensions = choice.surfaceExtensions});
}

}  // namespace raygraph::cli
