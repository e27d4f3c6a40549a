// L4. What reading and writing reports: a Status, and one line that names the place and the rule.
#pragma once

#include <charconv>
#include <cmath>
#include <string>

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/foundation/schema.hpp"

namespace nfopidn {

struct Outcome {
  Status status = Status::ok;
  std::string message = {};

  explicit operator bool() const { return status == Status::ok; }
};

// The shortest decimal that reads back as the same number.
NFOPIDN_HOST std::string number_text(double value);

// Text for one line of a terminal: control characters and bytes beyond ASCII that are no UTF-8
// become \xNN.
NFOPIDN_HOST std::string printable(const std::string& text);

NFOPIDN_HOST std::string range_text(const Range& range);

// "robot.mass is -1; must be in [1e-06, 1e+06] kg"
NFOPIDN_HOST Outcome refuse(Status status, const std::string& name, const std::string& value,
                            const std::string& rule);

NFOPIDN_HOST Outcome refuse_number(const std::string& name, double value, const Range& range,
                                   const char* unit = "");

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_IO

namespace nfopidn {

NFOPIDN_HOST std::string number_text(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value);
  return {text, end.ptr};
}

NFOPIDN_HOST std::string printable(const std::string& text) {
  std::string result;
  for (std::size_t i = 0; i < text.size();) {
    const auto byte = static_cast<unsigned char>(text[i]);
    std::size_t length =
        byte < 0x80 ? 1 : (byte >> 5 == 6 ? 2 : (byte >> 4 == 14 ? 3 : (byte >> 3 == 30 ? 4 : 0)));
    for (std::size_t k = 1; k < length; ++k) {
      const bool goes_on =
          i + k < text.size() && (static_cast<unsigned char>(text[i + k]) >> 6) == 2;
      if (!goes_on) length = 0;
    }
    if (length == 0 || byte < 0x20 || byte == 0x7F || byte == 0xC0 || byte == 0xC1) {
      constexpr const char* digits = "0123456789abcdef";
      result += "\\x";
      result += digits[byte >> 4];
      result += digits[byte & 15];
      ++i;
    } else {
      result += text.substr(i, length);
      i += length;
    }
  }
  return result;
}

NFOPIDN_HOST std::string range_text(const Range& range) {
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

NFOPIDN_HOST Outcome refuse(Status status, const std::string& name, const std::string& value,
                            const std::string& rule) {
  return {status, name + " is " + value + "; must be " + rule};
}

NFOPIDN_HOST Outcome refuse_number(const std::string& name, double value, const Range& range,
                                   const char* unit) {
  // Where the range alone would let infinity pass, say that it does not.
  const bool open = !std::isfinite(range.low) || !std::isfinite(range.high);
  const bool plain = !std::isfinite(range.low) && !std::isfinite(range.high);
  const std::string finite = !std::isfinite(value) && open && !plain ? "finite and " : "";
  const std::string rule =
      finite + range_text(range) + (*unit == '\0' ? "" : std::string(" ") + unit);
  return refuse(std::isfinite(value) ? Status::out_of_range : Status::not_finite, name,
                number_text(value), rule);
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_IO
