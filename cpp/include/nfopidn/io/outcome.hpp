// L4. What reading and writing reports: a Status, and one line that names the place and the rule.
#pragma once

#include <charconv>
#include <cmath>
#include <string>

#include "nfopidn/schema.hpp"

namespace nfopidn {

struct Outcome {
  Status status = Status::ok;
  std::string message = {};

  explicit operator bool() const { return status == Status::ok; }
};

// The shortest decimal that reads back as the same number.
inline std::string number_text(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value);
  return {text, end.ptr};
}

inline std::string range_text(const Range& range) {
  const bool low = std::isfinite(range.low);
  const bool high = std::isfinite(range.high);
  if (low && high) {
    return std::string(range.low_open ? "in (" : "in [") + number_text(range.low) + ", " +
           number_text(range.high) + (range.high_open ? ")" : "]");
  }
  if (low) return (range.low_open ? "greater than " : "at least ") + number_text(range.low);
  if (high) return (range.high_open ? "less than " : "at most ") + number_text(range.high);
  return "finite";
}

// "robot.mass is -1; must be in [1e-06, 1e+06] kg"
inline Outcome refuse(Status status, const std::string& name, const std::string& value,
                      const std::string& rule) {
  return {status, name + " is " + value + "; must be " + rule};
}

inline Outcome refuse_number(const std::string& name, double value, const Range& range,
                             const char* unit = "") {
  const std::string rule = range_text(range) + (*unit == '\0' ? "" : std::string(" ") + unit);
  return refuse(std::isfinite(value) ? Status::out_of_range : Status::not_finite, name,
                number_text(value), rule);
}

}  // namespace nfopidn
