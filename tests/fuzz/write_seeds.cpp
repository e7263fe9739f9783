// raygraph_fuzz_seeds FOLDER: writes the seeds of each target to FOLDER/TARGET, and prints the targets'
// names.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>

#include "tests/fuzz/seeds.h"

int main(int count, char** arguments) {
    using namespace raygraph::fuzz;
    if (count != 2) {
        std::fprintf(stderr, "raygraph_fuzz_seeds FOLDER\n");
        return 2;
    }
    try {
        for (const Target& target : Targets()) {
            const std::filesystem::path folder = std::filesystem::path(arguments[1]) / target.name;
            std::filesystem::create_directories(folder);
            for (const Seed& seed : Seeds(target, true)) {
                std::ofstream file(folder / seed.name, std::ios::binary);
                file.write(reinterpret_cast<const char*>(seed.bytes.data()),
                           static_cast<std::streamsize>(seed.bytes.size()));
                if (!file.flush()) throw std::runtime_error("cannot write " + (folder / seed.name).string());
            }
            std::printf("%s\n", target.name);
        }
    } catch (const std::exception& error) {
        std::fprintf(stderr, "raygraph_fuzz_seeds: %s\n", error.what());
        return 1;
    }
}
