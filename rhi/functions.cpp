#include "rhi/functions.h"

#include <string>

#include "base/os.h"
#include "base/text.h"

namespace raygraph::rhi {
namespace {

template <typename Function, typename Load>
void LoadOne(Function& function, const char* name, const char* owner, Load&& load) {
    function = reinterpret_cast<Function>(load(name));
    if (!function) throw MakeError(ErrorKind::NoDevice, "{} has no function {}", owner, name);
}

}  // namespace

#define RAYGRAPH_LOAD_(name)          LoadOne(table.name, #name, kOwner, load);
#define RAYGRAPH_LOAD_OPTIONAL_(name) table.name = reinterpret_cast<PFN_##name>(load(#name));

GlobalFunctions LoadGlobalFunctions(PFN_vkGetInstanceProcAddr loader) {
    constexpr const char* kOwner = "the Vulkan loader";
    const auto load = [&](const char* name) { return loader(VK_NULL_HANDLE, name); };
    GlobalFunctions table;
    RAYGRAPH_GLOBAL_FUNCTIONS(RAYGRAPH_LOAD_)
    return table;
}

InstanceFunctions LoadInstanceFunctions(PFN_vkGetInstanceProcAddr loader, VkInstance instance,
                                        bool debugUtils) {
    constexpr const char* kOwner = "the Vulkan instance";
    const auto load = [&](const char* name) { return loader(instance, name); };
    InstanceFunctions table;
    RAYGRAPH_INSTANCE_FUNCTIONS(RAYGRAPH_LOAD_)
    if (debugUtils) {
        RAYGRAPH_DEBUG_INSTANCE_FUNCTIONS(RAYGRAPH_LOAD_OPTIONAL_)
    }
    RAYGRAPH_SURFACE_FUNCTIONS(RAYGRAPH_LOAD_OPTIONAL_)
    return table;
}

DeviceFunctions LoadDeviceFunctions(PFN_vkGetDeviceProcAddr loader, VkDevice device, bool debugUtils) {
    constexpr const char* kOwner = "the Vulkan device";
    const auto load = [&](const char* name) { return loader(device, name); };
    DeviceFunctions table;
    RAYGRAPH_DEVICE_FUNCTIONS(RAYGRAPH_LOAD_)
    if (debugUtils) {
        RAYGRAPH_DEBUG_DEVICE_FUNCTIONS(RAYGRAPH_LOAD_OPTIONAL_)
    }
    RAYGRAPH_SWAPCHAIN_FUNCTIONS(RAYGRAPH_LOAD_OPTIONAL_)
    RAYGRAPH_STATISTICS_FUNCTIONS(RAYGRAPH_LOAD_OPTIONAL_)
    return table;
}

#undef RAYGRAPH_LOAD_
#undef RAYGRAPH_LOAD_OPTIONAL_

std::shared_ptr<VulkanLoader> VulkanLoader::Open() {
    // The library stays loaded until the process ends: drivers start threads and register handlers that may
    // outlive the last instance, and unloading their code would crash.
    constexpr const char* kLibrary = "libvulkan.so.1";
    std::shared_ptr<VulkanLoader> loader(new VulkanLoader);
    std::string whyNot;
    void* library = os::OpenLibrary(kLibrary, whyNot);
    if (!library) throw MakeError(ErrorKind::NoDevice, "no Vulkan loader: {}", whyNot);
    loader->m_getInstanceProcAddr =
        reinterpret_cast<PFN_vkGetInstanceProcAddr>(os::FunctionOf(library, "vkGetInstanceProcAddr"));
    if (!loader->m_getInstanceProcAddr)
        throw MakeError(ErrorKind::NoDevice, "{} has no function vkGetInstanceProcAddr", kLibrary);
    return loader;
}

}  // namespace raygraph::rhi
