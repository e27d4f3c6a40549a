// L2. How the host interrupts a long run: asked between two pieces of it, never within one.
#pragma once

namespace nfopidn {

// Runs that nobody interrupts: one piece. Firmware has no other.
struct NoPoll {
  static constexpr int samples = __INT_MAX__;
  static constexpr bool is_stopped() { return false; }
};

// A raw pointer to whom to ask, so that the lanes' units can have it too.
struct Poll {
  int samples = __INT_MAX__;          // of a piece
  bool (*question)(void*) = nullptr;  // null: nobody interrupts; must not throw
  void* asked = nullptr;              // its argument; borrowed

  bool is_stopped() const { return question != nullptr && question(asked); }
};

}  // namespace nfopidn
