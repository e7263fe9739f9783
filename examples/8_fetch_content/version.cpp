// Prints the version of the library that was fetched and compiled with this program.
#include <cstdio>

#include "base/version.h"

int main() {
    const raygraph::Version version = raygraph::LibraryVersion();
    std::printf("%d.%d.%d\n", version.major, version.minor, version.patch);
}
