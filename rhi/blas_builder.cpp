#include "rhi/blas_builder.h"

#include <algorithm>
#include <utility>

#include "base/check.h"
#include "base/error.h"
#include "base/text.h"
#include "rhi/blas_build.h"
#include "rhi/command_list.h"
#include "rhi/device.h"

namespace raygraph::rhi {
namespace {

const BlasDesc& DescOf(const BlasBuilder::RefitRequest& request) {
    return request.desc ? *request.desc : request.blas->Desc();
}

}  // namespace

struct BlasBuilder::Impl {
    Impl(Device& owner, const BlasBuilderDesc& builderDesc)
        : device(owner), desc(builderDesc), compaction(owner, builderDesc) {}

    VkBuildAccelerationStructureFlagsKHR FlagsFor(BlasKind kind) const {
        VkBuildAccelerationStructureFlagsKHR flags =
            VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR;
        if (kind == BlasKind::Deforming)
            flags |= VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR;
        else if (!compaction.IsOff())
            flags |= VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR;
        return flags;
    }

    // Builds or updates of one call, before their batches are known.
    struct Steps {
        std::vector<std::unique_ptr<BlasGeometry>> geometries;
        std::vector<uint64_t> scratchSizes;

        BlasGeometry& Add(std::unique_ptr<BlasGeometry> geometry, uint64_t scratchSize) {
            scratchSizes.push_back(scratchSize);
            return *geometries.emplace_back(std::move(geometry));
        }
    };
    // Allocates the memory for the builds of all added BLASes, and returns these BLASes.
    std::vector<std::shared_ptr<Blas>> Reserve();
    void Trim() noexcept {
        std::erase_if(deforming, [](const std::weak_ptr<Blas>& blas) { return blas.expired(); });
        if (deforming.empty()) refitScratch = {};
    }
    uint64_t RefitScratchSize(const Blas& blas, bool rebuilds) const {
        return AlignedScratchSize(device, rebuilds ? blas.m_buildScratch : blas.m_updateScratch);
    }
    void MarkBuilt(const std::vector<std::weak_ptr<Blas>>& blases, uint32_t newBatchCount);
    void RecordBatches(CommandList& commands, Steps& steps, const BatchPlan& plan,
                       const BuildScratch& scratch);

    Device& device;
    BlasBuilderDesc desc;
    Compaction compaction;
    std::vector<std::weak_ptr<Blas>> added;  // not built yet
    std::vector<std::weak_ptr<Blas>> built;
    std::vector<std::weak_ptr<Blas>> deforming;
    BuildScratch buildScratch;  // from Reserve until the builds are submitted
    BuildScratch refitScratch;  // for the largest rebuild; kept, since deformations come in every frame
    uint32_t buildCount = 0;
    uint32_t batchCount = 0;
    uint32_t refitCount = 0;
    uint32_t rebuildCount = 0;
};

void BlasBuilder::Impl::RecordBatches(CommandList& commands, Steps& steps, const BatchPlan& plan,
                                      const BuildScratch& scratch) {
    for (const BatchPlan::Batch& batch : plan.batches) {
        BarrierBetweenBuilds(commands);  // the scratch is shared with the batch before
        std::vector<VkAccelerationStructureBuildGeometryInfoKHR> infos;
        std::vector<const VkAccelerationStructureBuildRangeInfoKHR*> ranges;
        for (size_t i = batch.first; i < batch.end; ++i) {
            const VkDeviceAddress address = scratch.Address() + plan.offsets[i];
            RG_CHECK_EQ(address % device.Info().scratchAlignment, 0u);
            RG_CHECK_LE(plan.offsets[i] + steps.scratchSizes[i], scratch.Bytes());
            steps.geometries[i]->Info().scratchData.deviceAddress = address;
            infos.push_back(steps.geometries[i]->Info());
            ranges.push_back(steps.geometries[i]->Ranges());
        }
        device.Vk().vkCmdBuildAccelerationStructuresKHR(
            commands.Handle(), static_cast<uint32_t>(infos.size()), infos.data(), ranges.data());
    }
}

BlasBuilder::BlasBuilder(Device& device, const BlasBuilderDesc& desc)
    : m_impl(std::make_shared<Impl>(device, desc)) {}

BlasBuilder::~BlasBuilder() = default;

std::shared_ptr<Blas> BlasBuilder::Add(const BlasDesc& desc) {
    CheckBuildable(desc);
    auto blas = std::make_shared<Blas>();
    blas->m_desc = desc;
    if (desc.kind == BlasKind::Deforming) m_impl->deforming.push_back(blas);
    m_impl->added.push_back(blas);
    return blas;
}

std::vector<std::shared_ptr<Blas>> BlasBuilder::Impl::Reserve() {
    Trim();
    std::erase_if(added, [](const std::weak_ptr<Blas>& blas) { return blas.expired(); });
    std::vector<std::shared_ptr<Blas>> due;
    std::vector<uint64_t> scratchSizes, updateSizes;
    uint64_t largestRebuild = 0;
    for (const std::weak_ptr<Blas>& entry : added) {
        const std::shared_ptr<Blas> blas = entry.lock();
        if (!blas) continue;
        if (!blas->m_reserved) {
            blas->m_flags = FlagsFor(blas->Kind());
            const auto sizes = BlasGeometry(blas->m_desc, blas->m_flags).Sizes(device);
            blas->m_buildScratch = sizes.buildScratchSize;
            blas->m_updateScratch = sizes.updateScratchSize;
            blas->m_reserved =
                AccelerationStructure(device, blas->Name(), VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                                      sizes.accelerationStructureSize);
        }
        scratchSizes.push_back(AlignedScratchSize(device, blas->m_buildScratch));
        if (blas->Kind() == BlasKind::Deforming) {
            updateSizes.push_back(RefitScratchSize(*blas, false));
            largestRebuild = std::max(largestRebuild, RefitScratchSize(*blas, true));
        }
        due.push_back(blas);
    }
    if (due.empty()) return due;
    const BatchPlan plan = PlanBatches(scratchSizes, desc.scratchBudget);
    // Doubles the memory, since many structures may be added one by one
    if (buildScratch.Address() == 0 || buildScratch.Bytes() < plan.scratchBytes)
        buildScratch =
            BuildScratch(device, desc.name,
                         std::max(plan.scratchBytes, std::min(2 * buildScratch.Bytes(), desc.scratchBudget)));
    const uint64_t refitBytes =
        std::max(PlanBatches(updateSizes, desc.scratchBudget).scratchBytes, largestRebuild);
    if (refitScratch.Bytes() < refitBytes)
        refitScratch = BuildScratch(device, desc.name + " refit", refitBytes);
    return due;
}

void BlasBuilder::Reserve() {
    m_impl->Reserve();
}

void BlasBuilder::Trim() noexcept {
    m_impl->Trim();
}

void BlasBuilder::RecordBuilds(CommandList& commands) {
    Impl& impl = *m_impl;
    // Everything that may fail comes first and changes no BLAS: added ones stay added until their build is
    // recorded.
    const std::vector<std::shared_ptr<Blas>> due = impl.Reserve();
    if (due.empty()) return;
    Impl::Steps steps;
    std::vector<Compaction::Query> queries;
    for (const std::shared_ptr<Blas>& blas : due) {
        auto geometry = std::make_unique<BlasGeometry>(blas->m_desc, blas->m_flags);
        geometry->Info().dstAccelerationStructure = blas->m_reserved.Handle();
        steps.Add(std::move(geometry), AlignedScratchSize(impl.device, blas->m_buildScratch));
        if (blas->Kind() == BlasKind::Static) queries.push_back({blas, blas->m_reserved.Handle()});
    }
    const BatchPlan plan = PlanBatches(steps.scratchSizes, impl.desc.scratchBudget);
    const VkQueryPool pool = impl.compaction.CreatePool(queries.size());

    impl.RecordBatches(commands, steps, plan, impl.buildScratch);
    impl.compaction.RecordQueries(commands, pool, queries);
    impl.added.clear();
    const std::vector<std::weak_ptr<Blas>> added(due.begin(), due.end());
    for (const std::shared_ptr<Blas>& blas : due) {
        blas->m_structure = std::move(blas->m_reserved);
        blas->m_bytesBuilt = blas->m_structure.Bytes();
        ++blas->m_version;
    }
    const std::weak_ptr<Impl> owner = m_impl;
    commands.OnSubmitted([owner, added, batchCount = static_cast<uint32_t>(plan.batches.size())] {
        const std::shared_ptr<Impl> known = owner.lock();
        if (!known) return;
        known->MarkBuilt(added, batchCount);
        if (known->added.empty()) known->buildScratch = {};
    });
    commands.OnDropped([owner, added, pool] {
        for (const std::weak_ptr<Blas>& entry : added)
            if (const std::shared_ptr<Blas> blas = entry.lock()) {
                blas->m_reserved = std::move(blas->m_structure);
                blas->m_bytesBuilt = 0;
                ++blas->m_version;
            }
        const std::shared_ptr<Impl> known = owner.lock();
        if (!known) return;
        known->compaction.Abandon(pool);
        known->added.insert(known->added.begin(), added.begin(), added.end());
    });
}

void BlasBuilder::Impl::MarkBuilt(const std::vector<std::weak_ptr<Blas>>& blases, uint32_t newBatchCount) {
    buildCount += static_cast<uint32_t>(blases.size());
    batchCount += newBatchCount;
    std::erase_if(built, [](const auto& blas) { return blas.expired(); });
    built.insert(built.end(), blases.begin(), blases.end());
    if (!device.Log().IsEnabled(LogLevel::Debug)) return;
    uint64_t bytes = 0;
    for (const std::weak_ptr<Blas>& entry : blases)
        if (const std::shared_ptr<Blas> blas = entry.lock()) bytes += blas->BytesBuilt();
    WriteLog(device.Log(), LogLevel::Debug, log_category::kGeometry,
             "BLASes built: {}, batches: {}, memory: {}", blases.size(), newBatchCount, BytesText(bytes));
}

bool BlasBuilder::Poll() {
    return m_impl->compaction.Poll();
}

void BlasBuilder::RecordCompaction(CommandList& commands) {
    Impl& impl = *m_impl;
    // Replaced structures are kept until the list is submitted, so that dropping it restores them.
    const auto slice = std::make_shared<std::vector<Compaction::Ready>>(impl.compaction.TakeSlice());
    if (slice->empty()) return;
    BarrierBetweenBuilds(commands);  // The copies read what builds have written
    for (Compaction::Ready& ready : *slice) {
        VkCopyAccelerationStructureInfoKHR copy{};
        copy.sType = VK_STRUCTURE_TYPE_COPY_ACCELERATION_STRUCTURE_INFO_KHR;
        copy.src = ready.blas->Handle();
        copy.dst = ready.structure.Handle();
        copy.mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR;
        impl.device.Vk().vkCmdCopyAccelerationStructureKHR(commands.Handle(), &copy);
        std::swap(ready.blas->m_structure, ready.structure);
        ready.blas->m_isCompacted = true;
        ++ready.blas->m_version;
    }
    commands.OnSubmitted([&device = impl.device, slice] {
        if (!device.Log().IsEnabled(LogLevel::Debug)) return;
        uint64_t before = 0, after = 0;
        for (const Compaction::Ready& ready : *slice) {
            before += ready.structure.Bytes();
            after += ready.blas->Bytes();
        }
        WriteLog(device.Log(), LogLevel::Debug, log_category::kGeometry,
                 "BLASes compacted: {}, from {} to {}", slice->size(), BytesText(before), BytesText(after));
    });
    commands.OnDropped([owner = std::weak_ptr<Impl>(m_impl), slice] {
        for (Compaction::Ready& ready : *slice) {
            std::swap(ready.blas->m_structure, ready.structure);
            ready.blas->m_isCompacted = false;
            ++ready.blas->m_version;
        }
        if (const std::shared_ptr<Impl> known = owner.lock()) known->compaction.Requeue(*slice);
    });
}

void BlasBuilder::RecordRefits(CommandList& commands, std::span<const RefitRequest> requests) {
    Impl& impl = *m_impl;
    std::vector<const Blas*> blases;
    for (const RefitRequest& request : requests) {
        const Blas* blas = request.blas;
        if (!blas || !blas->IsBuilt())
            throw MakeError(ErrorKind::Usage, "BLAS '{}': update before its build", blas ? blas->Name() : "");
        CheckUpdatable(blas->Desc(), DescOf(request));
        blases.push_back(blas);
    }
    std::ranges::sort(blases);
    if (const auto twice = std::ranges::adjacent_find(blases); twice != blases.end())
        throw MakeError(ErrorKind::Usage, "BLAS '{}': updated twice in one call", (*twice)->Name());
    if (requests.empty()) return;

    Impl::Steps steps;
    uint32_t rebuildCount = 0;
    for (const RefitRequest& request : requests) {
        auto& info = steps
                         .Add(std::make_unique<BlasGeometry>(DescOf(request), request.blas->m_flags),
                              impl.RefitScratchSize(*request.blas, request.rebuilds))
                         .Info();
        info.dstAccelerationStructure = request.blas->Handle();
        if (request.rebuilds) {
            ++rebuildCount;
            continue;
        }
        info.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
        info.srcAccelerationStructure = request.blas->Handle();
    }
    const BatchPlan plan = PlanBatches(steps.scratchSizes, impl.refitScratch.Bytes());
    impl.RecordBatches(commands, steps, plan, impl.refitScratch);
    const uint32_t refitCount = static_cast<uint32_t>(requests.size()) - rebuildCount;
    commands.OnSubmitted([owner = std::weak_ptr<Impl>(m_impl), refitCount, rebuildCount] {
        const std::shared_ptr<Impl> known = owner.lock();
        if (!known) return;
        known->refitCount += refitCount;
        known->rebuildCount += rebuildCount;
    });
}

CompactionStatistics BlasBuilder::Statistics() const {
    const Impl& impl = *m_impl;
    CompactionStatistics statistics;
    for (const std::weak_ptr<Blas>& built : impl.built) {
        const std::shared_ptr<Blas> blas = built.lock();
        if (!blas) continue;
        ++statistics.blasCount;
        statistics.bytesBuilt += blas->BytesBuilt();
        statistics.bytesCompacted += blas->Bytes();
    }
    statistics.pending = impl.compaction.PendingCount();
    statistics.buildCount = impl.buildCount;
    statistics.batchCount = impl.batchCount;
    statistics.refitCount = impl.refitCount;
    statistics.rebuildCount = impl.rebuildCount;
    statistics.isOff = impl.compaction.IsOff();
    statistics.disabledReason = impl.compaction.DisabledReason();
    return statistics;
}

}  // namespace raygraph::rhi
