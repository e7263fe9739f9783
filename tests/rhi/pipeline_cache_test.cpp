// Tests the pipeline cache on disk: it is kept between devices, and never trusted.
#include <gmock/gmock.h>

#include <cstring>
#include <fstream>

#include "base/read_file.h"
#include "rhi/device.h"
#include "rhi/pipeline_cache_file.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::pipeline_cache_test {
namespace {

using rhi::PipelineCacheFile;
using test::TemporaryFolder;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

using Bytes = std::vector<std::byte>;

VkPhysicalDeviceProperties SomeDevice() {
    VkPhysicalDeviceProperties properties{};
    properties.vendorID = 0x10DE;
    properties.deviceID = 0x2335;
    for (uint32_t i = 0; i < VK_UUID_SIZE; ++i)
        properties.pipelineCacheUUID[i] = static_cast<uint8_t>(i * 17);
    return properties;
}

// Returns data as a driver's: its header, then anything.
Bytes DriverBytes(const VkPhysicalDeviceProperties& device) {
    VkPipelineCacheHeaderVersionOne header{
        sizeof(header), VK_PIPELINE_CACHE_HEADER_VERSION_ONE, device.vendorID, device.deviceID, {}};
    std::memcpy(header.pipelineCacheUUID, device.pipelineCacheUUID, VK_UUID_SIZE);
    Bytes bytes(sizeof(header) + 1000, std::byte{0x5A});
    std::memcpy(bytes.data(), &header, sizeof(header));
    return bytes;
}

void Overwrite(const std::filesystem::path& path, const Bytes& bytes) {
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

struct PipelineCacheFileTest : ::testing::Test {
    TemporaryFolder folder;
    VkPhysicalDeviceProperties device = SomeDevice();
    std::string Problem() { return PipelineCacheFile(folder.Path(), device).Load().problem; }
};

TEST_F(PipelineCacheFileTest, SavedBytesAreLoaded) {
    PipelineCacheFile file(folder / "new", device);
    EXPECT_THAT(file.Load().bytes, IsEmpty()) << "there is no file yet";
    EXPECT_THAT(file.Load().problem, IsEmpty());
    const Bytes bytes = DriverBytes(device);
    EXPECT_EQ(file.Save(bytes), "");
    EXPECT_EQ(PipelineCacheFile(folder / "new", device).Load().bytes, bytes);
    EXPECT_THAT(file.Path().filename().string(),
                AllOf(HasSubstr("000010de"), HasSubstr("00002335"), HasSubstr("0011223344556677")));
}

TEST_F(PipelineCacheFileTest, UnchangedBytesAreNotWrittenAgain) {
    PipelineCacheFile file(folder.Path(), device);
    ASSERT_EQ(file.Save(DriverBytes(device)), "");
    std::filesystem::remove(file.Path());
    EXPECT_EQ(file.Save(DriverBytes(device)), "");
    EXPECT_FALSE(std::filesystem::exists(file.Path()));
}

TEST_F(PipelineCacheFileTest, EveryFlippedByteIsNoticed) {
    PipelineCacheFile file(folder.Path(), device);
    ASSERT_EQ(file.Save(DriverBytes(device)), "");
    const Bytes good = ReadFile(file.Path());
    for (size_t i = 0; i < good.size(); i += i < 80 ? 1 : 97) {
        Bytes bad = good;
        bad[i] ^= std::byte{0x10};
        Overwrite(file.Path(), bad);
        const PipelineCacheFile::Loaded loaded = PipelineCacheFile(folder.Path(), device).Load();
        EXPECT_THAT(loaded.bytes, IsEmpty()) << i;
        EXPECT_THAT(loaded.problem, HasSubstr("is ignored")) << i;
    }
    Overwrite(file.Path(), good);
    EXPECT_EQ(Problem(), "");
}

TEST_F(PipelineCacheFileTest, CutOffFilesAreNoticed) {
    PipelineCacheFile file(folder.Path(), device);
    ASSERT_EQ(file.Save(DriverBytes(device)), "");
    const Bytes good = ReadFile(file.Path());
    for (const size_t size : {size_t{0}, size_t{7}, size_t{24}, size_t{60}, good.size() - 1}) {
        Overwrite(file.Path(), Bytes(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)));
        EXPECT_THAT(Problem(), HasSubstr("is ignored")) << size;
    }
}

TEST_F(PipelineCacheFileTest, EveryNumberOfDeviceAndDriver_NamesAnotherFileAndIsComparedInIt) {
    PipelineCacheFile file(folder.Path(), device);
    const auto expectOther = [&](const VkPhysicalDeviceProperties& other) {
        EXPECT_NE(PipelineCacheFile(folder.Path(), other).Path(), file.Path());
        ASSERT_EQ(file.Save(DriverBytes(other)), "");
        EXPECT_THAT(Problem(), HasSubstr("another device or driver"));
    };
    VkPhysicalDeviceProperties other = device;
    other.vendorID ^= 1;
    expectOther(other);
    other = device;
    other.deviceID ^= 1;
    expectOther(other);
    for (uint32_t i = 0; i < VK_UUID_SIZE; ++i) {
        SCOPED_TRACE(i);
        other = device;
        other.pipelineCacheUUID[i] ^= 1;
        expectOther(other);
    }
    ASSERT_EQ(file.Save(DriverBytes(device)), "");
    EXPECT_EQ(Problem(), "");
}

TEST_F(PipelineCacheFileTest, FolderThatCannotBeMade_IsReported) {
    Overwrite(folder / "file", Bytes(1));
    PipelineCacheFile file(folder / "file" / "cache", device);
    EXPECT_THAT(file.Save(DriverBytes(device)), HasSubstr((folder / "file").string()));
}

TEST(PipelineCacheFolderTest, FollowsTheXdgRules) {
    const auto set = [](const char* name, const char* value) {
        value ? setenv(name, value, 1) : unsetenv(name);
    };
    const auto get = [](const char* name) {
        const char* value = std::getenv(name);
        return value ? std::optional<std::string>(value) : std::nullopt;
    };
    const std::optional<std::string> cache = get("XDG_CACHE_HOME"), home = get("HOME");
    set("XDG_CACHE_HOME", "/caches");
    set("HOME", "/users/someone");
    EXPECT_EQ(rhi::PipelineCacheFolder("/mine"), "/mine");
    EXPECT_EQ(rhi::PipelineCacheFolder(""), "/caches/raygraph");
    set("XDG_CACHE_HOME", "relative");
    EXPECT_EQ(rhi::PipelineCacheFolder(""), "/users/someone/.cache/raygraph");
    set("XDG_CACHE_HOME", nullptr);
    EXPECT_EQ(rhi::PipelineCacheFolder(""), "/users/someone/.cache/raygraph");
    set("HOME", nullptr);
    EXPECT_EQ(rhi::PipelineCacheFolder(""), "");
    set("XDG_CACHE_HOME", cache ? cache->c_str() : nullptr);
    set("HOME", home ? home->c_str() : nullptr);
}

struct DeviceCacheTest : ::testing::Test {
    TemporaryFolder folder;
    MessageLog log;
    std::unique_ptr<rhi::Device> Make() {
        rhi::DeviceDesc desc;
        desc.cacheDirectory = folder.Path();
        desc.log = log.Listener();
        return rhi::Device::Create(desc);
    }
    std::filesystem::path File() {
        for (const auto& entry : std::filesystem::directory_iterator(folder.Path())) return entry.path();
        return {};
    }
};

TEST_F(DeviceCacheTest, IsWrittenWhenTheDeviceIsDestroyedAndReadByTheNext) {
    Make();
    ASSERT_FALSE(File().empty());
    EXPECT_TRUE(Make()->SavePipelineCache());
    EXPECT_EQ(log.Text(), "");
}

TEST_F(DeviceCacheTest, DamagedFile_IsIgnoredWithAMessageAndReplaced) {
    Make();
    const std::filesystem::path file = File();
    Overwrite(file, Bytes(100, std::byte{0x42}));
    Make();
    ASSERT_EQ(log.Count(), 1u);
    EXPECT_THAT(log.All()[0].text, AllOf(HasSubstr(file.string()), HasSubstr("is ignored")));
    EXPECT_EQ(log.All()[0].level, LogLevel::Warning);
    Make();
    EXPECT_EQ(log.Count(), 1u) << "the second one found a good file";
}

TEST_F(DeviceCacheTest, UnwritableFolder_IsAMessageNotAnError) {
    Overwrite(folder / "file", Bytes(1));
    rhi::DeviceDesc desc;
    desc.cacheDirectory = folder / "file" / "cache";
    desc.log = log.Listener();
    rhi::Device::Create(desc);
    EXPECT_THAT(log.Text(), HasSubstr("pipeline cache is not saved"));
}

TEST_F(DeviceCacheTest, SwitchedOff_WritesNothing) {
    rhi::DeviceDesc desc;
    desc.cacheDirectory = folder.Path();
    desc.savePipelineCache = false;
    EXPECT_FALSE(rhi::Device::Create(desc)->SavePipelineCache());
    EXPECT_TRUE(File().empty());
}

}  // namespace
}  // namespace raygraph::testing::pipeline_cache_test
