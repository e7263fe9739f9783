#include "tests/support/failing_files.h"

#include <fcntl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>
#include <cstdio>

namespace {

raygraph::testing::FailingCalls failing;

template <typename... Arguments>
int CallUnless(int error, long call, Arguments... arguments) {
    if (error != 0) {
        errno = error;
        return -1;
    }
    return static_cast<int>(syscall(call, arguments...));
}

}  // namespace

namespace raygraph::testing {

FailingFiles::FailingFiles(const FailingCalls& calls) {
    failing = calls;
}

FailingFiles::~FailingFiles() {
    failing = {};
}

}  // namespace raygraph::testing

// In place of the C library's, also for libraries that are loaded with the program.
#pragma GCC visibility push(default)
extern "C" {

int openat(int folder, const char* path, int flags, ...) {
    va_list arguments;
    va_start(arguments, flags);
    const unsigned mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(arguments, unsigned) : 0;
    va_end(arguments);
    const bool isNameless = (flags & O_TMPFILE) == O_TMPFILE;
    return CallUnless(isNameless ? failing.openNameless : 0, SYS_openat, folder, path, flags, mode);
}

int linkat(int fromFolder, const char* from, int toFolder, const char* to, int flags) noexcept {
    return CallUnless(failing.linkat, SYS_linkat, fromFolder, from, toFolder, to, flags);
}

int renameat(int fromFolder, const char* from, int toFolder, const char* to) noexcept {
    return CallUnless(failing.renameat, SYS_renameat2, fromFolder, from, toFolder, to, 0);
}
}
#pragma GCC visibility pop
