#include "renderer/gpu_scene/slot_ranges.h"

#include <algorithm>
#include <bit>
#include <stdexcept>

namespace raygraph {
namespace {

constexpr uint32_t kMaxSlots = 1u << 31;

}  // namespace

size_t SlotRanges::ListOf(uint32_t count) {
    static_assert(kExact + 32 - std::bit_width(kExact) < kLists);
    return count <= kExact ? count - 1 : kExact + static_cast<size_t>(std::bit_width(count - 1) - 5);
}

void SlotRanges::Link(uint32_t first, uint32_t count) noexcept {
    uint32_t& head = m_lists[ListOf(count)];
    m_slots[first + count - 1].count = count;
    m_slots[first] = {.count = count, .next = head, .previous = kNone};
    if (head != kNone) m_slots[head].previous = first;
    head = first;
}

void SlotRanges::Unlink(uint32_t first) noexcept {
    const Slot range = m_slots[first];
    if (range.next != kNone) m_slots[range.next].previous = range.previous;
    (range.previous != kNone ? m_slots[range.previous].next : m_lists[ListOf(range.count)]) = range.next;
    m_slots[first].count = m_slots[first + range.count - 1].count = 0;
}

// Finds a free range of at least `count` slots. Every range in the lists after that of `count` is large
// enough.
uint32_t SlotRanges::Find(uint32_t count) const {
    for (size_t list = ListOf(count); list < kLists; ++list)
        for (uint32_t first = m_lists[list]; first != kNone; first = m_slots[first].next)
            if (m_slots[first].count >= count) return first;
    return kNone;
}

uint32_t SlotRanges::Allocate(uint32_t count) {
    if (count == 0) return 0;
    uint32_t first = Find(count);
    if (first != kNone) {
        const uint32_t there = m_slots[first].count;
        Unlink(first);
        if (there > count) Link(first + count, there - count);
    } else {
        if (count > kMaxSlots - m_end) throw std::length_error("more than 2^31 slots");
        first = m_end;
        const size_t end = size_t{m_end} + count;
        if (m_slots.size() < end) m_slots.resize(end);
        m_end += count;
    }
    m_taken += count;
    return first;
}

void SlotRanges::Free(uint32_t first, uint32_t count) noexcept {
    if (count == 0) return;
    m_taken -= count;
    if (first > 0 && m_slots[first - 1].count > 0) {  // the slot before is the last one of a free range
        const uint32_t before = m_slots[first - 1].count;
        first -= before;
        count += before;
        Unlink(first);
    }
    if (const uint32_t end = first + count; end == m_end) {
        m_end = first;
        return;
    }
    if (const uint32_t after = m_slots[first + count].count; after > 0) {
        Unlink(first + count);
        count += after;
    }
    Link(first, count);
}

}  // namespace raygraph
