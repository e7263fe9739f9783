#include "rhi/choose_device.h"

#include <cctype>
#include <charconv>

#include "base/text.h"

namespace raygraph::rhi {
namespace {

std::string Lower(std::string text) {
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

// Empty: anything; digits: the index; otherwise a part of the name.
bool IsSelected(const DeviceReport& report, const std::string& select) {
    if (select.empty()) return true;
    uint32_t index = 0;
    const char* end = select.data() + select.size();
    const auto [stop, failure] = std::from_chars(select.data(), end, index);
    if (failure == std::errc{} && stop == end) return report.index == index;
    return Lower(report.name).find(Lower(select)) != std::string::npos;
}

int Rank(DeviceType type) {
    switch (type) {
        case DeviceType::Discrete:
            return 0;
        case DeviceType::Integrated:
            return 1;
        case DeviceType::Virtual:
            return 2;
        case DeviceType::Cpu:
            return 3;
        case DeviceType::Other:
            break;
    }
    return 4;
}

std::string Describe(const DeviceReport& report, bool isSelected) {
    std::string text = Text("{} '{}' ({})", report.index, report.name, Name(report.type));
    if (!isSelected) return text + " was not asked for";
    const char* separator = " ";
    for (const std::string& refusal : report.refusals) {
        text += separator + refusal;
        separator = ", ";
    }
    return text;
}

}  // namespace

const char* Name(DeviceType type) {
    switch (type) {
        case DeviceType::Cpu:
            return "CPU";
        case DeviceType::Integrated:
            return "integrated GPU";
        case DeviceType::Discrete:
            return "discrete GPU";
        case DeviceType::Virtual:
            return "virtual GPU";
        case DeviceType::Other:
            break;
    }
    return "other";
}

uint32_t ChooseDevice(const std::vector<DeviceReport>& reports, const std::string& select) {
    const DeviceReport* best = nullptr;
    for (const DeviceReport& report : reports)
        if (IsSelected(report, select) && report.refusals.empty() &&
            (!best || Rank(report.type) < Rank(best->type)))
            best = &report;
    if (best) return best->index;
    std::string text = "no suitable Vulkan device";
    if (!select.empty()) text += " for '" + select + "'";
    if (reports.empty()) text += ": the loader finds none";
    const char* separator = ": ";
    for (const DeviceReport& report : reports) {
        text += separator + Describe(report, IsSelected(report, select));
        separator = "; ";
    }
    throw Error(ErrorKind::NoDevice, text);
}

}  // namespace raygraph::rhi
