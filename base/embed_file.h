// RAYGRAPH_EMBED_FILE(symbol, path) puts a file of the build into the program: it declares `symbol`, its
// bytes, and `symbol_end`, the byte after the last; aligned to 16. `path` is a string literal. Neither the
// compiler nor ccache tells Ninja of the file: name it as OBJECT_DEPENDS of the source in CMakeLists.txt. For
// GCC and clang on ELF. Threads: any.
#pragma once

#include <cstddef>

#define RAYGRAPH_EMBED_FILE(symbol, path)                                                         \
    __asm__(".pushsection .rodata\n.balign 16\n.hidden " #symbol "\n.globl " #symbol "\n" #symbol \
            ":\n.incbin \"" path "\"\n.hidden " #symbol "_end\n.globl " #symbol "_end\n" #symbol  \
            "_end:\n.byte 0\n.popsection\n");                                                     \
    extern "C" {                                                                                  \
    __attribute__((visibility("hidden"))) extern const std::byte symbol[];                        \
    __attribute__((visibility("hidden"))) extern const std::byte symbol##_end[];                  \
    }                                                                                             \
    static_assert(true)
