// libvulkan.so.1 for a program whose calls of Vulkan are to fail: found through LD_LIBRARY_PATH, it opens the
// real one, the file RAYGRAPH_VULKAN_LIBRARY, and injects what RAYGRAPH_FAIL says (ParseFailure). Without
// RAYGRAPH_FAIL nothing fails. What cannot be read ends the program: a test that asks for it is wrong.
#include <dlfcn.h>

#include <cstdio>
#include <cstdlib>

#include "tests/support/failing_vulkan.h"

namespace raygraph::testing {
namespace {

[[noreturn]] void Refuse(const char* name, const char* value) {
    std::fprintf(stderr, "failing_vulkan_library: %s is '%s'\n", name, value ? value : "");
    std::abort();
}

PFN_vkGetInstanceProcAddr Open() {
    const char* const file = std::getenv("RAYGRAPH_VULKAN_LIBRARY");
    void* const library = file ? dlopen(file, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE) : nullptr;
    void* const entry = library ? dlsym(library, "vkGetInstanceProcAddr") : nullptr;
    if (!entry) Refuse("RAYGRAPH_VULKAN_LIBRARY", file);
    const char* const text = std::getenv("RAYGRAPH_FAIL");
    const std::optional<InjectedFailure> failure = text ? ParseFailure(text) : std::nullopt;
    if (text && !failure) Refuse("RAYGRAPH_FAIL", text);
    InjectFailure(failure);
    return FailingLoader(reinterpret_cast<PFN_vkGetInstanceProcAddr>(entry));
}

}  // namespace
}  // namespace raygraph::testing

extern "C" __attribute__((visibility("default"))) VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL
vkGetInstanceProcAddr(VkInstance instance, const char* name);

PFN_vkVoidFunction vkGetInstanceProcAddr(VkInstance instance, const char* name) {
    static const PFN_vkGetInstanceProcAddr entry = raygraph::testing::Open();
    return entry(instance, name);
}
