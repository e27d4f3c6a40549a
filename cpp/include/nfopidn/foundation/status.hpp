// L0. What a function of the core reports instead of throwing.
#pragma once

namespace nfopidn {

enum class Status : unsigned char {
  ok,
  not_finite,    // a number is NaN or infinite
  out_of_range,  // a number lies outside its documented range
  wrong_size,    // an array has the wrong length, or a trajectory too few samples
  not_a_choice,  // a word is none of the choices
  inconsistent,  // two settings contradict each other
  interrupted,   // asked to stop before the end
};

constexpr const char* status_to_string(Status status) noexcept {
  switch (status) {
    case Status::ok:
      return "ok";
    case Status::not_finite:
      return "not finite";
    case Status::out_of_range:
      return "out of range";
    case Status::wrong_size:
      return "wrong size";
    case Status::not_a_choice:
      return "not a choice";
    case Status::inconsistent:
      return "inconsistent";
    case Status::interrupted:
      return "interrupted";
  }
  return "unknown";
}

}  // namespace nfopidn
