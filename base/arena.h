// Arena: memory for values that all end together, such as those of one frame. Taking some costs a few
// instructions, and Clear keeps it, so that a frame like the one before allocates nothing. Threads: one at a
// time.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

#include "base/api.h"

namespace raygraph {

class RAYGRAPH_API Arena {
  public:
    Arena() = default;
    Arena(const Arena&) = delete;
    Arena& operator=(const Arena&) = delete;

    // Returns uninitialized bytes, valid until Clear. `alignment` is a power of two.
    void* Take(size_t bytes, size_t alignment) {
        const uintptr_t place = (m_next + alignment - 1) & ~(uintptr_t{alignment} - 1);
        if (place + bytes > m_end) return TakeFromNext(bytes, alignment);
        m_next = place + bytes;
        return reinterpret_cast<void*>(place);
    }
    // Returns a copy, valid until Clear, with a zero after it.
    std::string_view Copy(std::string_view text) {
        auto* copy = static_cast<char*>(Take(text.size() + 1, 1));
        *std::copy(text.begin(), text.end(), copy) = '\0';
        return {copy, text.size()};
    }
    template <typename T>
    std::span<const T> Copy(const std::vector<T>& values) {
        static_assert(std::is_trivially_copyable_v<T>);
        auto* copy = static_cast<T*>(Take(values.size() * sizeof(T), alignof(T)));
        std::uninitialized_copy(values.begin(), values.end(), copy);
        return {copy, values.size()};
    }
    // Ends all values, without calling destructors.
    void Clear() {
        m_used = 0;
        m_next = m_end = 0;
    }

  private:
    static constexpr size_t kBlockBytes = 16384;
    struct Block {
        std::unique_ptr<std::byte[]> memory;
        size_t bytes = 0;
    };

    void* TakeFromNext(size_t bytes, size_t alignment) {
        const size_t needed = bytes + alignment;
        while (m_used < m_blocks.size() && m_blocks[m_used].bytes < needed) ++m_used;
        if (m_used == m_blocks.size()) {
            const size_t size = std::max(kBlockBytes, needed);
            m_blocks.push_back({std::unique_ptr<std::byte[]>(new std::byte[size]), size});
        }
        const Block& block = m_blocks[m_used++];
        m_next = reinterpret_cast<uintptr_t>(block.memory.get());
        m_end = m_next + block.bytes;
        return Take(bytes, alignment);
    }

    std::vector<Block> m_blocks;
    size_t m_used = 0;  // blocks in use; the last of them is [.., m_end), free from m_next on
    uintptr_t m_next = 0;
    uintptr_t m_end = 0;
};

}  // namespace raygraph
