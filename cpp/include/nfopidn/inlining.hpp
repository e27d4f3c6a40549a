// L0. The control step, the plant and the cost become one block of arithmetic, in which equal terms
// (the sine of the heading, the errors) are computed once. That needs every piece inlined.
#pragma once

#define NFOPIDN_INLINE [[gnu::always_inline]] inline
#define NFOPIDN_NOINLINE [[gnu::noinline]]
