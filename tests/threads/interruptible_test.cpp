#include "editor/session/binding/interruptible.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>

// Work that its caller has left behind, and who waits for it.
namespace raygraph::session {
namespace {

using std::chrono::milliseconds;

// Sets its flag late, where a driver frees what it has for a thread.
struct LateEnd {
    std::shared_ptr<std::atomic<bool>> hasEnded;
    ~LateEnd() {
        if (!hasEnded) return;
        std::this_thread::sleep_for(milliseconds(300));
        *hasEnded = true;
    }
};

// Leaves work behind that runs until `mayEnd`. The last destructor of its thread sets the flag returned.
std::shared_ptr<std::atomic<bool>> LeaveBehind(const std::shared_ptr<std::atomic<bool>>& mayEnd) {
    const auto hasEnded = std::make_shared<std::atomic<bool>>(false);
    const auto result = RunInterruptibly(
        [mayEnd, hasEnded](Caller&) {
            thread_local LateEnd late;
            late.hasEnded = hasEnded;
            while (!*mayEnd) std::this_thread::sleep_for(milliseconds(1));
            return 1;
        },
        [] { return true; });
    EXPECT_FALSE(result.has_value());
    return hasEnded;
}

TEST(AbandonedWork, IsWaitedForWithTheDestructorsOfItsThread) {
    const auto mayEnd = std::make_shared<std::atomic<bool>>(false);
    const auto hasEnded = LeaveBehind(mayEnd);
    EXPECT_FALSE(*hasEnded);
    *mayEnd = true;
    WaitForAbandonedWork();
    EXPECT_TRUE(*hasEnded);
}

TEST(AbandonedWork, IsWaitedForByAllWhoAsk) {
    const auto mayEnd = std::make_shared<std::atomic<bool>>(false);
    const auto first = LeaveBehind(mayEnd), second = LeaveBehind(mayEnd);
    const auto wait = [&] {
        WaitForAbandonedWork();
        EXPECT_TRUE(*first);
        EXPECT_TRUE(*second);
    };
    std::thread one(wait), other(wait);
    std::this_thread::sleep_for(milliseconds(50));
    *mayEnd = true;
    one.join();
    other.join();
}

}  // namespace
}  // namespace raygraph::session
