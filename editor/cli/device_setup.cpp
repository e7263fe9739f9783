#include "editor/cli/device_setup.h"

#include <algorithm>
#include <utility>

namespace raygraph::cli {

namespace {

std::string OneLine(std::string text) {
    std::ranges::replace(text, '\n', ' ');
    return text;
}

}  // namespace

void DeviceMessages::Add(const rhi::Message& message) {
    const bool isSerious = message.severity != rhi::MessageSeverity::Info;
    const std::scoped_lock lock(m_mutex);
    if (message.isValidation && isSerious)
        m_validation.push_back(OneLine(message.text));
    else if (isSerious)
        m_warnings.push_back(OneLine(message.text));
}

std::vector<std::string> DeviceMessages::TakeWarnings() {
    const std::scoped_lock lock(m_mutex);
    return std::exchange(m_warnings, {});
}

void DeviceMessages::RequireValid() const {
    const std::scoped_lock lock(m_mutex);
    if (m_validation.empty()) return;
    const size_t others = m_validation.size() - 1;
    std::string message = "validation: " + m_validation.front();
    if (others > 0) message += " (and " + std::to_string(others) + " more)";
    throw Error(ErrorKind::Vulkan, message);
}

std::unique_ptr<rhi::Device> OpenDevice(const DeviceChoice& choice, DeviceMessages& messages) {
    return rhi::Device::Create(
        {.select = choice.select,
         .validation = choice.isValidating,
         .onMessage = [&messages](const rhi::Message& message) { messages.Add(message); },
         .surfaceExtensions = choice.surfaceExtensions});
}

}  // namespace raygraph::cli
