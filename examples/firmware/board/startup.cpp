// From reset to the program: vector table, floating point, memory.
#include <cstdint>

#include "semihosting.hpp"

int firmware();  // the program

extern "C" {

// Of the linker script; their addresses are what counts.
extern std::uint32_t image_data_load[], image_data_begin[], image_data_end[];
extern std::uint32_t image_bss_begin[], image_bss_end[], image_stack_top[];

void reset_handler();
void fault_handler();

[[noreturn]] void start_program() {
  for (std::uint32_t *from = image_data_load, *to = image_data_begin; to < image_data_end;) {
    *to++ = *from++;
  }
  for (std::uint32_t* to = image_bss_begin; to < image_bss_end;) *to++ = 0;
  semihosting::exit(firmware());
}

void fault_handler() {
  semihosting::write("fault\n");
  semihosting::exit(70);
}

// Naked, so that no floating-point register is saved before the coprocessor is on.
[[gnu::naked]] void reset_handler() {
  asm volatile(
      "ldr r0, =0xE000ED88\n"  // coprocessor access control register
      "ldr r1, [r0]\n"
      "orr r1, r1, #0xF00000\n"  // full access to CP10 and CP11
      "str r1, [r0]\n"
      "dsb\n"
      "isb\n"
      "b start_program\n");
}

using Handler = void (*)();

struct VectorTable {
  std::uint32_t* stack_top;
  Handler handlers[15];
};

// No interrupt is enabled: whatever comes is a fault.
[[gnu::section(".vectors"), gnu::used]] const VectorTable vectors = {
    image_stack_top,
    {reset_handler, fault_handler, fault_handler, fault_handler, fault_handler, fault_handler,
     nullptr, nullptr, nullptr, nullptr, fault_handler, fault_handler, nullptr, fault_handler,
     fault_handler}};

}  // extern "C"
