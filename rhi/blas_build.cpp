#include "rhi/blas_build.h"

#include <algorithm>
#include <iterator>

#include "base/check.h"
#include "base/error.h"
#include "base/text.h"
#include "rhi/command_list.h"
#include "rhi/device.h"
#include "rhi/shader_binding_table.h"

namespace raygraph::rhi {

BuildScratch::BuildScratch(Device& device, const std::string& name, uint64_t bytes) : m_bytes(bytes) {
    const uint64_t alignment = device.Info().scratchAlignment;
    m_buffer = device.CreateBuffer({.name = name + " scratch",
                                    .size = bytes + alignment,
                                    .usage = BufferUsage::Storage,
                                    .memory = MemoryKind::Device});
    m_address = AlignUp(m_buffer.Address(), alignment);
    RG_CHECK_EQ(m_address % alignment, 0u);
    RG_CHECK_LE(m_address + bytes, m_buffer.Address() + m_buffer.Size());
}

uint64_t AlignedScratchSize(const Device& device, uint64_t bytes) {
    return AlignUp(bytes, device.Info().scratchAlignment);
}

BatchPlan PlanBatches(std::span<const uint64_t> scratchSizes, uint64_t budget) {
    BatchPlan plan;
    for (size_t first = 0; first < scratchSizes.size();) {
        size_t end = first;
        uint64_t bytes = 0;
        while (end < scratchSizes.size() && (end == first || bytes + scratchSizes[end] <= budget)) {
            plan.offsets.push_back(bytes);
            bytes += scratchSizes[end++];
        }
        plan.batches.push_back({first, end});
        plan.scratchBytes = std::max(plan.scratchBytes, bytes);
        first = end;
    }
    return plan;
}

void BarrierBetweenBuilds(CommandList& commands) {
    VkMemoryBarrier2 barrier{};
    barrier.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2;
    barrier.srcStageMask = VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_BUILD_BIT_KHR;
    barrier.srcAccessMask =
        VK_ACCESS_2_ACCELERATION_STRUCTURE_READ_BIT_KHR | VK_ACCESS_2_ACCELERATION_STRUCTURE_WRITE_BIT_KHR;
    barrier.dstStageMask = barrier.srcStageMask;
    barrier.dstAccessMask = barrier.srcAccessMask;
    commands.Barriers({&barrier, 1}, {});
}

// --- The Vulkan structures of a BlasDesc, and their checks ---

namespace {

// The count that every device supports: maxPrimitiveCount is at least this.
constexpr uint64_t kMaxPrimitives = (uint64_t{1} << 29) - 1;

template <typename... Values>
[[noreturn]] void Fail(const BlasDesc& desc, fmt::format_string<Values...> format, Values&&... values) {
    throw MakeError(ErrorKind::Usage, "BLAS '{}': {}", desc.name,
                    Text(format, std::forward<Values>(values)...));
}

std::string At(const char* list, size_t index) {
    return Text("{}[{}]", list, index);
}

void CheckSame(const BlasDesc& desc, const std::string& what, uint64_t built, uint64_t next) {
    if (built == next) return;
    Fail(desc, "update changes {} from {} to {}", what, built, next);
}

void CheckAddress(const BlasDesc& desc, const std::string& what, VkDeviceAddress address,
                  uint64_t alignment) {
    if (address == 0) Fail(desc, "{} is null", what);
    if (address % alignment != 0) Fail(desc, "{} is not a multiple of {}", what, alignment);
}

VkGeometryFlagsKHR FlagsOf(bool isOpaque, bool noDuplicateAnyHit) {
    VkGeometryFlagsKHR flags = 0;
    if (isOpaque) flags |= VK_GEOMETRY_OPAQUE_BIT_KHR;
    if (noDuplicateAnyHit) flags |= VK_GEOMETRY_NO_DUPLICATE_ANY_HIT_INVOCATION_BIT_KHR;
    return flags;
}

}  // namespace

void CheckBuildable(const BlasDesc& desc) {
    if (desc.triangles.empty() == desc.aabbs.empty())
        Fail(desc, "{}", desc.triangles.empty() ? "has no geometry" : "has both triangles and AABBs");
    uint64_t primitiveCount = 0;
    for (size_t i = 0; i < desc.triangles.size(); ++i) {
        const TriangleGeometry& g = desc.triangles[i];
        const std::string name = At("triangles", i);
        if (g.triangleCount == 0 || g.vertexCount == 0) Fail(desc, "{} is empty", name);
        CheckAddress(desc, name + ".vertices", g.vertices, sizeof(float));
        CheckAddress(desc, name + ".indices", g.indices, sizeof(uint32_t));
        if (g.vertexStride % sizeof(float) != 0 || g.vertexStride < 3 * sizeof(float))
            Fail(desc, "{}.vertexStride is {}, not a multiple of 4 from 12 up", name, g.vertexStride);
        primitiveCount += g.triangleCount;
    }
    for (size_t i = 0; i < desc.aabbs.size(); ++i) {
        const std::string name = At("aabbs", i);
        if (desc.aabbs[i].boxCount == 0) Fail(desc, "{} is empty", name);
        CheckAddress(desc, name + ".boxes", desc.aabbs[i].boxes, 8);
        primitiveCount += desc.aabbs[i].boxCount;
    }
    if (primitiveCount > kMaxPrimitives)
        Fail(desc, "has {} primitives, at most {} can be built", primitiveCount, kMaxPrimitives);
}

void CheckUpdatable(const BlasDesc& built, const BlasDesc& next) {
    CheckBuildable(next);
    if (built.kind != BlasKind::Deforming || next.kind != BlasKind::Deforming)
        Fail(built, "update of a Static one; only a Deforming one can be updated");
    CheckSame(built, "triangles.size()", built.triangles.size(), next.triangles.size());
    CheckSame(built, "aabbs.size()", built.aabbs.size(), next.aabbs.size());
    for (size_t i = 0; i < built.triangles.size(); ++i) {
        const TriangleGeometry& a = built.triangles[i];
        const TriangleGeometry& b = next.triangles[i];
        const std::string name = At("triangles", i);
        CheckSame(built, name + ".triangleCount", a.triangleCount, b.triangleCount);
        CheckSame(built, name + ".vertexCount", a.vertexCount, b.vertexCount);
        CheckSame(built, name + ".isOpaque", a.isOpaque, b.isOpaque);
        CheckSame(built, name + ".noDuplicateAnyHit", a.noDuplicateAnyHit, b.noDuplicateAnyHit);
    }
    for (size_t i = 0; i < built.aabbs.size(); ++i) {
        const std::string name = At("aabbs", i);
        CheckSame(built, name + ".boxCount", built.aabbs[i].boxCount, next.aabbs[i].boxCount);
        CheckSame(built, name + ".isOpaque", built.aabbs[i].isOpaque, next.aabbs[i].isOpaque);
        CheckSame(built, name + ".noDuplicateAnyHit", built.aabbs[i].noDuplicateAnyHit,
                  next.aabbs[i].noDuplicateAnyHit);
    }
}

BlasGeometry::BlasGeometry(const BlasDesc& desc, VkBuildAccelerationStructureFlagsKHR flags) {
    for (const TriangleGeometry& source : desc.triangles) {
        VkAccelerationStructureGeometryKHR geometry{};
        geometry.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR;
        geometry.geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR;
        geometry.flags = FlagsOf(source.isOpaque, source.noDuplicateAnyHit);
        auto& triangles = geometry.geometry.triangles;
        triangles.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR;
        triangles.vertexFormat = VK_FORMAT_R32G32B32_SFLOAT;
        triangles.vertexData.deviceAddress = source.vertices;
        triangles.vertexStride = source.vertexStride;
        triangles.maxVertex = source.vertexCount - 1;
        triangles.indexType = VK_INDEX_TYPE_UINT32;
        triangles.indexData.deviceAddress = source.indices;
        m_geometries.push_back(geometry);
        m_ranges.push_back({source.triangleCount, 0, 0, 0});
    }
    for (const AabbGeometry& source : desc.aabbs) {
        VkAccelerationStructureGeometryKHR geometry{};
        geometry.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR;
        geometry.geometryType = VK_GEOMETRY_TYPE_AABBS_KHR;
        geometry.flags = FlagsOf(source.isOpaque, source.noDuplicateAnyHit);
        auto& aabbs = geometry.geometry.aabbs;
        aabbs.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_AABBS_DATA_KHR;
        aabbs.data.deviceAddress = source.boxes;
        aabbs.stride = sizeof(VkAabbPositionsKHR);
        m_geometries.push_back(geometry);
        m_ranges.push_back({source.boxCount, 0, 0, 0});
    }
    m_info.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR;
    m_info.type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR;
    m_info.flags = flags;
    m_info.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
    m_info.geometryCount = static_cast<uint32_t>(m_geometries.size());
    m_info.pGeometries = m_geometries.data();
}

VkAccelerationStructureBuildSizesInfoKHR BlasGeometry::Sizes(Device& device) const {
    std::vector<uint32_t> primitiveCounts;
    for (const auto& range : m_ranges) primitiveCounts.push_back(range.primitiveCount);
    VkAccelerationStructureBuildSizesInfoKHR sizes{};
    sizes.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR;
    device.Vk().vkGetAccelerationStructureBuildSizesKHR(device.Handle(),
                                                        VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR,
                                                        &m_info, primitiveCounts.data(), &sizes);
    return sizes;
}

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
        EvaluateSavings(batch);
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
            WriteLog(m_device.Log(), LogLevel::Info, log_category::kGeometry,
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
void Compaction::EvaluateSavings(const Batch& batch) {
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
    WriteLog(m_device.Log(), LogLevel::Info, log_category::kGeometry, "BLAS compaction is off: {}",
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
