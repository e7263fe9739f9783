#include "tests/fuzz/target.h"

#include <algorithm>
#include <array>

namespace raygraph::fuzz {

namespace {

constexpr std::array kTargets{
    Target{"gltf_text", RunGltfText, 16384},
    Target{"gltf_container", RunGltfContainer, 16384, RepairGlb},
    Target{"gltf_accessors", RunGltfAccessors, 512},
    Target{"gltf_compressed", RunGltfCompressed, 2048},
    Target{"gltf_save", RunGltfSave, 16384},
    Target{"images", RunImages, 4096, RepairPng},
    Target{"environment", RunEnvironment, 4096},
    Target{"light_profiles", RunProfiles, 4096},
    Target{"render_file", RunRenderFile, 1024, nullptr, true},
    Target{"settings", RunSettings, 4096, nullptr, true},
    Target{"texts", RunTexts, 2048},
    Target{"scripts", RunScripts, 2048},
    Target{"graph_files", RunGraphFiles, 4096},
};

}  // namespace

std::span<const Target> Targets() {
    return kTargets;
}

const Target* FindTarget(std::string_view name) {
    const auto found = std::ranges::find(kTargets, name, &Target::name);
    return found == kTargets.end() ? nullptr : &*found;
}

void Require(bool holds, const std::string& promise) {
    if (!holds) throw Finding(promise);
}

bool Succeeds(std::string_view subject, std::initializer_list<ErrorKind> kinds,
              const std::function<void()>& read) {
    constexpr size_t kLongestLine = 4096;
    try {
        read();
        return true;
    } catch (const Finding&) {
        throw;
    } catch (const Error& error) {
        const std::string line = error.what();
        Require(std::ranges::find(kinds, error.Kind()) != kinds.end(),
                "ended in an error of kind " + std::to_string(static_cast<int>(error.Kind())) + ": " + line);
        Require(line.starts_with(subject), "the error does not name its subject: " + line);
        Require(line.size() <= kLongestLine,
                "the error's line has " + std::to_string(line.size()) + " bytes");
        Require(std::ranges::none_of(
                    line, [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }),
                "the error has control characters: " + line);
        return false;
    } catch (const std::exception& other) {
        throw Finding(std::string("ended in an exception that is no Error: ") + other.what());
    }
}

}  // namespace raygraph::fuzz
