#!/usr/bin/env bash
# check_test.sh CHECK: shows that each rule of check.sh can fail. In a clean tree made here CHECK finds nothing; with
# one violation put in, it names that rule and nothing else. "quiet" cases look like violations and are none.
set -euo pipefail

check=$(realpath -- "$1")
tree=$(mktemp -d)
trap 'rm -rf -- "$tree"' EXIT
cases=0 failures=0

# A tree with a README everywhere and one legal file in each layer.
MakeCleanTree() {
    rm -rf -- "${tree:?}"/*
    local folder
    for folder in base rhi renderer renderer/image renderer/scene renderer/graph renderer/gpu_scene passes shaders \
        editor/viewport editor/session editor/graph_run editor/app editor/cli c python tests; do
        mkdir -p "$tree/$folder"
        echo "# $folder" >"$tree/$folder/README.md"
        printf '// Threads: any.\n#pragma once\n#include "base/ok.h"\n' >"$tree/$folder/ok.h"
    done
    printf '// Threads: any.\n#pragma once\n' | tee "$tree/shaders/ok.h" >"$tree/base/ok.h"
    mkdir -p "$tree/shaders/core" "$tree/tests/unit"
    echo '#include "core/other.glsl"' >"$tree/shaders/core/a.glsl"
    echo '#include "unit/fixture.h"' >"$tree/tests/unit/a.cpp"
    [[ -n ${isInstalled-} ]] || return 0
    mkdir -p "$tree/cmake"
    printf 'set(public\n    rhi/a.h)\n' >"$tree/cmake/InstallHeaders.cmake"
    printf '// A. Threads: any.\n#pragma once\n#include "rhi/b.h"\n' >"$tree/rhi/a.h"
}

# Expect RULE|quiet FILE TEXT
Expect() {
    local rule=$1 file=$2 text=$3 output status=0
    cases=$((cases + 1))
    MakeCleanTree
    mkdir -p "$(dirname "$tree/$file")"
    printf '%b' "${text:+$text\n}" >"$tree/$file"
    output=$("$check" "$tree") || status=$?
    if [[ $rule == quiet ]]; then
        ((status == 0)) && return
    elif ((status == 1)) && ! grep -qv "^$file:[0-9]*: $rule:" <<<"$output"; then
        return
    fi
    failures=$((failures + 1))
    printf 'expected %s for %s: %s\n  status %d, output: %s\n' "$rule" "$file" "${text:0:80}" "$status" "$output"
}

# Public RULE|quiet TEXT: the same for a header that an installed one includes.
Public() {
    isInstalled=1 Expect "$1" rhi/b.h "$2"
}

Lines() { printf 'int x;%.0s\\n' $(seq "$1"); }

Expect quiet base/clean.h '#pragma once'

Expect layer shaders/core/b.glsl '#include "rhi/device.h"'
Expect layer base/b.h '#include "rhi/device.h"'
Expect layer rhi/b.cpp '#include "renderer/renderer.h"'
Expect layer rhi/b.cpp '#include <passes/trace.h>'
Expect layer rhi/b.cpp '#include "shaders/core/rng.glsl"'
Expect layer renderer/image/b.cpp '#include "renderer/scene/model/scene_data.h"'
Expect layer renderer/scene/b.cpp '#include "rhi/device.h"'
Expect layer renderer/graph/b.cpp '#include "renderer/gpu_scene/gpu_scene.h"'
Expect layer renderer/gpu_scene/b.cpp '#include "passes/trace.h"'
Expect layer passes/b.cpp '#include "editor/viewport/viewport.h"'
Expect layer editor/viewport/b.cpp '#include "editor/app/app.h"'
Expect layer editor/viewport/b.cpp '#include "editor/session/session.h"'
Expect layer editor/session/b.cpp '#include "editor/viewport/viewport.h"'
Expect layer editor/session/b.cpp '#include "editor/cli/progress.h"'
Expect layer editor/graph_run/b.cpp '#include "editor/session/session.h"'
Expect quiet editor/cli/b.cpp '#include "editor/graph_run/graph_run.h"'
Expect layer editor/app/b.cpp '#include "editor/cli/main.h"'
Expect layer editor/cli/b.cpp '#include "editor/app/app.h"'
Expect quiet editor/app/b.cpp '#include "editor/session/session.h"'
Expect layer c/b.cpp '#include "python/bindings.h"'
Expect quiet c/b.cpp '#include "editor/viewport/viewport.h"'
Expect layer python/b.cpp '#include "editor/cli/progress.h"'
Expect quiet python/b.cpp '#include "editor/session/session.h"'
Expect quiet passes/b.cpp '#include "rhi/command_list.h"\n#include "renderer/graph/ids.h"'
Expect quiet rhi/b.cpp '// #include "passes/trace.h"\n#include "base/text.h"'
Expect layer rhi/b.cpp '#include "shaders/shared/ray_types.h"'
Expect quiet renderer/graph/b.h '#include "shaders/shared/ray_types.h"'
Expect include-root rhi/b.cpp '#include "device.h"'

Expect vk-call renderer/graph/b.cpp 'void f() { table.vkCmdDraw(cmd); }'
Expect vk-call editor/cli/b.cpp 'auto f = vkCreateInstance;'
Expect vk-call passes/b.cpp 'vkFoo(1);'
Expect quiet rhi/b.cpp 'void f() { vkCmdDraw(); }'
Expect quiet renderer/graph/b.cpp 'int vkResult = 0;'
Expect quiet renderer/graph/b.cpp '// vkCmdDraw\nconst char* kName = "vkCmdDraw";\n/* vkCmdDraw\n   vkCmdDraw */'
Expect no-vulkan renderer/scene/b.h 'VkFormat format;'
Expect no-vulkan renderer/image/b.h '#include <vulkan/vulkan_core.h>'
Expect no-vulkan base/b.h 'int x = VK_SUCCESS;'
Expect vk-token passes/b.h 'VkFormat format;'
Expect vk-token editor/viewport/viewport.h 'VkImage image;'
Expect vk-token editor/cli/b.cpp '#include <vulkan/vulkan.h>'
Expect quiet editor/viewport/vulkan_interop.h '#include <vulkan/vulkan_core.h>\nVkImage image;'
Expect quiet renderer/graph/b.h 'VkAccessFlags2 access;'
Expect window editor/viewport/b.cpp '#include <GLFW/glfw3.h>'
Expect window editor/cli/b.cpp 'ImGui::Begin("x");'
Expect window editor/session/b.cpp '#include <GLFW/glfw3.h>'
Expect quiet editor/app/b.cpp '#include <GLFW/glfw3.h>\nvoid f() { ImGui::End(); }'

Expect spdlog rhi/b.cpp '#include <spdlog/spdlog.h>'
Expect spdlog editor/session/b.cpp '#include <spdlog/spdlog.h>'
Expect spdlog editor/app/b.cpp 'void f() { spdlog::info("x"); }'
Expect quiet editor/cli/program_log.cpp '#include <spdlog/logger.h>\nspdlog::logger* l;'

Expect exit renderer/scene/b.cpp 'void f() { std::exit(1); }'
Expect exit editor/session/b.cpp 'void f() { std::exit(1); }'
Expect exit rhi/b.cpp 'void f() { abort(); }'
Expect output passes/b.cpp 'void f() { std::cout << 1; }'
Expect output editor/session/b.cpp 'void f() { std::puts(text); }'
Expect output renderer/image/b.cpp 'void f() { fprintf(stderr, "x"); }'
Expect output base/b.h 'inline void f() { printf("x"); }'
Expect quiet base/check.h 'void f() { fputs("x", stderr); abort(); }'
Expect quiet editor/cli/b.cpp 'void f() { std::fputs("x", stdout); std::exit(2); }'
Expect quiet renderer/image/b.cpp 'void f() { snprintf(a, 3, "x"); onexit(); }'

Expect system rhi/b.cpp '#include <dlfcn.h>'
Expect system renderer/scene/b.cpp '#  include <sys/stat.h>'
Expect system editor/cli/b.h '#include <csignal>'
Expect system base/b.cpp 'int f(FILE* f) { return fileno(f); }'
Expect system editor/app/b.cpp 'void f() { ::unlink("x"); }'
Expect quiet editor/cli/b.cpp '#include <cstdio>\n#include <system_error>\nvoid f() { std::fclose(g); window.unlinked(); }'

Expect size rhi/b.cpp "$(Lines 901)"
Expect quiet rhi/b.cpp "$(Lines 440)"
Expect quiet shaders/core/sobol.h "// Data table: Sobol matrices.\n$(Lines 500)"
Expect columns shaders/core/b.glsl "// $(printf 'x%.0s' {1..120})"
Expect quiet shaders/core/b.glsl "// $(printf 'é%.0s' {1..107})"
Expect quiet tests/unit/b.cpp "// $(printf 'x%.0s' {1..120})"
Expect unfinished passes/b.cpp '// TODO: more'
Expect unfinished cmake/b.cmake '# FIXME'
Expect empty passes/b.h ''
Expect readme-size rhi/README.md "$(Lines 61)"

Public threads '// B.\n#pragma once'
Public threads '// B.\n#pragma once\n// Threads: any.\nstruct B {};'
Public text '// B. Threads: any.\n#include "base/text.h"'
Public export '// B. Threads: any.\nint Count(int a);'
Public export '// B. Threads: any.\n[[nodiscard]] std::vector<std::byte> Read(\n    int a);'
Public export '// B. Threads: any.\nclass B : public A {\n};'
Public export '// B. Threads: any.\nstruct B {\n    int a = 0;\n    int Sum() const;\n};'
Public export '// B. Threads: any.\nstruct B {\n    std::string Text(int a,\n                     int b) const;\n};'
Public quiet '// B. Threads: any.\nstruct B {\n    int a = 0;\n    int Sum() const { return a; }\n    template <int N>\n    int Times() const;\n};'
Public quiet '// B. Threads: any.\nstruct RAYGRAPH_API B {\n    int Sum() const;\n};'
Public quiet '// B. For rhi/ alone. Threads: any.\nint Count();'
Public quiet '// B. Threads:\n// any.\nRAYGRAPH_API int Count();\ninline int One() { return 1; }\nclass RAYGRAPH_API B {\n};\nclass C;'

cases=$((cases + 1))
MakeCleanTree
rm "$tree/passes/README.md"
if [[ $("$check" "$tree") != 'passes/README.md:1: readme: '* ]]; then
    failures=$((failures + 1))
    echo "expected readme for a folder without one"
fi

echo "$cases cases, $failures failed"
((failures == 0))
