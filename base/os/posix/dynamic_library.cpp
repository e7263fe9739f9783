#include "base/os/dynamic_library.h"

#include <dlfcn.h>

namespace raygraph::os {

void* OpenLibrary(const char* name, std::string& whyNot) {
    void* library = dlopen(name, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    if (library != nullptr) return library;
    const char* reason = dlerror();
    whyNot = reason != nullptr ? reason : name;
    return nullptr;
}

void* FunctionOf(void* library, const char* name) {
    return dlsym(library, name);
}

}  // namespace raygraph::os
