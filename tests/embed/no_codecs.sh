#!/usr/bin/env bash
# no_codecs.sh PROGRAM: runs a program of the current folder. Fails and names the reason if it is linked with libraries of picture
# files (zstd, which unpacks the shaders, is none), or if code that reads pictures or scenes is in it.
set -euo pipefail

libraries=$(readelf --dynamic --wide "$1" | grep NEEDED)
if grep -E 'lib(png|jpeg|webp|sharpyuv|OpenEXR|Imath|Iex|IlmThread|z|meshoptimizer|draco)[-.]' <<<"$libraries"; then
    echo "$1 is linked with these" >&2
    exit 1
fi
symbols=$(nm --demangle "$1")
grep -qF 'raygraph::Renderer::' <<<"$symbols" || { echo "$1 has no renderer in it" >&2; exit 1; }
if grep -m 5 -E 'raygraph::(scene|image)::|tinygltf|png_read' <<<"$symbols"; then
    echo "$1 has these in it" >&2
    exit 1
fi
"./$1"
