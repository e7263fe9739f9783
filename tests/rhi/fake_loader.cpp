#include "tests/rhi/fake_loader.h"

#include <algorithm>
#include <cstring>
#include <vector>

#include "base/check.h"

namespace raygraph::testing {
namespace {

// The functions behind the fakes, as the system's loader gave them last.
struct State {
    Lies lies;
    PFN_vkGetInstanceProcAddr getInstanceProcAddr = nullptr;
    PFN_vkGetDeviceProcAddr getDeviceProcAddr = nullptr;
    PFN_vkEnumerateDeviceExtensionProperties enumerateExtensions = nullptr;
    PFN_vkGetPhysicalDeviceFeatures2 features = nullptr;
    PFN_vkGetPhysicalDeviceProperties2 properties = nullptr;
    PFN_vkQueueSubmit2 submit = nullptr;
    PFN_vkWaitSemaphores wait = nullptr;
};
State* g_state = nullptr;

// Calls `change` with every structure of a pNext chain of the given type.
template <typename T, typename Change>
void ForEach(void* chain, VkStructureType type, Change&& change) {
    for (auto* s = static_cast<VkBaseOutStructure*>(chain); s; s = s->pNext)
        if (s->sType == type) change(*reinterpret_cast<T*>(s));
}

VKAPI_ATTR VkResult VKAPI_CALL EnumerateExtensions(VkPhysicalDevice device, const char* layer,
                                                   uint32_t* count, VkExtensionProperties* properties) {
    uint32_t all = 0;
    g_state->enumerateExtensions(device, layer, &all, nullptr);
    std::vector<VkExtensionProperties> kept(all);
    g_state->enumerateExtensions(device, layer, &all, kept.data());
    std::erase_if(kept, [](const VkExtensionProperties& e) {
        return g_state->lies.hiddenExtension == e.extensionName;
    });
    if (properties) std::copy_n(kept.begin(), std::min<size_t>(*count, kept.size()), properties);
    *count = static_cast<uint32_t>(kept.size());
    return VK_SUCCESS;
}

VKAPI_ATTR void VKAPI_CALL Features(VkPhysicalDevice device, VkPhysicalDeviceFeatures2* features) {
    g_state->features(device, features);
    if (!g_state->lies.hasNoScalarBlockLayout) return;
    ForEach<VkPhysicalDeviceVulkan12Features>(features, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES,
                                              [](auto& f) { f.scalarBlockLayout = VK_FALSE; });
}

VKAPI_ATTR void VKAPI_CALL Properties(VkPhysicalDevice device, VkPhysicalDeviceProperties2* properties) {
    g_state->properties(device, properties);
    if (g_state->lies.apiVersion != 0) properties->properties.apiVersion = g_state->lies.apiVersion;
    if (g_state->lies.maxPushDescriptors == 0) return;
    ForEach<VkPhysicalDevicePushDescriptorPropertiesKHR>(
        properties, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PUSH_DESCRIPTOR_PROPERTIES_KHR,
        [](auto& p) { p.maxPushDescriptors = g_state->lies.maxPushDescriptors; });
}

VKAPI_ATTR VkResult VKAPI_CALL Submit(VkQueue queue, uint32_t count, const VkSubmitInfo2* infos,
                                      VkFence fence) {
    if (g_state->lies.submitResult != VK_SUCCESS) return g_state->lies.submitResult;
    return g_state->submit(queue, count, infos, fence);
}

VKAPI_ATTR VkResult VKAPI_CALL Wait(VkDevice device, const VkSemaphoreWaitInfo* info, uint64_t timeout) {
    if (g_state->lies.waitResult != VK_SUCCESS) return g_state->lies.waitResult;
    return g_state->wait(device, info, timeout);
}

template <typename Function>
PFN_vkVoidFunction Fake(PFN_vkVoidFunction real, Function& kept, Function fake) {
    if (!real) return nullptr;
    kept = reinterpret_cast<Function>(real);
    return reinterpret_cast<PFN_vkVoidFunction>(fake);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL GetDeviceProcAddr(VkDevice device, const char* name) {
    const PFN_vkVoidFunction real = g_state->getDeviceProcAddr(device, name);
    if (std::strcmp(name, "vkQueueSubmit2") == 0) return Fake(real, g_state->submit, Submit);
    if (std::strcmp(name, "vkWaitSemaphores") == 0) return Fake(real, g_state->wait, Wait);
    return real;
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL GetInstanceProcAddr(VkInstance instance, const char* name) {
    const PFN_vkVoidFunction real = g_state->getInstanceProcAddr(instance, name);
    const auto is = [&](const char* other) { return std::strcmp(name, other) == 0; };
    if (is("vkGetDeviceProcAddr")) return Fake(real, g_state->getDeviceProcAddr, GetDeviceProcAddr);
    if (is("vkEnumerateDeviceExtensionProperties"))
        return Fake(real, g_state->enumerateExtensions, EnumerateExtensions);
    if (is("vkGetPhysicalDeviceFeatures2")) return Fake(real, g_state->features, Features);
    if (is("vkGetPhysicalDeviceProperties2")) return Fake(real, g_state->properties, Properties);
    return real;
}

}  // namespace

FakeLoader::FakeLoader() : m_system(rhi::VulkanLoader::Open()) {
    RG_CHECK(g_state == nullptr);
    g_state = new State;
    g_state->getInstanceProcAddr = m_system->GetInstanceProcAddr();
}

FakeLoader::~FakeLoader() {
    delete g_state;
    g_state = nullptr;
}

PFN_vkGetInstanceProcAddr FakeLoader::Entry() const {
    return GetInstanceProcAddr;
}

Lies& FakeLoader::Tell() {
    return g_state->lies;
}

}  // namespace raygraph::testing
