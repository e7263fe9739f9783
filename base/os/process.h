// This process and its terminal. Threads: any.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>

namespace raygraph::os {

// Returns the processor time of all threads, user and system, in seconds. A CPU driver renders in this
// process.
double ProcessCpuSeconds();
// Returns the peak of the resident memory, in bytes.
uint64_t PeakResidentBytes();

// Returns the wall-clock time in this computer's time zone: "14:05:09".
std::string LocalTimeOfDay();

// Lets writes fail instead of ending the process: those to a pipe without a reader, and those beyond the
// limit on the size of files (SIGPIPE, SIGXFSZ). Those to a standard stream that is closed fail, too, and
// never go to a file that is opened in its place. For programs, at their start.
void LetWritesFail() noexcept;

bool IsTerminal(std::FILE* stream);
// Returns the columns of the terminal; 80 if unknown.
size_t TerminalWidth(std::FILE* stream);

// Returns whether a text matches a shell pattern: * ? [a-z].
bool FitsPattern(const std::string& text, const std::string& pattern);

}  // namespace raygraph::os
