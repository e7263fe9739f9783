#include "tests/support/failing_files.h"

#include <fcntl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdarg>

namespace {

raygraph::testing::FailingCalls failing;

template <typename... Arguments>
int FailOrCall(int error, long call, Arguments... arguments) {
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

FileSizeLimit::FileSizeLimit(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &m_old);
    m_oldHandler = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{bytes, m_old.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
}

FileSizeLimit::~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &m_old);
    std::signal(SIGXFSZ, m_oldHandler);
}

}  // namespace raygraph::testing

// These replace the C library's functions, also for libraries that are loaded with the program. They have its
// symbols but names of their own, because its headers may declare more than functions.
#pragma GCC visibility push(default)
extern "C" {
int ReplacedOpenat(int folder, const char* path, int flags, ...) __asm__("openat");
int ReplacedLinkat(int fromFolder, const char* from, int toFolder, const char* to,
                   int flags) __asm__("linkat");
int ReplacedRenameat(int fromFolder, const char* from, int toFolder, const char* to) __asm__("renameat");
int ReplacedFallocate(int file, int mode, off_t offset, off_t size) __asm__("fallocate");
}
#pragma GCC visibility pop

int ReplacedOpenat(int folder, const char* path, int flags, ...) {
    va_list arguments;
    va_start(arguments, flags);
    const unsigned mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(arguments, unsigned) : 0;
    va_end(arguments);
    const bool isNameless = (flags & O_TMPFILE) == O_TMPFILE;
    return FailOrCall(isNameless ? failing.openUnnamed : 0, SYS_openat, folder, path, flags, mode);
}

int ReplacedLinkat(int fromFolder, const char* from, int toFolder, const char* to, int flags) {
    return FailOrCall(failing.linkat, SYS_linkat, fromFolder, from, toFolder, to, flags);
}

int ReplacedRenameat(int fromFolder, const char* from, int toFolder, const char* to) {
    return FailOrCall(failing.renameat, SYS_renameat2, fromFolder, from, toFolder, to, 0);
}

int ReplacedFallocate(int file, int mode, off_t offset, off_t size) {
    return FailOrCall(failing.fallocate, SYS_fallocate, file, mode, offset, size);
}
