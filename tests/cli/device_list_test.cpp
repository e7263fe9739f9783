#include "editor/cli/device_list.h"

#include "tests/cli/cli_test.h"

namespace raygraph::cli::device_list_test {
namespace {

using Indices = std::vector<uint32_t>;

rhi::DeviceReport Device(uint32_t index, const char* name, rhi::DeviceType type, const char* driver = "d 1") {
    rhi::DeviceReport device;
    device.index = index;
    device.name = name;
    device.type = type;
    device.driver = driver;
    return device;
}

// Returns two equal GPUs, a different one, a slow one that is first, and one that lacks a requirement.
std::vector<rhi::DeviceReport> Devices() {
    std::vector<rhi::DeviceReport> devices{
        Device(0, "cpu", rhi::DeviceType::Cpu), Device(1, "gpu", rhi::DeviceType::Discrete),
        Device(2, "gpu", rhi::DeviceType::Discrete, "d 2"), Device(3, "gpu", rhi::DeviceType::Discrete),
        Device(4, "gpu", rhi::DeviceType::Discrete)};
    devices[3].refusals = {"lacks rays"};
    return devices;
}

TEST(DeviceList, EveryRefusalIsShown) {
    std::vector<rhi::DeviceReport> devices(2);
    devices[0].name = "fast";
    devices[0].apiVersion = (1u << 22) | (4u << 12) | 7u;
    devices[1].index = 1;
    devices[1].name = "old";
    devices[1].refusals = {"lacks this", "lacks that"};
    const std::string text = DescribeDevices(devices);
    for (const char* part :
         {"0  fast", "Vulkan 1.4", "suitable  yes", "1  old", "suitable  no", "- lacks this", "- lacks that"})
        EXPECT_NE(text.find(part), std::string::npos) << text << "lacks " << part;
    EXPECT_NE(DescribeDevices({}).find("no Vulkan devices"), std::string::npos);
}

TEST(DeviceList, ListIsAllOrIndices) {
    for (const char* list : {"all", "0", "0,0", "3,1,12"}) EXPECT_EQ(ValidatedDevices(list), list);
    for (const char* list : {"", "x", "0,", ",0", "0, 1", "-1", "1.5", "all,0", "All", "4294967296"})
        EXPECT_THROW(ValidatedDevices(list), Error) << list;
}

TEST(DeviceList, AllAreThoseLikeTheBest) {
    EXPECT_EQ(IndicesOf("all", Devices()), (Indices{1, 4})) << "neither another driver nor another kind";
    EXPECT_EQ(IndicesOf("all", {Devices()[0]}), (Indices{0}));
    test::ExpectError(
        ErrorKind::NoDevice, [] { IndicesOf("all", {Devices()[3]}); }, "lacks rays");
    test::ExpectError(
        ErrorKind::NoDevice, [] { IndicesOf("all", {}); }, "the loader finds none");
}

TEST(DeviceList, IndicesAreTakenAsTheyAreNamed) {
    EXPECT_EQ(IndicesOf("4,0,4", Devices()), (Indices{4, 0, 4}));
    test::ExpectError(
        ErrorKind::NoDevice, [] { IndicesOf("1,3", Devices()); }, "'3'", "lacks rays");
    test::ExpectError(
        ErrorKind::NoDevice, [] { IndicesOf("5", Devices()); }, "'5'");
}

TEST(DeviceList, ProcessesShareTheDevicesOfTheirComputer) {
    const Indices devices{5, 6, 7};
    EXPECT_EQ(ShareOf(devices, 0, 1), devices);
    EXPECT_EQ(ShareOf(devices, 0, 2), (Indices{5, 7}));
    EXPECT_EQ(ShareOf(devices, 1, 2), (Indices{6}));
    EXPECT_EQ(ShareOf(devices, 2, 3), (Indices{7}));
    for (uint32_t process = 0; process < 5; ++process)  // no process is without a device
        EXPECT_EQ(ShareOf(devices, process, 5), (Indices{devices[process % 3]}));
}

}  // namespace
}  // namespace raygraph::cli::device_list_test
