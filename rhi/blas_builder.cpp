#include "rhi/blas_builder.h"

#include <algorithm>

#include "base/check.h"
#include "base/error.h"
#include "rhi/blas_geometry.h"
#include "rhi/build_scratch.h"
#include "rhi/command_list.h"
#include "rhi/compaction.h"
#include "rhi/device.h"

namespace raygraph::rhi {
struct BlasBuilder::Impl {
    Impl(Device& owner, const BlasBuilderDesc& builderDesc)
        : device(owner), desc(builderDesc), compaction(owner, builderDesc) {}

    VkBuildAccelerationStructureFlagsKHR FlagsFor(BlasKind kind) const {
        if (kind == BlasKind::Deforming)
            return VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR |
                   VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR;
        VkBuildAccelerationStructureFlagsKHR flags =
            VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR;
        if (!compaction.IsOff()) flags |= VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR;
        return flags;
    }

    // Builds or updates of one call, before their batches are known.
    struct Steps {
        std::vector<std::unique_ptr<BlasGeometry>> geometries;
        std::vector<uint64_t> scratchShares;

        BlasGeometry& Add(std::unique_ptr<BlasGeometry> geometry, uint64_t scratchShare) {
            scratchShares.push_back(scratchShare);
            return *geometries.emplace_back(std::move(geometry));
        }
    };
    void RecordBatches(CommandList& commands, Steps& steps, const BatchPlan& plan,
                       const BuildScratch& scratch);

    Device& device;
    BlasBuilderDesc desc;
    Compaction compaction;
    std::vector<std::weak_ptr<Blas>> added;  // waiting for their build
    std::vector<std::weak_ptr<Blas>> built;
    BuildScratch refitScratch;  // grows; deformation comes every frame
    uint32_t buildCount = 0;
    uint32_t batchCount = 0;
    uint32_t refitCount = 0;
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
            RG_CHECK_LE(plan.offsets[i] + steps.scratchShares[i], scratch.Bytes());
            steps.geometries[i]->Info().scratchData.deviceAddress = address;
            infos.push_back(steps.geometries[i]->Info());
            ranges.push_back(steps.geometries[i]->Ranges());
        }
        device.Vk().vkCmdBuildAccelerationStructuresKHR(
            commands.Handle(), static_cast<uint32_t>(infos.size()), infos.data(), ranges.data());
    }
}

BlasBuilder::BlasBuilder(Device& device, const BlasBuilderDesc& desc)
    : m_impl(std::make_unique<Impl>(device, desc)) {}

BlasBuilder::~BlasBuilder() = default;

std::shared_ptr<Blas> BlasBuilder::Add(const BlasDesc& desc) {
    CheckBuildable(desc);
    auto blas = std::make_shared<Blas>();
    blas->m_desc = desc;
    m_impl->added.push_back(blas);
    return blas;
}

void BlasBuilder::RecordBuilds(CommandList& commands) {
    Impl& impl = *m_impl;
    std::vector<std::shared_ptr<Blas>> blases;
    Impl::Steps steps;
    for (const std::weak_ptr<Blas>& added : impl.added) {
        std::shared_ptr<Blas> blas = added.lock();
        if (!blas) continue;
        blas->m_flags = impl.FlagsFor(blas->Kind());
        auto geometry = std::make_unique<BlasGeometry>(blas->m_desc, blas->m_flags);
        const VkAccelerationStructureBuildSizesInfoKHR sizes = geometry->Sizes(impl.device);
        blas->m_structure =
            AccelerationStructure(impl.device, blas->Name(), VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                                  sizes.accelerationStructureSize);
        blas->m_bytesBuilt = sizes.accelerationStructureSize;
        blas->m_updateScratch = sizes.updateScratchSize;
        ++blas->m_version;
        geometry->Info().dstAccelerationStructure = blas->Handle();
        steps.Add(std::move(geometry), ScratchShare(impl.device, sizes.buildScratchSize));
        blases.push_back(std::move(blas));
    }
    impl.added.clear();
    if (blases.empty()) return;

    const BatchPlan plan = PlanBatches(steps.scratchShares, impl.desc.scratchBudget);
    const BuildScratch scratch(impl.device, impl.desc.name, plan.scratchBytes);
    impl.RecordBatches(commands, steps, plan, scratch);
    impl.buildCount += static_cast<uint32_t>(blases.size());
    impl.batchCount += static_cast<uint32_t>(plan.batches.size());
    impl.built.insert(impl.built.end(), blases.begin(), blases.end());

    std::erase_if(blases, [](const auto& blas) { return blas->Kind() != BlasKind::Static; });
    impl.compaction.RecordQueries(commands, blases);
}

bool BlasBuilder::Poll() {
    return m_impl->compaction.Poll();
}

void BlasBuilder::RecordCompaction(CommandList& commands) {
    BarrierBetweenBuilds(commands);  // the copies read what builds wrote
    for (Compaction::Ready& ready : m_impl->compaction.TakeReady()) {
        AccelerationStructure compacted(m_impl->device, ready.blas->Name(),
                                        VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, ready.bytes);
        VkCopyAccelerationStructureInfoKHR copy{};
        copy.sType = VK_STRUCTURE_TYPE_COPY_ACCELERATION_STRUCTURE_INFO_KHR;
        copy.src = ready.blas->Handle();
        copy.dst = compacted.Handle();
        copy.mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR;
        m_impl->device.Vk().vkCmdCopyAccelerationStructureKHR(commands.Handle(), &copy);
        ready.blas->m_structure = std::move(compacted);
        ready.blas->m_isCompacted = true;
        ++ready.blas->m_version;
    }
}

void BlasBuilder::RecordRefits(CommandList& commands, std::span<const RefitRequest> requests) {
    Impl& impl = *m_impl;
    for (size_t i = 0; i < requests.size(); ++i) {
        const Blas* blas = requests[i].blas;
        if (!blas || !blas->IsBuilt())
            throw Error(ErrorKind::Usage, "BLAS '" + requests[i].desc.name + "': update before its build");
        CheckUpdatable(blas->Desc(), requests[i].desc);
        for (size_t k = 0; k < i; ++k)
            if (requests[k].blas == blas)
                throw Error(ErrorKind::Usage, "BLAS '" + blas->Name() + "': updated twice in one call");
    }
    if (requests.empty()) return;

    Impl::Steps steps;
    for (const RefitRequest& request : requests) {
        auto& info = steps
                         .Add(std::make_unique<BlasGeometry>(request.desc, request.blas->m_flags),
                              ScratchShare(impl.device, request.blas->m_updateScratch))
                         .Info();
        info.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
        info.srcAccelerationStructure = request.blas->Handle();
        info.dstAccelerationStructure = request.blas->Handle();
    }
    const BatchPlan plan = PlanBatches(steps.scratchShares, impl.desc.scratchBudget);
    if (impl.refitScratch.Bytes() < plan.scratchBytes)
        impl.refitScratch = BuildScratch(impl.device, impl.desc.name + " refit", plan.scratchBytes);
    impl.RecordBatches(commands, steps, plan, impl.refitScratch);
    impl.refitCount += static_cast<uint32_t>(requests.size());
}

CompactionStatistics BlasBuilder::Statistics() const {
    Impl& impl = *m_impl;
    std::erase_if(impl.built, [](const auto& blas) { return blas.expired(); });
    CompactionStatistics statistics;
    for (const std::weak_ptr<Blas>& built : impl.built) {
        const std::shared_ptr<Blas> blas = built.lock();
        ++statistics.blasCount;
        statistics.bytesBuilt += blas->BytesBuilt();
        statistics.bytesCompacted += blas->Bytes();
    }
    statistics.pending = impl.compaction.PendingCount();
    statistics.buildCount = impl.buildCount;
    statistics.batchCount = impl.batchCount;
    statistics.refitCount = impl.refitCount;
    statistics.isOff = impl.compaction.IsOff();
    statistics.whyOff = impl.compaction.WhyOff();
    return statistics;
}

}  // namespace raygraph::rhi
