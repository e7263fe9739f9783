// Log: where a library's messages go: one callback of the host's, given with a device (rhi::DeviceDesc::log)
// or with what is loaded (scene::LoadOptions::log). There is no global one, and nothing is printed.
//
// Threads: a Log is a plain value, read by any thread. The callback is called on the thread that does the
// work, which may be any that calls into the library, and from several at once; possibly inside a Vulkan call
// or a destructor. Locks may be held meanwhile: the device's own, that of submissions among them, and the
// host's (rhi::AdoptedDeviceDesc::lockQueue). So it must not call back into the device that it is given to,
// nor into what belongs to that device, nor wait for a thread that does, nor take the lock behind lockQueue.
//
// It should not throw: what it throws is dropped, because nobody could catch it in a destructor or under a
// Vulkan call, and the work goes on.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string_view>
#include <utility>

#include "base/api.h"

namespace raygraph {

enum class LogLevel : uint8_t {
    Debug,    // every pipeline, every build: for whoever looks for the cause of something
    Info,     // what was done and how long it took; what is done in another way than asked for
    Warning,  // something is not as its user would expect: it is slow, left out, not saved
    Error,    // a fault that no Error can be thrown for; messages of the validation layers
    Off,      // a threshold alone
};
// Returns "debug", "info", "warning", "error" or "off".
RAYGRAPH_API const char* Name(LogLevel level);

// Messages have these categories, one for each area.
namespace log_category {
inline constexpr std::string_view kScene = "scene";            // reading and uploading scenes and images
inline constexpr std::string_view kDevice = "device";          // which one, what it lacks
inline constexpr std::string_view kMemory = "memory";          // device memory
inline constexpr std::string_view kCache = "cache";            // pipeline caches on disk
inline constexpr std::string_view kShaders = "shaders";        // compiling and reloading; pipelines
inline constexpr std::string_view kGeometry = "geometry";      // acceleration structures and their compaction
inline constexpr std::string_view kGraph = "graph";            // frames
inline constexpr std::string_view kValidation = "validation";  // what the Vulkan validation layers say
}  // namespace log_category
inline constexpr std::array kLogCategories{
    log_category::kScene,   log_category::kDevice,   log_category::kMemory, log_category::kCache,
    log_category::kShaders, log_category::kGeometry, log_category::kGraph,  log_category::kValidation};

// The texts live as long as the call.
struct LogMessage {
    LogLevel level = LogLevel::Info;
    std::string_view category;  // one of kLogCategories
    std::string_view text;      // one line; of the validation layers also several
};

class RAYGRAPH_API Log {
  public:
    using Callback = std::function<void(const LogMessage&)>;

    Log() = default;  // nobody listens
    // Messages below `least` are not made.
    explicit Log(Callback callback, LogLevel least = LogLevel::Info)
        : m_callback(std::move(callback)), m_least(m_callback ? least : LogLevel::Off) {}

    // Returns whether messages of the level are wanted. Ask before building a text: if nobody listens, that
    // costs one comparison.
    bool IsEnabled(LogLevel level) const noexcept { return level >= m_least && level < LogLevel::Off; }
    void Send(LogLevel level, std::string_view category, std::string_view text) const noexcept {
        if (!IsEnabled(level)) return;
        try {
            m_callback({level, category, text});
        } catch (...) {
            // An exception of the callback is dropped.
        }
    }

  private:
    Callback m_callback;
    LogLevel m_least = LogLevel::Off;
};

}  // namespace raygraph
