// Overloaded makes a visitor of lambdas, for std::visit. Threads: pure functions, for any thread.
#pragma once

namespace raygraph {

template <typename... Handlers>
struct Overloaded : Handlers... {
    using Handlers::operator()...;
};
template <typename... Handlers>
Overloaded(Handlers...) -> Overloaded<Handlers...>;

}  // namespace raygraph
