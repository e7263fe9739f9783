#include "renderer/graph/pass_marks.h"

#include "base/text.h"

#include <cstring>

#include "renderer/graph/text.h"

namespace raygraph {

PassMarks::PassMarks(rhi::Device& device)
    : m_words(device.CreateBuffer({.name = "pass marks",
                                   .size = uint64_t{device.FramesInFlight()} * kMaxPasses * sizeof(uint32_t),
                                   .usage = rhi::BufferUsage::CopyDestination,
                                   .memory = rhi::MemoryKind::Readback})),
      m_frames(device.FramesInFlight()) {
    std::memset(m_words.Mapped().data(), 0, m_words.Mapped().size());
}

void PassMarks::BeginFrame(uint64_t frame) {
    const std::lock_guard lock(m_mutex);
    m_slot = frame % m_frames.size();
    m_frames[m_slot].number = frame;
    m_frames[m_slot].passes.clear();
}

void PassMarks::Mark(rhi::CommandList& commands, const std::string& pass) {
    const std::lock_guard lock(m_mutex);
    Frame& frame = m_frames[m_slot];
    if (frame.passes.size() == kMaxPasses) return;
    commands.Fill(m_words, ValueOf(frame.number), OffsetOf(m_slot, frame.passes.size()), sizeof(uint32_t));
    frame.passes.push_back(pass);
}

std::string PassMarks::Report() const {
    const std::lock_guard lock(m_mutex);
    const Frame* newest = nullptr;
    size_t reached = 0;
    for (size_t slot = 0; slot < m_frames.size(); ++slot) {
        const Frame& frame = m_frames[slot];
        for (size_t pass = 0; pass < frame.passes.size(); ++pass) {
            uint32_t word = 0;
            std::memcpy(&word, m_words.Mapped().data() + OffsetOf(slot, pass), sizeof word);
            if (word != ValueOf(frame.number) || (newest && newest->number > frame.number)) continue;
            newest = &frame;
            reached = pass;
        }
    }
    if (!newest) return {};
    return Text("the last pass reached was pass {} ({} of {}) of frame {}", Quoted(newest->passes[reached]),
                reached + 1, newest->passes.size(), newest->number);
}

}  // namespace raygraph
