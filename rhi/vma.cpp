// The only file that compiles the implementation of the Vulkan Memory Allocator.
#define VMA_IMPLEMENTATION
#include "rhi/vma.h"
