#include "rhi/message_sink.h"

namespace raygraph::rhi {
namespace {

VKAPI_ATTR VkBool32 VKAPI_CALL Receive(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                       VkDebugUtilsMessageTypeFlagsEXT type,
                                       const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
    Message message;
    message.severity = severity >= VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT ? MessageSeverity::Error
                       : severity >= VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT
                           ? MessageSeverity::Warning
                           : MessageSeverity::Info;
    message.isValidation = (type & VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT) != 0;
    if (data->pMessageIdName) message.id = data->pMessageIdName;
    if (data->pMessage) message.text = data->pMessage;
    static_cast<MessageSink*>(user)->Send(message);
    return VK_FALSE;
}

}  // namespace

void MessageSink::Send(const Message& message) {
    if (message.isValidation) m_validationCount.fetch_add(1, std::memory_order_relaxed);
    if (m_callback) m_callback(message);
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
