#include "rhi/message_sink.h"

#include "base/text.h"

namespace raygraph::rhi {
namespace {

// Called by the layers, through whose frames nothing may be thrown.
VKAPI_ATTR VkBool32 VKAPI_CALL Receive(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                       VkDebugUtilsMessageTypeFlagsEXT,
                                       const VkDebugUtilsMessengerCallbackDataEXT* data,
                                       void* user) noexcept {
    const LogLevel level = severity >= VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT     ? LogLevel::Error
                           : severity >= VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT ? LogLevel::Warning
                                                                                         : LogLevel::Info;
    static_cast<MessageSink*>(user)->SendValidation(level, data->pMessageIdName ? data->pMessageIdName : "",
                                                    data->pMessage ? data->pMessage : "");
    return VK_FALSE;
}

}  // namespace

void MessageSink::SendValidation(LogLevel level, std::string_view id, std::string_view text) noexcept {
    m_validationCount.fetch_add(1, std::memory_order_relaxed);
    if (!m_log.IsEnabled(level)) return;
    // Most layers put the identifier into the text.
    if (id.empty() || text.find(id) != std::string_view::npos)
        m_log.Send(level, log_category::kValidation, text);
    else
        WriteLog(m_log, level, log_category::kValidation, "{}: {}", id, text);
}

VkDebugUtilsMessengerCreateInfoEXT MessageSink::MessengerInfo() {
    VkDebugUtilsMessengerCreateInfoEXT info{};
    info.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT;
    info.messageSeverity =
        VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    info.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
    info.pfnUserCallback = Receive;
    info.pUserData = this;
    return info;
}

}  // namespace raygraph::rhi
