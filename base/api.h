// RAYGRAPH_API marks what the shared library exports. All else is compiled hidden, so that neither internal
// symbols nor those of linked libraries clash with a host's. Threads: any.
#pragma once

#define RAYGRAPH_API __attribute__((visibility("default")))
