// L3. The floating-point arithmetic that the results are defined in.
#pragma once

#include <cfenv>

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

namespace nfopidn {

// While one exists, its thread rounds to nearest and keeps subnormal numbers. Other libraries leave
// another rounding, or "flush to zero", switched on, with which every result would be another. What
// was there before comes back at the end.
class StandardArithmetic {
 public:
  StandardArithmetic() : changes_(!is_standard()) {
    if (!changes_) return;
    std::fegetenv(&before_);
    std::fesetenv(FE_DFL_ENV);
  }
  ~StandardArithmetic() {
    if (changes_) std::fesetenv(&before_);
  }
  StandardArithmetic(const StandardArithmetic&) = delete;
  StandardArithmetic& operator=(const StandardArithmetic&) = delete;

  static bool is_standard() noexcept {
#if defined(__SSE2__)
    // Rounding, flush to zero and "denormals are zero" of the vector unit; x87 has a rounding of
    // its own.
    constexpr unsigned others = 0x6000 | 0x8000 | 0x0040;
    if ((_mm_getcsr() & others) != 0) return false;
#elif defined(__aarch64__)
    unsigned long control = 0;
    __asm__("mrs %0, fpcr" : "=r"(control));
    constexpr unsigned long others = 0x00C00000 | 0x01000000;
    if ((control & others) != 0) return false;
#endif
    return std::fegetround() == FE_TONEAREST;
  }

 private:
  bool changes_;
  std::fenv_t before_ = {};
};

}  // namespace nfopidn
