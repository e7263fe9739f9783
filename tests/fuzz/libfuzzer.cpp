// The program for libFuzzer: RAYGRAPH_FUZZ=TARGET raygraph_fuzz [libFuzzer's options] [corpora or files].
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "tests/fuzz/target.h"

namespace {

using namespace raygraph::fuzz;

const Target& Chosen() {
    static const Target& target = []() -> const Target& {
        const char* name = std::getenv("RAYGRAPH_FUZZ");
        if (const Target* found = FindTarget(name ? name : "")) return *found;
        std::fprintf(stderr, "RAYGRAPH_FUZZ must name a target:");
        for (const Target& each : Targets()) std::fprintf(stderr, " %s", each.name);
        std::fprintf(stderr, "\n");
        std::exit(2);
    }();
    return target;
}

}  // namespace

extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t maxSize);

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const Target& target = Chosen();
    if (size > target.maxBytes) return -1;  // not to be kept
    try {
        target.run(std::as_bytes(std::span(data, size)));
    } catch (const Finding& finding) {
        std::fprintf(stderr, "%s: %s\n", target.name, finding.what());
        std::abort();
    }
    return 0;
}

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t maxSize, unsigned seed) {
    const Target& target = Chosen();
    maxSize = std::min(maxSize, target.maxBytes);
    const size_t changedSize = LLVMFuzzerMutate(data, std::min(size, maxSize), maxSize);
    // Wrong lengths and checksums are tried, too
    if (!target.repair || seed % 4 == 0) return changedSize;
    const Input changed = std::as_bytes(std::span(data, changedSize));
    Bytes repaired(changed.begin(), changed.end());
    target.repair(repaired);
    if (repaired.size() > maxSize) return changedSize;
    std::memcpy(data, repaired.data(), repaired.size());
    return repaired.size();
}
