#include "renderer/graph/renderer.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "base/error.h"
#include "base/printable.h"
#include "base/text.h"
#include "renderer/graph/access.h"
#include "renderer/graph/plan_text.h"
#include "renderer/graph/queue_plan.h"
#include "renderer/graph/renderer_impl.h"
#include "renderer/graph/text.h"

namespace raygraph {

namespace {

uint32_t ComputeFamilyOf(const rhi::Device& device) {
    const auto queue = rhi::QueueKind::Compute;
    return device.HasQueue(queue) ? device.QueueFamily(queue) : VK_QUEUE_FAMILY_IGNORED;
}

}  // namespace

Renderer::Impl::Impl(Renderer& owner, rhi::Device& rhiDevice, const RendererDesc& desc)
    : renderer(owner),
      device(rhiDevice),
      shaders(desc.shaderRoot, desc.shaderIncludes),
      programs(rhiDevice),
      transients(rhiDevice),
      timer(rhiDevice, desc.gpuTimes, desc.keptTimings),
      submitted(rhiDevice.FramesInFlight(), 0),
      uniformBuffers(rhiDevice.FramesInFlight()) {
    graph.queueFamily = device.QueueFamily();
    if (!desc.passMarks) return;
    marks = std::make_unique<PassMarks>(device);
    lastPassReport = device.AddLastPassReport([this, name = desc.name] {
        const std::string report = marks->Report();
        return name.empty() || report.empty() ? report : "renderer " + Quoted(name) + ": " + report;
    });
}

Renderer::Renderer(rhi::Device& device, const RendererDesc& desc)
    : m_impl(std::make_unique<Impl>(*this, device, desc)) {}

Renderer::~Renderer() {
    DropFrame();
    try {
        m_impl->device.WaitFor({m_impl->lastSubmitted});
    } catch (const Error&) {
        // A lost device completes nothing. What a pending buffer of the host uses is retired, and kept.
    }
    for (const std::shared_ptr<Readback::State>& readback : m_impl->readbacks) {
        readback->submitted = Readback::State::kRendererGone;
        readback->buffer = {};
    }
}

rhi::Device& Renderer::Device() const {
    return m_impl->device;
}

uint64_t Renderer::FrameNumber() const {
    return m_impl->frameNumber;
}

void Renderer::BeginFrame() {
    Impl& impl = *m_impl;
    if (impl.isOpen) impl.DropFrame();
    if (impl.isCompiled) {
        std::swap(impl.graph, impl.lastGraph);
        std::swap(impl.plan, impl.lastPlan);
        std::swap(impl.resources, impl.lastResources);
        impl.graph.queueFamily = impl.lastGraph.queueFamily;
        impl.hasLastPlan = true;
        impl.isCompiled = impl.isRepeated = false;
    }
    const uint64_t next = impl.frameNumber + 1;
    impl.device.WaitFor({impl.OldestInFlight()});
    impl.timer.Poll();

    impl.frameNumber = next;
    impl.graph.Begin(next);
    impl.graph.computeFamily = ComputeFamilyOf(impl.device);
    impl.graph.blockStates = impl.blockStates;
    impl.resources.clear();
    impl.uniformBytes.clear();
    impl.openSeries.reset();
    impl.abandonReason.clear();
    impl.compileMs = 0.0;
    impl.isOpen = true;
    impl.sinceBegin = {};
}

bool Renderer::WouldBlock() const {
    return !m_impl->device.HasCompleted({m_impl->OldestInFlight()});
}

void Renderer::DropFrame(DropPolicy semaphores) {
    if (!m_impl->isOpen) return;
    if (semaphores == DropPolicy::LeaveAlone)
        m_impl->CloseFrame();
    else
        m_impl->DropFrame();
}

std::weak_ptr<const void> Renderer::OpenFrame() const {
    if (m_impl->CanExecute() && !m_impl->openFrame)
        m_impl->openFrame = std::make_shared<const uint64_t>(m_impl->frameNumber);
    return m_impl->openFrame;
}

void Renderer::OnSubmitted(std::function<void()> run) {
    m_impl->RequireOpen("OnSubmitted");
    m_impl->onSubmitted.push_back(std::move(run));
}

void Renderer::Impl::Abandon(std::string why) {
    abandonReason = std::move(why);
    openFrame = nullptr;
}

void Renderer::Impl::DropFrame() {
    ForwardSemaphores();
    CloseFrame();
}

// A failure here is ignored: it follows the Error that dropped the frame, which says more.
void Renderer::Impl::ForwardSemaphores() noexcept {
    if (waits.forwarded.empty() && signals.forwarded.empty()) return;
    try {
        lastSubmitted = device.Forward(waits.forwarded, signals.forwarded).value;
    } catch (const std::exception& failure) {
        WriteLog(device.Log(), LogLevel::Warning, log_category::kGraph,
                 "the semaphores of a dropped frame are not signalled: {}", failure.what());
    }
}

void Renderer::Impl::CloseFrame() {
    isOpen = false;
    openFrame = nullptr;
    onSubmitted.clear();
    waits.Clear();
    signals.Clear();
    persistents.DropReplacements();
    // The execute functions may keep captured objects alive.
    for (DeclaredPass& pass : passes) pass.execute = {};
    passMemory.Clear();
    for (const std::shared_ptr<Readback::State>& readback : readbacks)
        if (readback->submitted == Readback::State::kDeclared)
            readback->submitted = Readback::State::kDropped;
}

bool Renderer::WasExecuted(PassId pass) const {
    return pass.index < m_impl->wasExecuted.size() && m_impl->wasExecuted[pass.index] != 0;
}

std::string Renderer::DescribePlan() const {
    const auto& [graph, plan] = LastCompiled();
    return raygraph::DescribePlan(graph, plan);
}

std::string Renderer::DescribePlanDot() const {
    const auto& [graph, plan] = LastCompiled();
    return raygraph::DescribePlanDot(graph, plan);
}

Renderer::CompiledFrame Renderer::LastCompiled() const {
    if (m_impl->isCompiled) return {m_impl->graph, m_impl->plan};
    if (m_impl->hasLastPlan) return {m_impl->lastGraph, m_impl->lastPlan};
    throw Error(ErrorKind::Usage, "there is no plan: no frame has been compiled yet");
}

const FrameTiming& Renderer::Timing() const {
    m_impl->timer.Poll();
    return m_impl->timer.Latest();
}

std::vector<FrameTiming> Renderer::TakeTimings() {
    m_impl->timer.Poll();
    return m_impl->timer.TakeAll();
}

double Renderer::PipelineCreationMs() const {
    return m_impl->programs.CreationMs();
}

uint32_t Renderer::PipelineCount() const {
    return m_impl->programs.PipelineCount();
}

std::vector<PipelineReport> Renderer::PipelineReports() {
    return m_impl->programs.Reports();
}

std::vector<std::string> Renderer::ReloadShaders() {
    if (m_impl->CanExecute())
        throw Error(ErrorKind::Usage,
                    "ReloadShaders: a frame is open; it comes before BeginFrame or after Execute");
    return WithMemoryErrors("ReloadShaders", [&] {
        const Stopwatch watch;
        m_impl->programs.WaitForPipelines();
        ShaderLibrary::ReloadResult reloaded = m_impl->shaders.Reload();
        std::vector<std::string> messages = m_impl->programs.Rebuild(reloaded.changed);
        messages.insert(messages.begin(), reloaded.messages.begin(), reloaded.messages.end());
        const Log& log = m_impl->device.Log();
        for (const std::string& message : messages)
            log.Send(LogLevel::Warning, log_category::kShaders, message);
        if (const size_t count = reloaded.changed.size(); count > 0)
            WriteLog(log, LogLevel::Info, log_category::kShaders, "{} reloaded in {}",
                     Counted(count, "changed shader is", "changed shaders are"),
                     DurationText(watch.Seconds()));
        return messages;
    });
}

void Renderer::AddShader(std::string_view name, std::span<const uint32_t> spirv) {
    Impl& impl = *m_impl;
    const Shader* known = impl.shaders.FindLoaded(name);
    if (!known) {
        impl.shaders.Add(name, spirv);
        return;
    }
    if (std::ranges::equal(known->words, spirv)) return;
    const std::string subject = "AddShader " + Quoted(name) + ": ";
    if (impl.CanExecute())
        throw MakeError(ErrorKind::Usage,
                        "{}a frame is open, and its passes were checked against the shader of that name; it "
                        "comes before BeginFrame or after Execute",
                        subject);
    impl.programs.WaitForPipelines();
    const std::vector<uint32_t> before(known->words.begin(), known->words.end());
    impl.shaders.Add(name, spirv);
    const std::vector<std::string> problems = impl.programs.Rebuild({&known, 1});
    if (problems.empty()) return;
    impl.shaders.Add(name, before);
    impl.programs.Rebuild({&known, 1});
    throw MakeError(ErrorKind::Usage, "{}the one that was there stays, since {}", subject, problems.front());
}

// --- The declaration of a frame: resources, passes, roots ---

namespace {

// Returns all fields except the name. A new field of the description breaks the build until it is listed
// here.
auto PartsOf(const rhi::SamplerDesc& desc) {
    const auto& [name, magFilter, minFilter, mipFilter, addressU, addressV, maxAnisotropy] = desc;
    return std::tie(magFilter, minFilter, mipFilter, addressU, addressV, maxAnisotropy);
}

GraphResource TextureInfo(std::string_view name, Origin origin, const GraphTextureDesc& desc) {
    return {.name = name,
            .origin = origin,
            .extent = desc.extent,
            .format = desc.format,
            .levels = desc.levels,
            .layers = desc.layers};
}

GraphResource BufferInfo(std::string_view name, Origin origin, uint64_t bytes) {
    return {.name = name, .origin = origin, .bytes = bytes};
}

GraphResource ImportInfo(std::string_view name) {
    return {.name = name, .origin = Origin::Imported};
}

void CheckBuffer(std::string_view name, const GraphBufferDesc& desc, bool mayUpload) {
    if (desc.size == 0) throw MakeError(ErrorKind::Usage, "buffer {}: its size is zero", Quoted(name));
    if (desc.memory == rhi::MemoryKind::Readback)
        throw MakeError(ErrorKind::Usage, "buffer {}: Readback memory is what ReadBack uses", Quoted(name));
    if (desc.memory == rhi::MemoryKind::Upload && !mayUpload)
        throw MakeError(
            ErrorKind::Usage,
            "buffer {}: a persistent buffer in Upload memory would be written while frames in flight read it",
            Quoted(name));
}

}  // namespace

void Renderer::Impl::RequireOpen(std::string_view what) const {
    if (!isOpen) throw MakeError(ErrorKind::Usage, "{}: no frame has been begun (BeginFrame)", what);
    if (!abandonReason.empty())
        throw MakeError(ErrorKind::Usage, "{}: the frame is given up, since {}", what, abandonReason);
}

void Renderer::Impl::CheckTexture(std::string_view name, const GraphTextureDesc& desc) const {
    if (desc.extent.IsEmpty())
        throw MakeError(ErrorKind::Usage, "texture {}: its extent {}x{} is empty", Quoted(name),
                        desc.extent.width, desc.extent.height);
    if (desc.format == rhi::Format::Undefined)
        throw MakeError(ErrorKind::Usage, "texture {}: it has no format", Quoted(name));
    if (const uint32_t most = rhi::FullMipCount(desc.extent); desc.levels == 0 || desc.levels > most)
        throw MakeError(ErrorKind::Usage, "texture {}: {} levels; {}x{} texels have 1 to {}", Quoted(name),
                        desc.levels, desc.extent.width, desc.extent.height, most);
    if (const uint32_t most = device.Info().maxTextureLayers; desc.layers == 0 || desc.layers > most)
        throw MakeError(ErrorKind::Usage, "texture {}: {} layers; the device {} has 1 to {}", Quoted(name),
                        desc.layers, device.Info().name, most);
}

void Renderer::Impl::Change() {
    isCompiled = false;
    if (std::exchange(isRepeated, false)) std::swap(plan, lastPlan);
}

template <ResourceKind Kind>
ResourceId<Kind> Renderer::Impl::AddResource(const GraphResource& resource, const FrameResource& behind,
                                             std::span<const ResourceState> otherStates) {
    const ResourceId<Kind> id = graph.Add<Kind>(resource, otherStates);
    resources.push_back(behind);
    Change();
    return id;
}

TextureId Renderer::CreateTexture(std::string_view name, const GraphTextureDesc& desc) {
    m_impl->RequireOpen("CreateTexture");
    m_impl->CheckTexture(name, desc);
    if (m_impl->IsDivided()) return Persist(m_impl->openSeries->NameOf(name), desc, Persistence::Always);
    return m_impl->AddResource<ResourceKind::Texture>(TextureInfo(name, Origin::Transient, desc), {});
}

BufferId Renderer::CreateBuffer(std::string_view name, const GraphBufferDesc& desc) {
    m_impl->RequireOpen("CreateBuffer");
    CheckBuffer(name, desc, true);
    if (m_impl->IsDivided() && desc.memory == rhi::MemoryKind::Device)
        return PersistBuffer(m_impl->openSeries->NameOf(name), desc, Persistence::Always);
    GraphResource resource = BufferInfo(name, Origin::Transient, desc.size);
    resource.isHostWritten = desc.memory == rhi::MemoryKind::Upload;
    return m_impl->AddResource<ResourceKind::Buffer>(resource, {.memory = desc.memory});
}

template <ResourceKind Kind, typename ResourceDesc>
ResourceId<Kind> Renderer::Impl::PersistResource(std::string_view name, const ResourceDesc& desc,
                                                 Persistence persistence, GraphResource resource) {
    RequireOpen("Persist");
    if (Persistent* known = persistents.Declared(name, frameNumber)) {
        if (!known->Is(desc))
            throw MakeError(ErrorKind::Usage,
                            "Persist {}: it was declared in this frame with another description",
                            Quoted(name));
        return graph.IdOf<Kind>(known->resource);
    }
    Persistent& persistent = persistents.Find(name, desc);
    resource.persistence = persistence;
    resource.isShared = Kind == ResourceKind::Buffer;
    resource.state = persistent.states.front();
    const ResourceId<Kind> id =
        AddResource<Kind>(resource, {.persistent = &persistent}, std::span(persistent.states).subspan(1));
    persistent.lastFrame = frameNumber;
    persistent.resource = id.resource;
    return id;
}

TextureId Renderer::Persist(std::string_view name, const GraphTextureDesc& desc, Persistence persistence) {
    m_impl->CheckTexture(name, desc);
    return m_impl->PersistResource<ResourceKind::Texture>(name, desc, persistence,
                                                          TextureInfo(name, Origin::Persistent, desc));
}

BufferId Renderer::PersistBuffer(std::string_view name, const GraphBufferDesc& desc,
                                 Persistence persistence) {
    CheckBuffer(name, desc, false);
    return m_impl->PersistResource<ResourceKind::Buffer>(name, desc, persistence,
                                                         BufferInfo(name, Origin::Persistent, desc.size));
}

bool Renderer::Impl::HasNoContents(AnyId id, const Subresources& requested) const {
    RequireOpen("IsFresh");
    const uint32_t index = graph.ResolveAnyVersion(id, "IsFresh asks about");
    const Persistent* persistent = resources[index].persistent;
    if (!persistent) return false;
    const GraphResource& resource = graph.resources[index];
    const Subresources part = rhi::Resolved(requested, resource.levels, resource.layers);
    if (const std::string missing = rhi::DescribeMissing(part, resource.levels, resource.layers);
        !missing.empty())
        throw MakeError(ErrorKind::Usage, "IsFresh asks about {}: {}", Quoted(resource.name), missing);
    bool isFresh = false;
    graph.ForEachSubresource(index, part, [&](uint32_t, const Subresources& one) {
        const auto writesIt = [&](const ResourceUse& use) {
            return use.resource == index && Writes(use.access) && use.versionOut <= id.version &&
                   rhi::Overlap(use.part, one);
        };
        if (!persistent->isWritten[one.layer * resource.levels + one.level] &&
            std::none_of(graph.uses.begin(), graph.uses.end(), writesIt))
            isFresh = true;
    });
    return isFresh;
}

bool Renderer::IsFresh(TextureId texture, const Subresources& part) const {
    return m_impl->HasNoContents(texture, part);
}

bool Renderer::IsFresh(BufferId buffer) const {
    return m_impl->HasNoContents(buffer, {});
}

void Renderer::Release(std::string_view name) {
    if (m_impl->isOpen && m_impl->persistents.Declared(name, m_impl->frameNumber))
        throw MakeError(ErrorKind::Usage, "Forget {}: the current frame uses it", Quoted(name));
    m_impl->persistents.Release(name);
}

template <ResourceKind Kind, typename Object>
ResourceId<Kind> Renderer::Impl::ImportObject(std::string_view name, const Object& object,
                                              const Object* FrameResource::*member, GraphResource resource,
                                              ResourceState* state) {
    RequireOpen("Import");
    for (uint32_t r = 0; r < resources.size(); ++r) {
        if (resources[r].*member != &object) continue;
        if (resources[r].state != state)
            throw MakeError(ErrorKind::Usage,
                            "Import {}: it is in this frame already, as {} with another state", Quoted(name),
                            Quoted(graph.resources[r].name));
        return graph.IdOf<Kind>(r);
    }
    if (state) resource.state = *state;
    if constexpr (requires { object.IsShared(); }) resource.isShared = object.IsShared();
    FrameResource behind{.state = state};
    behind.*member = &object;
    return AddResource<Kind>(resource, behind);
}

TextureId Renderer::Import(std::string_view name, const rhi::Texture& texture, ResourceState& state) {
    if (!texture) throw MakeError(ErrorKind::Usage, "Import {}: the texture is empty", Quoted(name));
    return m_impl->ImportObject<ResourceKind::Texture>(name, texture, &FrameResource::texture,
                                                       TextureInfo(name, Origin::Imported,
                                                                   {.extent = texture.Extent(),
                                                                    .format = texture.Desc().format,
                                                                    .levels = texture.Desc().mipLevels,
                                                                    .layers = texture.Desc().layers}),
                                                       &state);
}

BufferId Renderer::Import(std::string_view name, const rhi::Buffer& buffer, ResourceState& state) {
    if (!buffer) throw MakeError(ErrorKind::Usage, "Import {}: the buffer is empty", Quoted(name));
    return m_impl->ImportObject<ResourceKind::Buffer>(
        name, buffer, &FrameResource::buffer, BufferInfo(name, Origin::Imported, buffer.Size()), &state);
}

TlasId Renderer::Import(std::string_view name, const rhi::Tlas& tlas, ResourceState& state) {
    return m_impl->ImportObject<ResourceKind::Tlas>(name, tlas, &FrameResource::tlas, ImportInfo(name),
                                                    &state);
}

BlasSetId Renderer::ImportBlasSet(std::string_view name, ResourceState& state) {
    // A BLAS set has no object: its state identifies it.
    return m_impl->ImportObject<ResourceKind::BlasSet>(name, state, &FrameResource::blasState,
                                                       ImportInfo(name), &state);
}

TextureSetId Renderer::Import(std::string_view name, const rhi::TextureTable& table) {
    return m_impl->ImportObject<ResourceKind::TextureSet>(name, table, &FrameResource::textures,
                                                          ImportInfo(name), nullptr);
}

GraphTextureDesc Renderer::Desc(TextureId texture) const {
    const GraphResource& resource =
        m_impl->graph.resources[m_impl->graph.ResolveAnyVersion(texture, "Desc asks about")];
    return {.extent = resource.extent,
            .format = resource.format,
            .levels = resource.levels,
            .layers = resource.layers};
}

GraphBufferDesc Renderer::Desc(BufferId buffer) const {
    const uint32_t index = m_impl->graph.ResolveAnyVersion(buffer, "Desc asks about");
    return {.size = m_impl->graph.resources[index].bytes, .memory = m_impl->resources[index].memory};
}

const rhi::Sampler* Renderer::Impl::FindSampler(const rhi::SamplerDesc& desc) {
    for (const auto& [known, sampler] : samplers)
        if (PartsOf(known) == PartsOf(desc)) return sampler.get();
    samplers.emplace_back(desc, std::make_unique<rhi::Sampler>(device.CreateSampler(desc)));
    return samplers.back().second.get();
}

PassId Renderer::NextPass() const {
    m_impl->RequireOpen("NextPass");
    return {static_cast<uint32_t>(m_impl->graph.passes.size())};
}

Arena& Renderer::BodyMemory() {
    return m_impl->passMemory;
}

PassId Renderer::AddPassErased(std::string_view name, PassKind kind, void (*setup)(const void*, PassBuilder&),
                               const void* setupData, PassBody execute) {
    Impl& impl = *m_impl;
    // Texts are made only for an error, since frames declare this often.
    const auto subject = [&] { return "AddPass " + Quoted(name); };
    if (!impl.CanExecute()) impl.RequireOpen(subject());
    try {
        impl.StartPass(name, kind);
        DeclaredPass& pass = impl.passes[impl.graph.passes.size() - 1];
        PassBuilder builder(*this, impl.graph, impl.shaders, impl.declaration);
        setup(setupData, builder);
        impl.FinishPass(pass);
        if (impl.IsDivided()) impl.TakeIntoSeries(pass);
        pass.execute = std::move(execute);
    } catch (...) {
        // A half-declared pass cannot be undone: its writes have made ids stale.
        impl.Abandon("pass " + Quoted(name) + " was not declared");
        WithMemoryErrors(subject(), [] { throw; });
    }
    return {static_cast<uint32_t>(impl.graph.passes.size() - 1)};
}

void Renderer::Impl::StartPass(std::string_view name, PassKind kind) {
    Change();
    const uint32_t index = graph.AddPass(name, kind);
    if (passes.size() <= index) passes.emplace_back();
    declaration.Clear(kind, passes[index].program);
}

// Decides which part of the last pass this frame executes, if it is one of the series.
void Renderer::Impl::TakeIntoSeries(DeclaredPass& pass) {
    GraphPass& info = graph.passes.back();
    const std::span uses(graph.uses.data() + info.firstUse, info.useCount);
    const auto isOfSeries = [&](const ResourceUse& use) {
        const Persistent* kept = resources[use.resource].persistent;
        return kept && openSeries->Keeps(kept->name);
    };
    if (std::ranges::none_of(uses,
                             [&](const ResourceUse& use) { return Writes(use.access) && isOfSeries(use); }))
        return;
    const PassId id{static_cast<uint32_t>(graph.passes.size() - 1)};
    const SeriesFrame::Parts parts = openSeries->Take(info.name, declaration.isDividable, id, frameNumber);
    for (const ResourceUse& use : uses)
        if (isOfSeries(use)) openSeries->NoteUse(graph.resources[use.resource].name);
    info.waits = parts.IsEmpty();
    if (info.waits) return;
    pass.portion = {.first = parts.first, .end = parts.end, .of = PassSeries::kParts};
    if (parts.first == 0) return;
    // The results of its first parts must stay
    for (ResourceUse& use : uses)
        if (use.access == Access::StorageWrite) use.access = Access::StorageUpdate;
}

void Renderer::BeginSeries(PassSeries& series, double milliseconds) {
    m_impl->RequireOpen("BeginSeries");
    if (m_impl->openSeries) throw Error(ErrorKind::Usage, "BeginSeries: a series is open");
    m_impl->openSeries.emplace(series, milliseconds);
}

bool Renderer::EndSeries() {
    m_impl->RequireOpen("EndSeries");
    if (!m_impl->openSeries) throw Error(ErrorKind::Usage, "EndSeries: no series is open");
    SeriesFrame frame = *std::exchange(m_impl->openSeries, std::nullopt);
    const bool isComplete = frame.IsComplete();
    OnSubmitted([this, frame = std::move(frame)]() mutable {
        for (std::string& name : frame.Commit()) m_impl->unneededOfSeries.push_back(std::move(name));
    });
    return isComplete;
}

void Renderer::CancelSeries() {
    m_impl->RequireOpen("CancelSeries");
    if (!m_impl->openSeries) throw Error(ErrorKind::Usage, "CancelSeries: no series is open");
    for (const PassId pass : m_impl->openSeries->Taken()) m_impl->graph.passes[pass.index].waits = true;
    m_impl->Change();
    m_impl->openSeries.reset();
}

void Renderer::Release(PassSeries& series) {
    for (const std::string& name : series.m_kept) Release(name);
    series.m_kept.clear();
    series.m_done = {};
}

void Renderer::Impl::FinishPass(DeclaredPass& pass) {
    const GraphPass& info = graph.passes.back();
    ResolveTargets(graph, declaration, device.Info().optional.layeredTargets);
    const bool needsShaders =
        info.kind == PassKind::RayTracing || info.kind == PassKind::Compute || info.kind == PassKind::Raster;
    Program* program = nullptr;
    if (needsShaders || declaration.request.HasShaders()) {
        program = programs.Find(declaration.request, declaration.guess);
        if (!program) {
            CheckShaders(info, declaration.request);
            program = &programs.Add(declaration.request, "pass " + Quoted(info.name));
        }
    }
    if (program) std::swap(declaration.places, program->lastPlaces);
    ResolveBindings(graph, declaration, program ? &program->Interface() : nullptr,
                    {.storageBuffer = device.Info().maxStorageBufferBytes,
                     .uniformBlock = device.Info().maxUniformBufferBytes});
    if (program) std::swap(declaration.places, program->lastPlaces);
    for (AddressTable& table : declaration.addressTables) table.uniformOffset = TakeUniform(table.bytes);
    CollectUsages(info);
    pass.program = program;
    pass.bindings = passMemory.Copy(declaration.bindings);
    pass.addressTables = passMemory.Copy(declaration.addressTables);
    pass.colors = passMemory.Copy(declaration.colors);
    pass.constants = passMemory.Copy(declaration.constants);
    pass.textureSet = declaration.textureSet;
    pass.depth = declaration.depth;
    pass.depthLoad = declaration.depthLoad;
    pass.depthPart = declaration.depthPart;
    pass.portion = {};
}

// Allocates zeroed bytes in the frame's uniform memory, and returns their offset.
uint64_t Renderer::Impl::TakeUniform(uint64_t bytes) {
    const uint64_t alignment = std::max<uint64_t>(device.Info().uniformAlignment, 16);
    const uint64_t offset = (uniformBytes.size() + alignment - 1) / alignment * alignment;
    uniformBytes.resize(offset + bytes);
    return offset;
}

// Collects the usage flags of resources, with which existing objects must have been created.
void Renderer::Impl::CollectUsages(const GraphPass& pass) {
    for (uint32_t u = pass.firstUse; u < pass.firstUse + pass.useCount; ++u) {
        const ResourceUse& use = graph.uses[u];
        FrameResource& behind = resources[use.resource];
        behind.isConcurrent |= graph.computeFamily != VK_QUEUE_FAMILY_IGNORED &&
                               pass.queue == rhi::QueueKind::Compute && CanRunOnComputeQueue(pass.kind);
        const GraphResource& resource = graph.resources[use.resource];
        bool hasRequiredUsage = true;
        if (resource.kind == ResourceKind::Texture) {
            const rhi::TextureUsage needed = Row(use.access).texture;
            behind.textureUsage |= needed;
            hasRequiredUsage = !behind.texture || rhi::Has(behind.texture->Desc().usage, needed);
        } else if (resource.kind == ResourceKind::Buffer) {
            const rhi::BufferUsage needed = Row(use.access).buffer;
            behind.bufferUsage |= needed;
            hasRequiredUsage = !behind.buffer || rhi::Has(behind.buffer->Desc().usage, needed);
        }
        if (!hasRequiredUsage)
            throw MakeError(ErrorKind::Usage, "pass {} uses {} as {}, but it was made without that usage",
                            Quoted(pass.name), Quoted(resource.name), Name(use.access));
    }
}

void Renderer::Present(TextureId texture) {
    m_impl->RequireOpen("Present");
    m_impl->graph.Present(texture);
    FrameResource& behind = m_impl->resources[texture.resource];
    behind.textureUsage |= rhi::TextureUsage::Sampled;
    if (behind.texture && !rhi::Has(behind.texture->Desc().usage, rhi::TextureUsage::Sampled))
        throw MakeError(ErrorKind::Usage, "Present shows {}, which was made without the usage Sampled",
                        Quoted(m_impl->graph.resources[texture.resource].name));
    m_impl->Change();
}

void Renderer::Export(TextureId texture, VkImageLayout layout, uint32_t queueFamily) {
    m_impl->RequireOpen("Export");
    m_impl->graph.Export(texture, layout, queueFamily);
    m_impl->Change();
}

void Renderer::Export(BufferId buffer, uint32_t queueFamily) {
    m_impl->RequireOpen("Export");
    m_impl->graph.Export(buffer, queueFamily);
    m_impl->Change();
}

void Renderer::WaitSemaphore(const rhi::SemaphoreUse& semaphore, DropPolicy dropPolicy) {
    m_impl->RequireOpen("WaitSemaphore");
    m_impl->waits.Add(semaphore, dropPolicy);
    m_impl->graph.waitStages |= semaphore.stages;
    m_impl->Change();
}

void Renderer::SignalSemaphore(const rhi::SemaphoreUse& semaphore, DropPolicy dropPolicy) {
    m_impl->RequireOpen("SignalSemaphore");
    m_impl->signals.Add(semaphore, dropPolicy);
}

// --- Readbacks ---
// A transfer pass of the frame copies into mapped memory, which the host reads once the frame has completed.

namespace {

// A limit, because a program may never poll again.
constexpr uint64_t kKeepFrames = 16;

}  // namespace

bool Readback::IsReady() const {
    if (!m_state) return false;
    const uint64_t submitted = m_state->submitted;
    if (submitted == State::kDeclared || submitted >= State::kRendererGone) return false;
    return m_state->device->HasCompleted({submitted});
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
    m_state->device->WaitFor({submitted});
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
    const std::string name =
        Text("{}{}", impl.graph.resources[index].name, rhi::PartText(part, desc.levels, desc.layers));
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
    const std::string name(impl.graph.resources[index].name);
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
