// Simulates file systems that are full or lack some operation: calls of the program that links this fail on
// demand.
#pragma once

#include <sys/resource.h>

namespace raygraph::testing {

// Each call fails with its error number where that is not 0.
struct FailingCalls {
    int openUnnamed = 0;  // openat for a file without a name
    int linkat = 0, renameat = 0, fallocate = 0;
};

// While an object lives, these calls fail in all threads. At most one object may exist.
class FailingFiles {
  public:
    explicit FailingFiles(const FailingCalls& calls);
    ~FailingFiles();
    FailingFiles(const FailingFiles&) = delete;
    FailingFiles& operator=(const FailingFiles&) = delete;
};

// While an object lives, no file of this process grows beyond `bytes`: writing fails as on a full disk, but
// for the reason, which is EFBIG.
class FileSizeLimit {
  public:
    explicit FileSizeLimit(rlim_t bytes);
    ~FileSizeLimit();
    FileSizeLimit(const FileSizeLimit&) = delete;
    FileSizeLimit& operator=(const FileSizeLimit&) = delete;

  private:
    rlimit m_old = {};
    void (*m_oldHandler)(int) = nullptr;
};

}  // namespace raygraph::testing
