#include "renderer/graph/program.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "base/error.h"
#include "base/text.h"
#include "renderer/graph/text.h"
#include "rhi/compile_ahead.h"
#include "rhi/device.h"

namespace raygraph {

namespace {

// Ray-generation shaders of more words than this take longer to compile than another device takes to create.
constexpr size_t kLongWords = 50'000;

rhi::ShaderStage StageOf(const Shader* shader) {
    if (!shader) return {};
    return {.name = shader->name, .spirv = shader->words, .reflection = &shader->reflection};
}

// Sets the hit sets of a pipeline with a table that has all of them: PassBuilder::HitGroup tells which groups
// those have that are not requested.
void SetHitSets(rhi::RayTracingPipelineDesc& desc, std::span<const HitGroupRequest> requests) {
    uint32_t count = kHitSetCount;
    for (const HitGroupRequest& request : requests) count = std::max(count, request.hitSet + 1);
    desc.hitSets.assign(kHitSetKinds, rhi::HitGroupSet(kRayTypeCount));
    for (uint32_t set = 0; set < count; ++set) desc.tableSets.push_back(set % kHitSetKinds);
    // The sets of number 0 come first, since others begin as their copies.
    for (const bool isFirst : {true, false}) {
        for (const HitGroupRequest& request : requests) {
            if ((request.hitSet < kHitSetKinds) != isFirst) continue;
            uint32_t& own = desc.tableSets[request.hitSet];
            if (!isFirst && own < kHitSetKinds) {
                desc.hitSets.push_back(rhi::HitGroupSet(desc.hitSets[own]));
                own = static_cast<uint32_t>(desc.hitSets.size() - 1);
            }
            desc.hitSets[own][static_cast<size_t>(request.rayType)] = {
                .closestHit = StageOf(request.closestHit),
                .anyHit = StageOf(request.anyHit),
                .intersection = StageOf(request.intersection),
                .recordData = {}};
        }
    }
}

std::string ConstantNames(const rhi::ShaderInterface& interface) {
    std::string names;
    for (const rhi::SpecializationConstant& constant : interface.specialization)
        if (!constant.name.empty()) names += (names.empty() ? "" : ", ") + constant.name;
    return names.empty() ? "no specialization constants" : names;
}

}  // namespace

void ProgramRequest::Clear(PassKind newKind) {
    kind = newKind;
    rayGen = compute = vertex = fragment = nullptr;
    miss = {};
    hitGroups.clear();
    callables.clear();
    maxRecursion = 1;
    specialization.clear();
    raster = {};
    colorFormats.clear();
    depthFormat = rhi::Format::Undefined;
}

bool ProgramRequest::HasShaders() const {
    return rayGen || compute || vertex || fragment || !hitGroups.empty() || !callables.empty() ||
           std::any_of(miss.begin(), miss.end(), [](const Shader* shader) { return shader != nullptr; });
}

void ProgramRequest::ListShaders(std::vector<const Shader*>& shaders) const {
    const auto add = [&](const Shader* shader) {
        if (shader) shaders.push_back(shader);
    };
    add(rayGen);
    add(compute);
    add(vertex);
    add(fragment);
    for (const Shader* shader : miss) add(shader);
    for (const HitGroupRequest& group : hitGroups) {
        add(group.closestHit);
        add(group.anyHit);
        add(group.intersection);
    }
    for (const Shader* shader : callables) add(shader);
}

Program* ProgramCache::Find(const ProgramRequest& request, Program* guess) {
    if (guess && guess->m_request == request) {
        guess->m_isRequested = true;
        return guess;
    }
    const auto known =
        std::ranges::find_if(m_programs, [&](const auto& program) { return program->m_request == request; });
    if (known == m_programs.end()) return nullptr;
    (*known)->m_isRequested = true;
    return known->get();
}

Program& ProgramCache::Add(const ProgramRequest& request, std::string_view pass) {
    auto program = std::make_unique<Program>();
    program->m_request = request;
    std::vector<std::string> constants;
    for (const SpecializationRequest& constant : request.specialization)
        constants.emplace_back(constant.name);
    program->m_constants = std::make_shared<const std::vector<std::string>>(std::move(constants));
    for (size_t i = 0; i < program->m_constants->size(); ++i)
        program->m_request.specialization[i].name = (*program->m_constants)[i];
    Reflect(*program, pass);
    return *m_programs.emplace_back(std::move(program));
}

void ProgramCache::Reflect(Program& program, std::string_view pass) const {
    std::vector<const Shader*> all;
    program.m_request.ListShaders(all);
    std::vector<const Shader*> shaders;
    std::vector<rhi::NamedReflection> reflections;
    for (const Shader* shader : all) {
        if (std::ranges::find(shaders, shader) != shaders.end()) continue;
        shaders.push_back(shader);
        reflections.push_back({shader->name, shader->reflection});
    }
    rhi::ShaderInterface interface;
    try {
        interface = rhi::MergeInterface(reflections);
    } catch (const Error& error) {
        throw MakeError(error.Kind(), "{}: {}", pass, error.what());
    }
    std::vector<rhi::SpecializationValue> values;
    for (const SpecializationRequest& request : program.m_request.specialization) {
        bool isKnown = false;
        for (const rhi::SpecializationConstant& constant : interface.specialization) {
            if (constant.name != request.name) continue;
            values.push_back({.id = constant.id, .value = request.value});
            isKnown = true;
        }
        if (!isKnown)
            throw MakeError(ErrorKind::Usage, "{} specializes {}: no such constant; {} has {}", pass,
                            Quoted(request.name), shaders.front()->name, ConstantNames(interface));
    }
    program.m_name = shaders.front()->name;
    program.m_shaders = std::move(shaders);
    program.m_interface = std::move(interface);
    program.m_specialization = std::move(values);
}

void ProgramCache::EnsurePipeline(Program& program) {
    if (program.m_future.valid()) TakeCompiled(program);
    if (const std::exception_ptr failure = program.m_failure) {
        // One frame is lost to all failures: the next one retries all of these programs
        for (const auto& failed : m_programs) failed->m_failure = nullptr;
        std::rethrow_exception(failure);
    }
    if (!program.m_hasPipeline) Take(program, MakePipeline(program, false));
}

void ProgramCache::EnsurePipelines(std::span<Program* const> programs) {
    // lavapipe numbers shader groups in the order of creation, and its cached machine code contains the
    // numbers: such pipelines are created in the order of the passes, below.
    const bool isOrdered = m_device.Info().isLavapipe;
    Program* last = nullptr;
    for (Program* program : programs) {
        if (HasPipeline(*program) || program->m_failure || program->m_future.valid() || program == last ||
            (isOrdered && program->Kind() == PassKind::RayTracing))
            continue;
        if (last) Begin(*last, false);
        last = program;
    }
    if (last) {
        Begin(*last, false, std::launch::deferred);  // TakeCompiled creates it on this thread
        TakeCompiled(*last);
    }
    for (Program* program : programs)
        if (program->m_future.valid()) TakeCompiled(*program);
    for (Program* program : programs) EnsurePipeline(*program);
}

bool ProgramCache::BeginPipeline(Program& program) {
    if (HasPipeline(program) || program.m_failure) return true;
    if (!program.m_future.valid()) Begin(program, true);
    return HasPipeline(program) || program.m_failure;
}

void ProgramCache::Begin(Program& program, bool isAhead, std::launch launch) {
    program.m_future =
        std::async(launch, [this, &program, isAhead] { return MakePipeline(program, isAhead); });
}

bool ProgramCache::HasPipeline(Program& program) {
    if (program.m_future.valid() && !program.IsCompiling()) TakeCompiled(program);
    return program.m_hasPipeline;
}

void ProgramCache::TakeCompiled(Program& program) {
    try {
        Take(program, program.m_future.get());
    } catch (const std::exception&) {
        program.m_failure = std::current_exception();
    }
}

void ProgramCache::EndFrame() {
    m_frameEnd = std::chrono::steady_clock::now();
    for (const auto& program : m_programs)
        if (std::exchange(program->m_isRequested, false)) program->m_lastRequested = m_frameEnd;
}

bool ProgramCache::Trim(double lifetime) {
    const size_t removed = std::erase_if(m_programs, [&](const auto& known) {
        const Program& program = *known;
        const std::chrono::duration<double> unused = m_frameEnd - program.m_lastRequested;
        return !program.m_isRequested && unused.count() > lifetime && !program.IsCompiling();
    });
    return removed > 0;
}

bool ProgramCache::IsCompilingPipelines() const {
    return std::ranges::any_of(m_programs, [](const auto& program) { return program->IsCompiling(); });
}

void ProgramCache::WaitForPipelines() {
    for (const auto& program : m_programs)
        if (program->m_future.valid()) program->m_future.wait();
}

ProgramPipeline ProgramCache::MakePipeline(const Program& program, bool isAhead) const {
    const ProgramRequest& request = program.m_request;
    ProgramPipeline made;
    switch (request.kind) {
        case PassKind::Compute: {
            const rhi::ComputePipelineDesc desc{.name = program.m_name,
                                                .shader = StageOf(request.compute),
                                                .specialization = program.m_specialization};
            made.compute = rhi::CreateComputePipeline(m_device, desc);
            made.creationMs = made.compute.CreationMs();
            if (isAhead && request.compute->words.size() > kLongWords)
                rhi::CompileAhead(m_device, desc, made.compute);
            break;
        }
        case PassKind::Raster: {
            const RasterState& raster = request.raster;
            made.raster = rhi::CreateRasterPipeline(m_device, {.name = program.m_name,
                                                               .vertex = StageOf(request.vertex),
                                                               .fragment = StageOf(request.fragment),
                                                               .specialization = program.m_specialization,
                                                               .colorFormats = request.colorFormats,
                                                               .depthFormat = request.depthFormat,
                                                               .topology = raster.topology,
                                                               .cull = raster.cull,
                                                               .isFrontClockwise = raster.isFrontClockwise,
                                                               .depthCompare = raster.depthCompare,
                                                               .writesDepth = raster.writesDepth,
                                                               .blend = raster.blend,
                                                               .isWireframe = raster.isWireframe});
            made.creationMs = made.raster.CreationMs();
            break;
        }
        case PassKind::RayTracing: {
            rhi::RayTracingPipelineDesc desc;
            desc.name = program.m_name;
            desc.rayGen.stage = StageOf(request.rayGen);
            for (const Shader* miss : request.miss)
                desc.miss.push_back({.stage = StageOf(miss), .recordData = {}});
            SetHitSets(desc, request.hitGroups);
            for (const Shader* callable : request.callables)
                desc.callables.push_back({.stage = StageOf(callable), .recordData = {}});
            desc.specialization = program.m_specialization;
            desc.maxRecursion = request.maxRecursion;
            made.rayTracing = rhi::CreateRayTracingPipeline(m_device, desc);
            made.creationMs = made.rayTracing.CreationMs();
            if (isAhead && request.rayGen->words.size() > kLongWords)
                rhi::CompileAhead(m_device, desc, made.rayTracing);
            break;
        }
        case PassKind::Transfer:
        case PassKind::AccelerationStructure:
            break;
    }
    return made;
}

void ProgramCache::Take(Program& program, ProgramPipeline&& made) {
    program.m_pipeline = std::move(made);
    if (program.Kind() == PassKind::Transfer || program.Kind() == PassKind::AccelerationStructure) return;
    const double ms = program.m_pipeline.creationMs;
    m_creationMs += ms;
    constexpr double kLongMs = 1000.0;  // somebody is waiting for longer than this
    WriteLog(m_device.Log(), ms < kLongMs ? LogLevel::Debug : LogLevel::Info, log_category::kShaders,
             "pipeline of {} is made in {}", program.m_name, DurationText(1e-3 * ms));
    m_pipelineCount += program.m_hasPipeline ? 0 : 1;
    program.m_hasPipeline = true;
}

std::vector<PipelineReport> ProgramCache::Reports() {
    WaitForPipelines();
    std::vector<PipelineReport> reports;
    for (const auto& program : m_programs) {
        if (program->m_future.valid()) EnsurePipeline(*program);
        if (!program->m_hasPipeline) continue;
        const ProgramPipeline& made = program->m_pipeline;
        const rhi::Pipeline* pipeline = &made.compute;
        if (program->Kind() == PassKind::Raster) pipeline = &made.raster;
        if (program->Kind() == PassKind::RayTracing) pipeline = &made.rayTracing;
        reports.push_back({program->Name(), made.creationMs, rhi::StatisticsOf(m_device, *pipeline)});
    }
    std::ranges::stable_sort(reports, {}, &PipelineReport::name);
    return reports;
}

std::vector<std::string> ProgramCache::Rebuild(std::span<const Shader* const> changed) {
    std::vector<std::string> messages;
    for (const auto& program : m_programs) {
        const auto isChanged = [&](const Shader* shader) {
            return std::ranges::find(changed, shader) != changed.end();
        };
        if (std::ranges::none_of(program->m_shaders, isChanged)) continue;
        Program next;
        next.m_request = program->m_request;
        next.m_constants = program->m_constants;
        next.m_lastRequested = program->m_lastRequested;
        try {
            Reflect(next, program->m_name);
            if (program->m_hasPipeline) {
                next.m_hasPipeline = true;
                Take(next, MakePipeline(next, false));
            }
            *program = std::move(next);
        } catch (const Error& error) {
            messages.emplace_back(error.what());
        }
    }
    return messages;
}

}  // namespace raygraph
