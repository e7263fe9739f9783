// Libraries that are loaded at run time. Threads: any.
#pragma once

#include <string>

namespace raygraph::os {

// Loads a library by its file name, to the end of the process: nothing is unloaded, because other code may
// still run in it. Returns null and sets the reason if it cannot be loaded.
void* OpenLibrary(const char* name, std::string& whyNot);
// Returns null if the library has no function of that name.
void* FunctionOf(void* library, const char* name);

}  // namespace raygraph::os
