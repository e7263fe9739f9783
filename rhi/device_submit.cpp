// The timelines: submission of command lists, and destruction of objects when the timelines have passed their
// last use.
#include <algorithm>
#include <array>
#include <memory_resource>
#include <utility>
#include <vector>

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

CommandList Device::BeginCommands(const std::string& name, QueueKind queue) {
    if (!HasQueue(queue))
        throw MakeError(ErrorKind::Usage, "command list '{}': the device has no such queue", name);
    const DeviceFunctions& vk = m_impl->vk;
    // The text is made only for an error, since every frame comes here.
    const auto check = [&](VkResult result, const char* call) {
        if (result != VK_SUCCESS) Check(result, "command list '" + name + "': " + call);
    };
    CommandSlot slot;
    {
        const std::lock_guard lock(m_impl->slotMutex);
        auto& slots = m_impl->slots;
        const uint64_t completed = slots.empty() ? 0 : CompletedValue(queue);
        const auto free = std::find_if(slots.begin(), slots.end(), [&](const CommandSlot& s) {
            return s.until.queue == queue && s.until.value <= completed;
        });
        if (free != slots.end()) {
            slot = *free;
            slots.erase(free);
        }
    }
    if (slot.pool) {
        const VkResult result = vk.vkResetCommandPool(Handle(), slot.pool, 0);
        if (result != VK_SUCCESS) vk.vkDestroyCommandPool(Handle(), slot.pool, AllocationCallbacks());
        check(result, "vkResetCommandPool");
    } else {
        VkCommandPoolCreateInfo poolInfo{};
        poolInfo.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
        poolInfo.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT;
        poolInfo.queueFamilyIndex = QueueFamily(queue);
        check(vk.vkCreateCommandPool(Handle(), &poolInfo, AllocationCallbacks(), &slot.pool),
              "vkCreateCommandPool");
        VkCommandBufferAllocateInfo allocate{};
        allocate.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
        allocate.commandPool = slot.pool;
        allocate.commandBufferCount = 1;
        const VkResult result = vk.vkAllocateCommandBuffers(Handle(), &allocate, &slot.commands);
        if (result != VK_SUCCESS) vk.vkDestroyCommandPool(Handle(), slot.pool, AllocationCallbacks());
        check(result, "vkAllocateCommandBuffers");
    }
    CommandList list;
    list.m_device = this;
    list.m_queue = queue;
    list.m_commands = slot.commands;
    list.m_pool = slot.pool;
    list.m_serial = m_impl->retired.OpenList();
    SetName(VK_OBJECT_TYPE_COMMAND_BUFFER, reinterpret_cast<uint64_t>(slot.commands), name);
    VkCommandBufferBeginInfo begin{};
    begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    check(vk.vkBeginCommandBuffer(slot.commands, &begin), "vkBeginCommandBuffer");
    return list;
}

// Moves the Vulkan objects out of the list for reuse once the submission has completed (value 0: at once,
// since the list was not submitted), and runs the callbacks for its outcome.
void Device::Recycle(CommandList& commands, const Submission& submission) noexcept {
    if (commands.m_pool != VK_NULL_HANDLE) {
        const std::lock_guard lock(m_impl->slotMutex);
        m_impl->slots.push_back({commands.m_pool, commands.m_commands, {submission.value, commands.m_queue}});
    }
    m_impl->retired.CloseList(commands.m_serial, submission);
    commands.m_device = nullptr;
    commands.m_commands = VK_NULL_HANDLE;
    commands.m_pool = VK_NULL_HANDLE;
    // Either may retire its captures: the list is closed, so that nothing waits for it in vain.
    const std::vector<std::function<void()>> onSubmitted = std::exchange(commands.m_onSubmitted, {});
    const std::vector<std::function<void()>> onDropped = std::exchange(commands.m_onDropped, {});
    if (submission)
        for (const std::function<void()>& run : onSubmitted) run();
    else
        for (auto undo = onDropped.rbegin(); undo != onDropped.rend(); ++undo) (*undo)();
    // Memory may be exhausted by what the list kept alive: free that without waiting for a submission.
    if (!submission) m_impl->retired.Collect(m_impl->LastCompleted());
}

// Submits one batch, with or without commands, that advances the queue's timeline.
Submission Device::Impl::SubmitBatch(const Device& owner, QueueKind queue, VkCommandBuffer commands,
                                     std::span<const SemaphoreUse> waits,
                                     std::span<const SemaphoreUse> signals) {
    std::array<std::byte, 2048> buffered;  // enough for most, so that a frame allocates nothing here
    std::pmr::monotonic_buffer_resource infoMemory(buffered.data(), buffered.size());
    std::pmr::vector<VkSemaphoreSubmitInfo> waitInfos(&infoMemory), signalInfos(&infoMemory);
    waitInfos.reserve(waits.size() + 1);
    for (const SemaphoreUse& use : waits) waitInfos.push_back(SubmitInfo(use));
    QueueState& state = Queue(queue);
    for (const SemaphoreUse& use : signals) signalInfos.push_back(SubmitInfo(use));
    signalInfos.push_back(SubmitInfo({state.timeline, 0}));
    VkCommandBufferSubmitInfo buffer{};
    buffer.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO;
    buffer.commandBuffer = commands;
    VkSubmitInfo2 batch{};
    batch.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2;
    batch.commandBufferInfoCount = commands ? 1 : 0;
    batch.pCommandBufferInfos = &buffer;
    batch.signalSemaphoreInfoCount = static_cast<uint32_t>(signalInfos.size());
    batch.pSignalSemaphoreInfos = signalInfos.data();

    const std::lock_guard lock(submitMutex);
    const QueueState& transfers = Queue(QueueKind::Transfer);
    const uint64_t transferred = queue == QueueKind::Transfer ? 0 : transfers.lastSubmitted.load();
    if (transferred > state.joinedTransfers)
        waitInfos.push_back(SubmitInfo({transfers.timeline, transferred}));
    batch.waitSemaphoreInfoCount = static_cast<uint32_t>(waitInfos.size());
    batch.pWaitSemaphoreInfos = waitInfos.data();
    const uint64_t value = state.lastSubmitted.load() + 1;
    signalInfos.back().value = value;
    LockQueues();
    const VkResult result = vk.vkQueueSubmit2(state.queue, 1, &batch, VK_NULL_HANDLE);
    UnlockQueues();
    owner.Check(result, "vkQueueSubmit2");
    state.lastSubmitted = value;
    state.lastSignaled = value;
    state.joinedTransfers = std::max(state.joinedTransfers, transferred);
    return {value, queue};
}

Submission Device::Submit(CommandList&& commands, std::span<const SemaphoreUse> waits,
                          std::span<const SemaphoreUse> signals) {
    if (commands.m_device != this)
        throw Error(ErrorKind::Usage, "Submit: the command list is empty or of another device");
    if (commands.m_pool == VK_NULL_HANDLE)
        throw Error(ErrorKind::Usage, "Submit: the command list is a buffer of the host's (HandOver)");
    CommandList list = std::move(commands);  // dropped if anything below throws
    Check(m_impl->vk.vkEndCommandBuffer(list.Handle()), "vkEndCommandBuffer");

    const Submission submission = m_impl->SubmitBatch(*this, list.Queue(), list.Handle(), waits, signals);
    Recycle(list, submission);
    // The commands have been submitted, and an Error here would mean that they have not. The next wait
    // reports a device that does not respond.
    QueueValues completed{};
    if (m_impl->QueryCompleted(completed) == VK_SUCCESS) m_impl->retired.Collect(completed);
    return submission;
}

Submission Device::Forward(std::span<const SemaphoreUse> waits, std::span<const SemaphoreUse> signals) {
    // Without commands, no other stage orders the signals after the waits.
    const auto atAllStages = [](std::span<const SemaphoreUse> uses) {
        std::vector<SemaphoreUse> all(uses.begin(), uses.end());
        for (SemaphoreUse& use : all) use.stages = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
        return all;
    };
    return m_impl->SubmitBatch(*this, QueueKind::Main, VK_NULL_HANDLE, atAllStages(waits),
                               atAllStages(signals));
}

void Device::JoinTransfers() {
    // A submission waits for them even without commands, and with it all that is submitted later.
    const uint64_t transferred = LastSubmittedValue(QueueKind::Transfer);
    const auto isJoined = [&] {
        const std::lock_guard lock(m_impl->submitMutex);
        return transferred <= m_impl->Queue(QueueKind::Main).joinedTransfers;
    };
    if (!isJoined()) Forward({}, {});
}

CommandList Device::RecordInto(VkCommandBuffer commands) {
    CommandList list;
    list.m_device = this;
    list.m_commands = commands;
    list.m_serial = m_impl->retired.OpenList();
    return list;
}

Submission Device::HandOver(CommandList&& commands) {
    if (commands.m_device != this || commands.m_pool != VK_NULL_HANDLE)
        throw Error(ErrorKind::Usage, "HandOver: the command list is not one of RecordInto");
    CommandList list = std::move(commands);
    Submission submission;
    {
        const std::scoped_lock lock(m_impl->submitMutex, m_impl->handedMutex);
        std::atomic<uint64_t>& last = m_impl->Queue(QueueKind::Main).lastSubmitted;
        submission.value = last.load() + 1;
        m_impl->pendingInHost.insert(submission.value);
        last = submission.value;
    }
    Recycle(list, submission);
    return submission;
}

void Device::Complete(const Submission& submission) {
    {
        const std::lock_guard lock(m_impl->handedMutex);
        const bool isMain = submission.queue == QueueKind::Main;
        const auto node = m_impl->pendingInHost.extract(isMain ? submission.value : 0);
        if (node.empty())
            throw MakeError(ErrorKind::Usage, "Complete({}): no pending buffer of the host has this value",
                            submission.value);
        m_impl->completedInHost.insert(submission.value);
    }
    CollectGarbage();
}

bool Device::Impl::IsPendingInHost(const Submission& submission) const {
    const std::lock_guard lock(handedMutex);
    return submission.queue == QueueKind::Main && pendingInHost.contains(submission.value);
}

bool Device::Impl::IsCompletedInHost(const Submission& submission) const {
    const std::lock_guard lock(handedMutex);
    return submission.queue == QueueKind::Main && completedInHost.contains(submission.value);
}

VkResult Device::Impl::QuerySignaled(QueueKind queue, uint64_t& value) noexcept {
    return vk.vkGetSemaphoreCounterValue(device, Queue(queue).timeline, &value);
}

VkResult Device::Impl::QueryProgress(uint64_t& sum) noexcept {
    sum = 0;
    for (const QueueKind queue : kQueueKinds) {
        if (!Queue(queue).timeline) continue;
        uint64_t value = 0;
        if (const VkResult result = QuerySignaled(queue, value); result != VK_SUCCESS) return result;
        sum += value;
    }
    return VK_SUCCESS;
}

VkResult Device::Impl::QueryCompleted(QueueKind queue, uint64_t& value) noexcept {
    const VkResult result = QuerySignaled(queue, value);
    if (result != VK_SUCCESS) return result;
    if (queue == QueueKind::Main) {
        const std::lock_guard lock(handedMutex);
        completedInHost.erase(completedInHost.begin(), completedInHost.upper_bound(value));
        for (const uint64_t done : completedInHost) {
            if (done != value + 1) break;
            value = done;
        }
        if (!pendingInHost.empty()) value = std::min(value, *pendingInHost.begin() - 1);
    }
    std::atomic<uint64_t>& last = Queue(queue).lastCompleted;
    uint64_t known = last.load();
    while (known < value && !last.compare_exchange_weak(known, value)) {
    }
    return result;
}

VkResult Device::Impl::QueryCompleted(QueueValues& values) noexcept {
    values = {};
    for (const QueueKind queue : kQueueKinds) {
        if (!Queue(queue).isUsed) continue;
        const VkResult result = QueryCompleted(queue, values[IndexOf(queue)]);
        if (result != VK_SUCCESS) return result;
    }
    return VK_SUCCESS;
}

QueueValues Device::Impl::LastCompleted() const {
    QueueValues values{};
    for (const QueueKind queue : kQueueKinds) values[IndexOf(queue)] = Queue(queue).lastCompleted.load();
    return values;
}

uint64_t Device::CompletedValue(QueueKind queue) const {
    if (!HasQueue(queue)) return 0;
    uint64_t value = 0;
    Check(m_impl->QueryCompleted(queue, value), "vkGetSemaphoreCounterValue");
    return value;
}

bool Device::HasCompleted(const Submission& submission) const {
    if (!submission) return true;
    uint64_t signaled = 0;
    Check(m_impl->QuerySignaled(submission.queue, signaled), "vkGetSemaphoreCounterValue");
    if (m_impl->IsPendingInHost(submission)) return false;
    return submission.value <= signaled || m_impl->IsCompletedInHost(submission);
}

uint64_t Device::LastSubmittedValue(QueueKind queue) const {
    return m_impl->Queue(queue).lastSubmitted.load();
}

VkSemaphore Device::Timeline(QueueKind queue) const {
    return m_impl->Queue(queue).timeline;
}

SemaphoreUse Device::After(const Submission& submission) const {
    return {.semaphore = Timeline(submission.queue), .value = submission.value};
}

void Device::WaitFor(const Submission& submission) {
    if (submission.value > LastSubmittedValue(submission.queue))
        throw MakeError(ErrorKind::Usage, "WaitFor({}): the last submission is {}", submission.value,
                        LastSubmittedValue(submission.queue));
    if (m_impl->IsPendingInHost(submission))
        throw MakeError(
            ErrorKind::Usage,
            "WaitFor({}): it is in a command buffer of the host, which has not completed it (Complete)",
            submission.value);
    const bool isDone = !submission || m_impl->IsCompletedInHost(submission);
    const VkResult result = isDone ? VK_SUCCESS : m_impl->Await(submission);
    if (result == VK_TIMEOUT)
        throw Error(ErrorKind::DeviceLost,
                    Text("the device hangs: waiting for submission {}, none after {} has completed for {} "
                         "ms; {}",
                         submission.value, CompletedValue(submission.queue), m_impl->hangLimit.count(),
                         m_impl->lastPassReports->Text()),
                    VK_TIMEOUT);
    Check(result, "vkWaitSemaphores");
    CollectGarbage();
}

void Device::WaitIdle() {
    for (const QueueKind queue : kQueueKinds) WaitFor({m_impl->Queue(queue).lastSignaled.load(), queue});
}

VkResult Device::Present(const VkPresentInfoKHR& info) {
    const std::lock_guard lock(m_impl->submitMutex);
    m_impl->LockQueues();
    const VkResult result = m_impl->vk.vkQueuePresentKHR(m_impl->Queue(QueueKind::Main).queue, &info);
    m_impl->UnlockQueues();
    return result;
}

void Device::WaitQueueIdle() {
    WaitIdle();
    const std::lock_guard lock(m_impl->submitMutex);
    m_impl->LockQueues();
    const VkResult result = m_impl->vk.vkQueueWaitIdle(m_impl->Queue(QueueKind::Main).queue);
    m_impl->UnlockQueues();
    Check(result, "vkQueueWaitIdle");
}

void Device::Retire(std::function<void()> destroy) {
    m_impl->retired.Retire(std::move(destroy), m_impl->LastCompleted());
}

void Device::CollectGarbage() {
    QueueValues completed{};
    Check(m_impl->QueryCompleted(completed), "vkGetSemaphoreCounterValue");
    m_impl->retired.Collect(completed);
}

}  // namespace raygraph::rhi
