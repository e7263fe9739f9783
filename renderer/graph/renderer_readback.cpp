// Readbacks: a transfer pass of the frame copies into mapped memory, which the host reads once the frame has
// completed.
#include "base/error.h"
#include "renderer/graph/renderer_impl.h"
#include "renderer/graph/text.h"

namespace raygraph {

namespace {

// A limit, because a program may never poll again.
constexpr uint64_t kKeepFrames = 16;

}  // namespace

bool Readback::IsReady() const {
    if (!m_state) return false;
    const uint64_t submitted = m_state->submitted;
    if (submitted == State::kDeclared || submitted >= State::kRendererGone) return false;
    return m_state->device->CompletedValue() >= submitted;
}

void Readback::Wait() const {
    if (!m_state) throw Error(ErrorKind::Usage, "Readback: it is empty");
    const uint64_t submitted = m_state->submitted;
    if (submitted == State::kRendererGone)
        throw Error(ErrorKind::Usage, "Readback: its Renderer has been destroyed");
    if (submitted == State::kDeclared)
        throw Error(ErrorKind::Usage, "Readback: its frame has not been executed");
    if (submitted == State::kDropped)
        throw Error(ErrorKind::Usage, "Readback: its frame was dropped and never ran");
    m_state->device->WaitFor(submitted);
}

std::span<const std::byte> Readback::Bytes() const {
    if (!IsReady()) throw Error(ErrorKind::Usage, "Readback: its bytes are not there yet (Wait)");
    return m_state->buffer.Mapped().first(static_cast<size_t>(m_state->bytes));
}

Extent2D Readback::Extent() const {
    return m_state ? m_state->extent : Extent2D{};
}

rhi::Format Readback::Format() const {
    return m_state ? m_state->format : rhi::Format::Undefined;
}

// Returns a state that has no holder any more, or a new one, as the pointer of a Readback, whose last copy
// releases it.
std::shared_ptr<Readback::State> Renderer::Impl::TakeReadback(uint64_t bytes) {
    using State = Readback::State;
    const uint64_t completed = device.CompletedValue();
    std::shared_ptr<Readback::State> free;
    std::erase_if(readbacks, [&](const std::shared_ptr<Readback::State>& readback) {
        const uint64_t value = readback->submitted;
        const bool isIdle = !readback->isHeld && value != State::kDeclared &&
                            (value == State::kDropped || value <= completed);
        if (!isIdle) return false;
        if (!free && readback->buffer.Size() == bytes) {
            free = readback;
            return false;
        }
        return readback->frame + kKeepFrames < frameNumber;
    });
    if (!free) {
        free = std::make_shared<Readback::State>();
        free->device = &device;
        free->buffer = device.CreateBuffer({.name = "readback",
                                            .size = bytes,
                                            .usage = rhi::BufferUsage::CopyDestination,
                                            .memory = rhi::MemoryKind::Readback});
        readbacks.push_back(free);
    }
    free->bytes = bytes;
    free->submitted = State::kDeclared;
    free->frame = frameNumber;
    free->isHeld = true;
    return {free.get(), [free](State*) { free->isHeld = false; }};
}

BufferId Renderer::Impl::AddReadback(const std::shared_ptr<Readback::State>& state, std::string_view name) {
    return AddResource<ResourceKind::Buffer>(
        {.name = "readback of " + std::string(name), .origin = Origin::Imported, .bytes = state->bytes},
        {.buffer = &state->buffer});
}

Readback Renderer::ReadBack(TextureId texture, uint32_t level, uint32_t layer) {
    Impl& impl = *m_impl;
    impl.RequireOpen("ReadBack");
    const uint32_t index = impl.graph.Resolve(texture, "ReadBack reads");
    const GraphTextureDesc desc = Desc(texture);
    const Subresources part = Subresource(level, layer);
    const std::string missing = rhi::DescribeMissing(part, desc.levels, desc.layers);
    if (!missing.empty())
        throw MakeError(ErrorKind::Usage, "ReadBack reads {}: {}", Quoted(impl.graph.resources[index].name),
                        missing);
    const std::string name = impl.graph.resources[index].name + rhi::PartText(part, desc.levels, desc.layers);
    const Extent2D extent = rhi::MipExtent(desc.extent, level);
    const uint64_t bytes = rhi::ImageBytes(desc.format, extent);
    Readback readback;
    readback.m_state = impl.TakeReadback(bytes);
    readback.m_state->extent = extent;
    readback.m_state->format = desc.format;
    BufferId target = impl.AddReadback(readback.m_state, name);
    AddPass(
        "Read back " + name, PassKind::Transfer,
        [&](PassBuilder& pass) {
            pass.CopiesFrom(texture, part);
            target = pass.CopiesTo(target);
        },
        [texture, target, level, layer](CommandList& commands, const PassResources& resources) {
            commands.CopyToBuffer(resources.Texture(texture), resources.Buffer(target), 0, level, layer);
        });
    impl.graph.ReadOnHost(target);
    return readback;
}

Readback Renderer::ReadBack(BufferId buffer) {
    Impl& impl = *m_impl;
    impl.RequireOpen("ReadBack");
    const uint32_t index = impl.graph.Resolve(buffer, "ReadBack reads");
    const std::string name = impl.graph.resources[index].name;
    Readback readback;
    readback.m_state = impl.TakeReadback(impl.graph.resources[index].bytes);
    readback.m_state->extent = {};
    readback.m_state->format = rhi::Format::Undefined;
    BufferId target = impl.AddReadback(readback.m_state, name);
    AddPass(
        "Read back " + name, PassKind::Transfer,
        [&](PassBuilder& pass) {
            pass.CopiesFrom(buffer);
            target = pass.CopiesTo(target);
        },
        [buffer, target, bytes = readback.m_state->bytes](CommandList& commands,
                                                          const PassResources& resources) {
            commands.CopyBuffer(resources.Buffer(buffer), 0, resources.Buffer(target), 0, bytes);
        });
    impl.graph.ReadOnHost(target);
    return readback;
}

}  // namespace raygraph
