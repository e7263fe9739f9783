// Renderer: declares, compiles and submits one frame's render graph after the other on one Device.
//
//   renderer.BeginFrame();
//   renderer.Present(Tonemap(renderer, Accumulate(renderer, Trace(renderer, scene, t).radiance, a), m));
//   renderer.Execute();
//
// The graph is rebuilt every frame; pipelines, transient memory and persistent resources are kept between
// frames. Threads: one thread at a time. Several Renderers may share a Device.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/api.h"
#include "renderer/graph/access.h"
#include "renderer/graph/frame_graph.h"
#include "renderer/graph/ids.h"
#include "renderer/graph/pass_builder.h"
#include "renderer/graph/pipeline_report.h"
#include "rhi/command_list.h"
#include "rhi/device.h"
#include "rhi/resources.h"

namespace raygraph::rhi {
class Tlas;
class TextureTable;
}  // namespace raygraph::rhi

namespace raygraph {

struct Plan;  // renderer/graph/plan.h

using rhi::CommandList;
using rhi::Extent2D;
using rhi::Format;

struct RendererDesc {
    std::string name = {};  // distinguishes Renderers of one Device in the report of a lost device
    // The root of the shader sources to reload from; "" uses the SPIR-V built into the library.
    std::filesystem::path shaderRoot;
    // Further include folders for those sources: the installed shaders, for passes outside the library.
    std::vector<std::filesystem::path> shaderIncludes = {};
    bool gpuTimes = true;   // a timestamp between passes
    bool passMarks = true;  // record on the device which pass was reached, for the report of a lost device
};

// A texture of the graph; usage flags follow from how passes use it.
struct GraphTextureDesc {
    Extent2D extent;
    Format format = Format::Rgba32Float;
    uint32_t levels = 1;  // mip levels, at most rhi::FullMipCount(extent)
    uint32_t layers = 1;  // layers of an array; six square ones are a cube map, +x -x +y -y +z -z

    bool operator==(const GraphTextureDesc&) const = default;
};
struct GraphBufferDesc {
    uint64_t size = 0;  // bytes
    rhi::MemoryKind memory = rhi::MemoryKind::Device;

    bool operator==(const GraphBufferDesc&) const = default;
};

// Resources of the pass, resolved: for execute functions that copy or build. Error{Usage} for an id that the
// pass did not declare.
class RAYGRAPH_API PassResources {
  public:
    const rhi::Texture& Texture(TextureId id) const;
    const rhi::Buffer& Buffer(BufferId id) const;

  private:
    friend class Renderer;
    PassResources(const Renderer& renderer, uint32_t pass) : m_renderer(renderer), m_pass(pass) {}
    const Renderer& m_renderer;
    uint32_t m_pass;
};

// A copy of a texture or buffer on its way to the CPU. Valid until the Renderer is destroyed. Copies share
// the same bytes; each may be polled, waited for and read on a thread of its own, beside the Renderer's.
class RAYGRAPH_API Readback {
  public:
    bool IsReady() const;  // the frame has completed
    void Wait() const;     // until IsReady()
    // Returns tightly packed rows, or the buffer's bytes. Throws Error{Usage} when not ready.
    std::span<const std::byte> Bytes() const;
    Extent2D Extent() const;
    rhi::Format Format() const;

  private:
    friend class Renderer;
    struct State;
    std::shared_ptr<State> m_state;
};

// The fate of a semaphore of a frame that is dropped.
enum class DropPolicy : uint8_t {
    Forward,     // waited for or signaled all the same, so that its other users can continue
    LeaveAlone,  // for the next frame to use
};

struct PassTiming {
    std::string name;
    double cpuMs = 0.0;  // recording
    double gpuMs = 0.0;  // between the pass's two timestamps
    PassKind kind = PassKind::Compute;
    PassId id = {};  // its id in its frame
};

struct FrameTiming {
    uint64_t frame = 0;
    double declareMs = 0.0;  // BeginFrame returned .. Execute called
    double compileMs = 0.0;
    double recordMs = 0.0;  // finding the resources and recording the commands
    double submitMs = 0.0;
    std::vector<PassTiming> passes;  // executed ones, in order
};

class RAYGRAPH_API Renderer {
  public:
    explicit Renderer(rhi::Device& device, const RendererDesc& desc = {});
    ~Renderer();  // waits for its frames
    Renderer(const Renderer&) = delete;
    Renderer& operator=(const Renderer&) = delete;

    rhi::Device& Device() const;

    // Waits until at most framesInFlight - 1 frames are pending, then starts declaring. A frame that is open
    // is dropped.
    void BeginFrame();
    // Returns whether BeginFrame would wait now: for a program that does something else meanwhile. Never
    // waits.
    bool WouldBlock() const;
    uint64_t FrameNumber() const;
    // Drops the open frame, for a program that continues after an Error while declaring: its semaphores are
    // forwarded now, not when the next frame begins. LeaveAlone forwards none of them, for a host that has
    // not submitted what signals the binary ones. Does nothing when no frame is open.
    void DropFrame(DropPolicy semaphores = DropPolicy::Forward);
    // Expires when the current frame has been executed or dropped: until then, everything that the frame was
    // declared from must stay unchanged. Already expired when no frame is open.
    std::weak_ptr<const void> OpenFrame() const;
    // Runs when the current frame has been submitted; discarded when it is dropped. Changes of state for the
    // whole frame belong here, those of a pass into CommandList::OnSubmitted, which a culled pass never
    // reaches. Must not throw.
    void OnSubmitted(std::function<void()> run);

    // --- Resources ---
    // Transient: contents live within the frame; memory is shared by resources with disjoint lifetimes.
    TextureId CreateTexture(std::string_view name, const GraphTextureDesc& desc);
    BufferId CreateBuffer(std::string_view name, const GraphBufferDesc& desc);
    // Persistent: found again by name in later frames, with contents and last access. A changed desc
    // recreates it when the frame is submitted.
    TextureId Persist(std::string_view name, const GraphTextureDesc& desc,
                      Persistence persistence = Persistence::OnDemand);
    BufferId PersistBuffer(std::string_view name, const GraphBufferDesc& desc,
                           Persistence persistence = Persistence::OnDemand);
    // Returns true for a persistent resource without contents: neither a submitted frame nor, before this id,
    // a pass of this one has written it, or some level of some layer of the part. For ids of the open frame.
    bool IsFresh(TextureId texture, const Subresources& part = {}) const;
    bool IsFresh(BufferId buffer) const;
    // Releases a persistent resource.
    void Forget(std::string_view name);
    // Imported: owned by the caller, alive until the frame has completed. `state` is read when the frame is
    // compiled and written back when it is submitted; it must outlive Execute. A resource that is imported
    // twice in a frame is one resource: the id of its newest version is returned. A resource that another
    // queue family released (state.queueFamily) is acquired before the first pass: the whole of a buffer,
    // an image with oldLayout = newLayout = state.layout. The state of a texture is one for all its levels
    // and layers: the frame leaves them in one layout. An acceleration structure is transferred with the
    // buffer that holds it, imported as well: with another family of its own it is refused when the frame
    // is compiled.
    TextureId Import(std::string_view name, const rhi::Texture& texture, ResourceState& state);
    BufferId Import(std::string_view name, const rhi::Buffer& buffer, ResourceState& state);
    TlasId Import(std::string_view name, const rhi::Tlas& tlas, ResourceState& state);
    BlasSetId ImportBlasSet(std::string_view name, ResourceState& state);
    TextureSetId Import(std::string_view name, const rhi::TextureTable& table);

    GraphTextureDesc Desc(TextureId texture) const;
    GraphBufferDesc Desc(BufferId buffer) const;

    // --- Passes ---
    using SetupFunction = std::function<void(PassBuilder&)>;
    using ExecuteFunction = std::function<void(CommandList&, const PassResources&)>;
    // `execute` takes (CommandList&) or (CommandList&, const PassResources&).
    template <typename Setup, typename ExecuteBody>
    PassId AddPass(std::string_view name, PassKind kind, Setup&& setup, ExecuteBody&& execute);

    // The id that the next pass of the open frame gets. Passes between two of them are those from the first
    // on, up to the second without it.
    PassId NextPass() const;

    // --- Roots: what the frame is for. Passes that lead to no root are culled. ---
    // The texture shown; left in the layout VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL unless exported.
    void Present(TextureId texture);
    // Hands an imported texture back in the given layout and queue family, or a buffer in the queue family.
    void Export(TextureId texture, VkImageLayout layout, uint32_t queueFamily = VK_QUEUE_FAMILY_IGNORED);
    void Export(BufferId buffer, uint32_t queueFamily = VK_QUEUE_FAMILY_IGNORED);
    Readback ReadBack(TextureId texture, uint32_t level = 0, uint32_t layer = 0);
    Readback ReadBack(BufferId buffer);
    // The frame's submission waits for, or signals, a semaphore of the host. A frame that is dropped
    // forwards those that it has been given: a submission without commands waits and signals in its
    // place, unless the device is lost. So the signal of a binary semaphore that the frame waits for must
    // be submitted before the frame can be dropped: before Execute and DropFrame, and before the
    // BeginFrame or the destructor that drops an open frame. Vulkan requires that of every wait for a
    // binary semaphore. If the signal comes later, give the semaphore with LeaveAlone, or drop its frame
    // by DropFrame(DropPolicy::LeaveAlone).
    void WaitSemaphore(const rhi::SemaphoreUse& semaphore, DropPolicy dropPolicy = DropPolicy::Forward);
    void SignalSemaphore(const rhi::SemaphoreUse& semaphore, DropPolicy dropPolicy = DropPolicy::Forward);

    // Compiles, records and submits; returns the timeline value that completes the frame. On an Error the
    // frame is dropped and the next BeginFrame starts clean.
    uint64_t Execute();
    // Compiles what has been declared so far without recording anything, for DescribePlan before Execute.
    void Compile();
    // Compiles, and begins to create the pipelines of the executed passes that are not there yet, each on a
    // thread of its own. Returns true if Execute will wait for none. A host whose frames must not wait for
    // pipelines, which may take seconds, drops the frame while this is false, shows what it has, and declares
    // it again; Execute waits for those that are being created.
    bool PreparePipelines();
    // Prepares the pipelines of the declared passes from `first` on, up to `end` without it, whether the open
    // frame will execute them or not. A caller can so declare both what it would like to show and what it can
    // show now, and use one of them. Error{Usage} for passes that are not declared.
    bool PreparePipelines(PassId first, PassId end);
    // Returns whether those are all there, without beginning to create any. One that could not be created is
    // not: it fails when it is needed.
    bool HasPipelines(PassId first, PassId end) const;
    // Returns whether any pipeline is being created on another thread. ReloadShaders, AddShader of other
    // words and the destructor wait for those.
    bool IsPreparingPipelines() const;
    // Called between frames: destroys the pipelines for which no frame of the last `lifetime` seconds has
    // declared a pass, culled or not. One that is needed again later is created again; one that is being
    // created stays. Without this call all are kept. Does nothing while a frame is open.
    void ForgetPipelines(double lifetime);

    // --- What happened ---
    bool WasExecuted(PassId pass) const;  // in the frame executed last: not culled
    // The plan of the last compiled frame: order, culled passes, barriers, lifetimes, aliases.
    std::string DescribePlan() const;
    std::string DescribePlanDot() const;  // Graphviz
    // The plan of the last frame as data, for tools that draw it. Both are valid until the next BeginFrame.
    // Error{Usage} before the first frame.
    struct CompiledFrame {
        const FrameGraph& graph;
        const Plan& plan;
    };
    CompiledFrame LastCompiled() const;
    // The latest frame whose GPU times have arrived; empty before that.
    const FrameTiming& Timing() const;
    // Returns all timings that arrived since the last call, oldest first.
    std::vector<FrameTiming> TakeTimings();
    // The milliseconds spent creating pipelines so far, and the number of pipelines.
    double PipelineCreationMs() const;
    uint32_t PipelineCount() const;
    // Returns the driver's statistics of each pipeline, by name: see rhi/pipeline_statistics.h. Waits for
    // those that are being created.
    std::vector<PipelineReport> PipelineReports();
    // Reloads shaders whose source changed under RendererDesc::shaderRoot. A shader that fails to compile
    // leaves its last good pipeline in use; the messages ("file:line: text") are returned. Error{Usage} while
    // a frame is open: its passes were checked against the shaders as they are.
    std::vector<std::string> ReloadShaders();

    // Shaders of passes outside the library: SPIR-V under a name, copied. Other words under a known name
    // rebuild the pipelines that use it; Error{Usage} while a frame is open, and if they do not fit those
    // passes: then the shader stays as it was.
    void AddShader(std::string_view name, std::span<const uint32_t> spirv);

  private:
    friend class PassBuilder;
    friend class PassResources;
    PassId AddPassErased(std::string_view name, PassKind kind, const SetupFunction& setup,
                         ExecuteFunction execute);

    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

template <typename Setup, typename ExecuteBody>
PassId Renderer::AddPass(std::string_view name, PassKind kind, Setup&& setup, ExecuteBody&& execute) {
    // The setup runs before this returns: a reference to it will do.
    if constexpr (std::is_invocable_v<ExecuteBody&, CommandList&, const PassResources&>)
        return AddPassErased(name, kind, std::ref(setup), std::forward<ExecuteBody>(execute));
    else
        return AddPassErased(name, kind, std::ref(setup),
                             [run = std::forward<ExecuteBody>(execute)](
                                 CommandList& commands, const PassResources&) mutable { run(commands); });
}

}  // namespace raygraph
