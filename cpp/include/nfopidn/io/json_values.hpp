// L4. How the values of settings stand in JSON: one reader and one writer a type.
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "nfopidn/control/controller_settings.hpp"
#include "nfopidn/foundation/host.hpp"
#include "nfopidn/io/nearest.hpp"
#include "nfopidn/io/outcome.hpp"
#include "nfopidn/simulation/scenario.hpp"

namespace nfopidn {

using Json = nlohmann::ordered_json;

namespace json {

// What a reader needs to know of the field it reads, and where its complaint goes.
struct Context {
  std::string path;
  Range range;
  const char* unit;
  Outcome* outcome;

  Context at(std::size_t index) const {
    return {path + "[" + std::to_string(index) + "]", range, unit, outcome};
  }
  void complain(const Outcome& complaint) const {
    if (outcome->status == Status::ok) *outcome = complaint;
  }
  // Of a text that is none of the words, the message names the word that was probably meant.
  void wrong_type(const Json& value, const std::string& rule,
                  const std::vector<std::string>& words = {}) const;
};

template <class Choice>
std::string choice_list() {
  std::string list = "one of";
  for (const char* name : ChoiceNames<Choice>::names) {
    list += (list.size() > 6 ? ", \"" : " \"") + std::string(name) + "\"";
  }
  return list;
}

NFOPIDN_HOST void read(const Json& value, const Context& context, double& result);

// Whether a whole number lies in a range whose ends are whole and belong to it.
NFOPIDN_HOST bool within(const Json& value, const Range& range);

// A whole number may be written 5 or 5.0.
template <class Integer, std::enable_if_t<std::is_integral_v<Integer>, int> = 0>
void read(const Json& value, const Context& context, Integer& result) {
  if constexpr (std::is_same_v<Integer, bool>) {
    if (!value.is_boolean()) return context.wrong_type(value, "true or false");
    result = value.get<bool>();
  } else {
    if (!value.is_number()) return context.wrong_type(value, "a whole number");
    const double number = value.get<double>();
    // Beyond 2^53 neighbours share a double: there the number itself is compared.
    const bool fits = value.is_number_float()
                          ? std::isfinite(number) && context.range.contains(number)
                          : within(value, context.range);
    if (!fits) {
      const std::string text =
          std::isfinite(number) && !value.is_number_float() ? value.dump() : number_text(number);
      Outcome complaint = refuse_number(context.path, number, context.range, context.unit);
      complaint.message.replace(context.path.size() + 4, number_text(number).size(), text);
      return context.complain(complaint);
    }
    if (number != std::floor(number)) return context.wrong_type(value, "a whole number");
    result = value.is_number_float() ? static_cast<Integer>(number) : value.get<Integer>();
  }
}

// JSON has no number for infinity.
NFOPIDN_HOST void read(const Json& value, const Context& context, Memory& result);

NFOPIDN_HOST void read(const Json& value, const Context& context, SampleTime<double>& result);

template <class Choice, std::enable_if_t<std::is_enum_v<Choice>, int> = 0>
void read(const Json& value, const Context& context, Choice& result) {
  if (value.is_string()) {
    unsigned char index = 0;
    for (const char* name : ChoiceNames<Choice>::names) {
      if (value.get_ref<const std::string&>() == name) {
        result = static_cast<Choice>(index);
        return;
      }
      ++index;
    }
  }
  const auto& names = ChoiceNames<Choice>::names;
  context.wrong_type(value, choice_list<Choice>(), {std::begin(names), std::end(names)});
}

template <class Element, std::size_t count>
void read_elements(const Json& value, const Context& context, Element (&result)[count]) {
  if (!value.is_array() || value.size() != count) {
    return context.wrong_type(value, "a list of " + std::to_string(count));
  }
  for (std::size_t i = 0; i < count; ++i) read(value[i], context.at(i), result[i]);
}

template <std::size_t rows, std::size_t columns>
void read(const Json& value, const Context& context, double (&result)[rows][columns]) {
  if (!value.is_array() || value.size() != rows) {
    return context.wrong_type(
        value, std::to_string(rows) + " lists of " + std::to_string(columns) + " numbers");
  }
  for (std::size_t i = 0; i < rows; ++i) read_elements(value[i], context.at(i), result[i]);
}

// One number for all channels, or one each.
template <std::size_t count>
void read(const Json& value, const Context& context, double (&result)[count]) {
  if (value.is_array()) return read_elements(value, context, result);
  double number = 0;
  read(value, context, number);
  if (context.outcome->status == Status::ok) std::fill(result, result + count, number);
}

template <std::size_t count>
void read(const Json& value, const Context& context, std::array<double, count>& result) {
  if (!value.is_array() || value.size() != count) {
    return context.wrong_type(value, "a list of " + std::to_string(count) + " numbers");
  }
  for (std::size_t i = 0; i < count; ++i) read(value[i], context.at(i), result[i]);
}

NFOPIDN_HOST void read(const Json& value, const Context& context, Allocation<double>& result);

NFOPIDN_HOST void read(const Json& value, const Context& context, std::optional<double>& result);

template <std::size_t count>
void read(const Json& value, const Context& context,
          std::optional<std::array<double, count>>& result) {
  if (value.is_null()) {
    result.reset();
    return;
  }
  std::array<double, count> numbers{};
  read(value, context, numbers);
  if (context.outcome->status == Status::ok) result = numbers;
}

NFOPIDN_HOST void read(const Json& value, const Context& context, InitialVelocity& result);

NFOPIDN_HOST void read(const Json& value, const Context& context,
                       std::vector<std::array<double, 2>>& result);

template <class Number, std::enable_if_t<std::is_arithmetic_v<Number>, int> = 0>
Json write(Number value) {
  return value;
}
NFOPIDN_HOST Json write(const Memory& value);
NFOPIDN_HOST Json write(const SampleTime<double>& value);
template <class Choice, std::enable_if_t<std::is_enum_v<Choice>, int> = 0>
Json write(Choice value) {
  return ChoiceNames<Choice>::names[static_cast<int>(value)];
}
template <std::size_t rows, std::size_t columns>
Json write(const double (&value)[rows][columns]) {
  Json list = Json::array();
  for (const auto& row : value) list.push_back(Json(row));
  return list;
}
template <std::size_t count>
Json write(const double (&value)[count]) {
  if (std::all_of(value, value + count, [&](double v) { return v == value[0]; })) return value[0];
  return Json(value);
}
template <std::size_t count>
Json write(const std::array<double, count>& value) {
  return Json(value);
}
NFOPIDN_HOST Json write(const Allocation<double>& value);
NFOPIDN_HOST Json write(const std::optional<double>& value);
template <std::size_t count>
Json write(const std::optional<std::array<double, count>>& value) {
  return value ? Json(*value) : Json(nullptr);
}
NFOPIDN_HOST Json write(const InitialVelocity& value);
NFOPIDN_HOST Json write(const std::vector<std::array<double, 2>>& value);

}  // namespace json

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_IO

namespace nfopidn::json {

NFOPIDN_HOST void read(const Json& value, const Context& context, double& result) {
  if (!value.is_number()) return context.wrong_type(value, "a number");
  const double number = value.get<double>();
  if (!std::isfinite(number) || !context.range.contains(number)) {
    return context.complain(refuse_number(context.path, number, context.range, context.unit));
  }
  result = number;
}

NFOPIDN_HOST void read(const Json& value, const Context& context, Memory& result) {
  if (value == "inf") {
    result = infinite_memory;
  } else {
    read(value, {context.path, context.range, "samples, or \"inf\"", context.outcome},
         result.samples);
  }
}

NFOPIDN_HOST void read(const Json& value, const Context& context, SampleTime<double>& result) {
  if (value.is_null()) {
    result = {};
  } else {
    read(value, context, result.seconds);
  }
}

NFOPIDN_HOST void read(const Json& value, const Context& context, Allocation<double>& result) {
  if (value == "paper") {
    result = Allocation<double>::paper();
  } else if (value == "decoupled") {
    result = Allocation<double>::decoupled();
  } else if (value.is_array()) {
    read(value, context, result.matrix);
  } else {
    context.wrong_type(value, "\"paper\", \"decoupled\" or 2 lists of 3 numbers",
                       {"paper", "decoupled"});
  }
}

NFOPIDN_HOST void read(const Json& value, const Context& context, std::optional<double>& result) {
  if (value.is_null()) {
    result.reset();
    return;
  }
  double number = 0;
  read(value, context, number);
  if (context.outcome->status == Status::ok) result = number;
}

NFOPIDN_HOST void read(const Json& value, const Context& context, InitialVelocity& result) {
  if (value == "reference") {
    result = {true, {0, 0}};
  } else if (value.is_array()) {
    result.reference = false;
    read(value, context, result.value);
  } else {
    context.wrong_type(value, "a list of 2 numbers or \"reference\"");
  }
}

NFOPIDN_HOST void read(const Json& value, const Context& context,
                       std::vector<std::array<double, 2>>& result) {
  if (!value.is_array() || value.empty()) {
    return context.wrong_type(value, "a list of 2 numbers, or one such list a sample");
  }
  const bool by_sample = value[0].is_array();
  std::vector<std::array<double, 2>> pairs(by_sample ? value.size() : 1);
  if (!by_sample) read(value, context, pairs[0]);
  for (std::size_t i = 0; by_sample && i < pairs.size(); ++i) {
    read(value[i], context.at(i), pairs[i]);
  }
  if (context.outcome->status == Status::ok) result = std::move(pairs);
}

NFOPIDN_HOST Json write(const Memory& value) {
  return value.is_infinite() ? Json("inf") : Json(value.samples);
}

NFOPIDN_HOST Json write(const SampleTime<double>& value) {
  return value.has_value() ? Json(*value) : Json(nullptr);
}

NFOPIDN_HOST Json write(const Allocation<double>& value) {
  switch (value.kind()) {
    case AllocationKind::paper:
      return "paper";
    case AllocationKind::decoupled:
      return "decoupled";
    case AllocationKind::any:
      break;
  }
  return write(value.matrix);
}

NFOPIDN_HOST Json write(const std::optional<double>& value) {
  return value ? Json(*value) : Json(nullptr);
}

NFOPIDN_HOST Json write(const InitialVelocity& value) {
  return value.reference ? Json("reference") : Json(value.value);
}

NFOPIDN_HOST Json write(const std::vector<std::array<double, 2>>& value) {
  return value.size() == 1 ? Json(value[0]) : Json(value);
}

NFOPIDN_HOST bool within(const Json& value, const Range& range) {
  if (value.is_number_unsigned()) {
    return range.high >= 0 &&
           value.get<std::uint64_t>() <= static_cast<std::uint64_t>(range.high) &&
           (range.low <= 0 || value.get<std::uint64_t>() >= static_cast<std::uint64_t>(range.low));
  }
  const auto number = value.get<std::int64_t>();
  return number >= static_cast<std::int64_t>(range.low) &&
         number <= static_cast<std::int64_t>(range.high);
}

NFOPIDN_HOST void Context::wrong_type(const Json& value, const std::string& rule,
                                      const std::vector<std::string>& words) const {
  std::string text = value.dump(-1, ' ', true, Json::error_handler_t::replace);
  if (text.size() > 40) text = text.substr(0, 37) + "...";
  if (value.is_string()) text += suggestion(value.get_ref<const std::string&>(), words);
  complain(refuse(Status::not_a_choice, path, text, rule));
}

}  // namespace nfopidn::json

#endif  // NFOPIDN_DEFINES_IO
