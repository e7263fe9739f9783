// RunInterruptibly: what a binding of another language runs where its user may lose patience. A driver
// compiles shaders for seconds in one call that nothing ends, and files are read in large pieces: the work
// has a thread of its own, which the caller leaves behind.
// Threads: any number of calls at once.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>

#include "base/api.h"

namespace raygraph::session {

// The caller of a work, seen by the work. Threads: that of the work.
class RAYGRAPH_API Caller {
  public:
    struct State;
    explicit Caller(State& state) : m_state(state) {}
    Caller(const Caller&) = delete;
    Caller& operator=(const Caller&) = delete;

    // Returns whether the work should end: nobody waits for more of it.
    bool IsStopRequested() const;
    // If so, throws a type that is no error; the call of RunInterruptibly returns none then.
    void ThrowIfStopRequested() const;
    // Runs `question`, which throws nothing, on the caller's thread, and returns after it; at once, without
    // having run it, if a stop is requested.
    void Ask(const std::function<void()>& question);

  private:
    State& m_state;
};

// Runs `work(caller)` on another thread, and returns what it returns or throws what it throws. All that it
// captures is gone by then. Meanwhile `isStopRequested`, which throws nothing, is called on this thread every
// 20 ms. Once it returns true the work has 0.2 seconds to end by itself. After that it is left behind, and
// the function returns none: so the work must own all that it uses, and its result is dropped.
template <typename Work>
auto RunInterruptibly(Work work, const std::function<bool()>& isStopRequested)
    -> std::optional<std::invoke_result_t<Work&, Caller&>>;

// Waits for all work that was left behind, before something ends that it does not own: Vulkan objects of a
// host, or the process, whose end destroys the driver's statics under a thread that compiles.
RAYGRAPH_API void WaitForAbandonedWork();

namespace detail {

// Returns whether the work has ended with a result.
RAYGRAPH_API bool RunOnThread(std::function<void(Caller&)> work,
                              const std::function<bool()>& isStopRequested);

}  // namespace detail

template <typename Work>
auto RunInterruptibly(Work work, const std::function<bool()>& isStopRequested)
    -> std::optional<std::invoke_result_t<Work&, Caller&>> {
    using Result = std::invoke_result_t<Work&, Caller&>;
    const auto result = std::make_shared<std::optional<Result>>();
    // std::function takes what can be copied
    std::function<void(Caller&)> run = [result, owned = std::make_shared<Work>(std::move(work))](
                                           Caller& caller) { *result = (*owned)(caller); };
    if (!detail::RunOnThread(std::move(run), isStopRequested)) return std::nullopt;
    return std::move(*result);
}

}  // namespace raygraph::session
