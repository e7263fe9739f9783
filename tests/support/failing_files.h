// Simulates file systems without some operation: calls of the program that links this fail on demand.
#pragma once

namespace raygraph::testing {

// Each call fails with its error number where that is not 0.
struct FailingCalls {
    int openNameless = 0;  // openat for a file without a name
    int linkat = 0, renameat = 0;
};

// While an object lives, these calls fail in all threads. At most one object may exist.
class FailingFiles {
  public:
    explicit FailingFiles(const FailingCalls& calls);
    ~FailingFiles();
    FailingFiles(const FailingFiles&) = delete;
    FailingFiles& operator=(const FailingFiles&) = delete;
};

}  // namespace raygraph::testing
