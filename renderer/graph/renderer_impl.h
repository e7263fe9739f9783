// The private state of Renderer. Only for the sources of renderer/graph.
#pragma once

#include <array>
#include <atomic>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/stopwatch.h"
#include "renderer/graph/compile.h"
#include "renderer/graph/frame_timer.h"
#include "renderer/graph/pass_declaration.h"
#include "renderer/graph/program.h"
#include "renderer/graph/renderer.h"
#include "renderer/graph/resource_pool.h"
#include "renderer/graph/shader_library.h"

namespace raygraph {

// Describes a readback: a mapped buffer and the frame that fills it. Its holders may poll it from any thread:
// members that change meanwhile are atomic, and the Renderer reuses the others only when no holder is left.
struct Readback::State {
    // Values of `submitted` that are no timeline values.
    static constexpr uint64_t kDeclared = 0;            // its frame is open
    static constexpr uint64_t kDropped = ~uint64_t{0};  // its frame never ran
    static constexpr uint64_t kRendererGone = kDropped - 1;

    rhi::Device* device = nullptr;
    rhi::Buffer buffer;
    uint64_t bytes = 0;
    Extent2D extent;
    rhi::Format format = rhi::Format::Undefined;
    std::atomic<uint64_t> submitted = kDeclared;
    std::atomic<bool> isHeld = false;  // a Readback holds it
    uint64_t frame = 0;                // the frame that uses it
};

// Holds the object behind a resource of the frame, parallel to FrameGraph::resources.
struct FrameResource {
    rhi::TextureUsage textureUsage = rhi::TextureUsage::None;  // all uses so far
    rhi::BufferUsage bufferUsage = rhi::BufferUsage::None;
    rhi::MemoryKind memory = rhi::MemoryKind::Device;
    const rhi::Texture* texture = nullptr;  // null for transients and persistents before Prepare
    const rhi::Buffer* buffer = nullptr;
    const rhi::Tlas* tlas = nullptr;
    const rhi::TextureTable* textures = nullptr;
    const ResourceState* blasState = nullptr;  // identifies the BLAS set
    ResourceState* state = nullptr;            // state of an import
    Persistent* persistent = nullptr;
    bool isConcurrent = false;    // a pass that may run on the compute queue uses it
    uint64_t* lastUse = nullptr;  // of a transient in a block: TransientPool's frame number of its last use
};

// Holds the semaphores that a frame waits for, or those that it signals.
struct FrameSemaphores {
    std::vector<rhi::SemaphoreUse> all;
    std::vector<rhi::SemaphoreUse> forwarded;  // the subset that is forwarded when the frame is dropped

    void Add(const rhi::SemaphoreUse& semaphore, DropPolicy dropPolicy) {
        all.push_back(semaphore);
        if (dropPolicy == DropPolicy::Forward) forwarded.push_back(semaphore);
    }
    void Clear() {
        all.clear();
        forwarded.clear();
    }
};

// SeriesFrame decides what the open frame executes of a series.
class SeriesFrame {
  public:
    SeriesFrame(PassSeries& series, double milliseconds)
        : m_series(&series),
          m_next(series.m_done),
          m_leftMs(milliseconds > 0.0 ? milliseconds : std::numeric_limits<double>::infinity()),
          m_isDivided(milliseconds > 0.0 || series.IsBegun()) {}

    // Returns false if this frame executes all of the series, as if there was none.
    bool IsDivided() const { return m_isDivided; }
    // Returns the name under which the next resource is kept.
    std::string NameOf(std::string_view resource);
    // Returns the parts of the next pass that this frame executes: from `first` to before `end`, none if both
    // are equal. Parts of a pass that cannot be divided are all or none.
    struct Parts {
        uint32_t first = 0;
        uint32_t end = 0;
        bool IsEmpty() const { return first == end; }
    };
    Parts Take(std::string_view pass, bool isDividable, PassId id, uint64_t frame);
    bool Keeps(std::string_view resource) const;
    // Records that the pass taken last uses the resource of that name.
    void NoteUse(std::string_view resource);
    bool IsComplete() const { return !m_isFull; }
    // Returns the passes of which this frame executes some parts.
    std::vector<PassId> Taken() const;
    // Must be called when the frame has been submitted. Returns the resources that no later frame needs.
    std::vector<std::string> Commit();

  private:
    double CostOf(std::string_view pass, uint32_t index) const;

    PassSeries* m_series;
    PassSeries::Place m_next;
    double m_leftMs;
    bool m_isDivided;
    uint32_t m_passCount = 0;
    bool m_isFull = false;             // later passes wait for another frame
    std::vector<std::string> m_names;  // of the passes
    std::vector<PassSeries::Kept> m_kept;
    std::vector<PassSeries::Executed> m_executed;
};

struct Renderer::Impl {
    Impl(Renderer& owner, rhi::Device& rhiDevice, const RendererDesc& desc);

    // --- Declaring (renderer.cpp) ---
    // Throws Error{Usage} outside of a frame, or in one that failed.
    void RequireOpen(std::string_view what) const;
    template <ResourceKind Kind>
    ResourceId<Kind> AddResource(const GraphResource& resource, const FrameResource& behind,
                                 std::span<const ResourceState> otherStates = {});
    template <ResourceKind Kind, typename Object>
    ResourceId<Kind> ImportObject(std::string_view name, const Object& object,
                                  const Object* FrameResource::*member, GraphResource resource,
                                  ResourceState* state);
    // Must be called by every declaration: `plan` is no longer that of the frame.
    void Change();
    template <ResourceKind Kind, typename ResourceDesc>
    ResourceId<Kind> PersistResource(std::string_view name, const ResourceDesc& desc, Persistence persistence,
                                     GraphResource resource);
    bool HasNoContents(AnyId id, const Subresources& requested) const;
    void CheckTexture(std::string_view name, const GraphTextureDesc& desc) const;
    const rhi::Sampler* FindSampler(const rhi::SamplerDesc& desc);
    void StartPass(std::string_view name, PassKind kind);
    // Returns whether the passes that are declared now belong to a series of several frames.
    bool IsDivided() const { return openSeries && openSeries->IsDivided(); }
    void TakeIntoSeries(DeclaredPass& pass);
    void FinishPass(DeclaredPass& pass);
    void CollectUsages(const GraphPass& pass);
    BufferId AddReadback(const std::shared_ptr<Readback::State>& state, std::string_view name);
    std::shared_ptr<Readback::State> TakeReadback(uint64_t bytes);

    // --- Executing (renderer_execute.cpp) ---
    //
    // Returns the passes [first, end) of the open frame; throws Error{Usage} for passes of others.
    std::span<const DeclaredPass> PassesBetween(PassId first, PassId end, std::string_view what) const;
    void CompileFrame();
    void FindRequirements(size_t resource);
    void Prepare();
    void PlaceTransient(size_t resource, bool areLastValid);
    uint64_t TakeUniform(uint64_t bytes);
    void FillAddresses(const DeclaredPass& pass);
    void UploadUniforms();
    void Record(rhi::CommandList& commands, const PlannedBatch& batch, FrameTiming& timing);
    rhi::Submission SubmitBatches(FrameTiming& timing, const Stopwatch& recording);
    void RecordPass(rhi::CommandList& commands, const PlannedPass& planned);
    void RecordBarriers(rhi::CommandList& commands, const BarrierRange& range, bool holdsTransfers);
    void BindPass(rhi::CommandList& commands, const DeclaredPass& pass);
    void BeginTargets(rhi::CommandList& commands, const DeclaredPass& pass);
    rhi::Submission Submit(FrameTiming& timing, VkCommandBuffer host);
    // Executes the open frame, or records it into a buffer of the host; on an Error it is dropped.
    rhi::Submission Finish(std::string_view call, VkCommandBuffer host);
    void MarkWritten(const ResourceUse& use);
    void Commit(uint64_t value);
    void Abandon(std::string why);
    // Returns the resource behind an id that the pass has declared; throws Error{Usage} otherwise.
    uint32_t DeclaredBy(uint32_t pass, AnyId id) const;
    // Ends the frame, executed or not.
    void CloseFrame();
    // Ends a frame that was not submitted.
    void DropFrame();
    void ForwardSemaphores() noexcept;

    Renderer& renderer;
    rhi::Device& device;
    ShaderLibrary shaders;
    ProgramCache programs;
    TransientPool transients;
    PersistentStore persistents;
    std::vector<std::pair<rhi::SamplerDesc, std::unique_ptr<rhi::Sampler>>> samplers;
    FrameTimer timer;
    std::unique_ptr<PassMarks> marks;            // null: marks are off
    std::shared_ptr<const void> lastPassReport;  // keeps `marks` registered with the device
    std::vector<std::shared_ptr<Readback::State>> readbacks;

    // The current frame.
    uint64_t frameNumber = 0;
    bool isOpen = false;  // between BeginFrame and Execute
    // What OpenFrame returns for the open frame, if it has been called.
    mutable std::shared_ptr<const uint64_t> openFrame;
    std::string abandonReason;  // why the open frame cannot be executed; empty: it can
    bool CanExecute() const { return isOpen && abandonReason.empty(); }
    bool isCompiled = false;  // `plan` is that of `graph`
    bool isRepeated = false;  // and the last frame had the same, so that `lastPlan` is not valid
    FrameGraph graph;
    Plan plan;
    CompileMemory compileMemory;
    Arena passMemory;                      // what DeclaredPass refers to
    std::vector<FrameResource> resources;  // by FrameGraph::resources
    PassDeclaration declaration;           // of the pass whose setup runs
    std::vector<DeclaredPass> passes;      // may be longer than FrameGraph::passes, for the next frame
    std::vector<std::byte> uniformBytes;   // all uniform data of the frame
    FrameSemaphores waits;
    FrameSemaphores signals;
    std::vector<std::function<void()>> onSubmitted;
    std::optional<SeriesFrame> openSeries;      // between BeginSeries and EndSeries
    std::vector<std::string> unneededOfSeries;  // persistent resources to be released after the frame
    Stopwatch sinceBegin;
    double compileMs = 0.0;

    // The last compiled frame, even after the next one has begun.
    FrameGraph lastGraph;
    Plan lastPlan;
    std::vector<FrameResource> lastResources;
    bool hasLastPlan = false;
    std::vector<ResourceState> blockStates;  // of transient memory, as the last submitted frame left it

    // By frame in flight.
    std::vector<uint64_t> submitted;
    // Returns the submission that must complete before the next frame begins.
    uint64_t OldestInFlight() const { return submitted[(frameNumber + 1) % submitted.size()]; }
    std::vector<rhi::Buffer> uniformBuffers;
    uint64_t lastSubmitted = 0;
    std::vector<uint8_t> wasExecuted;  // by pass of the frame executed last

    // Members that keep their memory from frame to frame.
    std::vector<VkImageMemoryBarrier2> imageBarriers;
    std::vector<VkBufferMemoryBarrier2> bufferBarriers;
    std::vector<rhi::BoundResource> bound;
    std::vector<rhi::ColorTarget> colorTargets;
    std::vector<Program*> neededPrograms;
    std::vector<rhi::CommandList> batchLists;
    std::vector<rhi::Submission> batchSubmissions;
    std::vector<rhi::SemaphoreUse> batchWaits;
    std::string label;
};

}  // namespace raygraph
