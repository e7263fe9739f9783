// Allocates ranges of neighboring slots in a growing table: the instances of a scene, the groups of a mesh.
// Freed slots are reused before the table grows. Threads: as std::vector.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace raygraph {

class SlotRanges {
  public:
    // Takes `count` neighboring slots and returns the first. They lie beyond End() only if no free range
    // before it is large enough. Takes nothing and returns 0 for a count of 0. Throws std::bad_alloc, or
    // std::length_error beyond 2^31 slots, and has then changed nothing.
    uint32_t Allocate(uint32_t count);
    // Frees slots that are taken: those of one Allocate, of several, or a part of them.
    void Free(uint32_t first, uint32_t count) noexcept;

    // Returns the index after the last slot that is taken; 0 if none is.
    uint32_t End() const { return m_end; }
    uint32_t TakenCount() const { return m_taken; }

  private:
    static constexpr uint32_t kNone = ~0u;
    // Free ranges are listed by size: one list for each size up to kExact, then one for each power of two.
    static constexpr uint32_t kExact = 16;
    static constexpr size_t kLists = 48;
    // The first slot of a free range has all fields, its last one `count` alone, and the others none.
    struct Slot {
        uint32_t count = 0;  // 0: taken
        uint32_t next = kNone, previous = kNone;
    };

    static size_t ListOf(uint32_t count);
    void Link(uint32_t first, uint32_t count) noexcept;
    void Unlink(uint32_t first) noexcept;
    uint32_t Find(uint32_t count) const;

    std::vector<Slot> m_slots;  // up to the greatest end so far; slots beyond m_end count as taken
    std::array<uint32_t, kLists> m_lists = Empty();
    uint32_t m_end = 0;
    uint32_t m_taken = 0;

    static constexpr std::array<uint32_t, kLists> Empty() {
        std::array<uint32_t, kLists> lists{};
        lists.fill(kNone);
        return lists;
    }
};

}  // namespace raygraph
