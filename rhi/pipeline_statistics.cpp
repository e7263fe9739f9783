#include "rhi/pipeline_statistics.h"

#include "rhi/device.h"
#include "rhi/pipeline.h"

namespace raygraph::rhi {
namespace {

double ValueOf(const VkPipelineExecutableStatisticKHR& statistic) {
    switch (statistic.format) {
        case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_BOOL32_KHR:
            return statistic.value.b32 ? 1.0 : 0.0;
        case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_INT64_KHR:
            return static_cast<double>(statistic.value.i64);
        case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_UINT64_KHR:
            return static_cast<double>(statistic.value.u64);
        default:
            return statistic.value.f64;
    }
}

// Calls an enumerating function of Vulkan twice: for the number, then for as many structures of `type`.
template <typename T, typename Ask>
std::vector<T> ListOf(const Device& device, const char* what, VkStructureType type, Ask&& ask) {
    uint32_t count = 0;
    device.Check(ask(&count, nullptr), what);
    T empty{};
    empty.sType = type;
    std::vector<T> list(count, empty);
    device.Check(ask(&count, list.data()), what);
    list.resize(count);
    return list;
}

}  // namespace

std::vector<ProgramStatistics> StatisticsOf(const Device& device, const Pipeline& pipeline) {
    if ((device.PipelineFlags() & VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR) == 0 || !pipeline) return {};
    const DeviceFunctions& vk = device.Vk();
    VkPipelineInfoKHR info{VK_STRUCTURE_TYPE_PIPELINE_INFO_KHR, nullptr, pipeline.Handle()};
    const auto programs = ListOf<VkPipelineExecutablePropertiesKHR>(
        device, "vkGetPipelineExecutablePropertiesKHR", VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_PROPERTIES_KHR,
        [&](uint32_t* count, VkPipelineExecutablePropertiesKHR* list) {
            return vk.vkGetPipelineExecutablePropertiesKHR(device.Handle(), &info, count, list);
        });
    std::vector<ProgramStatistics> all;
    for (uint32_t i = 0; i < programs.size(); ++i) {
        VkPipelineExecutableInfoKHR program{VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_INFO_KHR, nullptr,
                                            pipeline.Handle(), i};
        ProgramStatistics& told = all.emplace_back();
        told.name = programs[i].name;
        told.subgroupSize = programs[i].subgroupSize;
        for (const VkPipelineExecutableStatisticKHR& statistic : ListOf<VkPipelineExecutableStatisticKHR>(
                 device, "vkGetPipelineExecutableStatisticsKHR",
                 VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_STATISTIC_KHR,
                 [&](uint32_t*count, VkPipelineExecutableStatisticKHR*list) {
                     return vk.vkGetPipelineExecutableStatisticsKHR(device.Handle(), &program, count, list);
                 }))
            told.statistics.push_back({statistic.name, statistic.description, ValueOf(statistic)});
    }
    return all;
}

}  // namespace raygraph::rhi
