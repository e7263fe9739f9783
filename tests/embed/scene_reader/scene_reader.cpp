// Reads a scene without a device.
#include <cstdio>
#include <exception>

#include "renderer/scene/gltf/load_gltf.h"

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fputs("scene_reader SCENE\n", stderr);
        return 2;
    }
    try {
        const raygraph::scene::SceneData scene = raygraph::scene::LoadGltf(argv[1]);
        std::printf("%zu instances\n", scene.instances.size());
        return scene.instances.empty() ? 1 : 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
