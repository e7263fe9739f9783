// An $XDG_CACHE_HOME in which the programs of a test find nothing. What the driver has compiled for other tests
// stays known: to compile it again would take most of the time. Not while other threads read or write the
// environment.
#pragma once

#include <string>

#include "tests/support/environment_variable.h"
#include "tests/support/source_file.h"

namespace raygraph::test {

class OwnCache {
  public:
    explicit OwnCache(const std::string& folder)
        : m_driver("MESA_SHADER_CACHE_DIR", DriverCache()), m_cache("XDG_CACHE_HOME", folder) {}

  private:
    static std::string DriverCache() {
        const std::string home = std::string(EnvironmentOr("HOME", "")) + "/.cache";
        return EnvironmentOr("MESA_SHADER_CACHE_DIR", EnvironmentOr("XDG_CACHE_HOME", home.c_str()));
    }

    EnvironmentVariable m_driver, m_cache;
};

}  // namespace raygraph::test
