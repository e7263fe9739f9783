// File systems that lack something: calls of the program that links this fail on demand.
#pragma once

namespace raygraph::testing {

// Each call fails with its error number where that is not 0.
struct FailingCalls {
    int openNameless = 0;  // openat for a file without a name
    int linkat = 0, renameat = 0;
};

// While it lives, these calls of all threads fail. One at a time.
class FailingFiles {
  public:
    explicit FailingFiles(const FailingCalls& calls);
    ~FailingFiles();
    FailingFiles(const FailingFiles&) = delete;
    FailingFiles& operator=(const FailingFiles&) = delete;
};

}  // namespace raygraph::testing
