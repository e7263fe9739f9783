// Renderer: declares, compiles and submits the render graphs of one frame after the other on one Device.
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
#include <type_traits>
#include <utility>
#include <vector>

#include "base/api.h"
#include "base/arena.h"
#include "renderer/graph/access.h"
#include "renderer/graph/frame_graph.h"
#include "renderer/graph/ids.h"
#include "renderer/graph/pass_builder.h"
#include "renderer/graph/pass_series.h"
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
    // The folder of shader sources from which stages are reloaded; with "", the SPIR-V in the library is
    // used.
    std::filesystem::path shaderRoot;
    // Further include folders for those sources, such as the installed shaders for passes outside the
    // library.
    std::vector<std::filesystem::path> shaderIncludes = {};
    bool gpuTimes = true;   // a timestamp between passes
    bool passMarks = true;  // record on the device which pass was reached, for the report of a lost device
    // The number of frames whose timings wait for TakeTimings; older ones are dropped. With 0, a host that
    // looks at Timing() alone allocates no memory for the others.
    uint32_t keptTimings = 4096;
};

// Describes a texture of the graph. Its usage flags follow from the passes that use it.
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

// The resources of a pass, for execute functions that copy or build. Throws Error{Usage} for an id that the
// pass has not declared.
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

// Holds what a pass executes, in the memory of its frame. For AddPass alone.
class RAYGRAPH_API PassBody {
  public:
    PassBody() = default;
    PassBody(PassBody&& other) noexcept { *this = std::move(other); }
    PassBody& operator=(PassBody&& other) noexcept {
        if (this == &other) return *this;
        if (m_destroy) m_destroy(m_body);
        m_body = std::exchange(other.m_body, nullptr);
        m_run = std::exchange(other.m_run, nullptr);
        m_destroy = std::exchange(other.m_destroy, nullptr);
        return *this;
    }
    ~PassBody() {
        if (m_destroy) m_destroy(m_body);
    }

    template <typename Body>
    static PassBody In(Arena& memory, Body&& given) {
        using Own = std::decay_t<Body>;
        PassBody body;
        body.m_body = new (memory.Take(sizeof(Own), alignof(Own))) Own(std::forward<Body>(given));
        body.m_run = [](void* own, CommandList& commands, const PassResources& resources) {
            if constexpr (std::is_invocable_v<Own&, CommandList&, const PassResources&>)
                (*static_cast<Own*>(own))(commands, resources);
            else
                (*static_cast<Own*>(own))(commands);
        };
        if constexpr (!std::is_trivially_destructible_v<Own>)
            body.m_destroy = [](void* own) { static_cast<Own*>(own)->~Own(); };
        return body;
    }
    void operator()(CommandList& commands, const PassResources& resources) {
        m_run(m_body, commands, resources);
    }

  private:
    void* m_body = nullptr;
    void (*m_run)(void*, CommandList&, const PassResources&) = nullptr;
    void (*m_destroy)(void*) = nullptr;  // null: there is nothing to destroy
};

// A copy of a texture or buffer that is read back by the CPU. Valid until the Renderer is destroyed. Copies
// of this object share the same bytes; each may be polled, waited for and read on its own thread, beside the
// Renderer's.
class RAYGRAPH_API Readback {
  public:
    bool IsReady() const;  // the frame has completed
    void Wait() const;     // until IsReady()
    // Returns tightly packed rows, or the buffer's bytes. Throws Error{Usage} if the readback is not ready.
    std::span<const std::byte> Bytes() const;
    Extent2D Extent() const;
    rhi::Format Format() const;

  private:
    friend class Renderer;
    struct State;
    std::shared_ptr<State> m_state;
};

// Says whether a dropped frame still waits for or signals a semaphore.
enum class DropPolicy : uint8_t {
    Forward,     // waited for or signaled nevertheless, so that its other users can continue
    LeaveAlone,  // not used, for the next frame
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
    double recordMs = 0.0;  // time for finding the resources and recording the commands
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

    // Waits until at most framesInFlight - 1 frames are pending, then opens a frame for declarations. Drops a
    // frame that is still open.
    void BeginFrame();
    // Returns whether BeginFrame would wait now, for a program that can do something else meanwhile. Never
    // waits.
    bool WouldBlock() const;
    uint64_t FrameNumber() const;
    // Drops the open frame, for a program that continues after an Error in its declarations. Its semaphores
    // are forwarded now, not when the next frame begins. LeaveAlone forwards none of them, for a host that
    // has not yet submitted the signals of the binary ones. Does nothing when no frame is open.
    void DropFrame(DropPolicy semaphores = DropPolicy::Forward);
    // Returns a pointer that expires when the current frame has been executed or dropped: until then,
    // everything from which the frame was declared must stay unchanged. It has expired already if no frame is
    // open.
    std::weak_ptr<const void> OpenFrame() const;
    // Calls `run` when the current frame has been submitted, and discards it when the frame is dropped. State
    // changes of the whole frame belong here, those of a pass into CommandList::OnSubmitted, which a culled
    // pass never reaches. `run` must not throw.
    void OnSubmitted(std::function<void()> run);

    // --- Resources ---
    // Transient: its contents live within the frame, and resources with disjoint lifetimes share memory.
    TextureId CreateTexture(std::string_view name, const GraphTextureDesc& desc);
    BufferId CreateBuffer(std::string_view name, const GraphBufferDesc& desc);
    // Persistent: later frames find it by name, with its contents and last access. A changed description
    // recreates it when the frame is submitted.
    TextureId Persist(std::string_view name, const GraphTextureDesc& desc,
                      Persistence persistence = Persistence::OnDemand);
    BufferId PersistBuffer(std::string_view name, const GraphBufferDesc& desc,
                           Persistence persistence = Persistence::OnDemand);
    // Returns true for a persistent resource without contents: no submitted frame has written it, nor has a
    // pass of this frame before this id. Also true if that holds for some level of some layer of the part.
    // For ids of the open frame.
    bool IsFresh(TextureId texture, const Subresources& part = {}) const;
    bool IsFresh(BufferId buffer) const;
    // Releases a persistent resource.
    void Release(std::string_view name);
    // Imported: the resource is owned by the caller, and must live until the frame has completed. `state` is
    // read when the frame is compiled and written back when it is submitted; it must outlive Execute. A
    // resource that is imported twice in a frame is one resource: the id of its newest version is returned. A
    // resource that another queue family has released (state.queueFamily) is acquired before the first pass:
    // the whole of a buffer, or an image with oldLayout = newLayout = state.layout. A texture has one state
    // for all its levels and layers, and the frame leaves them in one layout. An acceleration structure is
    // transferred with the buffer that holds it, which must be imported as well: if it has a queue family of
    // its own, compiling the frame throws Error{Usage}.
    TextureId Import(std::string_view name, const rhi::Texture& texture, ResourceState& state);
    BufferId Import(std::string_view name, const rhi::Buffer& buffer, ResourceState& state);
    TlasId Import(std::string_view name, const rhi::Tlas& tlas, ResourceState& state);
    BlasSetId ImportBlasSet(std::string_view name, ResourceState& state);
    TextureSetId Import(std::string_view name, const rhi::TextureTable& table);

    GraphTextureDesc Desc(TextureId texture) const;
    GraphBufferDesc Desc(BufferId buffer) const;

    // --- Passes ---
    // `setup` takes (PassBuilder&) and runs now. `execute` takes (CommandList&) or (CommandList&,
    // const PassResources&), and runs when the frame is executed.
    template <typename Setup, typename ExecuteBody>
    PassId AddPass(std::string_view name, PassKind kind, Setup&& setup, ExecuteBody&& execute);

    // Returns the id that the next pass of the open frame will get. A range of passes [first, end) is given
    // by two of these.
    PassId NextPass() const;

    // --- Series: passes that are executed over several frames (renderer/graph/pass_series.h) ---
    // Passes declared until EndSeries are those of the series. This frame executes as many as take about
    // `milliseconds`; with 0, all that remain. Error{Usage}: a series is open, or for the others, none is.
    void BeginSeries(PassSeries& series, double milliseconds);
    // Returns true if this frame executes the last pass: only then may the results be used.
    [[nodiscard]] bool EndSeries();
    // Ends the open series as if this frame had not declared it: none of its passes is executed.
    void CancelSeries();
    // Discards what was executed, and releases what is kept: the next frame starts with the first pass.
    void Release(PassSeries& series);

    // --- Roots: the results of the frame. Passes that lead to no root are culled. ---
    // Shows the texture, which is left in the layout VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL unless it is
    // exported.
    void Present(TextureId texture);
    // Hands an imported texture back in the given layout and queue family, or a buffer in the queue family.
    void Export(TextureId texture, VkImageLayout layout, uint32_t queueFamily = VK_QUEUE_FAMILY_IGNORED);
    void Export(BufferId buffer, uint32_t queueFamily = VK_QUEUE_FAMILY_IGNORED);
    Readback ReadBack(TextureId texture, uint32_t level = 0, uint32_t layer = 0);
    Readback ReadBack(BufferId buffer);
    // The frame's submission waits for, or signals, a semaphore of the host. A frame that is dropped forwards
    // its semaphores: a submission without commands waits and signals instead, unless the device is lost.
    // Hence the signal of a binary semaphore for which the frame waits must be submitted before the frame can
    // be dropped: before Execute and DropFrame, and before the BeginFrame or the destructor that drops an
    // open frame. Vulkan requires this of every wait for a binary semaphore. If the signal is submitted
    // later, pass LeaveAlone here, or drop the frame by DropFrame(DropPolicy::LeaveAlone).
    void WaitSemaphore(const rhi::SemaphoreUse& semaphore, DropPolicy dropPolicy = DropPolicy::Forward);
    void SignalSemaphore(const rhi::SemaphoreUse& semaphore, DropPolicy dropPolicy = DropPolicy::Forward);

    // Compiles, records and submits the frame; returns what completes it. On an Error the frame is dropped,
    // and the next BeginFrame starts without it.
    rhi::Submission Execute();
    // Records the frame into a primary command buffer of the host, in place of Execute, and submits nothing.
    // The buffer is of the device's queue family, in the recording state and outside of rendering; what was
    // bound in it is lost. Imported resources are expected as Import says, and left as Export says; all
    // else that orders them with other commands is the host's. The host submits the buffer exactly once, to
    // the device's queue and before later frames, and passes what is returned to rhi::Device::Complete when
    // that has completed: until then the frame counts as in flight. Throws Error{Usage} for a frame with
    // semaphores, which belong to the host's submission. On an Error the frame is dropped, and the host
    // resets the buffer, into which a part may have been recorded.
    rhi::Submission Record(VkCommandBuffer commands);
    // Compiles the declarations so far without recording anything, for DescribePlan before Execute.
    void Compile();
    // Compiles, and begins to create the missing pipelines of the executed passes, each on its own thread.
    // Returns true if Execute will wait for none. A host whose frames must not wait for pipelines, which may
    // take seconds, drops the frame while this returns false, shows an earlier picture, and declares the
    // frame again. Execute waits for pipelines that are being created.
    bool PreparePipelines();
    // Prepares the pipelines of the declared passes [first, end), whether the open frame will execute them or
    // not. Hence a caller can declare both the passes that it would like to show and those that it can show
    // now, and use one of the two. Throws Error{Usage} for passes that are not declared.
    bool PreparePipelines(PassId first, PassId end);
    // Returns whether all these pipelines exist, without beginning to create any. A pipeline whose creation
    // has failed does not count as existing: it fails when it is needed.
    bool HasPipelines(PassId first, PassId end) const;
    // Returns whether any pipeline is being created on another thread. ReloadShaders, the destructor, and an
    // AddShader that changes a shader wait for those.
    bool IsPreparingPipelines() const;
    // Destroys the pipelines for which no frame of the last `lifetime` seconds has declared a pass, culled or
    // not. Must be called between frames; does nothing while a frame is open. A pipeline that is needed again
    // is created again, and one that is being created stays. Without this call all are kept.
    void ReleasePipelines(double lifetime);

    // --- Reports ---
    bool WasExecuted(PassId pass) const;  // in the frame executed last: not culled
    // Returns the plan of the last compiled frame: order, culled passes, barriers, lifetimes, aliases.
    std::string DescribePlan() const;
    std::string DescribePlanDot() const;  // Graphviz
    // Holds the plan of the last frame as data, for tools that draw it. Both pointers are valid until the
    // next BeginFrame. Throws Error{Usage} before the first frame.
    struct CompiledFrame {
        const FrameGraph& graph;
        const Plan& plan;
    };
    CompiledFrame LastCompiled() const;
    // Returns the latest frame whose GPU times have arrived; empty before the first.
    const FrameTiming& Timing() const;
    // Returns all timings that arrived since the last call, oldest first, of up to
    // RendererDesc::keptTimings frames.
    std::vector<FrameTiming> TakeTimings();
    // Returns the milliseconds spent on creating pipelines so far, and the number of pipelines.
    double PipelineCreationMs() const;
    uint32_t PipelineCount() const;
    // Returns the driver's statistics of each pipeline, by name: see rhi/pipeline.h. Waits for
    // pipelines that are being created.
    std::vector<PipelineReport> PipelineReports();
    // Reloads shaders whose source changed under RendererDesc::shaderRoot. A shader that fails to compile
    // leaves its last good pipeline in use, and the messages ("file:line: text") are returned. Throws
    // Error{Usage} while a frame is open, because its passes were checked against the current shaders.
    std::vector<std::string> ReloadShaders();

    // Adds the SPIR-V of a pass outside the library under a name, as a copy. Other words under a known name
    // rebuild the pipelines that use it. Throws Error{Usage} while a frame is open, and if the words do not
    // fit those passes, in which case the shader does not change.
    void AddShader(std::string_view name, std::span<const uint32_t> spirv);

  private:
    friend class PassBuilder;
    friend class PassResources;
    PassId AddPassErased(std::string_view name, PassKind kind, void (*setup)(const void*, PassBuilder&),
                         const void* setupData, PassBody execute);
    Arena& BodyMemory();

    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

template <typename Setup, typename ExecuteBody>
PassId Renderer::AddPass(std::string_view name, PassKind kind, Setup&& setup, ExecuteBody&& execute) {
    // The setup runs before this call returns, so that a reference is enough.
    const auto runSetup = [&setup](PassBuilder& builder) { setup(builder); };
    const auto call = [](const void* data, PassBuilder& builder) {
        (*static_cast<const decltype(runSetup)*>(data))(builder);
    };
    return AddPassErased(name, kind, call, &runSetup,
                         PassBody::In(BodyMemory(), std::forward<ExecuteBody>(execute)));
}

}  // namespace raygraph
