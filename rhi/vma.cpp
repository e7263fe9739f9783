// The one file that compiles the text of the Vulkan Memory Allocator.
#define VMA_IMPLEMENTATION
#include "rhi/vma.h"
