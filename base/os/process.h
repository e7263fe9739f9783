// This process and its terminal. Threads: any, but see InterruptWatch.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>

namespace raygraph::os {

// Processor time of all threads, user and system, seconds. A CPU driver renders in this process.
double ProcessCpuSeconds();
// Peak resident memory.
uint64_t PeakResidentBytes();

// Of the wall clock, in the time zone of this computer: "14:05:09".
std::string LocalTimeOfDay();

bool IsTerminal(std::FILE* stream);
// Columns; 80 if unknown.
size_t TerminalWidth(std::FILE* stream);

// Whether a text matches a shell pattern: * ? [a-z].
bool FitsPattern(const std::string& text, const std::string& pattern);

// Ctrl-C: recorded instead of ending the process at once, so that a render can write its samples. While it
// lives, the first SIGINT or SIGTERM is noted; a second one ends the process as usual. One at a time.
class InterruptWatch {
  public:
    InterruptWatch();
    ~InterruptWatch();
    InterruptWatch(const InterruptWatch&) = delete;
    InterruptWatch& operator=(const InterruptWatch&) = delete;

    bool IsRequested() const;

  private:
    struct Before;
    std::unique_ptr<Before> m_before;
};

}  // namespace raygraph::os
