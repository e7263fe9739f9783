#include "tests/support/failing_vulkan.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <cstring>
#include <iterator>
#include <mutex>
#include <string_view>
#include <tuple>

#include "tests/support/replaced_function.h"

namespace raygraph::testing {
namespace {

// clang-format off
#define RAYGRAPH_FAILING_FUNCTIONS(X)                     \
    X(Allocation, vkAllocateMemory)                       \
    X(Allocation, vkBindBufferMemory)                     \
    X(Allocation, vkBindBufferMemory2)                    \
    X(Allocation, vkBindImageMemory)                      \
    X(Allocation, vkBindImageMemory2)                     \
    X(Allocation, vkMapMemory)                            \
    X(Creation, vkCreateBuffer)                           \
    X(Creation, vkCreateImage)                            \
    X(Creation, vkCreateImageView)                        \
    X(Creation, vkCreateSampler)                          \
    X(Creation, vkCreateSemaphore)                        \
    X(Creation, vkCreateShaderModule)                     \
    X(Creation, vkCreatePipelineLayout)                   \
    X(Creation, vkCreatePipelineCache)                    \
    X(Creation, vkCreateComputePipelines)                 \
    X(Creation, vkCreateGraphicsPipelines)                \
    X(Creation, vkCreateRayTracingPipelinesKHR)           \
    X(Creation, vkGetRayTracingShaderGroupHandlesKHR)     \
    X(Creation, vkCreateDescriptorSetLayout)              \
    X(Creation, vkCreateDescriptorPool)                   \
    X(Creation, vkAllocateDescriptorSets)                 \
    X(Creation, vkCreateAccelerationStructureKHR)         \
    X(Creation, vkCreateQueryPool)                        \
    X(Creation, vkCreateCommandPool)                      \
    X(Creation, vkResetCommandPool)                       \
    X(Creation, vkAllocateCommandBuffers)                 \
    X(Creation, vkBeginCommandBuffer)                     \
    X(Creation, vkEndCommandBuffer)                       \
    X(Submission, vkQueueSubmit2)                         \
    X(Wait, vkWaitSemaphores)                             \
    X(Wait, vkGetSemaphoreCounterValue)                   \
    X(Wait, vkQueueWaitIdle)                              \
    X(Wait, vkGetQueryPoolResults)
// clang-format on

#define RAYGRAPH_COUNT_(kind, name) +1
constexpr size_t kFunctionCount = 0 RAYGRAPH_FAILING_FUNCTIONS(RAYGRAPH_COUNT_);
#undef RAYGRAPH_COUNT_

struct State {
    PFN_vkGetInstanceProcAddr getInstanceProcAddr = nullptr;
    PFN_vkGetDeviceProcAddr getDeviceProcAddr = nullptr;
    PFN_vkGetDeviceQueue getDeviceQueue = nullptr;
    PFN_vkQueueWaitIdle waitIdle = nullptr;
    PFN_vkGetPhysicalDeviceMemoryProperties memory = nullptr;
    PFN_vkGetPhysicalDeviceMemoryProperties2 memory2 = nullptr;
    std::array<PFN_vkVoidFunction, kFunctionCount> real{};
    std::atomic<VkQueue> queue{VK_NULL_HANDLE};  // queue of the newest device
    std::atomic<bool> shrinksHeaps{false};

    std::mutex mutex;  // guards all members below
    std::optional<InjectedFailure> failure;
    std::vector<const char*> calls;  // of the selected kind
    bool hasFailed = false;
    bool isLost = false;
};

State& Current() {
    static State state;
    return state;
}

bool IsQueueCall(FailingCall call) {
    return call == FailingCall::Submission || call == FailingCall::Wait;
}

// Returns the result to return in place of the call; VK_SUCCESS: make the call.
VkResult Answer(FailingCall call, const char* function) {
    State& state = Current();
    const std::lock_guard lock(state.mutex);
    if (state.isLost && IsQueueCall(call)) return VK_ERROR_DEVICE_LOST;
    if (!state.failure || state.failure->call.value_or(call) != call) return VK_SUCCESS;
    if (state.hasFailed) return state.failure->lasts ? state.failure->result : VK_SUCCESS;
    state.calls.push_back(function);
    if (state.calls.size() < state.failure->number) return VK_SUCCESS;
    state.hasFailed = true;
    if (state.failure->result == VK_ERROR_DEVICE_LOST) {
        state.isLost = true;
        // Work on a lost device counts as finished; wait for it, since its resources may be destroyed next.
        if (state.queue.load()) state.waitIdle(state.queue.load());
    }
    return state.failure->result;
}

enum Index : size_t {
#define RAYGRAPH_INDEX_(kind, name) k_##name,
    RAYGRAPH_FAILING_FUNCTIONS(RAYGRAPH_INDEX_)
#undef RAYGRAPH_INDEX_
};

template <size_t kIndex, FailingCall kCall, typename Function>
struct Failing;

// A failed call leaves an undefined handle; here it is null.
template <typename Handle>
void InvalidateHandle(Handle** handle) {
    *handle = reinterpret_cast<Handle*>(uintptr_t{0xBAD});
}
template <typename Other>
void InvalidateHandle(Other&&) {}

template <size_t kIndex, FailingCall kCall, typename... Arguments>
struct Failing<kIndex, kCall, VkResult(VKAPI_PTR*)(Arguments...)> {
    static inline const char* function = "";
    // Pipelines and command buffers are null then.
    static constexpr bool kInvalidatesHandle =
        kCall == FailingCall::Creation && kIndex != k_vkCreateComputePipelines &&
        kIndex != k_vkCreateGraphicsPipelines && kIndex != k_vkCreateRayTracingPipelinesKHR &&
        kIndex != k_vkAllocateCommandBuffers && kIndex != k_vkAllocateDescriptorSets;
    static VKAPI_ATTR VkResult VKAPI_CALL Call(Arguments... arguments) {
        if (const VkResult answer = Answer(kCall, function); answer != VK_SUCCESS) {
            if constexpr (kInvalidatesHandle)
                InvalidateHandle(std::get<sizeof...(Arguments) - 1>(std::tie(arguments...)));
            return answer;
        }
        return reinterpret_cast<VkResult(VKAPI_PTR*)(Arguments...)>(Current().real[kIndex])(arguments...);
    }
};

VKAPI_ATTR void VKAPI_CALL GetDeviceQueue(VkDevice device, uint32_t family, uint32_t index, VkQueue* queue) {
    Current().getDeviceQueue(device, family, index, queue);
    Current().queue = *queue;
}

void ShrinkHeaps(VkPhysicalDeviceMemoryProperties& properties) {
    constexpr VkDeviceSize kSmall = 1024;  // blocks of an eighth
    if (!Current().shrinksHeaps) return;
    for (uint32_t i = 0; i < properties.memoryHeapCount; ++i) properties.memoryHeaps[i].size = kSmall;
}

VKAPI_ATTR void VKAPI_CALL Memory(VkPhysicalDevice device, VkPhysicalDeviceMemoryProperties* properties) {
    Current().memory(device, properties);
    ShrinkHeaps(*properties);
}

VKAPI_ATTR void VKAPI_CALL Memory2(VkPhysicalDevice device, VkPhysicalDeviceMemoryProperties2* properties) {
    Current().memory2(device, properties);
    ShrinkHeaps(properties->memoryProperties);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL GetDeviceProcAddr(VkDevice device, const char* name) {
    State& state = Current();
    const PFN_vkVoidFunction real = state.getDeviceProcAddr(device, name);
    if (!real) return nullptr;
    if (std::strcmp(name, "vkGetDeviceQueue") == 0) {
        state.queue = VK_NULL_HANDLE;  // another device, without one so far
        return Replaced(real, state.getDeviceQueue, GetDeviceQueue);
    }
    if (std::strcmp(name, "vkQueueWaitIdle") == 0)
        state.waitIdle = reinterpret_cast<PFN_vkQueueWaitIdle>(real);
#define RAYGRAPH_WRAP_(kind, function_)                                             \
    if (std::strcmp(name, #function_) == 0) {                                       \
        using Wrapper = Failing<k_##function_, FailingCall::kind, PFN_##function_>; \
        Wrapper::function = #function_;                                             \
        state.real[k_##function_] = real;                                           \
        return reinterpret_cast<PFN_vkVoidFunction>(&Wrapper::Call);                \
    }
    RAYGRAPH_FAILING_FUNCTIONS(RAYGRAPH_WRAP_)
#undef RAYGRAPH_WRAP_
    return real;
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL GetInstanceProcAddr(VkInstance instance, const char* name) {
    State& state = Current();
    const PFN_vkVoidFunction real = state.getInstanceProcAddr(instance, name);
    const std::string_view asked = name;
    if (asked == "vkGetDeviceProcAddr") return Replaced(real, state.getDeviceProcAddr, GetDeviceProcAddr);
    if (asked == "vkGetPhysicalDeviceMemoryProperties") return Replaced(real, state.memory, Memory);
    if (asked == "vkGetPhysicalDeviceMemoryProperties2") return Replaced(real, state.memory2, Memory2);
    return real;
}

}  // namespace

const char* Name(FailingCall call) {
    switch (call) {
        case FailingCall::Allocation:
            return "allocation";
        case FailingCall::Creation:
            return "creation";
        case FailingCall::Submission:
            return "submission";
        case FailingCall::Wait:
            return "wait";
    }
    return "";
}

std::string InjectedFailure::Text() const {
    return std::string(call ? Name(*call) : "any") + ":" + std::to_string(number) +
           (result == VK_ERROR_DEVICE_LOST ? ":lost" : ":oom") + (lasts ? ":on" : "");
}

std::optional<InjectedFailure> ParseFailure(const std::string& text) {
    const size_t first = text.find(':');
    const size_t second = first == std::string::npos ? first : text.find(':', first + 1);
    if (second == std::string::npos) return std::nullopt;
    InjectedFailure failure;
    const std::string kind = text.substr(0, first);
    for (const FailingCall call : kFailingCalls)
        if (kind == Name(call)) failure.call = call;
    if (!failure.call && kind != "any") return std::nullopt;
    const char* const end = text.data() + second;
    const auto [stop, error] = std::from_chars(text.data() + first + 1, end, failure.number);
    if (error != std::errc{} || stop != end || failure.number == 0) return std::nullopt;
    std::string rest = text.substr(second + 1);
    constexpr std::string_view kLasts = ":on";
    failure.lasts = rest.ends_with(kLasts);
    if (failure.lasts) rest.resize(rest.size() - kLasts.size());
    if (rest != "oom" && rest != "lost") return std::nullopt;
    failure.result = rest == "oom" ? VK_ERROR_OUT_OF_DEVICE_MEMORY : VK_ERROR_DEVICE_LOST;
    return failure;
}

PFN_vkGetInstanceProcAddr FailingLoader(PFN_vkGetInstanceProcAddr system) {
    Current().getInstanceProcAddr = system;
    return GetInstanceProcAddr;
}

void InjectFailure(const std::optional<InjectedFailure>& failure) {
    State& state = Current();
    const std::lock_guard lock(state.mutex);
    state.failure = failure;
    state.calls.clear();
    state.hasFailed = state.isLost = false;
}

void ClearInjectedFailure() {
    State& state = Current();
    const std::lock_guard lock(state.mutex);
    state.failure.reset();
}

bool HasFailed() {
    State& state = Current();
    const std::lock_guard lock(state.mutex);
    return state.hasFailed;
}

std::vector<const char*> RecordedCalls() {
    State& state = Current();
    const std::lock_guard lock(state.mutex);
    return state.calls;
}

void UseDedicatedAllocations(bool isOn) {
    Current().shrinksHeaps = isOn;
}

}  // namespace raygraph::testing
