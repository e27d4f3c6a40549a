// L0. How a settings struct describes its fields, once, for everyone who needs the list: JSON,
// command-line options, Python keywords, range checks and the tests that turn every knob.
//
// A settings struct has   template <class Visitor> static constexpr void fields(Visitor&& visit)
// that calls visit(Field) for each field in order. A choice (an enum) has a ChoiceNames.
#pragma once

#include "nfopidn/foundation/status.hpp"
#include "nfopidn/foundation/traits.hpp"

namespace nfopidn {

constexpr double infinity = __builtin_inf();

struct Range {
  double low = -infinity;
  double high = infinity;
  bool low_open = false;   // low itself is refused
  bool high_open = false;  // high itself is refused

  template <class Number>
  constexpr bool contains(Number value) const {
    const double number = static_cast<double>(value);
    return (low_open ? number > low : number >= low) &&
           (high_open ? number < high : number <= high);
  }
};

constexpr Range any_number() { return {}; }
constexpr Range greater_than(double low) { return {low, infinity, true, false}; }
constexpr Range at_least(double low) { return {low, infinity, false, false}; }
constexpr Range between(double low, double high) { return {low, high, false, false}; }

template <class Owner, class Value>
struct Field {
  const char* name;
  Value Owner::*member;
  const char* unit;    // "" where there is none
  Range range;         // of every number in the field
  const char* text;    // one line, for people
  const char* option;  // the command line's short name for it, without the dashes; or nullptr
};

template <class Owner, class Value>
constexpr Field<Owner, Value> field(const char* name, Value Owner::*member, const char* unit,
                                    Range range, const char* text, const char* option = nullptr) {
  return {name, member, unit, range, text, option};
}

// The words of a choice, in the order of the enum's values.
template <class Choice>
struct ChoiceNames;  // static constexpr const char* names[]

// What is wrong with a settings struct: the first field that breaks its range.
struct Finding {
  Status status = Status::ok;
  const char* field = "";
  double value = 0;
  Range range = {};
};

namespace detail {

// The standard containers of host-side settings by what they offer: this layer knows none of them.
template <class Value, class = void>
constexpr bool has_elements = false;
template <class Value>
constexpr bool
    has_elements<Value, traits::void_t<decltype(traits::declval<const Value&>().begin())>> = true;
template <class Value, class = void>
constexpr bool may_be_absent = false;
template <class Value>
constexpr bool
    may_be_absent<Value, traits::void_t<decltype(traits::declval<const Value&>().has_value())>> =
        true;
template <class Value, class = void>
constexpr bool wraps_elements = false;
template <class Value>
constexpr bool
    wraps_elements<Value, traits::void_t<decltype(traits::declval<const Value&>().value.begin())>> =
        true;

struct IgnoresFields {
  template <class Field>
  constexpr void operator()(const Field& /*field*/) const {}
};
template <class Value, class = void>
constexpr bool has_fields = false;
template <class Value>
constexpr bool has_fields<Value, traits::void_t<decltype(Value::fields(IgnoresFields()))>> = true;

struct RangeCheck {
  Finding finding;

  template <class Number>
  constexpr void number(const char* name, const Range& range, Number value) {
    if (finding.status != Status::ok) return;
    const bool finite = value - value == Number(0);
    if (finite && range.contains(value)) return;
    finding = {finite ? Status::out_of_range : Status::not_finite, name, static_cast<double>(value),
               range};
  }
  template <class Value>
  constexpr void check(const char* name, const Range& range, const Value& value) {
    if constexpr (may_be_absent<Value>) {
      if (value.has_value()) check(name, range, *value);
    } else if constexpr (has_fields<Value>) {
      // Settings within settings have ranges of their own.
      Value::fields(
          [&](const auto& field) { check(field.name, field.range, value.*field.member); });
    } else if constexpr (wraps_elements<Value>) {
      check(name, range, value.value);
    } else if constexpr (traits::is_array<Value> || has_elements<Value>) {
      for (const auto& element : value) check(name, range, element);
    } else if constexpr (traits::is_class<Value> && traits::is_convertible<Value, int>) {
      if (!value.is_infinite()) number(name, range, static_cast<int>(value));
    } else if constexpr (traits::is_class<Value>) {
      check(name, range, value.matrix);
    } else if constexpr (traits::is_arithmetic<Value> && !traits::is_same<Value, bool>) {
      number(name, range, value);
    }
  }
};

}  // namespace detail

// Checks every number of a settings struct against its field's range.
template <class Settings>
constexpr Finding check_ranges(const Settings& settings) noexcept {
  detail::RangeCheck visitor;
  Settings::fields(
      [&](const auto& field) { visitor.check(field.name, field.range, settings.*field.member); });
  return visitor.finding;
}

}  // namespace nfopidn
