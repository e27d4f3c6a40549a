// L0. The control step, the plant and the cost become one block of arithmetic, in which equal terms
// (the sine of the heading, the errors) are computed once. That needs every piece inlined.
#pragma once

#ifdef NFOPIDN_PLAIN_INLINE  // for tests: forced inlining doubles the time that they take to
                             // compile
#define NFOPIDN_INLINE inline
#else
#define NFOPIDN_INLINE [[gnu::always_inline]] inline
#endif
#define NFOPIDN_NOINLINE [[gnu::noinline]]
