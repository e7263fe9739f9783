// RG_CHECK_* check our own invariants. A failed check is a bug in Raygraph, never in its input: it prints
// both values and aborts. Active in debug builds and with RAYGRAPH_ASSERTS. Threads: any.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <sstream>

#if !defined(NDEBUG) && !defined(RAYGRAPH_ASSERTS)
#define RAYGRAPH_ASSERTS 1
#endif

namespace raygraph::detail {

template <typename A, typename B>
[[noreturn]] void CheckFailed(const char* text, const A& a, const B& b, const char* file, int line) {
    std::ostringstream message;
    message << file << ':' << line << ": check failed: " << text << " (" << a << " against " << b << ")\n";
    std::fputs(message.str().c_str(), stderr);
    std::abort();
}

}  // namespace raygraph::detail

#ifdef RAYGRAPH_ASSERTS
#define RG_CHECK_OP_(a, op, b)                                                                          \
    do {                                                                                                \
        const auto& rgCheckA = (a);                                                                     \
        const auto& rgCheckB = (b);                                                                     \
        if (!(rgCheckA op rgCheckB))                                                                    \
            ::raygraph::detail::CheckFailed(#a " " #op " " #b, rgCheckA, rgCheckB, __FILE__, __LINE__); \
    } while (false)
#else
#define RG_CHECK_OP_(a, op, b) ((void)sizeof((a)op(b)))
#endif

#define RG_CHECK_EQ(a, b)   RG_CHECK_OP_(a, ==, b)
#define RG_CHECK_NE(a, b)   RG_CHECK_OP_(a, !=, b)
#define RG_CHECK_LT(a, b)   RG_CHECK_OP_(a, <, b)
#define RG_CHECK_LE(a, b)   RG_CHECK_OP_(a, <=, b)
#define RG_CHECK_GT(a, b)   RG_CHECK_OP_(a, >, b)
#define RG_CHECK_GE(a, b)   RG_CHECK_OP_(a, >=, b)
#define RG_CHECK(condition) RG_CHECK_OP_(static_cast<bool>(condition), ==, true)
