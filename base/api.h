// RAYGRAPH_API: what the shared library exports. All else is compiled hidden, so that neither our own insides
// nor the libraries that we are linked with meet a host's symbols. Threads: any, nothing here runs.
#pragma once

#define RAYGRAPH_API __attribute__((visibility("default")))
