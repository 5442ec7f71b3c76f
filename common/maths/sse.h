#pragma once

// The SSE 4.1 intrinsics, on every processor: elsewhere SIMDe makes them of what that one has, with the same results.
#if defined(__x86_64__)
#include <smmintrin.h>
#else
#define SIMDE_ENABLE_NATIVE_ALIASES
#include <simde/x86/sse4.1.h>
#endif
