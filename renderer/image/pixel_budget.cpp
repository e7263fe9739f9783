#include "renderer/image/pixel_budget.h"

#include "base/check.h"

namespace raygraph::image {

PixelBudget::Share::~Share() {
    {
        const std::lock_guard lock(m_budget.m_mutex);
        m_budget.m_decoding -= m_pixels;
    }
    m_budget.m_isDone.notify_all();
}

bool PixelBudget::Share::Take(uint64_t pixels) {
    RG_CHECK_EQ(m_pixels, uint64_t{0});
    std::unique_lock lock(m_budget.m_mutex);
    if (pixels > m_budget.m_left) return false;
    m_budget.m_left -= pixels;
    m_budget.m_isDone.wait(
        lock, [&] { return m_budget.m_decoding == 0 || m_budget.m_decoding + pixels <= m_budget.m_atOnce; });
    m_budget.m_decoding += pixels;
    m_pixels = pixels;
    return true;
}

}  // namespace raygraph::image
