#include "rhi/compaction.h"

#include <algorithm>

#include "rhi/build_scratch.h"
#include "rhi/command_list.h"
#include "rhi/device.h"

namespace raygraph::rhi {

Compaction::Compaction(Device& device, const BlasBuilderDesc& desc)
    : m_device(device), m_compactsWithoutGain(desc.compactsWithoutGain) {
    if (!desc.compacts) m_whyOff = "not asked for";
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
    m_device.Check(
        m_device.Vk().vkCreateQueryPool(m_device.Handle(), &create, m_device.AllocationCallbacks(), &pool),
        "compacted sizes: vkCreateQueryPool");
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

void Compaction::GiveUp(VkQueryPool pool) {
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
        if (!IsOff()) m_ready.insert(m_ready.end(), batch.entries.begin(), batch.entries.end());
        Release(batch);
        m_waiting.erase(m_waiting.begin() + static_cast<std::ptrdiff_t>(i));
    }
    std::erase_if(m_ready, [](const Entry& entry) { return entry.blas.expired(); });
    return !m_ready.empty();
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

// The first batch tells whether the driver gains anything at all.
void Compaction::Judge(const Batch& batch) {
    if (m_isJudged || m_compactsWithoutGain || IsOff()) return;
    uint64_t built = 0;
    uint64_t compacted = 0;
    for (const Entry& entry : batch.entries) {
        const std::shared_ptr<Blas> blas = entry.blas.lock();
        if (!blas) continue;
        built += blas->BytesBuilt();
        compacted += entry.bytes;
    }
    if (built == 0) return;  // all of them dropped: the next batch decides
    m_isJudged = true;
    if (compacted < built - built / 2000) return;  // below 1.000 when written with three decimals
    m_whyOff = m_device.Info().name + " gains nothing by it: " + std::to_string(compacted) +
               " bytes after, " + std::to_string(built) + " before";
    m_device.Say(MessageSeverity::Info, "BLAS compaction is off: " + m_whyOff);
}

std::vector<Compaction::Ready> Compaction::ReadyOnes() const {
    std::vector<Ready> ready;
    for (const Entry& entry : m_ready) {
        std::shared_ptr<Blas> blas = entry.blas.lock();
        if (!blas || (entry.bytes >= blas->BytesBuilt() && !m_compactsWithoutGain)) continue;
        ready.push_back({std::move(blas), entry.bytes});
    }
    return ready;
}

void Compaction::PutBack(std::span<const Ready> ready) {
    for (const Ready& entry : ready) m_ready.push_back({entry.blas, entry.bytes});
}

uint32_t Compaction::PendingCount() const {
    auto live = [](const std::vector<Entry>& entries) {
        return static_cast<uint32_t>(std::count_if(entries.begin(), entries.end(),
                                                   [](const Entry& entry) { return !entry.blas.expired(); }));
    };
    uint32_t count = live(m_ready);
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
