#!/usr/bin/env bash
# headers_alone.sh PREFIX COMPILER...: each installed header compiles alone, without asserts and without warnings. Of
# shaders/shared some are for one language alone.
set -euo pipefail

package=$(find "$1" -name raygraph.pc)
read -ra flags <<<"$(PKG_CONFIG_PATH=${package%/*} pkg-config --cflags raygraph)"
find "$1/include" -name '*.h' ! -path '*/shaders/shared/*' -print0 |
    xargs -0 -P 2 -I '{}' "${@:2}" -std=c++20 -DNDEBUG -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion \
        -Wno-missing-field-initializers -Werror "${flags[@]}" -fsyntax-only -include '{}' -x c++ /dev/null
