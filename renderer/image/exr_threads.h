// Threads that code OpenEXR files, for programs. Threads: any.
//
//   const image::ExrThreads threads;
//   image::WriteExr(path, picture);
#pragma once

#include "base/api.h"

namespace raygraph::image {

// While there is one, ReadExr and WriteExr use several threads of the OpenEXR library, which has one pool of
// them for the whole process. The first object starts them and the last one ends them; where the process has
// started some itself (Imf::setGlobalThreadCount), they are left alone. Files have the same bits with any
// number.
class RAYGRAPH_API ExrThreads {
  public:
    explicit ExrThreads(unsigned count = 0);  // 0: one a core
    ~ExrThreads();
    ExrThreads(const ExrThreads&) = delete;
    ExrThreads& operator=(const ExrThreads&) = delete;

  private:
    bool m_isCounted = false;
};

}  // namespace raygraph::image
