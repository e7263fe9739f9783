// A Vulkan loader whose N-th call fails: the system's own, with one call, or all from one on, answered by an
// error and kept from the driver.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "rhi/vulkan.h"

namespace raygraph::testing {

// Calls that may fail, by what they ask for. vkCreateInstance and vkCreateDevice are none of them.
enum class FailingCall : uint8_t {
    Allocation,  // memory: vkAllocateMemory, vkBind*Memory, vkMapMemory
    Creation,    // objects and command buffers: vkCreate*, vkAllocate*, vkBeginCommandBuffer ...
    Submission,  // vkQueueSubmit2
    Wait,        // waits, and questions about what has completed: vkWaitSemaphores, vkGetQueryPoolResults ...
};
inline constexpr FailingCall kFailingCalls[] = {FailingCall::Allocation, FailingCall::Creation,
                                                FailingCall::Submission, FailingCall::Wait};
const char* Name(FailingCall call);  // "allocation"

struct InjectedFailure {
    std::optional<FailingCall> call;  // none: of any kind
    uint64_t number = 1;              // index of the first call that fails, among those of its kind
    VkResult result = VK_ERROR_OUT_OF_DEVICE_MEMORY;
    bool lasts = false;        // all later calls of the kind fail, too, until ClearInjectedFailure
    std::string Text() const;  // in ParseFailure's syntax
};
// "allocation:17:oom", "wait:3:lost", "any:200:oom", "allocation:17:oom:on" for one that lasts. Null: no such
// text.
std::optional<InjectedFailure> ParseFailure(const std::string& text);

// Vulkan's functions carry no user data, so all this is the process's. Threads: any, but for InjectFailure
// and ClearInjectedFailure while others call Vulkan.

// The functions of `system`, with failures. Another loader may not be in use.
PFN_vkGetInstanceProcAddr FailingLoader(PFN_vkGetInstanceProcAddr system);
// Counts calls from 1 from now on. VK_ERROR_DEVICE_LOST persists: once a call has returned it, earlier work
// completes, and every submission and wait on any device returns it until the next InjectFailure. Without a
// failure, calls are only counted.
void InjectFailure(const std::optional<InjectedFailure>& failure);
// Calls succeed again. A lost device stays lost.
void ClearInjectedFailure();
// Returns whether the last injected failure has occurred.
bool HasFailed();
// The functions of its kind that were called from then on up to the failure, which is of the last one.
std::vector<const char*> RecordedCalls();
// If on, heaps are reported as so small that the allocator gives each buffer and texture its own memory, so
// that each allocation can fail. Call it before the device is created.
void UseDedicatedAllocations(bool isOn);

}  // namespace raygraph::testing
