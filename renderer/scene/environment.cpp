#include "renderer/scene/environment.h"

#include <cmath>
#include <glm/gtc/constants.hpp>

namespace raygraph::scene {

glm::mat3 WorldToEnvironment(const EnvironmentDesc& environment) {
    // Quarter turns come out exact: sin and cos of a rounded pi/2 do not.
    const double degrees = std::remainder(static_cast<double>(environment.rotationDegrees), 360.0);
    const double quarters = std::round(degrees / 90.0);
    const double rest = (degrees - 90.0 * quarters) * glm::pi<double>() / 180.0;
    double c = std::cos(rest);
    double s = std::sin(rest);
    for (int turn = static_cast<int>(quarters) & 3; turn > 0; --turn) {
        const double previous = c;
        c = -s;
        s = previous;
    }
    // A turn by -angle about +y; columns are the images of x, y and z.
    const auto cosine = static_cast<float>(c);
    const auto sine = static_cast<float>(s);
    return {glm::vec3(cosine, 0, sine), glm::vec3(0, 1, 0), glm::vec3(-sine, 0, cosine)};
}

}  // namespace raygraph::scene
