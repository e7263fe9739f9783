#!/usr/bin/env bash
# render_and_check.sh SCENE: in the folder of the two programs.
set -euo pipefail

rm -f picture.exr
./render "$1" picture.exr
./check "$1" picture.exr
