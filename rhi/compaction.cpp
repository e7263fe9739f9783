#include "rhi/compaction.h"

#include <algorithm>
#include <iterator>

#include "base/error.h"
#include "base/text.h"
#include "rhi/build_scratch.h"
#include "rhi/command_list.h"
#include "rhi/device.h"

namespace raygraph::rhi {

Compaction::Compaction(Device& device, const BlasBuilderDesc& desc)
    : m_device(device), m_budget(desc.compactionBudget) {
    if (!desc.compacts) m_disabledReason = "not asked for";
}

Compaction::~Compaction() {
    for (Batch& batch : m_waiting) Release(batch);
}

VkQueryPool Compaction::CreatePool(size_t count) {
    if (IsOff() || count == 0) return VK_NULL_HANDLE;
    VkQueryPoolCreateInfo create{};
    create.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO;
    create.queryType = VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR;
    create.queryCount = static_cast<uint32_t>(count);
    VkQueryPool pool = VK_NULL_HANDLE;
    const VkResult result =
        m_device.Vk().vkCreateQueryPool(m_device.Handle(), &create, m_device.AllocationCallbacks(), &pool);
    if (result == VK_ERROR_OUT_OF_HOST_MEMORY || result == VK_ERROR_OUT_OF_DEVICE_MEMORY)
        return VK_NULL_HANDLE;
    m_device.Check(result, "compacted sizes: vkCreateQueryPool");
    return pool;
}

void Compaction::RecordQueries(CommandList& commands, VkQueryPool pool, std::span<const Query> queries) {
    if (!pool) return;
    Batch batch{.pool = pool};
    std::vector<VkAccelerationStructureKHR> structures;
    for (const Query& query : queries) {
        structures.push_back(query.structure);
        batch.entries.push_back({query.blas, 0});
    }
    const auto count = static_cast<uint32_t>(structures.size());
    const DeviceFunctions& vk = m_device.Vk();
    vk.vkCmdResetQueryPool(commands.Handle(), pool, 0, count);
    BarrierBetweenBuilds(commands);
    vk.vkCmdWriteAccelerationStructuresPropertiesKHR(commands.Handle(), count, structures.data(),
                                                     VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR,
                                                     pool, 0);
    batch.isCompleted = std::make_shared<std::atomic<bool>>(false);
    m_device.Retire([flag = batch.isCompleted] { flag->store(true); });
    m_waiting.push_back(std::move(batch));
}

void Compaction::Abandon(VkQueryPool pool) {
    const auto batch =
        std::find_if(m_waiting.begin(), m_waiting.end(), [&](const Batch& b) { return b.pool == pool; });
    if (batch == m_waiting.end()) return;
    Release(*batch);
    m_waiting.erase(batch);
}

bool Compaction::Poll() {
    if (!m_waiting.empty()) m_device.CollectGarbage();
    for (size_t i = 0; i < m_waiting.size();) {
        Batch& batch = m_waiting[i];
        if (!batch.isCompleted->load() || !ReadSizes(batch)) {
            ++i;
            continue;
        }
        Judge(batch);
        if (!IsOff())
            std::copy_if(batch.entries.begin(), batch.entries.end(), std::back_inserter(m_ready),
                         [&](const Entry& entry) { return IsWorthCompacting(entry); });
        Release(batch);
        m_waiting.erase(m_waiting.begin() + static_cast<std::ptrdiff_t>(i));
    }
    std::erase_if(m_ready, [](const Entry& entry) { return entry.blas.expired(); });
    std::erase_if(m_slice, [](const Reserved& entry) { return entry.blas.expired(); });
    if (m_slice.empty()) ReserveSlice();
    return !m_slice.empty();
}

bool Compaction::IsWorthCompacting(const Entry& entry) const {
    const std::shared_ptr<Blas> blas = entry.blas.lock();
    return blas && entry.bytes < blas->BytesBuilt();
}

// Reserves memory for as many structures as the budget allows, at least one. If memory is short, it tries
// again later: the larger structures can be used in the meantime.
void Compaction::ReserveSlice() {
    if (m_ready.empty()) return;
    if (m_pollsToRetry > 0) {
        --m_pollsToRetry;
        return;
    }
    uint64_t bytes = 0;
    size_t taken = 0;
    for (; taken < m_ready.size(); ++taken) {
        const Entry& entry = m_ready[taken];
        if (taken > 0 && (bytes >= m_budget || entry.bytes > m_budget - bytes)) break;
        bytes += entry.bytes;
    }
    std::vector<Reserved> slice;
    size_t done = 0;
    try {
        for (; done < taken; ++done)
            if (const std::shared_ptr<Blas> blas = m_ready[done].blas.lock())
                slice.push_back({blas, AccelerationStructure(m_device, blas->Name(),
                                                             VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                                                             m_ready[done].bytes)});
    } catch (const Error& error) {
        if (error.Kind() != ErrorKind::OutOfMemory) throw;
        m_pollsToRetry = BlasBuilder::kRetryPolls - 1;
        if (!m_hasRunOut)
            Say(m_device.Log(), LogLevel::Info, log_category::kGeometry,
                "BLAS compaction waits for memory: {}", error.what());
        m_hasRunOut = true;
        // The structures with memory are kept: each of them frees some of its own when it has been copied
        taken = done;
    }
    m_slice = std::move(slice);
    m_ready.erase(m_ready.begin(), m_ready.begin() + static_cast<std::ptrdiff_t>(taken));
}

bool Compaction::ReadSizes(Batch& batch) {
    std::vector<uint64_t> sizes(batch.entries.size());
    const VkResult result = m_device.Vk().vkGetQueryPoolResults(
        m_device.Handle(), batch.pool, 0, static_cast<uint32_t>(sizes.size()),
        sizes.size() * sizeof(uint64_t), sizes.data(), sizeof(uint64_t), VK_QUERY_RESULT_64_BIT);
    if (result == VK_NOT_READY) return false;
    m_device.Check(result, "compacted sizes: vkGetQueryPoolResults");
    for (size_t i = 0; i < sizes.size(); ++i) batch.entries[i].bytes = sizes[i];
    return true;
}

// The first batch shows whether compaction saves anything with this driver.
void Compaction::Judge(const Batch& batch) {
    if (m_isJudged || IsOff()) return;
    uint64_t built = 0;
    uint64_t compacted = 0;
    for (const Entry& entry : batch.entries) {
        const std::shared_ptr<Blas> blas = entry.blas.lock();
        if (!blas) continue;
        built += blas->BytesBuilt();
        compacted += entry.bytes;
    }
    if (built == 0) return;  // all of them were dropped, so that the next batch decides
    m_isJudged = true;
    if (compacted < built - built / 2000) return;  // below 1.000 when written with three decimals
    m_disabledReason =
        Text("{} gains nothing by it: {} bytes after, {} before", m_device.Info().name, compacted, built);
    Say(m_device.Log(), LogLevel::Info, log_category::kGeometry, "BLAS compaction is off: {}",
        m_disabledReason);
}

std::vector<Compaction::Ready> Compaction::TakeSlice() {
    std::vector<Ready> slice;
    for (Reserved& entry : m_slice)
        if (std::shared_ptr<Blas> blas = entry.blas.lock())
            slice.push_back({std::move(blas), std::move(entry.structure)});
    m_slice.clear();
    return slice;
}

void Compaction::Requeue(std::span<const Ready> slice) {
    for (const Ready& ready : slice) m_ready.push_back({ready.blas, ready.structure.Bytes()});
}

uint32_t Compaction::PendingCount() const {
    auto live = [](const auto& entries) {
        return static_cast<uint32_t>(std::count_if(entries.begin(), entries.end(),
                                                   [](const auto& entry) { return !entry.blas.expired(); }));
    };
    uint32_t count = live(m_ready) + live(m_slice);
    for (const Batch& batch : m_waiting) count += live(batch.entries);
    return IsOff() ? 0 : count;
}

void Compaction::Release(Batch& batch) {
    m_device.Retire([&device = m_device, pool = batch.pool] {
        device.Vk().vkDestroyQueryPool(device.Handle(), pool, device.AllocationCallbacks());
    });
    batch.pool = VK_NULL_HANDLE;
}

}  // namespace raygraph::rhi
