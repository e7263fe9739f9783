// Disposer destroys large objects on threads of its own: giving hundreds of megabytes back to the system can
// hold a thread for tens of milliseconds. Threads: one at a time.
#pragma once

#include <chrono>
#include <exception>
#include <future>
#include <utility>
#include <vector>

#include "base/api.h"

namespace raygraph {

// The destructor waits until everything is destroyed.
class RAYGRAPH_API Disposer {
  public:
    // No other object may use `value`, and its destructor may run on any thread. Throws nothing: where there
    // is no thread or no memory for one, the caller's thread destroys it.
    template <typename Value>
    void Dispose(Value value) noexcept {
        std::erase_if(m_running, [](const std::future<void>& running) {
            return running.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
        });
        try {
            m_running.reserve(m_running.size() + 1);
            m_running.push_back(std::async(std::launch::async, [taken = std::move(value)]() mutable {
                const Value destroyedHere(std::move(taken));
            }));
        } catch (const std::exception&) {
        }
    }

  private:
    std::vector<std::future<void>> m_running;
};

}  // namespace raygraph
