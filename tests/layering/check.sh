#!/usr/bin/env bash
# check.sh [ROOT]: the rules that keep the layers apart and the files small, as greps over the source tree.
# Prints one line for each violation, "path:line: rule: text", and exits with 1 if there is any. A grep that finds
# nothing is the good case, so failures are not fatal here; check_test.sh shows that each rule can fail.
set -u
export LC_ALL=C.UTF-8
cd -- "${1:-$(dirname -- "${BASH_SOURCE[0]}")/../..}" || exit 2

folders=()
for folder in base rhi renderer passes shaders editor c python tests scenes cmake docs .ci; do
    [[ ! -d $folder ]] || folders+=("$folder")
done
mapfile -t files < <(find "${folders[@]}" -type f | sort)
mapfile -t sources < <(printf '%s\n' "${files[@]}" |
    grep -E '\.(h|cpp|glsl|rgen|rmiss|rchit|rahit|rint|rcall|comp|vert|frag)$')
if ((${#sources[@]} == 0)); then
    echo "check.sh: no sources under $PWD" >&2
    exit 2
fi

# The code without comments and strings as "path:line: text"; include lines keep their quotes.
code=$(awk '
    FNR == 1 { inComment = 0 }
    {
        text = $0
        if (inComment) {
            if (!match(text, /\*\//)) next
            text = substr(text, RSTART + 2)
            inComment = 0
        }
        if (text !~ /^[ \t]*#[ \t]*include/) gsub(/"([^"\\]|\\.)*"/, "\"\"", text)
        gsub(/\/\*([^*]|\*+[^*\/])*\*+\//, " ", text)
        sub(/\/\/.*/, "", text)
        if (match(text, /\/\*/)) {
            text = substr(text, 1, RSTART - 1)
            inComment = 1
        }
        if (text ~ /[^ \t]/) print FILENAME ":" FNR ": " text
    }' "${sources[@]}")

# Lines RULE: turns "path:line:text" into a report.
Report() {
    local path line text
    while IFS=: read -r path line text; do
        printf '%s:%s: %s: %s\n' "$path" "$line" "$1" "${text#"${text%%[![:space:]]*}"}"
    done
}

# Find FOLDERS PATTERN: lines of code under these folders that hold the pattern.
Find() { grep -E "^($1)[^:]*:[0-9]+:.*($2)" <<<"$code"; }

# Word PATTERN: the pattern where a word begins.
Word() { printf '(^|[^[:alnum:]_])(%s)' "$1"; }

# MayInclude FOLDER PREFIXES: of the project's headers, those that files under FOLDER may include.
MayInclude() {
    grep -E "^$1[^:]*:[0-9]+: *# *include *[<\"](base|rhi|renderer|passes|shaders|editor|c|python|tests)/" <<<"$code" |
        grep -vE ": *# *include *\"($2)" | Report "layer: $1 includes only ${2//|/ }"
}

# MayNotInclude FOLDER PREFIXES: of the headers beside it, those that files under FOLDER may not include.
MayNotInclude() {
    Find "$1" "# *include *\"($2)" | Report "layer: $1 does not include $2"
}

CheckLayers() {
    local lower='base/|shaders/shared/'
    MayInclude shaders/ 'shaders/|base/api.h|base/check.h'
    MayInclude base/ "$lower"
    MayInclude rhi/ 'base/|rhi/'
    MayInclude renderer/image/ "$lower|renderer/image/"
    MayInclude renderer/scene/ "$lower|renderer/image/|renderer/scene/"
    MayInclude renderer/graph/ "$lower|shaders/embedded.h|rhi/|renderer/graph/"
    MayInclude renderer/ "$lower|shaders/embedded.h|rhi/|renderer/"
    MayInclude passes/ "$lower|rhi/|renderer/|passes/"
    MayInclude editor/viewport/ "$lower|rhi/|renderer/|passes/|editor/viewport/"
    MayInclude editor/session/ "$lower|shaders/core/|rhi/|renderer/|passes/|editor/session/"
    MayInclude editor/app/ "$lower|shaders/core/|rhi/|renderer/|passes/|editor/viewport/|editor/session/|editor/app/"
    MayInclude editor/graph_run/ 'base/|rhi/|renderer/image/|renderer/graph/|editor/graph_run/'
    MayInclude editor/cli/ "$lower|rhi/|renderer/|passes/|editor/session/|editor/graph_run/|editor/viewport/view_settings.h|editor/viewport/viewport.h|editor/app/edit.h|editor/cli/"
    MayInclude c/ "$lower|rhi/|renderer/|passes/|editor/session/|editor/viewport/|c/"
    MayInclude python/ "$lower|rhi/|renderer/|passes/|editor/session/|python/"
    MayNotInclude 'renderer/scene/(model|animation|geometry|formats)/' 'renderer/scene/gltf/'
    MayNotInclude 'renderer/gpu_scene/(geometry|instances|materials|lights|deform)/' 'renderer/gpu_scene/streaming/'
    MayNotInclude 'renderer/gpu_scene/materials/' 'renderer/gpu_scene/(instances|lights|deform)/'
    MayNotInclude 'editor/session/(frames|file|settings)/' 'editor/session/group/'
    # editor/session/cpu compiles shader text, whose includes count from shaders/
    Find 'base/|rhi/|renderer/|passes/|editor/|c/|python/' '# *include *"' |
        grep -vE '"(base|rhi|renderer|passes|shaders|editor|c|python)/|^editor/session/cpu/[^:]*:[0-9]+:.*\.glsl"' |
        Report 'include-root: our headers are named from the root of the tree'
}

CheckTokens() {
    local libraries='base/|rhi/|renderer/|passes/|shaders/|editor/viewport/|editor/session/|c/|python/'
    local verbs='Cmd|Create|Destroy|Get|Allocate|Free|Queue|Device|Enumerate|Bind|Begin|End|Reset|Wait|Acquire|Build'
    Find 'base/|renderer/|passes/|shaders/|editor/|c/|python/' "$(Word "vk($verbs)[A-Z]|vk[A-Z][[:alnum:]]* *\\(")" |
        Report 'vk-call: Vulkan is called in rhi alone'
    Find 'base/|renderer/image/|renderer/scene/' "$(Word 'Vk[A-Z]|VK_')|include.*vulkan/" |
        Report 'no-vulkan: base, image and scene know nothing of Vulkan'
    Find 'passes/|editor/|python/' "$(Word 'Vk[A-Z]|VK_')|include.*vulkan/" |
        grep -v '^editor/viewport/vulkan_interop\.' |
        Report 'vk-token: passes and editor reach Vulkan through rhi; hosts through viewport/vulkan_interop.h'
    Find 'base/|rhi/|renderer/|passes/|shaders/|editor/viewport/|editor/session/|editor/cli/' "$(Word 'glfw|GLFW|imgui|ImGui|IMGUI')" |
        Report 'window: GLFW and ImGui are used in editor/app alone'
    Find 'base/|rhi/|renderer/|passes/|shaders/|editor/' "$(Word 'spdlog')|include.*<spdlog/" |
        grep -v '^editor/cli/program_log\.cpp:' |
        Report 'spdlog: the log of the program is editor/cli/program_log.cpp alone; libraries have base/log.h'
    Find "$libraries" "$(Word '_exit|_Exit|exit|quick_exit|abort|terminate') *\\(" |
        grep -v -e '^base/check\.h:' -e '^base/os_posix\.cpp:' |  # the latter with the status it was given
        Report 'exit: a library never ends the process'
    Find "$libraries" "$(Word 'cout|cerr|clog|printf|fprintf|vprintf|vfprintf|perror|puts|stdout|stderr')([^[:alnum:]_]|$)" |
        grep -v '^base/check\.h:' | Report 'output: a library never writes to stdout or stderr'
}

# What one system has and another has not is in base/os_posix.cpp, for a port to be one file.
CheckSystem() {
    local product='base/|rhi/|renderer/|passes/|shaders/|editor/|c/|python/'
    local folders='sys|arpa|net|netinet|linux'
    local headers='aio|dirent|dlfcn|fcntl|fnmatch|ftw|glob|grp|langinfo|libgen|netdb|poll|pthread|pwd|regex|sched'
    headers+='|semaphore|signal|spawn|strings|syslog|termios|ucontext|unistd|utime|windows|wordexp'
    local calls='dlopen|dlsym|fchmod|fdopen|fileno|fork|fseeko|fsync|ftello|getpid|getrusage|isatty|localtime_r|mmap'
    calls+='|nanosleep|openat|popen|readlink|setenv|sigaction|unlink|usleep'
    { Find "$product" "# *include *<(($folders)/[^>]*|($headers)\\.h|csignal)>" || true
      Find "$product" "$(Word "($calls)") *\\("; } | grep -v '^base/os_posix\.cpp:' |
        Report 'system: headers and calls of the operating system are in base/os_posix.cpp alone'
}

CheckFiles() {
    local file first count
    for file in "${sources[@]}"; do
        count=$(wc -l <"$file")
        ((count > 900)) || continue
        read -r first <"$file"
        # A table of numbers may be long and says so.
        [[ $first == '// Data table: '* ]] ||
            echo "$file:$count:" | Report 'size: more than 900 lines is more than one subject'
    done
    find "${folders[@]}" -type f -empty -printf '%p:1:\n' | Report 'empty: a file without content is left over'
    # Tests hold shaders and expected messages as raw strings, which nothing may break.
    grep -nHE '^.{111,}$' -- "${sources[@]}" | grep -v '^tests/' | cut -c -100 | Report 'columns: longer than 110'
    grep -nHIE "$(Word 'TODO|FIXME|XXX')([^[:alnum:]_]|$)" -- "${files[@]}" | grep -v '^tests/layering/' |
        Report 'unfinished: do it now or leave it out'
}

# A folder with sources has a README; the parts of shaders, tests and the largest folders share their parent's.
CheckReadmes() {
    local folder readme count
    printf '%s\n' "${sources[@]%/*}" | sed -E 's#^(shaders|tests|renderer/scene|renderer/gpu_scene|editor/session)/.*#\1#' | sort -u | while read -r folder; do
        [[ -f $folder/README.md ]] || echo "$folder/README.md:1:" | Report 'readme: every source folder has one'
    done
    for readme in "${files[@]}"; do
        [[ $readme == */README.md ]] || continue
        count=$(wc -l <"$readme")
        ((count <= 60)) || echo "$readme:$count:" | Report 'readme-size: at most 60 lines'
    done
}

# Prints the headers that are installed: those that cmake/InstallHeaders.cmake lists, and all that these include.
# Without those that shaders include too, which are constants and plain records.
PublicHeaders() {
    local list=cmake/InstallHeaders.cmake header included
    [[ -f $list ]] || return 0
    local -A seen=()
    local todo=(base/*.h passes/*.h)
    mapfile -t -O ${#todo[@]} todo < <(sed -n '/^set(public$/,/)/p' "$list" | grep -oE '[[:alnum:]_/]+\.h')
    while ((${#todo[@]})); do
        header=${todo[-1]}
        unset 'todo[-1]'
        [[ $header != base/text.h && $header != base/os.h && $header != base/embed_file.h ]] || continue  # not installed
        [[ -z ${seen[$header]-} && -f $header && $header != shaders/shared/* ]] || continue
        seen[$header]=1
        while read -r included; do todo+=("$included"); done < <(sed -nE 's/^#include "([^"]+)".*/\1/p' "$header")
    done
    printf '%s\n' "${!seen[@]}" | sort
}

# What a user of the installed headers relies on.
CheckPublicHeaders() {
    local header
    PublicHeaders | while read -r header; do
        sed '/^[^/]/Q' "$header" | grep -q 'Threads:' ||
            echo "$header:1:" | Report 'threads: the comment on top says "Threads: ..."'
        grep -nH '#include "base/text.h"' "$header" | Report 'text: hosts have no {fmt}, so installed headers do not need it'
        # Internal ones say so: "For rhi/ alone."
        ! sed '/^[^/]/Q' "$header" | grep -qE '/ alone\.' || continue
        awk -v name="$header" '
            /^(\[\[nodiscard\]\] )?[A-Za-z_][][A-Za-z0-9_:<>*&, ]* [*&]?[A-Z][A-Za-z0-9]*\(/ || /^class [A-Za-z0-9]+.*\{/ {
                if (!/RAYGRAPH_API/ && !/^(inline|constexpr|template|static|using|typedef)/ && before !~ /^template/)
                    print name ":" FNR ":" $0
            }
            # A struct whose member functions are not all written where they are declared; `call` is such a one so far.
            /^struct / { isOpen = /\{$/ && !/RAYGRAPH_API/; struct = name ":" FNR ":" $0; call = "" }
            /^};/ { isOpen = 0 }
            isOpen && (call != "" || /^    [A-Za-z_][][A-Za-z0-9_:<>*&, ]*[ *&][A-Z][A-Za-z0-9]*\(/) {
                if (call != "" || before !~ /^ *template/) call = call $0
                if (call ~ /;/ && call !~ /[{=]/) { print struct; isOpen = 0 }
                if (call ~ /[;{]/) call = ""
            }
            { before = $0 }' "$header" | Report 'export: what users call is marked RAYGRAPH_API'
    done
}

found=$(
    CheckLayers
    CheckTokens
    CheckSystem
    CheckFiles
    CheckReadmes
    CheckPublicHeaders
)
[[ -n $found ]] || exit 0
printf '%s\n' "$found"
exit 1
