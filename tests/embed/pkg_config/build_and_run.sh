#!/usr/bin/env bash
# build_and_run.sh PREFIX static|shared FOLDER SCENE COMPILER...: a program made with what pkg-config says of the package
# in PREFIX, and nothing else. It is linked with the kind of library that was asked for.
set -euo pipefail

prefix=$1 kind=$2 folder=$3 scene=$4
compiler=("${@:5}")
here=$(dirname -- "${BASH_SOURCE[0]}")
mkdir -p -- "$folder"
package=raygraph
[[ $kind == shared ]] || package+=-$kind
file=$(find "$prefix" -name "$package.pc")
export PKG_CONFIG_PATH=${file%/*}${PKG_CONFIG_PATH:+:$PKG_CONFIG_PATH}
read -ra flags <<<"$(pkg-config --cflags --libs "$package")"
"${compiler[@]}" -std=c++20 "$here/main.cpp" -o "$folder/check" "${flags[@]}"
libraries=$(readelf --dynamic "$folder/check" | grep NEEDED)
linked=static
[[ $libraries != *libraygraph* ]] || linked=shared
if [[ $linked != "$kind" || $libraries == *libvulkan* ]]; then
    printf 'of %s the program is linked with\n%s\n' "$package" "$libraries" >&2
    exit 1
fi
LD_LIBRARY_PATH=$(pkg-config --variable=libdir "$package") "$folder/check" "$scene" "$folder/missing.gltf"
if [[ $kind == shared ]]; then  # the static libraries need a linker of C++
    cc -std=c11 "$here/../../../examples/9_render.c" -o "$folder/render" "${flags[@]}"
    LD_LIBRARY_PATH=$(pkg-config --variable=libdir "$package") "$folder/render" "$scene" "$folder/render.png"
fi
[[ -f $(pkg-config --variable=shaderdir "$package")/post/tonemap.comp ]]
