// Tests renders on several devices: the tests' own, opened more than once. It needs a device.
#include <nlohmann/json.hpp>

#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/text_files.h"

namespace raygraph::program_devices_test {
namespace {

using test::ProgramResult;
using test::RunProgram;
using test::TemporaryFolder;
using test::TextOf;

// Returns the first index in the list of `info --devices` that belongs to a suitable device.
std::string SuitableIndex() {
    const ProgramResult listed = RunProgram(TemporaryFolder(), "info --json --devices");
    const auto json = nlohmann::json::parse(listed.output);
    for (const auto& device : json.at("devices"))
        if (device.at("suitable")) return std::to_string(device.at("index").get<int>());
    throw std::runtime_error(listed.output);
}

TEST(ProgramDevices, TwoGiveTheBytesOfOne) {
    const TemporaryFolder folder;
    const std::string index = SuitableIndex(), list = index + "," + index;
    const std::string options = "render @cornell.gltf --size 24x16 --spp 13 --aov all --max-depth 3 ";
    const ProgramResult one =
        RunProgram(folder, options + "-o one.exr -o one.png --report one.json --device " + index);
    ASSERT_EQ(one.exitCode, 0) << one.messages;
    const ProgramResult two =
        RunProgram(folder, options + "-o two.exr -o two.png --report two.json --devices " + list);
    ASSERT_EQ(two.exitCode, 0) << two.messages;
    EXPECT_EQ(TextOf(folder / "two.exr"), TextOf(folder / "one.exr"));
    EXPECT_EQ(TextOf(folder / "two.png"), TextOf(folder / "one.png"));
    EXPECT_NE(two.output.find(", 2 devices\n"), std::string::npos) << two.output;
    EXPECT_EQ(one.output.find(" devices"), std::string::npos) << one.output;

    const auto ofOne = nlohmann::json::parse(TextOf(folder / "one.json")),
               ofTwo = nlohmann::json::parse(TextOf(folder / "two.json"));
    const std::string name = ofOne.at("device").at("name");
    EXPECT_EQ(ofOne.at("devices"), nlohmann::json({name}));
    EXPECT_EQ(ofTwo.at("devices"), nlohmann::json({name, name}));
    EXPECT_EQ(ofTwo.at("device"), ofOne.at("device"));
    EXPECT_EQ(ofTwo.at("samples"), 13);
}

TEST(ProgramDevices, AllAreThoseOfTheBestKind) {
    const TemporaryFolder folder;
    const ProgramResult result =
        RunProgram(folder, "render @cornell.gltf --size 8x8 --spp 2 -o a.exr --report a.json --devices all");
    ASSERT_EQ(result.exitCode, 0) << result.messages;
    const auto report = nlohmann::json::parse(TextOf(folder / "a.json"));
    ASSERT_GE(report.at("devices").size(), 1u);
    for (const auto& name : report.at("devices")) EXPECT_EQ(name, report.at("device").at("name"));
}

TEST(ProgramDevices, WhatIsNoDeviceIsRefused) {
    const TemporaryFolder folder;
    const auto expectRefused = [&](const std::string& options, int exitCode, const std::string& text) {
        const ProgramResult result = RunProgram(folder, "render @cornell.gltf -o a.exr " + options);
        EXPECT_EQ(result.exitCode, exitCode) << options;
        EXPECT_NE(result.messages.find(text), std::string::npos) << options << "\n" << result.messages;
        EXPECT_EQ(std::ranges::count(result.messages, '\n'), 1) << result.messages;
        EXPECT_TRUE(std::filesystem::is_empty(folder.Path()));
    };
    expectRefused("--devices 0 --device 0", 2, "--device excludes --devices");
    expectRefused("--devices x", 2, "--devices: \"x\" is not a whole number");
    expectRefused("--devices 0,", 2, "--devices: ");
    expectRefused("--devices 4000", 3, "no suitable Vulkan device for '4000': 0 '");
}

}  // namespace
}  // namespace raygraph::program_devices_test
