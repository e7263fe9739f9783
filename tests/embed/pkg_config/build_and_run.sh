#!/usr/bin/env bash
# build_and_run.sh PREFIX static|shared FOLDER SCENE COMPILER...: a program made with what pkg-config says of the package
# in PREFIX, and nothing else.
set -euo pipefail

prefix=$1 kind=$2 folder=$3 scene=$4
compiler=("${@:5}")
here=$(dirname -- "${BASH_SOURCE[0]}")
mkdir -p -- "$folder"
file=$(find "$prefix" -name raygraph.pc)
export PKG_CONFIG_PATH=${file%/*}${PKG_CONFIG_PATH:+:$PKG_CONFIG_PATH}
options=(--cflags --libs)
[[ $kind != static ]] || options+=(--static)
read -ra flags <<<"$(pkg-config "${options[@]}" raygraph)"
"${compiler[@]}" -std=c++20 "$here/main.cpp" -o "$folder/check" "${flags[@]}"
LD_LIBRARY_PATH=$(pkg-config --variable=libdir raygraph) "$folder/check" "$scene" "$folder/missing.gltf"
[[ -f $(pkg-config --variable=shaderdir raygraph)/post/tonemap.comp ]]
