#include "tests/cli/animated_box.h"

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/cli/program_runner.h"

namespace raygraph::test {

using nlohmann::json;

void WriteBox(const TemporaryFolder& folder) {
    json scene = json::parse(std::ifstream(SceneFile("cornell.gltf")));
    // 0 and 1; (0, 0, 0) and (0, 0.1, 0); (0, 0, 0) and (0, -0.1, 0)
    const size_t buffer = scene["buffers"].size();
    scene["buffers"].push_back(
        {{"byteLength", 56},
         {"uri",
          "data:application/"
          "octet-stream;base64,AAAAAAAAgD8AAAAAAAAAAAAAAAAAAAAAzczMPQAAAAAAAAAAAAAAAAAAAAAAAAAAzc"
          "zMvQAAAAA="}});
    const size_t view = scene["bufferViews"].size();
    scene["bufferViews"].push_back({{"buffer", buffer}, {"byteLength", 56}});
    const size_t times = scene["accessors"].size();
    scene["accessors"].push_back({{"bufferView", view},
                                  {"componentType", 5126},
                                  {"count", 2},
                                  {"type", "SCALAR"},
                                  {"min", json::array({0})},
                                  {"max", json::array({1})}});
    size_t node = 0;
    while (!scene["nodes"][node].contains("mesh")) ++node;
    for (const size_t offset : {8, 32}) {
        scene["accessors"].push_back({{"bufferView", view},
                                      {"byteOffset", offset},
                                      {"componentType", 5126},
                                      {"count", 2},
                                      {"type", "VEC3"}});
        scene["animations"].push_back(
            {{"name", offset == 8 ? "rise" : "sink"},
             {"samplers", json::array({{{"input", times}, {"output", scene["accessors"].size() - 1}}})},
             {"channels",
              json::array({{{"sampler", 0}, {"target", {{"node", node}, {"path", "translation"}}}}})}});
    }
    std::ofstream(folder / "box.gltf") << scene;
}

}  // namespace raygraph::test
