#!/usr/bin/env bash
# exported_symbols.sh LIBRARY: fails and names the first symbols, if the shared library exports any but ours, rg_... of the
# C interface among them, and weak ones of the C++ library's templates; or if it does not export what every host needs.
set -euo pipefail

# As they are mangled: names within raygraph, and what belongs to them; the same of std and __gnu_cxx.
belonging='^_Z(T[ISV]|GV|Thn[0-9]+_)?Z*N?K?'
ours="${belonging}8raygraph|^rg_[a-z_]+$"
std="$belonging(S[tabsiod]|9__gnu_cxx)"

symbols=$(nm -D --defined-only "$1")
strangers=$(awk -v ours="$ours" -v std="$std" '
    $3 ~ ours { next }
    $2 ~ /^[WVu]$/ && $3 ~ std { next }
    { print $2, $3 }' <<<"$symbols")
if [[ -n $strangers ]]; then
    echo "$1 exports what is not ours:" >&2
    head -n 20 <<<"$strangers" | c++filt >&2
    exit 1
fi
demangled=$(c++filt <<<"$symbols")
for needed in 'typeinfo for raygraph::Error' 'raygraph::rhi::Requirements()' 'raygraph::LibraryVersion()' \
    'raygraph::viewport::Viewport::Declare()' 'raygraph::session::Session::Result() const' \
    'raygraph::testing::PassHarness::Run('; do
    grep -qF "$needed" <<<"$demangled" || {
        echo "$1 does not export $needed" >&2
        exit 1
    }
done
