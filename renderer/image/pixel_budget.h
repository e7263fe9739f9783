// PixelBudget is a memory budget that pictures share that are decoded at once. Threads: any.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>

#include "base/api.h"

namespace raygraph::image {

// Counts pixels of all pictures, whose texels stay, and pixels of those that are being decoded, beside whose
// texels a decoder needs memory of its own: up to about nine bytes a pixel (the coefficients of a progressive
// JPEG, libwebp's output before it is copied, Zstandard's output).
class RAYGRAPH_API PixelBudget {
  public:
    // A picture of more than `atOnce` is decoded when no other one is.
    PixelBudget(uint64_t inAll, uint64_t atOnce) : m_left(inAll), m_atOnce(atOnce) {}
    PixelBudget(const PixelBudget&) = delete;
    PixelBudget& operator=(const PixelBudget&) = delete;

    // Share is the share of one decoder: DecodeLimits::share. Destroying it says that the decoder is done.
    class RAYGRAPH_API Share {
      public:
        explicit Share(PixelBudget& budget) : m_budget(budget) {}
        Share(const Share&) = delete;
        Share& operator=(const Share&) = delete;
        ~Share();
        // Is called once, before anything of the picture's size is allocated. Waits for others to be done.
        // Returns false if fewer pixels are left for all pictures.
        bool Take(uint64_t pixels);

      private:
        PixelBudget& m_budget;
        uint64_t m_pixels = 0;
    };

  private:
    std::mutex m_mutex;
    std::condition_variable m_isDone;
    uint64_t m_left;
    const uint64_t m_atOnce;
    uint64_t m_decoding = 0;
};

}  // namespace raygraph::image
