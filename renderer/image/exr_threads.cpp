#include "renderer/image/exr_threads.h"

#include <OpenEXR/ImfThreading.h>

#include <algorithm>
#include <cstdint>
#include <mutex>
#include <thread>

namespace raygraph::image {

namespace {

// The library has one pool of threads for the whole process.
struct Pool {
    std::mutex mutex;
    uint32_t users = 0;  // of threads that were started here
};
Pool& SharedPool() {
    static Pool pool;
    return pool;
}

}  // namespace

ExrThreads::ExrThreads(unsigned count) {
    constexpr unsigned kMax = 256;
    if (count == 0) count = std::thread::hardware_concurrency();
    if (count < 2) return;  // as good as none
    Pool& pool = SharedPool();
    const std::lock_guard lock(pool.mutex);
    if (pool.users == 0) {
        if (Imf::globalThreadCount() > 0) return;  // the process has its own
        Imf::setGlobalThreadCount(static_cast<int>(std::min(count, kMax)));
    }
    ++pool.users;
    m_isCounted = true;
}

ExrThreads::~ExrThreads() {
    if (!m_isCounted) return;
    Pool& pool = SharedPool();
    const std::lock_guard lock(pool.mutex);
    if (--pool.users == 0) Imf::setGlobalThreadCount(0);
}

}  // namespace raygraph::image
