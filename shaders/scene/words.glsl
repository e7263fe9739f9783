// Records in words of 16 bytes. A device loads such a word at once, and Mesa's driver for CPUs, which
// branches for each lane of each scalar that it loads, in two parts.
#ifndef RAYGRAPH_SCENE_WORDS_GLSL
#define RAYGRAPH_SCENE_WORDS_GLSL

uvec4 HalvesOf(u64vec2 word) { return uvec4(unpackUint2x32(word.x), unpackUint2x32(word.y)); }

#endif
