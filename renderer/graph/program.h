// Program: the shaders of a pass with their bindings, and the pipeline that is created from them when it is
// first needed. Threads: that of the Renderer; threads of its own create pipelines.
//
// In every frame, ProgramCache finds the program of a pass by comparing its whole request. Interfaces come
// from reflection, so that a culled pass never creates a pipeline.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <exception>
#include <future>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/graph/access.h"
#include "renderer/graph/pass_builder.h"
#include "renderer/graph/pipeline_report.h"
#include "renderer/graph/shader_library.h"
#include "rhi/pipeline.h"
#include "rhi/reflection.h"

namespace raygraph {

// The group of a ray type in a hit set; null stands for a stage that is left out.
struct HitGroupRequest {
    uint32_t hitSet = 0;
    RayType rayType = RayType::Radiance;
    const Shader* closestHit = nullptr;
    const Shader* anyHit = nullptr;
    const Shader* intersection = nullptr;

    bool operator==(const HitGroupRequest&) const = default;
};

struct SpecializationRequest {
    std::string_view name;  // lives as long as the frame, or as the Program that has the request
    uint32_t value = 0;

    bool operator==(const SpecializationRequest&) const = default;
};

// Holds the program that a pass requests. The vectors keep their memory from frame to frame. Passes share a
// program if and only if their requests are equal.
struct ProgramRequest {
    PassKind kind = PassKind::Compute;
    const Shader* rayGen = nullptr;
    std::array<const Shader*, kRayTypeCount> miss{};
    std::vector<HitGroupRequest> hitGroups;  // at most one for a ray type in a hit set
    std::vector<const Shader*> callables;
    uint32_t maxRecursion = 1;
    const Shader* compute = nullptr;
    const Shader* vertex = nullptr;
    const Shader* fragment = nullptr;
    std::vector<SpecializationRequest> specialization;
    RasterState raster;
    std::vector<rhi::Format> colorFormats;
    rhi::Format depthFormat = rhi::Format::Undefined;

    bool operator==(const ProgramRequest&) const = default;
    // Resets the request to ProgramRequest{.kind = newKind}; the vectors keep their memory.
    void Clear(PassKind newKind);
    bool HasShaders() const;
    // Lists all shaders of the request, with ray generation, compute or vertex first. One may occur more than
    // once.
    void ListShaders(std::vector<const Shader*>& shaders) const;
};

// Holds the pipeline of the program's kind; the two other pointers are null.
struct ProgramPipeline {
    rhi::ComputePipeline compute;
    rhi::RasterPipeline raster;
    rhi::RayTracingPipeline rayTracing;
    double creationMs = 0.0;
};

class Program {
  public:
    const std::string& Name() const { return m_name; }  // name of its first shader
    const rhi::ShaderInterface& Interface() const { return m_interface; }
    PassKind Kind() const { return m_request.kind; }
    std::span<const Shader* const> Shaders() const { return m_shaders; }  // without repetition
    // The places in the interface of what the last pass with this program has bound, in its order. Other
    // passes mostly bind in the same order.
    std::vector<size_t> lastPlaces;
    const rhi::ComputePipeline& Compute() const { return m_pipeline.compute; }
    const rhi::RasterPipeline& Raster() const { return m_pipeline.raster; }
    const rhi::RayTracingPipeline& RayTracing() const { return m_pipeline.rayTracing; }

  private:
    friend class ProgramCache;
    bool IsCompiling() const {
        return m_future.valid() && m_future.wait_for(std::chrono::seconds(0)) == std::future_status::timeout;
    }

    ProgramRequest m_request;
    std::shared_ptr<const std::vector<std::string>> m_constants;  // the names in the request
    std::string m_name;
    std::vector<const Shader*> m_shaders;
    rhi::ShaderInterface m_interface;
    std::vector<rhi::SpecializationValue> m_specialization;
    // A frame has requested it since the last one ended.
    bool m_isRequested = true;
    std::chrono::steady_clock::time_point m_lastRequested;  // when a frame that requested it ended
    bool m_hasPipeline = false;
    ProgramPipeline m_pipeline;
    std::exception_ptr m_failure;           // error of its thread, until EnsurePipelines reports it
    std::future<ProgramPipeline> m_future;  // its thread reads m_request, m_name and m_specialization
};

class ProgramCache {
  public:
    explicit ProgramCache(rhi::Device& device) : m_device(device) {}

    // Returns null if it has never been requested. Tries `guess` first, which may be null.
    Program* Find(const ProgramRequest& request, Program* guess = nullptr);
    // Throws Error{Usage} that starts with `pass` (as in: pass "Trace") for shaders that do not fit together,
    // or a specialization constant that none of them has.
    Program& Add(const ProgramRequest& request, std::string_view pass);
    // Creates the missing pipelines concurrently, one on the calling thread and each other on its own thread,
    // because drivers compile on the calling thread. Throws the error of the first program whose pipeline
    // failed, as rhi::Create*Pipeline do.
    void EnsurePipelines(std::span<Program* const> programs);
    // Begins to create the pipeline on another thread. Returns true if EnsurePipelines has nothing to wait
    // for, or fails.
    bool BeginPipeline(Program& program);
    // Tells whether the pipeline exists: it is neither being created, nor has its creation failed.
    bool HasPipeline(Program& program);
    // A frame was executed, which needed the programs that were requested since the last one.
    void EndFrame();
    // Must be called between frames. Removes programs that no frame has needed for more than `lifetime`
    // seconds before the end of the last frame, except those on which threads are working. Returns whether
    // there were any.
    bool Trim(double lifetime);
    bool IsCompilingPipelines() const;  // on other threads
    // Waits until no thread reads shaders.
    void WaitForPipelines();
    // Rebuilds every program that uses a changed shader. One that fails keeps its interface and pipeline, and
    // the returned messages say why. Must be called after WaitForPipelines and after the change.
    std::vector<std::string> Rebuild(std::span<const Shader* const> changed);

    // Reports on the pipelines that exist, by name. Must follow WaitForPipelines.
    std::vector<PipelineReport> Reports();

    double CreationMs() const { return m_creationMs; }
    uint32_t PipelineCount() const { return m_pipelineCount; }

  private:
    void Reflect(Program& program, std::string_view pass) const;
    void EnsurePipeline(Program& program);
    // By default, TakeCompiled creates the pipeline if no thread can be started.
    void Begin(Program& program, bool isAhead,
               std::launch launch = std::launch::async | std::launch::deferred);
    // `isAhead`: no frame waits for the pipeline (rhi/compile_ahead.h).
    ProgramPipeline MakePipeline(const Program& program, bool isAhead) const;
    void Take(Program& program, ProgramPipeline&& made);
    // Takes the pipeline that its thread has created, or the error.
    void TakeCompiled(Program& program);

    rhi::Device& m_device;
    std::vector<std::unique_ptr<Program>> m_programs;  // there are few, with different requests
    std::chrono::steady_clock::time_point m_frameEnd;
    double m_creationMs = 0.0;
    uint32_t m_pipelineCount = 0;
};

}  // namespace raygraph
