// Devices: the library's own, and those of a host.
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "c/call.h"
#include "c/handles.h"
#include "editor/session/binding/interruptible.h"
#include "rhi/device.h"
#include "rhi/device_requirements.h"
#include "rhi/memory_allocator.h"

using raygraph::ErrorKind;
using raygraph::MakeError;
using raygraph::c::Call;
using raygraph::c::Guarded;
namespace rhi = raygraph::rhi;

struct RgRequirements {
    uint32_t queueFamily = 0, computeFamily = RG_NONE, transferFamily = RG_NONE;
    rhi::FeatureChain features;
    std::vector<const char*> extensions;
    rhi::OptionalFeatures optional;
};

namespace raygraph::c {

namespace {

struct NamedFeature {
    bool rhi::OptionalFeatures::*member;
    RgFeatures bit;
};
constexpr NamedFeature kFeatures[] = {
    {&rhi::OptionalFeatures::rayQuery, RG_FEATURE_RAY_QUERY},
    {&rhi::OptionalFeatures::positionFetch, RG_FEATURE_POSITION_FETCH},
    {&rhi::OptionalFeatures::shaderClock, RG_FEATURE_SHADER_CLOCK},
    {&rhi::OptionalFeatures::invocationReorder, RG_FEATURE_INVOCATION_REORDER},
    {&rhi::OptionalFeatures::opacityMicromap, RG_FEATURE_OPACITY_MICROMAP},
    {&rhi::OptionalFeatures::wireframe, RG_FEATURE_WIREFRAME},
    {&rhi::OptionalFeatures::clipDistance, RG_FEATURE_CLIP_DISTANCE},
    {&rhi::OptionalFeatures::multiDrawIndirect, RG_FEATURE_MULTI_DRAW_INDIRECT},
    {&rhi::OptionalFeatures::drawIndirectFirstInstance, RG_FEATURE_DRAW_INDIRECT_FIRST_INSTANCE},
    {&rhi::OptionalFeatures::bufferInt64Atomics, RG_FEATURE_BUFFER_INT64_ATOMICS},
    {&rhi::OptionalFeatures::textureCompressionBc, RG_FEATURE_TEXTURE_COMPRESSION_BC},
    {&rhi::OptionalFeatures::samplerAnisotropy, RG_FEATURE_SAMPLER_ANISOTROPY},
    {&rhi::OptionalFeatures::pipelineStatistics, RG_FEATURE_PIPELINE_STATISTICS},
    {&rhi::OptionalFeatures::layeredTargets, RG_FEATURE_LAYERED_TARGETS},
    {&rhi::OptionalFeatures::memoryBudget, RG_FEATURE_MEMORY_BUDGET},
};

RgFeatures MaskOf(const rhi::OptionalFeatures& features) {
    RgFeatures mask = 0;
    for (const auto& [member, bit] : kFeatures)
        if (features.*member) mask |= bit;
    return mask;
}

rhi::OptionalFeatures FeaturesOf(RgFeatures mask) {
    rhi::OptionalFeatures features;
    for (const auto& [member, bit] : kFeatures) features.*member = (mask & bit) != 0;
    return features;
}

rhi::Submission SubmissionOf(const Call& call, const RgToken& token) {
    if (token.queue > static_cast<uint32_t>(rhi::QueueKind::Transfer))
        call.Refuse(Text("token.queue is {}: there is no such queue", token.queue));
    return {token.value, static_cast<rhi::QueueKind>(token.queue)};
}

// The allocator of a host.
class HostMemory final : public rhi::MemoryAllocator {
  public:
    explicit HostMemory(const RgMemoryAllocator& host) : m_host(host) {}

    VkResult CreateBuffer(const VkBufferCreateInfo& info, const rhi::MemoryRequest& request, VkBuffer& buffer,
                          rhi::MemoryAllocation& memory) override {
        return Create(buffer, request, memory, [&](const RgMemoryRequest& wanted, RgMemory& made) {
            return m_host.create_buffer(m_host.user, &info, &wanted, &buffer, &made);
        });
    }
    VkResult CreateImage(const VkImageCreateInfo& info, const rhi::MemoryRequest& request, VkImage& image,
                         rhi::MemoryAllocation& memory) override {
        return Create(image, request, memory, [&](const RgMemoryRequest& wanted, RgMemory& made) {
            return m_host.create_image(m_host.user, &info, &wanted, &image, &made);
        });
    }
    VkResult Allocate(const VkMemoryRequirements& requirements, const rhi::MemoryRequest& request,
                      rhi::MemoryAllocation& memory) override {
        return Ask(request, memory, [&](const RgMemoryRequest& wanted, RgMemory& made) {
            return m_host.allocate(m_host.user, &requirements, &wanted, &made);
        });
    }
    void Free(const rhi::MemoryAllocation& memory) noexcept override {
        const RgMemory freed{sizeof(RgMemory), memory.memoryType, memory.memory, memory.offset,
                             memory.size,      memory.mapped,     memory.handle};
        m_host.free(m_host.user, &freed);
    }

  private:
    template <typename Handle, typename Call>
    VkResult Create(Handle& handle, const rhi::MemoryRequest& request, rhi::MemoryAllocation& memory,
                    Call&& call) const {
        const VkResult result = Ask(request, memory, call);
        if (result != VK_SUCCESS) handle = VK_NULL_HANDLE;  // a host may leave what it has destroyed there
        return result;
    }
    template <typename Call>
    VkResult Ask(const rhi::MemoryRequest& request, rhi::MemoryAllocation& memory, Call&& call) const {
        static_assert(RG_MEMORY_DEVICE == static_cast<int>(rhi::MemoryKind::Device) &&
                      RG_MEMORY_UPLOAD == static_cast<int>(rhi::MemoryKind::Upload) &&
                      RG_MEMORY_READBACK == static_cast<int>(rhi::MemoryKind::Readback));
        RgMemoryRequest wanted{};
        wanted.struct_size = sizeof wanted;
        wanted.kind = static_cast<RgMemoryKind>(request.kind);
        wanted.name = request.name;
        wanted.alignment = request.alignment;
        wanted.must_be_device_local = request.mustBeDeviceLocal;
        wanted.is_only_copied = request.isOnlyCopied;
        wanted.is_dedicated = request.isDedicated;
        RgMemory made{};
        made.struct_size = sizeof made;
        const auto result = static_cast<VkResult>(call(wanted, made));
        if (result == VK_SUCCESS)
            memory = {.memory = made.memory,
                      .offset = made.offset,
                      .size = made.size,
                      .memoryType = made.memory_type,
                      .mapped = static_cast<std::byte*>(made.mapped),
                      .handle = made.handle};
        return result;
    }

    RgMemoryAllocator m_host;
};

// A device with the allocator that it uses until it is gone.
struct HostedDevice {
    std::optional<HostMemory> memory;
    std::unique_ptr<rhi::Device> device;
};

}  // namespace

}  // namespace raygraph::c

RgResult rg_requirements_create(PFN_vkGetInstanceProcAddr loader, VkInstance instance,
                                VkPhysicalDevice physical_device, RgRequirements** requirements) {
    return Guarded("rg_requirements_create", [&](const Call& call) {
        call.Required(requirements, "requirements");
        if (loader == nullptr) call.Refuse("loader is NULL");
        call.Required(instance, "instance");
        call.Required(physical_device, "physical_device");
        if (const auto unmet = rhi::UnmetRequirements(physical_device, loader, instance); !unmet.empty()) {
            std::string list;
            for (const std::string& one : unmet) list += (list.empty() ? "" : "; ") + one;
            throw MakeError(ErrorKind::NoDevice, "rg_requirements_create: the physical device {}", list);
        }
        const auto family = [&](rhi::QueueKind queue) {
            return rhi::QueueFamilyFor(physical_device, loader, instance, queue).value_or(RG_NONE);
        };
        *requirements = new RgRequirements{family(rhi::QueueKind::Main),
                                           family(rhi::QueueKind::Compute),
                                           family(rhi::QueueKind::Transfer),
                                           rhi::FeaturesFor(physical_device, loader, instance),
                                           rhi::ExtensionsFor(physical_device, loader, instance),
                                           rhi::OptionalFeaturesOf(physical_device, loader, instance)};
    });
}

void rg_requirements_destroy(RgRequirements* requirements) {
    delete requirements;
}

RgResult rg_requirements_get(const RgRequirements* requirements, RgDeviceSetup* setup) {
    return Guarded("rg_requirements_get", [&](const Call& call) {
        const RgRequirements& needed = call.Required(requirements, "requirements");
        RgDeviceSetup made{};
        made.queue_family = needed.queueFamily;
        made.features = const_cast<VkPhysicalDeviceFeatures2*>(needed.features.Root());
        made.extensions = needed.extensions.data();
        made.extension_count = static_cast<uint32_t>(needed.extensions.size());
        made.optional_features = raygraph::c::MaskOf(needed.optional);
        made.compute_family = needed.computeFamily;
        made.transfer_family = needed.transferFamily;
        call.Write(setup, "setup", made);
    });
}

RgResult rg_device_create(const RgDeviceDesc* desc, RgDevice** device) {
    return Guarded("rg_device_create", [&](const Call& call) {
        call.Required(device, "device");
        const RgDeviceDesc given = call.ReadOr(desc, "desc");
        rhi::DeviceDesc wanted;
        wanted.select = raygraph::c::TextOr(given.select);
        wanted.validation = given.validation != 0;
        wanted.cacheDirectory = raygraph::c::TextOr(given.cache_directory);
        if (given.frames_in_flight != 0) wanted.framesInFlight = given.frames_in_flight;
        wanted.log = raygraph::c::LogOf(given.log);
        auto made = std::make_unique<RgDevice>(rhi::Device::Create(wanted));
        made->device->LimitMemory(given.memory_limit);
        *device = made.release();
    });
}

RgResult rg_device_adopt(const RgAdoptDesc* desc, RgDevice** device) {
    return Guarded("rg_device_adopt", [&](const Call& call) {
        call.Required(device, "device");
        const RgAdoptDesc given = call.Read(desc, "desc");
        if (given.loader == nullptr) call.Refuse("desc.loader is NULL");
        rhi::AdoptedDeviceDesc adopted;
        adopted.instance = &call.Required(given.instance, "desc.instance");
        adopted.physicalDevice = &call.Required(given.physical_device, "desc.physical_device");
        adopted.device = &call.Required(given.device, "desc.device");
        adopted.queue = &call.Required(given.queue, "desc.queue");
        adopted.queueFamily = given.queue_family;
        adopted.computeQueue = {given.compute_queue, given.compute_family};
        adopted.transferQueue = {given.transfer_queue, given.transfer_family};
        adopted.getInstanceProcAddr = given.loader;
        for (uint32_t i = 0; i < given.extension_count; ++i)
            adopted.enabledExtensions.emplace_back(call.RequiredText(
                (&call.Required(given.extensions, "desc.extensions"))[i], "one of desc.extensions"));
        adopted.enabledFeatures = raygraph::c::FeaturesOf(given.optional_features);
        adopted.debugUtilsEnabled = given.debug_utils != 0;
        if ((given.lock_queue == nullptr) != (given.unlock_queue == nullptr))
            call.Refuse("desc has one of lock_queue and unlock_queue, and needs both or neither");
        if (given.lock_queue != nullptr) {
            adopted.lockQueue = [given] { given.lock_queue(given.lock_user); };
            adopted.unlockQueue = [given] { given.unlock_queue(given.lock_user); };
        }
        adopted.log = raygraph::c::LogOf(given.log);
        if (given.frames_in_flight != 0) adopted.framesInFlight = given.frames_in_flight;
        adopted.savePipelineCache = given.cache_directory != nullptr;
        adopted.cacheDirectory = raygraph::c::TextOr(given.cache_directory);
        const auto hosted = std::make_shared<raygraph::c::HostedDevice>();
        if (given.allocator != nullptr) {
            const RgMemoryAllocator allocator = call.Read(given.allocator, "desc.allocator");
            if (allocator.create_buffer == nullptr || allocator.create_image == nullptr ||
                allocator.allocate == nullptr || allocator.free == nullptr)
                call.Refuse("desc.allocator lacks one of its four functions");
            adopted.memoryAllocator = &hosted->memory.emplace(allocator);
        }
        hosted->device = rhi::Device::Adopt(adopted);
        auto made = std::make_unique<RgDevice>(std::shared_ptr<rhi::Device>(hosted, hosted->device.get()));
        made->device->LimitMemory(given.memory_limit);
        *device = made.release();
    });
}

void rg_device_destroy(RgDevice* device) {
    if (device != nullptr) raygraph::session::WaitForAbandonedWork();
    delete device;
}

RgResult rg_device_get_info(const RgDevice* device, RgDeviceInfo* info) {
    return Guarded("rg_device_get_info", [&](const Call& call) {
        const rhi::Device& of = *call.Required(device, "device").device;
        RgDeviceInfo made{};
        made.validation_messages = static_cast<uint32_t>(of.ValidationMessageCount());
        made.name = of.Info().name.c_str();
        made.driver = of.Info().driver.c_str();
        made.kind = rhi::Name(of.Info().type);
        made.memory_used = of.Memory().usedBytes;
        call.Write(info, "info", made);
    });
}

RgResult rg_device_complete(RgDevice* device, RgToken token) {
    return Guarded("rg_device_complete", [&](const Call& call) {
        call.Required(device, "device").device->Complete(raygraph::c::SubmissionOf(call, token));
    });
}

RgResult rg_device_has_completed(const RgDevice* device, RgToken token, bool* has_completed) {
    return Guarded("rg_device_has_completed", [&](const Call& call) {
        const bool has =
            call.Required(device, "device").device->HasCompleted(raygraph::c::SubmissionOf(call, token));
        call.Required(has_completed, "has_completed") = has;
    });
}

RgResult rg_device_wait(RgDevice* device, RgToken token) {
    return Guarded("rg_device_wait", [&](const Call& call) {
        call.Required(device, "device").device->WaitFor(raygraph::c::SubmissionOf(call, token));
    });
}

RgResult rg_device_after(const RgDevice* device, RgToken token, RgSemaphoreUse* use) {
    return Guarded("rg_device_after", [&](const Call& call) {
        const rhi::SemaphoreUse after =
            call.Required(device, "device").device->After(raygraph::c::SubmissionOf(call, token));
        call.Required(use, "use") = {after.semaphore, after.value};
    });
}
