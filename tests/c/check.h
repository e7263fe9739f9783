// Checks of the tests in C: a failed one prints its line, and the program ends with 1.
#ifndef CHECK_H
#define CHECK_H

#include <raygraph.h>
#include <stdio.h>
#include <string.h>

static int g_failures = 0;

static void Check(bool holds, const char* file, int line, const char* what) {
    if (holds) return;
    fprintf(stderr, "%s:%d: not so: %s (last error: %s)\n", file, line, what, rg_last_error());
    ++g_failures;
}
#define CHECK(holds)   Check((holds), __FILE__, __LINE__, #holds)
#define CHECK_OK(call) Check((call) == RG_OK, __FILE__, __LINE__, #call)
// The call fails with this result, and its line contains the text.
#define CHECK_FAILS(call, result, text)                                                      \
    Check((call) == (result) && strstr(rg_last_error(), (text)) != NULL, __FILE__, __LINE__, \
          #call " fails: " text)

#endif
