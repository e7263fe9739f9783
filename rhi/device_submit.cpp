// The timeline: submission of command lists, and destruction of objects when the timeline has reached a
// value.
#include <algorithm>

#include <array>
#include <utility>
#include "base/text.h"

#include "rhi/command_list.h"
#include "rhi/device_impl.h"

namespace raygraph::rhi {
namespace {

VkSemaphoreSubmitInfo SubmitInfo(const SemaphoreUse& use) {
    VkSemaphoreSubmitInfo info{};
    info.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO;
    info.semaphore = use.semaphore;
    info.value = use.value;
    info.stageMask = use.stages;
    return info;
}

}  // namespace

CommandList Device::BeginCommands(const std::string& name) {
    const DeviceFunctions& vk = m_impl->vk;
    CommandSlot slot;
    {
        const std::lock_guard lock(m_impl->slotMutex);
        auto& slots = m_impl->slots;
        const uint64_t completed = slots.empty() ? 0 : CompletedValue();
        const auto free = std::find_if(slots.begin(), slots.end(),
                                       [&](const CommandSlot& s) { return s.until <= completed; });
        if (free != slots.end()) {
            slot = *free;
            slots.erase(free);
        }
    }
    if (slot.pool) {
        const VkResult result = vk.vkResetCommandPool(Handle(), slot.pool, 0);
        if (result != VK_SUCCESS) vk.vkDestroyCommandPool(Handle(), slot.pool, AllocationCallbacks());
        Check(result, "command list '" + name + "': vkResetCommandPool");
    } else {
        VkCommandPoolCreateInfo poolInfo{};
        poolInfo.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
        poolInfo.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT;
        poolInfo.queueFamilyIndex = QueueFamily();
        Check(vk.vkCreateCommandPool(Handle(), &poolInfo, AllocationCallbacks(), &slot.pool),
              "command list '" + name + "': vkCreateCommandPool");
        VkCommandBufferAllocateInfo allocate{};
        allocate.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
        allocate.commandPool = slot.pool;
        allocate.commandBufferCount = 1;
        const VkResult result = vk.vkAllocateCommandBuffers(Handle(), &allocate, &slot.commands);
        if (result != VK_SUCCESS) vk.vkDestroyCommandPool(Handle(), slot.pool, AllocationCallbacks());
        Check(result, "command list '" + name + "': vkAllocateCommandBuffers");
    }
    CommandList list;
    list.m_device = this;
    list.m_commands = slot.commands;
    list.m_pool = slot.pool;
    list.m_serial = m_impl->retired.OpenList();
    SetName(VK_OBJECT_TYPE_COMMAND_BUFFER, reinterpret_cast<uint64_t>(slot.commands), name);
    VkCommandBufferBeginInfo begin{};
    begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    Check(vk.vkBeginCommandBuffer(slot.commands, &begin),
          "command list '" + name + "': vkBeginCommandBuffer");
    return list;
}

// Moves the Vulkan objects out of the list for reuse once the timeline has reached `value` (0: at once, since
// the list was not submitted), and runs the callbacks for its outcome.
void Device::Recycle(CommandList& commands, uint64_t value) noexcept {
    if (commands.m_pool != VK_NULL_HANDLE) {
        const std::lock_guard lock(m_impl->slotMutex);
        m_impl->slots.push_back({commands.m_pool, commands.m_commands, value});
    }
    m_impl->retired.CloseList(commands.m_serial, value);
    commands.m_device = nullptr;
    commands.m_commands = VK_NULL_HANDLE;
    commands.m_pool = VK_NULL_HANDLE;
    // Either may retire its captures: the list is closed, so that nothing waits for it in vain.
    const std::vector<std::function<void()>> onSubmitted = std::exchange(commands.m_onSubmitted, {});
    const std::vector<std::function<void()>> onDropped = std::exchange(commands.m_onDropped, {});
    if (value != 0)
        for (const std::function<void()>& run : onSubmitted) run();
    else
        for (auto undo = onDropped.rbegin(); undo != onDropped.rend(); ++undo) (*undo)();
    // Memory may be exhausted by what the list kept alive: free that without waiting for a submission.
    if (value == 0) m_impl->retired.Collect(m_impl->lastCompleted.load());
}

// Submits one batch, with or without commands, that advances the timeline; returns its value.
uint64_t Device::Impl::SubmitBatch(const Device& owner, VkCommandBuffer commands,
                                   std::span<const SemaphoreUse> waits,
                                   std::span<const SemaphoreUse> signals) {
    std::vector<VkSemaphoreSubmitInfo> waitInfos, signalInfos;
    for (const SemaphoreUse& use : waits) waitInfos.push_back(SubmitInfo(use));
    for (const SemaphoreUse& use : signals) signalInfos.push_back(SubmitInfo(use));
    signalInfos.push_back(SubmitInfo({timeline, 0}));
    VkCommandBufferSubmitInfo buffer{};
    buffer.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO;
    buffer.commandBuffer = commands;
    VkSubmitInfo2 batch{};
    batch.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2;
    batch.waitSemaphoreInfoCount = static_cast<uint32_t>(waitInfos.size());
    batch.pWaitSemaphoreInfos = waitInfos.data();
    batch.commandBufferInfoCount = commands ? 1 : 0;
    batch.pCommandBufferInfos = &buffer;
    batch.signalSemaphoreInfoCount = static_cast<uint32_t>(signalInfos.size());
    batch.pSignalSemaphoreInfos = signalInfos.data();

    const std::lock_guard lock(submitMutex);
    const uint64_t value = lastSubmitted.load() + 1;
    signalInfos.back().value = value;
    LockQueue();
    const VkResult result = vk.vkQueueSubmit2(queue, 1, &batch, VK_NULL_HANDLE);
    UnlockQueue();
    owner.Check(result, "vkQueueSubmit2");
    lastSubmitted = value;
    lastSignaled = value;
    return value;
}

uint64_t Device::Submit(CommandList&& commands, std::span<const SemaphoreUse> waits,
                        std::span<const SemaphoreUse> signals) {
    if (commands.m_device != this)
        throw Error(ErrorKind::Usage, "Submit: the command list is empty or of another device");
    if (commands.m_pool == VK_NULL_HANDLE)
        throw Error(ErrorKind::Usage, "Submit: the command list is a buffer of the host's (HandOver)");
    CommandList list = std::move(commands);  // dropped if anything below throws
    Check(m_impl->vk.vkEndCommandBuffer(list.Handle()), "vkEndCommandBuffer");

    const uint64_t value = m_impl->SubmitBatch(*this, list.Handle(), waits, signals);
    Recycle(list, value);
    // The commands have been submitted, and an Error here would mean that they have not. The next wait
    // reports a device that does not respond.
    uint64_t completed = 0;
    if (m_impl->QueryCompleted(completed) == VK_SUCCESS) m_impl->retired.Collect(completed);
    return value;
}

uint64_t Device::Forward(std::span<const SemaphoreUse> waits, std::span<const SemaphoreUse> signals) {
    // Without commands, no other stage orders the signals after the waits.
    const auto atAllStages = [](std::span<const SemaphoreUse> uses) {
        std::vector<SemaphoreUse> all(uses.begin(), uses.end());
        for (SemaphoreUse& use : all) use.stages = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
        return all;
    };
    return m_impl->SubmitBatch(*this, VK_NULL_HANDLE, atAllStages(waits), atAllStages(signals));
}

CommandList Device::RecordInto(VkCommandBuffer commands) {
    CommandList list;
    list.m_device = this;
    list.m_commands = commands;
    list.m_serial = m_impl->retired.OpenList();
    return list;
}

uint64_t Device::HandOver(CommandList&& commands) {
    if (commands.m_device != this || commands.m_pool != VK_NULL_HANDLE)
        throw Error(ErrorKind::Usage, "HandOver: the command list is not one of RecordInto");
    CommandList list = std::move(commands);
    uint64_t value = 0;
    {
        const std::scoped_lock lock(m_impl->submitMutex, m_impl->handedMutex);
        value = m_impl->lastSubmitted.load() + 1;
        m_impl->pendingInHost.insert(value);
        m_impl->lastSubmitted = value;
    }
    Recycle(list, value);
    return value;
}

void Device::Complete(uint64_t value) {
    {
        const std::lock_guard lock(m_impl->handedMutex);
        const auto node = m_impl->pendingInHost.extract(value);
        if (node.empty())
            throw MakeError(ErrorKind::Usage, "Complete({}): no pending buffer of the host has this value",
                            value);
        m_impl->completedInHost.insert(value);
    }
    CollectGarbage();
}

bool Device::Impl::IsPendingInHost(uint64_t value) const {
    const std::lock_guard lock(handedMutex);
    return pendingInHost.contains(value);
}

bool Device::Impl::IsCompletedInHost(uint64_t value) const {
    const std::lock_guard lock(handedMutex);
    return completedInHost.contains(value);
}

VkResult Device::Impl::QuerySignaled(uint64_t& value) noexcept {
    return vk.vkGetSemaphoreCounterValue(device, timeline, &value);
}

VkResult Device::Impl::QueryCompleted(uint64_t& value) noexcept {
    const VkResult result = QuerySignaled(value);
    if (result != VK_SUCCESS) return result;
    {
        const std::lock_guard lock(handedMutex);
        completedInHost.erase(completedInHost.begin(), completedInHost.upper_bound(value));
        for (const uint64_t done : completedInHost) {
            if (done != value + 1) break;
            value = done;
        }
        if (!pendingInHost.empty()) value = std::min(value, *pendingInHost.begin() - 1);
    }
    uint64_t known = lastCompleted.load();
    while (known < value && !lastCompleted.compare_exchange_weak(known, value)) {
    }
    return result;
}

uint64_t Device::CompletedValue() const {
    uint64_t value = 0;
    Check(m_impl->QueryCompleted(value), "vkGetSemaphoreCounterValue");
    return value;
}

bool Device::HasCompleted(uint64_t value) const {
    uint64_t signaled = 0;
    Check(m_impl->QuerySignaled(signaled), "vkGetSemaphoreCounterValue");
    const std::lock_guard lock(m_impl->handedMutex);
    if (m_impl->pendingInHost.contains(value)) return false;
    return value <= signaled || m_impl->completedInHost.contains(value);
}

uint64_t Device::LastSubmittedValue() const {
    return m_impl->lastSubmitted.load();
}

VkSemaphore Device::Timeline() const {
    return m_impl->timeline;
}

void Device::WaitFor(uint64_t value) {
    if (value > LastSubmittedValue())
        throw MakeError(ErrorKind::Usage, "WaitFor({}): the last submission is {}", value,
                        LastSubmittedValue());
    if (m_impl->IsPendingInHost(value))
        throw MakeError(
            ErrorKind::Usage,
            "WaitFor({}): it is in a command buffer of the host, which has not completed it (Complete)",
            value);
    const VkResult result = m_impl->IsCompletedInHost(value) ? VK_SUCCESS : m_impl->Await(value);
    if (result == VK_TIMEOUT)
        throw Error(
            ErrorKind::DeviceLost,
            Text("the device hangs: waiting for submission {}, none after {} has completed for {} ms; {}",
                 value, CompletedValue(), m_impl->hangLimit.count(), m_impl->lastPassReports->Text()),
            VK_TIMEOUT);
    Check(result, "vkWaitSemaphores");
    CollectGarbage();
}

void Device::WaitIdle() {
    WaitFor(m_impl->lastSignaled.load());
}

VkResult Device::Present(const VkPresentInfoKHR& info) {
    const std::lock_guard lock(m_impl->submitMutex);
    m_impl->LockQueue();
    const VkResult result = m_impl->vk.vkQueuePresentKHR(m_impl->queue, &info);
    m_impl->UnlockQueue();
    return result;
}

void Device::WaitQueueIdle() {
    WaitIdle();
    const std::lock_guard lock(m_impl->submitMutex);
    m_impl->LockQueue();
    const VkResult result = m_impl->vk.vkQueueWaitIdle(m_impl->queue);
    m_impl->UnlockQueue();
    Check(result, "vkQueueWaitIdle");
}

void Device::Retire(std::function<void()> destroy) {
    m_impl->retired.Retire(std::move(destroy), m_impl->lastCompleted.load());
}

void Device::CollectGarbage() {
    m_impl->retired.Collect(CompletedValue());
}

}  // namespace raygraph::rhi
