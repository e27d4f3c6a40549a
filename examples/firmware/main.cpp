// The program for the board: runs the recorded samples through the control step and prints each
// pair of torques as bit patterns, `left right`, in hexadecimal.
#include <cstdint>

int firmware();

#include "board/semihosting.hpp"
#include "recording.hpp"

namespace {

// SysTick counts down from 2^24 - 1 at the processor's clock.
volatile std::uint32_t& systick_control = *reinterpret_cast<std::uint32_t*>(0xE000E010U);
volatile std::uint32_t& systick_reload = *reinterpret_cast<std::uint32_t*>(0xE000E014U);
volatile std::uint32_t& systick_value = *reinterpret_cast<std::uint32_t*>(0xE000E018U);
constexpr std::uint32_t systick_mask = 0xFFFFFFU;

void append_hex(char*& end, std::uint32_t number) {
  for (int shift = 28; shift >= 0; shift -= 4) *end++ = "0123456789abcdef"[(number >> shift) & 15U];
}

void print(const char* name, std::uint32_t a, std::uint32_t b) {
  char line[64];
  char* end = line;
  while (*name != '\0') *end++ = *name++;
  append_hex(end, a);
  *end++ = ' ';
  append_hex(end, b);
  *end++ = '\n';
  *end = '\0';
  semihosting::write(line);
}

std::uint32_t bits_of(float value) { return __builtin_bit_cast(std::uint32_t, value); }

template <int count>
void run(const Sample (&samples)[count]) {
  control_reset();
  for (const Sample& sample : samples) {
    const Torques torques = control_step(sample.measured, sample.reference);
    print("", bits_of(torques.left), bits_of(torques.right));
  }
}

// The same without printing, timed as a whole: a tick is longer than a step.
template <int count>
std::uint32_t ticks(const Sample (&samples)[count]) {
  control_reset();
  const std::uint32_t begin = systick_value;
  for (const Sample& sample : samples) control_step(sample.measured, sample.reference);
  return (begin - systick_value) & systick_mask;
}

}  // namespace

int firmware() {
  systick_reload = systick_mask;
  systick_value = 0;
  systick_control = 5;  // on, from the processor's clock
  run(recorded);
  run(stress);
  print("ticks ", ticks(recorded), sizeof recorded / sizeof recorded[0]);
  return 0;
}
