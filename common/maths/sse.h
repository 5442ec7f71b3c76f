#pragma once

// The SSE 4.1 intrinsics; on another processor than x86-64 those of SIMDe.
#if defined(__x86_64__)
#include <smmintrin.h>
#else
#define SIMDE_ENABLE_NATIVE_ALIASES
#include <simde/x86/sse4.1.h>
#endif
