#include "renderer/graph/renderer.h"

#include <algorithm>

#include "base/counted.h"
#include "base/error.h"
#include "base/out_of_memory.h"
#include "base/text.h"
#include "renderer/graph/plan_text.h"
#include "renderer/graph/renderer_impl.h"
#include "renderer/graph/text.h"

namespace raygraph {

Renderer::Impl::Impl(Renderer& owner, rhi::Device& rhiDevice, const RendererDesc& desc)
    : renderer(owner),
      device(rhiDevice),
      shaders(desc.shaderRoot, desc.shaderIncludes),
      programs(rhiDevice),
      transients(rhiDevice),
      timer(rhiDevice, desc.gpuTimes),
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
        m_impl->device.WaitFor(m_impl->lastSubmitted);
    } catch (const Error&) {
        // A lost device completes nothing, so that there is nothing to wait for.
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
        impl.graph.queueFamily = impl.lastGraph.queueFamily;
        impl.graph.blockStates = impl.lastGraph.blockStates;
        impl.hasLastPlan = true;
        impl.isCompiled = false;
    }
    const uint64_t next = impl.frameNumber + 1;
    impl.device.WaitFor(impl.OldestInFlight());
    impl.timer.Poll();

    impl.frameNumber = next;
    impl.graph.Begin(next);
    impl.resources.clear();
    impl.uniformBytes.clear();
    impl.abandonReason.clear();
    impl.compileMs = 0.0;
    impl.isOpen = true;
    impl.openFrame = std::make_shared<const uint64_t>(next);
    impl.sinceBegin = {};
}

bool Renderer::WouldBlock() const {
    return m_impl->device.CompletedValue() < m_impl->OldestInFlight();
}

void Renderer::DropFrame(DropPolicy semaphores) {
    if (!m_impl->isOpen) return;
    if (semaphores == DropPolicy::LeaveAlone)
        m_impl->CloseFrame();
    else
        m_impl->DropFrame();
}

std::weak_ptr<const void> Renderer::OpenFrame() const {
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
        lastSubmitted = device.Forward(waits.forwarded, signals.forwarded);
    } catch (const std::exception& failure) {
        Say(device.Log(), LogLevel::Warning, log_category::kGraph,
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
    for (PassDeclaration& pass : passes) pass.execute = nullptr;
    for (const std::shared_ptr<Readback::State>& readback : readbacks)
        if (readback->submitted == Readback::State::kDeclared)
            readback->submitted = Readback::State::kDropped;
}

bool Renderer::WasExecuted(PassId pass) const {
    return pass.index < m_impl->wasExecuted.size() && m_impl->wasExecuted[pass.index] != 0;
}

std::string Renderer::DescribePlan() const {
    if (m_impl->isCompiled) return raygraph::DescribePlan(m_impl->graph, m_impl->plan);
    if (m_impl->hasLastPlan) return raygraph::DescribePlan(m_impl->lastGraph, m_impl->lastPlan);
    throw Error(ErrorKind::Usage, "DescribePlan: no frame has been compiled yet");
}

std::string Renderer::DescribePlanDot() const {
    if (m_impl->isCompiled) return raygraph::DescribePlanDot(m_impl->graph, m_impl->plan);
    if (m_impl->hasLastPlan) return raygraph::DescribePlanDot(m_impl->lastGraph, m_impl->lastPlan);
    throw Error(ErrorKind::Usage, "DescribePlanDot: no frame has been compiled yet");
}

Renderer::CompiledFrame Renderer::LastCompiled() const {
    if (m_impl->isCompiled) return {m_impl->graph, m_impl->plan};
    if (m_impl->hasLastPlan) return {m_impl->lastGraph, m_impl->lastPlan};
    throw Error(ErrorKind::Usage, "LastCompiled: no frame has been compiled yet");
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
    if (m_impl->openFrame)
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
            Say(log, LogLevel::Info, log_category::kShaders, "{} reloaded in {}",
                Counted(count, "changed shader is", "changed shaders are"), DurationText(watch.Seconds()));
        return messages;
    });
}

void Renderer::AddShader(std::string_view name, std::span<const uint32_t> spirv) {
    Impl& impl = *m_impl;
    const Shader* known = impl.shaders.Known(name);
    if (!known) {
        impl.shaders.Add(name, spirv);
        return;
    }
    if (std::ranges::equal(known->words, spirv)) return;
    const std::string subject = "AddShader " + Quoted(name) + ": ";
    if (impl.openFrame)
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

}  // namespace raygraph
