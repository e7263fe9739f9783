// Tests that a driver which compiles at the first execution has the machine code of pipelines before.
#include "rhi/compile_ahead.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <optional>

#include "rhi/command_list.h"
#include "rhi/device.h"
#include "rhi/shader_compiler.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::rhi::compile_ahead_test {
namespace {

// Sets an environment variable while it lives.
class Environment {
  public:
    Environment(const char* name, const std::string& value) : m_name(name) {
        if (const char* before = std::getenv(name)) m_before = before;
        setenv(name, value.c_str(), 1);
    }
    ~Environment() { m_before ? setenv(m_name, m_before->c_str(), 1) : unsetenv(m_name); }

  private:
    const char* m_name;
    std::optional<std::string> m_before;
};

// Gives Mesa's cache a folder of its own, in which each piece of machine code is a file.
class CompileAheadTest : public ::testing::Test {
  protected:
    RayTracingPipelineDesc Desc(const std::vector<uint32_t>& words) const {
        RayTracingPipelineDesc desc{.name = "ahead"};
        desc.rayGen.stage = {.name = "ahead.rgen", .spirv = words};
        return desc;
    }
    static std::vector<uint32_t> RayGen(const std::string& value) {
        return CompileGlsl({.name = "ahead.rgen",
                            .text = R"(#version 460
                                #extension GL_EXT_ray_tracing : require
                                #extension GL_EXT_buffer_reference_uvec2 : require
                                layout(buffer_reference) buffer Number { uint number; };
                                layout(push_constant) uniform Constants { uvec2 at; } constants;
                                void main() {
                                    if (gl_LaunchIDEXT.x > 99u) Number(constants.at).number = )" +
                                    value + "; }\n"});
    }
    // Call it after the device has ended, which writes the compiled code.
    size_t FileCount() const {
        namespace fs = std::filesystem;
        return static_cast<size_t>(
            std::count_if(fs::recursive_directory_iterator(m_folder.Path()),
                          fs::recursive_directory_iterator(), [](const fs::directory_entry& entry) {
                              return entry.is_regular_file() && entry.path().filename() != "index" &&
                                     entry.path().filename() != "marker";
                          }));
    }
    // Returns how many files the first execution of what `make` makes writes; `launch` records the execution.
    template <typename Make, typename Launch>
    size_t FilesOfFirst(Make&& make, Launch&& launch) {
        size_t before = 0;
        {
            const std::unique_ptr<Device> device = Device::Create({.savePipelineCache = false});
            const auto pipeline = make(*device);
            before = FileCount();
            CommandList commands = device->BeginCommands("first");
            commands.Bind(pipeline);
            const std::array<uint32_t, 2> nowhere{};
            commands.PushConstants(std::as_bytes(std::span(nowhere)));
            launch(commands);
            device->WaitFor(device->Submit(std::move(commands)));
        }
        return FileCount() - before;
    }
    // Returns the files by a ray-tracing pipeline that is made after `skipped` others.
    size_t FilesOfFirstExecution(uint32_t skipped, bool isAhead) {
        const auto make = [&](Device& device) {
            const std::vector<uint32_t> other = RayGen("7u");
            for (uint32_t i = 0; i < skipped; ++i)
                static_cast<void>(CreateRayTracingPipeline(device, Desc(other)));
            const std::vector<uint32_t> words = RayGen(std::to_string(skipped + 10) + "u");
            RayTracingPipelineDesc desc = Desc(words);
            RayTracingPipeline pipeline = CreateRayTracingPipeline(device, desc);
            if (isAhead) CompileAhead(device, desc, pipeline);
            return pipeline;
        };
        return FilesOfFirst(make, [](CommandList& commands) { commands.TraceRays({1, 1}); });
    }
    // Returns the files by a compute pipeline.
    size_t FilesOfFirstDispatch(bool isAhead) {
        const auto make = [&](Device& device) {
            const std::vector<uint32_t> words =
                CompileGlsl({.name = "ahead.comp",
                             .text = R"(#version 460
                                 #extension GL_EXT_buffer_reference_uvec2 : require
                                 layout(buffer_reference) buffer Number { uint number; };
                                 layout(push_constant) uniform Constants { uvec2 at; } constants;
                                 void main() {
                                     if (gl_GlobalInvocationID.x > 99u) Number(constants.at).number = )" +
                                     std::string(isAhead ? "1u" : "2u") + "; }\n"});
            const ComputePipelineDesc desc{.name = "ahead", .shader = {.name = "ahead.comp", .spirv = words}};
            ComputePipeline pipeline = CreateComputePipeline(device, desc);
            if (isAhead) CompileAhead(device, desc, pipeline);
            return pipeline;
        };
        return FilesOfFirst(make, [](CommandList& commands) { commands.Dispatch(1); });
    }

  private:
    test::TemporaryFolder m_folder;
    Environment m_cache{"MESA_SHADER_CACHE_DIR", m_folder.Path().string()};
    Environment m_isOff{"MESA_SHADER_CACHE_DISABLE", "false"};
    Environment m_kind{"MESA_DISK_CACHE_MULTI_FILE", "true"};
};

TEST_F(CompileAheadTest, TheFirstExecutionFindsTheMachineCode) {
    testing::MessageLog log;
    const std::unique_ptr<Device> device =
        Device::Create({.log = log.Listener(LogLevel::Debug), .savePipelineCache = false});
    if (!device->Info()
             .isLavapipe) {  // Other drivers compile when pipelines are made, and nothing is left to do.
        const std::vector<uint32_t> words = RayGen("7u");
        const RayTracingPipelineDesc desc = Desc(words);
        const RayTracingPipeline pipeline = CreateRayTracingPipeline(*device, desc);
        const size_t said = log.Count();
        CompileAhead(*device, desc, pipeline);
        EXPECT_EQ(log.Text(said), "");
        return;
    }
    EXPECT_EQ(FilesOfFirstExecution(0, false), 1u) << "else there is nothing to do ahead";
    // The code contains the groups' indices on the device, whatever was made before
    for (const uint32_t skipped : {1u, 2u, 3u})
        EXPECT_EQ(FilesOfFirstExecution(skipped, true), 0u) << skipped;
    EXPECT_EQ(FilesOfFirstDispatch(false), 1u);
    EXPECT_EQ(FilesOfFirstDispatch(true), 0u);
}

}  // namespace
}  // namespace raygraph::rhi::compile_ahead_test
