// L4. Settings from words, as a command line has them: each word becomes the JSON that a file
// would hold, and passes through the same reader.
#pragma once

#include <map>

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/io/csv.hpp"

namespace nfopidn {

// The command line's names of a field, without the dashes: that of its key in JSON, and its short
// one if it has one. A field called `name` tells which kind its object is, so that its option has
// the object's name.
template <class Owner, class Value>
std::vector<std::string> option_names(const Field<Owner, Value>& field, const std::string& object) {
  std::string name = field.name == std::string_view("name") ? object : field.name;
  std::replace(name.begin(), name.end(), '_', '-');
  if (field.option == nullptr) return {name};
  return {name, field.option};
}

namespace words {

NFOPIDN_HOST Json number_or_text(std::string_view word);

NFOPIDN_HOST Json list(std::string_view text);

NFOPIDN_HOST Json rows(std::string_view text, std::size_t columns);

template <class Value>
struct Reading {
  static Json read(const std::string& text) { return number_or_text(text); }
};
template <std::size_t count>
struct Reading<double[count]> {
  static Json read(const std::string& text) {
    const Json numbers = list(text);
    return numbers.size() == 1 ? numbers[0] : numbers;
  }
};
template <std::size_t count>
struct Reading<std::array<double, count>> {
  static Json read(const std::string& text) { return list(text); }
};
template <std::size_t count>
struct Reading<std::optional<std::array<double, count>>> {
  static Json read(const std::string& text) { return list(text); }
};
template <std::size_t row_count, std::size_t columns>
using Matrix = double[row_count][columns];
template <std::size_t row_count, std::size_t columns>
struct Reading<Matrix<row_count, columns>> {
  static Json read(const std::string& text) { return rows(text, columns); }
};
// The numbers of settings within settings, a robot or a motor, in the order of their fields.
template <class Settings>
Json settings_of_numbers(const std::string& text) {
  Json numbers = list(text);
  Json settings = Json::object();
  std::size_t place = 0;
  Settings::fields([&](const auto& field) {
    if (place < numbers.size()) settings[field.name] = numbers[place];
    ++place;
  });
  if (numbers.size() > place) return numbers;
  return settings;
}
template <>
struct Reading<std::optional<Robot<double>>> {
  static Json read(const std::string& text) { return settings_of_numbers<Robot<double>>(text); }
};
template <>
struct Reading<std::optional<Motor<double>>> {
  static Json read(const std::string& text) { return settings_of_numbers<Motor<double>>(text); }
};
template <>
struct Reading<Memory> {
  static Json read(const std::string& text) {
    return text == "inf" ? Json(text) : number_or_text(text);
  }
};
template <>
struct Reading<std::optional<double>> {
  static Json read(const std::string& text) { return number_or_text(text); }
};
template <>
struct Reading<SampleTime<double>> {
  static Json read(const std::string& text) { return number_or_text(text); }
};
template <>
struct Reading<Allocation<double>> {
  static Json read(const std::string& text) {
    return text.find(',') == std::string::npos ? Json(text) : rows(text, channel_count);
  }
};
template <>
struct Reading<InitialVelocity> {
  static Json read(const std::string& text) {
    return text == "reference" ? Json(text) : list(text);
  }
};
template <>
struct Reading<std::vector<std::array<double, 2>>> {
  static Json read(const std::string& text) { return list(text); }
};

// The word for null, as the field's text tells it; "" of a field that has none.
inline std::string word_for_null(const std::string& text) {
  constexpr std::string_view before = "(in words: ";
  const std::size_t found = text.find(before);
  if (found == std::string::npos) return "";
  const std::size_t begin = found + before.size();
  return text.substr(begin, text.find(')', begin) - begin);
}

}  // namespace words

// The words given for the fields of one settings struct, by field name.
using Words = std::map<std::string, std::string>;

// The JSON object that the words stand for.
template <class Settings>
Json words_to_json(const Words& given) {
  Json object = Json::object();
  Settings::fields([&](const auto& field) {
    const auto found = given.find(field.name);
    if (found == given.end()) return;
    using Value = std::remove_reference_t<decltype(std::declval<Settings&>().*field.member)>;
    if constexpr (std::is_same_v<Value, bool>) {
      object[field.name] = found->second == "true";
    } else if (!found->second.empty() && found->second == words::word_for_null(field.text)) {
      object[field.name] = nullptr;
    } else {
      object[field.name] = words::Reading<Value>::read(found->second);
    }
  });
  return object;
}

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_IO

namespace nfopidn::words {

NFOPIDN_HOST Json number_or_text(std::string_view word) {
  double number = 0;
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  // Whole numbers beyond 2^53 are kept as they are: a double would round them.
  std::int64_t whole = 0;
  const auto digits = std::from_chars(word.data(), word.data() + word.size(), whole);
  const bool is_whole = digits.ec == std::errc() && digits.ptr == word.data() + word.size();
  if (is_whole && std::abs(whole) > (std::int64_t{1} << 53)) return whole;
  const auto result = std::from_chars(word.data(), word.data() + word.size(), number);
  if (result.ec != std::errc() || result.ptr != word.data() + word.size()) return std::string(word);
  return number;
}

NFOPIDN_HOST Json list(std::string_view text) {
  Json numbers = Json::array();
  for (const std::string_view word : csv::split(text)) numbers.push_back(number_or_text(word));
  return numbers;
}

NFOPIDN_HOST Json rows(std::string_view text, std::size_t columns) {
  const Json flat = list(text);
  Json result = Json::array();
  for (std::size_t i = 0; i < flat.size(); ++i) {
    if (i % columns == 0) result.push_back(Json::array());
    result.back().push_back(flat[i]);
  }
  return result;
}

}  // namespace nfopidn::words

#endif  // NFOPIDN_DEFINES_IO
