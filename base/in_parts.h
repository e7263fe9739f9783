// InParts shares work on the pixels of a picture among processors. Threads: any; `body` is called by several.
#pragma once

#include <algorithm>
#include <cstddef>
#include <exception>
#include <thread>
#include <vector>

namespace raygraph {

// Calls body(first, end) for parts of the pixels that together are all of them. A large picture is worked on
// by a thread for each processor. Throws what `body` throws, after all parts.
template <typename Body>
void InParts(size_t pixels, const Body& body) {
    constexpr size_t kPixelsOfPart = size_t{1} << 16;
    const size_t processors = std::max(std::thread::hardware_concurrency(), 1u);
    const size_t count = std::clamp<size_t>(pixels / kPixelsOfPart, 1, processors);
    const auto begin = [&](size_t part) { return pixels * part / count; };
    std::vector<std::exception_ptr> failures(count);
    {
        std::vector<std::jthread> threads;
        for (size_t part = 1; part < count; ++part)
            threads.emplace_back([&, part] {
                try {
                    body(begin(part), begin(part + 1));
                } catch (...) {
                    failures[part] = std::current_exception();
                }
            });
        body(0, begin(1));
    }
    for (const std::exception_ptr& failure : failures)
        if (failure) std::rethrow_exception(failure);
}

}  // namespace raygraph
