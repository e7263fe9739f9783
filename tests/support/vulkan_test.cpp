#include "tests/support/vulkan_test.h"

#include <exception>
#include <utility>

#include "tests/support/source_file.h"

#if defined(__SANITIZE_ADDRESS__)
#define RAYGRAPH_LEAKS_ARE_LOOKED_FOR 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define RAYGRAPH_LEAKS_ARE_LOOKED_FOR 1
#endif
#endif
#ifdef RAYGRAPH_LEAKS_ARE_LOOKED_FOR
#include <dlfcn.h>

// The validation layer 1.3.239 keeps some of its own objects alive by cycles of shared pointers. A leak can
// be told to be the layer's only while the layer is loaded, so DeviceEnvironment keeps it.
// NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming): the name is the sanitizer's
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
    return "leak:libVkLayer_khronos_validation\n";
}
// NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming)
#endif

#if defined(__SANITIZE_THREAD__)
#define RAYGRAPH_RACES_ARE_LOOKED_FOR 1
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define RAYGRAPH_RACES_ARE_LOOKED_FOR 1
#endif
#endif
#ifdef RAYGRAPH_RACES_ARE_LOOKED_FOR
// Driver, its compiler and the validation layer are not instrumented: of what they do between their own
// threads, half is seen. (To ignore their calls altogether, called_from_lib, also hides the unlocking of
// mutexes.)
// NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming): the name is the sanitizer's
extern "C" const char* __tsan_default_suppressions();
extern "C" const char* __tsan_default_suppressions() {
    return "race:libvulkan_lvp.so\nrace:libLLVM\nrace:libVkLayer_khronos_validation.so\n";
}
// NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming)
#endif

namespace raygraph::testing {
namespace {

struct SharedDevice {
    MessageLog log;
    std::unique_ptr<rhi::Device> device;
    std::vector<std::function<void()>> beforeItGoes;
};

SharedDevice& Shared() {
    static SharedDevice shared;
    return shared;
}

// Destroys the shared device before main returns, while loader, layers and driver are still in order.
class DeviceEnvironment : public ::testing::Environment {
  public:
#ifdef RAYGRAPH_LEAKS_ARE_LOOKED_FOR
    void SetUp() override {
        dlopen("libVkLayer_khronos_validation.so", RTLD_LAZY | RTLD_NODELETE);
    }
#endif
    void TearDown() override {
        if (!Shared().device) return;
        const size_t before = Shared().log.Count();
        for (const auto& destroy : Shared().beforeItGoes) destroy();
        Shared().device.reset();
        EXPECT_EQ(Shared().log.Count(), before) << "messages while the device was destroyed:\n"
                                                << Shared().log.Text(before);
    }
};

const ::testing::Environment* const kEnvironment = ::testing::AddGlobalTestEnvironment(new DeviceEnvironment);

}  // namespace

Log MessageLog::Listener(LogLevel least) {
    const auto note = [this](const LogMessage& message) {
        const std::lock_guard lock(m_mutex);
        m_messages.push_back({message.level, std::string(message.category), std::string(message.text)});
    };
    return Log(note, least);
}

size_t MessageLog::Count() const {
    const std::lock_guard lock(m_mutex);
    return m_messages.size();
}

std::string MessageLog::Text(size_t first, bool validationOnly) const {
    const std::lock_guard lock(m_mutex);
    std::string text;
    for (size_t i = first; i < m_messages.size(); ++i)
        if (m_messages[i].IsValidation() || !validationOnly) text += m_messages[i].text + "\n";
    return text;
}

std::vector<MessageLog::Message> MessageLog::All() const {
    const std::lock_guard lock(m_mutex);
    return m_messages;
}

rhi::Device& VulkanTest::Device() {
    SharedDevice& shared = Shared();
    if (!shared.device)
        shared.device = rhi::Device::Create({.name = "test",
                                             .validation = true,
                                             .log = shared.log.Listener(LogLevel::Info),
                                             .cacheDirectory = test::CacheFolder()});
    return *shared.device;
}

MessageLog& VulkanTest::Log() {
    return Shared().log;
}

void VulkanTest::OnDeviceDestroy(std::function<void()> destroy) {
    Shared().beforeItGoes.push_back(std::move(destroy));
}

VulkanTest::VulkanTest()
    : m_validationCount(Device().ValidationMessageCount()), m_messageCount(Log().Count()) {}

VulkanTest::~VulkanTest() {
    try {
        Device().WaitIdle();
    } catch (const std::exception& error) {
        ADD_FAILURE() << "the device at the end of the test: " << error.what();
    }
    EXPECT_EQ(Device().ValidationMessageCount(), m_validationCount) << "validation messages:\n"
                                                                    << Log().Text(m_messageCount, true);
}

}  // namespace raygraph::testing
