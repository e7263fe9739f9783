// Passes of one's own from Python.
#include "python/bindings.h"

namespace raygraph::python {

void BindPasses(py::module_&) {}

}  // namespace raygraph::python
