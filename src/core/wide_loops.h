// Wider vector instructions for single functions.
#pragma once

// In front of a function whose loops the compiler can vectorise: it is compiled for AVX2 too, and
// the processor decides which one runs. Results are the same bits, because nothing is contracted or
// reordered. GCC only; sanitizers do not start where functions are chosen at load time.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define TETREC_WIDE_LOOPS __attribute__((target_clones("avx2", "default")))
#else
#define TETREC_WIDE_LOOPS
#endif
