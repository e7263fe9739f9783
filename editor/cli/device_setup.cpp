#include "editor/cli/device_setup.h"

#include <cstdlib>

#include "base/text.h"

namespace raygraph::cli {

std::unique_ptr<rhi::Device> OpenDevice(const DeviceChoice& choice, const Log& log) {
    const auto open = [&](const std::string& select) {
        return rhi::Device::Create({.select = select,
                                    .validation = choice.isValidating,
                                    .log = log,
                                    .surfaceExtensions = choice.surfaceExtensions});
    };
    if (!choice.select.empty()) return open(choice.select);
    const char* variable = std::getenv("RAYGRAPH_DEVICE");
    if (!variable || !*variable) return open("");
    try {
        return open(variable);
    } catch (const Error& error) {
        const std::string message = error.what();
        if (message.find(Text("'{}'", variable)) == message.npos) throw;  // no device would do
        throw Error(error.Kind(), "RAYGRAPH_DEVICE: " + message, error.Result());
    }
}

}  // namespace raygraph::cli
