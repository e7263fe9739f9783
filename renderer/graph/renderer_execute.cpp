// The execution of a frame: compile, allocate memory, record, submit.
#include <algorithm>
#include <cstring>

#include "base/check.h"
#include "base/error.h"
#include "base/text.h"
#include "renderer/graph/renderer_impl.h"
#include "renderer/graph/text.h"
#include "rhi/command_list.h"
#include "rhi/texture_table.h"
#include "rhi/tlas.h"

namespace raygraph {

namespace {

rhi::TextureDesc TextureDescOf(const GraphResource& resource, const FrameResource& behind) {
    // A texture that only culled passes declare still needs memory requirements, for which any usage will do.
    const rhi::TextureUsage usage =
        behind.textureUsage == rhi::TextureUsage::None ? rhi::TextureUsage::Sampled : behind.textureUsage;
    return {.name = std::string(resource.name),
            .extent = resource.extent,
            .format = resource.format,
            .usage = usage,
            .mipLevels = resource.levels,
            .layers = resource.layers,
            .isShared = behind.isConcurrent};
}

rhi::BufferDesc BufferDescOf(const GraphResource& resource, const FrameResource& behind) {
    const rhi::BufferUsage usage =
        behind.bufferUsage == rhi::BufferUsage::None ? rhi::BufferUsage::Storage : behind.bufferUsage;
    return {
        .name = std::string(resource.name), .size = resource.bytes, .usage = usage, .memory = behind.memory};
}

// A debug label around a pass, closed also when its body throws.
class Label {
  public:
    Label(rhi::CommandList& commands, const std::string& name) : m_commands(commands) {
        commands.BeginLabel(name);
    }
    ~Label() { m_commands.EndLabel(); }
    Label(const Label&) = delete;
    Label& operator=(const Label&) = delete;

  private:
    rhi::CommandList& m_commands;
};

}  // namespace

// Compiles the frame, unless it is declared like the last one: then that plan is taken over.
void Renderer::Impl::CompileFrame() {
    if (isCompiled) return;
    const Stopwatch stopwatch;
    for (size_t r = 0; r < resources.size(); ++r) {
        if (resources[r].state) graph.resources[r].state = *resources[r].state;
        if (graph.resources[r].origin == Origin::Transient) FindRequirements(r);
    }
    isRepeated = hasLastPlan && graph.HasSamePlanAs(lastGraph);
    if (isRepeated)
        std::swap(plan, lastPlan);
    else
        raygraph::Compile(graph, plan, compileMemory);
    isCompiled = true;
    compileMs += stopwatch.Milliseconds();
}

// Finds the memory requirements of a transient. The last frame mostly had the same at this place.
void Renderer::Impl::FindRequirements(size_t r) {
    GraphResource& resource = graph.resources[r];
    const FrameResource& behind = resources[r];
    if (behind.memory != rhi::MemoryKind::Device) return;
    if (hasLastPlan && r < lastResources.size()) {
        const GraphResource& last = lastGraph.resources[r];
        const FrameResource& lastBehind = lastResources[r];
        if (last.origin == Origin::Transient && last.kind == resource.kind &&
            last.extent == resource.extent && last.format == resource.format &&
            last.levels == resource.levels && last.layers == resource.layers &&
            last.bytes == resource.bytes && lastBehind.textureUsage == behind.textureUsage &&
            lastBehind.bufferUsage == behind.bufferUsage && lastBehind.memory == behind.memory &&
            lastBehind.isConcurrent == behind.isConcurrent) {
            resource.memory = last.memory;
            return;
        }
    }
    if (resource.kind == ResourceKind::Texture)
        resource.memory = transients.RequirementsOf(TextureDescOf(resource, behind));
    else if (resource.kind == ResourceKind::Buffer)
        resource.memory = transients.RequirementsOf(BufferDescOf(resource, behind));
}

void Renderer::Compile() {
    m_impl->RequireOpen("Compile");
    WithMemoryErrors("Compile", [&] { m_impl->CompileFrame(); });
}

bool Renderer::PreparePipelines() {
    Compile();
    Impl& impl = *m_impl;
    bool isReady = true;
    for (const PlannedPass& planned : impl.plan.passes)
        if (Program* program = impl.passes[planned.pass].program)
            isReady &= impl.programs.BeginPipeline(*program);
    return isReady;
}

std::span<const DeclaredPass> Renderer::Impl::PassesBetween(PassId first, PassId end,
                                                            std::string_view what) const {
    RequireOpen(what);
    if (first.index > end.index || end.index > graph.passes.size())
        throw MakeError(ErrorKind::Usage, "{}: passes {} to {} were asked for, of {} that are declared", what,
                        first.index, end.index, graph.passes.size());
    return std::span(passes).subspan(first.index, end.index - first.index);
}

bool Renderer::PreparePipelines(PassId first, PassId end) {
    bool isReady = true;
    for (const DeclaredPass& pass : m_impl->PassesBetween(first, end, "PreparePipelines"))
        if (pass.program) isReady &= m_impl->programs.BeginPipeline(*pass.program);
    return isReady;
}

bool Renderer::HasPipelines(PassId first, PassId end) const {
    const std::span<const DeclaredPass> requested = m_impl->PassesBetween(first, end, "HasPipelines");
    return std::ranges::all_of(requested, [&](const DeclaredPass& pass) {
        return !pass.program || m_impl->programs.HasPipeline(*pass.program);
    });
}

bool Renderer::IsPreparingPipelines() const {
    return m_impl->programs.IsCompilingPipelines();
}

void Renderer::ReleasePipelines(double lifetime) {
    if (m_impl->isOpen || !m_impl->programs.Trim(lifetime)) return;
    for (DeclaredPass& pass : m_impl->passes) pass.program = nullptr;  // it may be one of those
}

// Finds or creates the objects that the executed passes use: memory, persistent resources, pipelines.
void Renderer::Impl::Prepare() {
    const bool areBlocksKept = transients.Reserve(plan.blocks, frameNumber);
    // No pass of this frame may access the shown texture, if it is unchanged.
    for (const Root& root : graph.roots)
        if (resources[root.resource].persistent)
            persistents.Ensure(device, *resources[root.resource].persistent);
    for (uint32_t r = 0; r < resources.size(); ++r) {
        const Lifetime& lifetime = plan.lifetimes[r];
        const bool isShown = resources[r].persistent && resources[r].persistent->IsMade();
        if (!lifetime.IsUsed() && !isShown) continue;
        const GraphResource& resource = graph.resources[r];
        FrameResource& behind = resources[r];
        if (behind.persistent) {
            persistents.Ensure(device, *behind.persistent);
            (resource.kind == ResourceKind::Texture ? void(behind.texture = &behind.persistent->texture)
                                                    : void(behind.buffer = &behind.persistent->buffer));
        } else if (resource.origin == Origin::Transient) {
            PlaceTransient(r, isRepeated && areBlocksKept);
        }
    }
    neededPrograms.clear();
    for (const PlannedPass& planned : plan.passes)
        if (Program* program = passes[planned.pass].program) neededPrograms.push_back(program);
    programs.EnsurePipelines(neededPrograms);
    for (const PlannedPass& planned : plan.passes) FillAddresses(passes[planned.pass]);
    UploadUniforms();
}

// Finds the object behind a transient. With `areLastValid` it is that of the last frame, if that has come so
// far.
void Renderer::Impl::PlaceTransient(size_t r, bool areLastValid) {
    const GraphResource& resource = graph.resources[r];
    FrameResource& behind = resources[r];
    const uint32_t block = plan.lifetimes[r].block;
    if (block == kNone) {
        behind.buffer = &transients.TakeUpload(BufferDescOf(resource, behind), frameNumber);
        return;
    }
    if (areLastValid && lastResources[r].lastUse) {
        behind.texture = lastResources[r].texture;
        behind.buffer = lastResources[r].buffer;
        behind.lastUse = lastResources[r].lastUse;
        *behind.lastUse = frameNumber;
    } else if (resource.kind == ResourceKind::Texture) {
        auto& placed = transients.Place(TextureDescOf(resource, behind), block, frameNumber);
        behind.texture = &placed.object;
        behind.lastUse = &placed.lastFrame;
    } else {
        auto& placed = transients.Place(BufferDescOf(resource, behind), block, frameNumber);
        behind.buffer = &placed.object;
        behind.lastUse = &placed.lastFrame;
    }
}

void Renderer::Impl::FillAddresses(const DeclaredPass& pass) {
    for (const AddressTable& table : pass.addressTables) {
        for (const DeclaredBinding& binding : pass.bindings) {
            if (!binding.isAddress || binding.binding != table.binding) continue;
            const VkDeviceAddress address = resources[binding.resource].buffer->Address();
            std::memcpy(uniformBytes.data() + table.uniformOffset + binding.addressOffset, &address,
                        sizeof(address));
        }
    }
}

void Renderer::Impl::UploadUniforms() {
    if (uniformBytes.empty()) return;
    rhi::Buffer& buffer = uniformBuffers[frameNumber % uniformBuffers.size()];
    if (!buffer || buffer.Size() < uniformBytes.size()) {
        constexpr uint64_t kMin = 16384;
        const uint64_t size = std::max<uint64_t>(kMin, uniformBytes.size() * 2);
        buffer = device.CreateBuffer({.name = "uniform memory",
                                      .size = size,
                                      .usage = rhi::BufferUsage::Uniform,
                                      .memory = rhi::MemoryKind::Upload});
    }
    std::memcpy(buffer.Mapped().data(), uniformBytes.data(), uniformBytes.size());
}

void Renderer::Impl::Record(rhi::CommandList& commands, const PlannedBatch& batch, FrameTiming& timing) {
    if (&batch == &plan.batches.front()) {
        if (marks) marks->BeginFrame(frameNumber, graph, plan);
        timer.BeginFrame(commands);
        RecordBarriers(commands, plan.acquire, false);
        timing.passes.resize(plan.passes.size());  // those of an earlier frame, whose names keep their memory
    } else if (batch.passCount > 0) {
        timer.BeginBatch(commands, batch.firstPass);
    }
    const Stopwatch stopwatch;
    double before = 0.0;
    for (size_t position = batch.firstPass; position < batch.firstPass + batch.passCount; ++position) {
        const PlannedPass& planned = plan.passes[position];
        RecordPass(commands, planned);
        timer.Stamp(commands);
        const double now = stopwatch.Milliseconds();
        PassTiming& pass = timing.passes[position];
        pass.name = graph.passes[planned.pass].name;
        pass.cpuMs = now - before;
        pass.gpuMs = 0.0;
        pass.kind = graph.passes[planned.pass].kind;
        pass.id = {planned.pass};
        before = now;
    }
    RecordBarriers(commands, batch.release, false);
    if (&batch != &plan.batches.back()) return;
    RecordBarriers(commands, plan.regain, false);
    RecordBarriers(commands, plan.finish, false);
    RecordBarriers(commands, plan.release, false);
}

void Renderer::Impl::RecordPass(rhi::CommandList& commands, const PlannedPass& planned) {
    DeclaredPass& pass = passes[planned.pass];
    const GraphPass& info = graph.passes[planned.pass];
    label = info.name;
    const Label scope(commands, label);
    RecordBarriers(commands, planned.barriers, marks != nullptr);
    if (marks) marks->Mark(commands);
    if (pass.program) BindPass(commands, pass);
    if (info.kind == PassKind::Raster) BeginTargets(commands, pass);
    commands.SetPortion(pass.portion);
    pass.execute(commands, PassResources(renderer, planned.pass));
    commands.SetPortion({});
    if (info.kind == PassKind::Raster) commands.EndRendering();
}

// Records one merged memory barrier for buffers and acceleration structures, and one barrier each for
// textures and for resources that change their queue family. With `holdsTransfers` transfers wait as well,
// since the pass's mark is one.
void Renderer::Impl::RecordBarriers(rhi::CommandList& commands, const BarrierRange& range,
                                    bool holdsTransfers) {
    if (range.count == 0) return;
    imageBarriers.clear();
    bufferBarriers.clear();
    VkMemoryBarrier2 memory{};
    memory.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2;
    bool hasMemory = false;
    for (uint32_t b = range.first; b < range.first + range.count; ++b) {
        const PlannedBarrier& barrier = plan.barriers[b];
        const Dependency& dependency = barrier.dependency;
        const VkPipelineStageFlags2 dstStages =
            dependency.dstStages | (holdsTransfers ? VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT : 0);
        if (barrier.srcQueueFamily != barrier.dstQueueFamily &&
            graph.resources[barrier.resource].kind == ResourceKind::Buffer) {
            VkBufferMemoryBarrier2& buffer = bufferBarriers.emplace_back();
            buffer = {};
            buffer.sType = VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER_2;
            buffer.srcStageMask = dependency.srcStages;
            buffer.srcAccessMask = dependency.srcAccess;
            buffer.dstStageMask = dstStages;
            buffer.dstAccessMask = dependency.dstAccess;
            buffer.srcQueueFamilyIndex = barrier.srcQueueFamily;
            buffer.dstQueueFamilyIndex = barrier.dstQueueFamily;
            buffer.buffer = resources[barrier.resource].buffer->Handle();
            buffer.size = VK_WHOLE_SIZE;
            continue;
        }
        const bool isTexture = graph.resources[barrier.resource].kind == ResourceKind::Texture;
        // Writes to the same memory as another resource are no accesses through this image.
        const bool isHandOver = barrier.predecessor != kNone || barrier.followsLastFrame;
        if (!isTexture || (isHandOver && dependency.srcAccess != VK_ACCESS_2_NONE)) {
            memory.srcStageMask |= dependency.srcStages;
            memory.srcAccessMask |= dependency.srcAccess;
            memory.dstStageMask |= dstStages;
            memory.dstAccessMask |= dependency.dstAccess;
            hasMemory = true;
        }
        if (!isTexture) continue;
        const rhi::Texture& texture = *resources[barrier.resource].texture;
        VkImageMemoryBarrier2& image = imageBarriers.emplace_back(
            rhi::ImageBarrier(texture, dependency.oldLayout, dependency.newLayout));
        image.subresourceRange = texture.RangeOf(barrier.part);
        image.srcStageMask = dependency.srcStages;
        image.srcAccessMask = dependency.srcAccess;
        image.dstStageMask = dstStages;
        image.dstAccessMask = dependency.dstAccess;
        image.srcQueueFamilyIndex = barrier.srcQueueFamily;
        image.dstQueueFamilyIndex = barrier.dstQueueFamily;
    }
    commands.Barriers(std::span(&memory, hasMemory ? 1 : 0), imageBarriers, bufferBarriers);
}

void Renderer::Impl::BindPass(rhi::CommandList& commands, const DeclaredPass& pass) {
    switch (pass.program->Kind()) {
        case PassKind::Compute:
            commands.Bind(pass.program->Compute());
            break;
        case PassKind::Raster:
            commands.Bind(pass.program->Raster());
            break;
        default:
            commands.Bind(pass.program->RayTracing());
            break;
    }
    bound.clear();
    const rhi::Buffer& uniforms = uniformBuffers[frameNumber % uniformBuffers.size()];
    for (const AddressTable& table : pass.addressTables)
        bound.push_back({.binding = table.binding,
                         .type = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER,
                         .buffer = &uniforms,
                         .offset = table.uniformOffset,
                         .size = table.bytes});
    for (const DeclaredBinding& binding : pass.bindings) {
        if (binding.isAddress) continue;
        rhi::BoundResource& target = bound.emplace_back();
        target.binding = binding.binding;
        target.element = binding.element;
        target.type = binding.type;
        if (binding.resource == kNone) {
            target.buffer = &uniforms;
            target.offset = binding.uniformOffset;
            target.size = binding.uniformBytes;
            continue;
        }
        const FrameResource& behind = resources[binding.resource];
        target.buffer = behind.buffer;
        if (binding.uniformBytes > 0) target.size = binding.uniformBytes;  // a buffer may exceed the limit
        target.texture = behind.texture;
        target.sampler = binding.sampler;
        if (binding.isPart) target.view = behind.texture->View(graph.uses[binding.use].part, binding.shape);
        // Queried now, because a pass before this one may have rebuilt it.
        if (behind.tlas) target.accelerationStructure = behind.tlas->Handle();
    }
    commands.BindResources(bound);
    const rhi::ShaderInterface& interface = pass.program->Interface();
    if (interface.usesTextureTable) commands.BindTextures(*resources[pass.textureSet].textures);
    if (!pass.constants.empty()) commands.PushConstants(pass.constants.first(interface.pushConstants.bytes));
}

void Renderer::Impl::BeginTargets(rhi::CommandList& commands, const DeclaredPass& pass) {
    colorTargets.clear();
    for (const DeclaredColor& color : pass.colors) {
        rhi::ColorTarget& target = colorTargets.emplace_back();
        target.texture = resources[color.resource].texture;
        target.part = color.part;
        target.clear = color.load.clear;
        std::copy_n(color.load.value, 4, target.clearValue);
    }
    rhi::DepthTarget depth;
    if (pass.depth != kNone)
        depth = {.texture = resources[pass.depth].texture,
                 .clear = pass.depthLoad.clear,
                 .clearValue = pass.depthLoad.value,
                 .part = pass.depthPart};
    // ResolveTargets has checked that a target exists, and that all have the same extent and layers.
    const bool isDepthOnly = pass.colors.empty();
    const uint32_t first = isDepthOnly ? pass.depth : pass.colors.front().resource;
    const uint32_t level = (isDepthOnly ? pass.depthPart : pass.colors.front().part).level;
    commands.BeginRendering(rhi::MipExtent(graph.resources[first].extent, level), colorTargets,
                            pass.depth != kNone ? &depth : nullptr);
}

void Renderer::Impl::MarkWritten(const ResourceUse& use) {
    Persistent* persistent = resources[use.resource].persistent;
    if (!persistent) return;
    const uint32_t levels = graph.resources[use.resource].levels;
    graph.ForEachSubresource(use.resource, use.part, [&](uint32_t, const Subresources& one) {
        persistent->isWritten[one.layer * levels + one.level] = 1;
    });
}

// Must be called when the frame has been submitted: its final states are the initial states of the next one.
void Renderer::Impl::Commit(uint64_t value) {
    submitted[frameNumber % submitted.size()] = value;
    lastSubmitted = value;
    blockStates = plan.blockStates;
    for (size_t r = 0; r < resources.size(); ++r) {
        if (resources[r].state) *resources[r].state = plan.states[r];
        if (Persistent* persistent = resources[r].persistent) {
            auto state = persistent->states.begin();
            graph.ForEachSubresource(static_cast<uint32_t>(r),
                                     [&](uint32_t number, auto&&) { *state++ = plan.states[number]; });
        }
    }
    wasExecuted.assign(graph.passes.size(), 0);
    for (const PlannedPass& planned : plan.passes) {
        wasExecuted[planned.pass] = 1;
        const GraphPass& pass = graph.passes[planned.pass];
        for (uint32_t u = pass.firstUse; u < pass.firstUse + pass.useCount; ++u)
            if (Writes(graph.uses[u].access)) MarkWritten(graph.uses[u]);
    }
    persistents.CommitReplacements();
    for (const std::shared_ptr<Readback::State>& readback : readbacks)
        if (readback->submitted == Readback::State::kDeclared) readback->submitted = value;
}

// Compiles, records and submits the declared frame; with a buffer of the host, records into that instead.
rhi::Submission Renderer::Impl::Submit(FrameTiming& timing, VkCommandBuffer host) {
    if (host && !(waits.all.empty() && signals.all.empty()))
        throw Error(ErrorKind::Usage,
                    "Record: the frame has semaphores, which belong to the host's submission");
    if (host && graph.computeFamily != VK_QUEUE_FAMILY_IGNORED) {
        Change();
        graph.computeFamily = VK_QUEUE_FAMILY_IGNORED;  // the host's buffer is for one queue
    }
    CompileFrame();
    const Stopwatch recording;
    Prepare();
    if (plan.batches.size() > 1) return SubmitBatches(timing, recording);
    rhi::CommandList commands = host ? device.RecordInto(host) : device.BeginCommands("frame");
    Record(commands, plan.batches.front(), timing);
    for (std::function<void()>& run : onSubmitted) commands.OnSubmitted(std::move(run));
    timing.recordMs = recording.Milliseconds();
    const Stopwatch submitting;
    if (host) device.JoinTransfers();
    const rhi::Submission submission = host ? device.HandOver(std::move(commands))
                                            : device.Submit(std::move(commands), waits.all, signals.all);
    timing.submitMs = submitting.Milliseconds();
    return submission;
}

// Records all before it submits any, so that an Error in a pass leaves the queues as they are.
rhi::Submission Renderer::Impl::SubmitBatches(FrameTiming& timing, const Stopwatch& recording) {
    std::vector<rhi::CommandList>& lists = batchLists;
    const struct Clear {
        std::vector<rhi::CommandList>& lists;
        ~Clear() { lists.clear(); }  // after an Error, too: unsubmitted lists are dropped at once
    } clear{lists};
    for (const PlannedBatch& batch : plan.batches) {
        lists.push_back(device.BeginCommands("frame", batch.queue));
        Record(lists.back(), batch, timing);
    }
    for (std::function<void()>& run : onSubmitted) lists.back().OnSubmitted(std::move(run));
    timing.recordMs = recording.Milliseconds();
    const Stopwatch submitting;
    std::vector<rhi::Submission>& submissions = batchSubmissions;
    submissions.clear();
    const auto submit = [&](size_t b) {
        const PlannedBatch& batch = plan.batches[b];
        std::vector<rhi::SemaphoreUse>& waited = batchWaits;
        waited.clear();
        if (batch.waitsFor != kNone) waited.push_back(device.After(submissions[batch.waitsFor]));
        // The first one has no commands that would wait before it signals.
        if (b == 0)
            for (rhi::SemaphoreUse wait : waits.all) {
                wait.stages = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
                waited.push_back(wait);
            }
        const bool isLast = b + 1 == lists.size();
        submissions.push_back(device.Submit(
            std::move(lists[b]), waited,
            isLast ? std::span<const rhi::SemaphoreUse>(signals.all) : std::span<const rhi::SemaphoreUse>()));
        if (b == 0) waits.Clear();  // an Error now must not wait for them once more
    };
    try {
        for (size_t b = 0; b < lists.size(); ++b) submit(b);
    } catch (...) {
        // Submitted batches must not run on beside the next frame, which knows nothing of them.
        try {
            device.WaitIdle();
        } catch (const Error&) {
            // The device is lost, of which the first Error tells.
        }
        throw;
    }
    timing.submitMs = submitting.Milliseconds();
    return submissions.back();
}

rhi::Submission Renderer::Impl::Finish(std::string_view call, VkCommandBuffer host) {
    FrameTiming timing = timer.NewTiming();
    timing.frame = frameNumber;
    timing.declareMs = sinceBegin.Milliseconds();
    rhi::Submission frame;
    try {
        RequireOpen(call);
        frame = WithMemoryErrors(call, [&] { return Submit(timing, host); });
    } catch (...) {
        DropFrame();
        throw;
    }
    // The frame is closed before the callbacks run, which are not part of it.
    Commit(frame.value);
    CloseFrame();
    timing.compileMs = compileMs;
    timer.EndFrame(frame.value, std::move(timing));
    for (const std::string& name : std::exchange(unneededOfSeries, {})) persistents.Release(name);
    transients.Trim(frameNumber);
    programs.EndFrame();
    return frame;
}

rhi::Submission Renderer::Execute() {
    return m_impl->Finish("Execute", VK_NULL_HANDLE);
}

rhi::Submission Renderer::Record(VkCommandBuffer commands) {
    if (commands == VK_NULL_HANDLE) throw Error(ErrorKind::Usage, "Record: there is no command buffer");
    return m_impl->Finish("Record", commands);
}

const rhi::Texture& PassResources::Texture(TextureId id) const {
    return *m_renderer.m_impl->resources[m_renderer.m_impl->DeclaredBy(m_pass, id)].texture;
}

const rhi::Buffer& PassResources::Buffer(BufferId id) const {
    return *m_renderer.m_impl->resources[m_renderer.m_impl->DeclaredBy(m_pass, id)].buffer;
}

uint32_t Renderer::Impl::DeclaredBy(uint32_t pass, AnyId id) const {
    const GraphPass& info = graph.passes[pass];
    const auto asks = [&] { return "pass " + Quoted(info.name) + " asks for"; };
    const bool isGood = id.isValid && id.frame == (graph.frame & TextureId::kFrameMask) &&
                        id.resource < graph.resources.size() && graph.resources[id.resource].kind == id.kind;
    const uint32_t resource = isGood ? id.resource : graph.ResolveAnyVersion(id, asks());
    const auto begin = graph.uses.begin() + info.firstUse;
    const auto isMatch = [&](const ResourceUse& use) { return use.resource == resource; };
    if (std::none_of(begin, begin + info.useCount, isMatch))
        throw MakeError(ErrorKind::Usage, "{} {}, which it did not declare in its setup", asks(),
                        Quoted(graph.resources[resource].name));
    return resource;
}

}  // namespace raygraph
