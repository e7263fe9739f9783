// raygraph::Error: every failure that leaves the module. WithMemoryErrors makes exhausted memory one, too.
//
// Four kinds of failure, four answers:
//   1. A mistake in the calling code that can be named (unbound name, stale id): Error{Usage}, when declared.
//   2. The world (no device, missing file, device lost): Error of the fitting kind, with its VkResult if any.
//   3. An expected outcome (size not ready, swapchain out of date): a return value, never an Error.
//   4. A broken invariant of ours: RG_CHECK_* (base/check.h), which aborts with both values.
//
// Threads: any. An Error is a plain value; what is thrown on a thread is caught there.
#pragma once

#include <cstdint>
#include <new>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "base/api.h"

namespace raygraph {

enum class ErrorKind : uint8_t {
    Usage,        // the request is impossible; the message names object, request and what there was
    BadInput,     // a file is malformed, hostile or of an unknown kind
    Io,           // a file cannot be opened, read or written
    NoDevice,     // no Vulkan device meets the requirements
    OutOfMemory,  // host or device memory is exhausted
    DeviceLost,   // the device stopped; the message names the last pass reached
    Vulkan,       // any other Vulkan call failed; `Result()` has its VkResult
};

// The message is one line and complete by itself: "scene.gltf: accessors[3].count: 12 exceeds ...".
class RAYGRAPH_API Error : public std::runtime_error {
  public:
    Error(ErrorKind kind, const std::string& message, int32_t vkResult = 0)
        : std::runtime_error(message), m_kind(kind), m_result(vkResult) {}

    ErrorKind Kind() const noexcept { return m_kind; }
    // Returns the VkResult behind a Vulkan failure, 0 when there was none.
    int32_t Result() const noexcept { return m_result; }

  private:
    ErrorKind m_kind;
    int32_t m_result;
};

// Returns what `run` returns. std::bad_alloc and std::length_error become Error{OutOfMemory}, in which
// `subject` names the object or the call; all other exceptions pass through. Functions that allocate by the
// size of their input run within it, so that a host catches one type and can free something.
template <typename Run>
decltype(auto) WithMemoryErrors(std::string_view subject, Run&& run) {
    try {
        return std::forward<Run>(run)();
    } catch (const std::bad_alloc&) {
        throw Error(ErrorKind::OutOfMemory, std::string(subject) + ": host memory is exhausted");
    } catch (const std::length_error&) {
        throw Error(ErrorKind::OutOfMemory,
                    std::string(subject) + ": asks for more memory than a process can have");
    }
}

}  // namespace raygraph
