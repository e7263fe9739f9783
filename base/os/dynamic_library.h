// Libraries that are found when the program runs. Threads: any.
#pragma once

#include <string>

namespace raygraph::os {

// Loads a library by its file name, to the end of the process: nothing is unloaded that other code may still
// be in. Null, and why, if there is none.
void* OpenLibrary(const char* name, std::string& whyNot);
// Null if the library has no function of that name.
void* FunctionOf(void* library, const char* name);

}  // namespace raygraph::os
