// L4. What the columns of a table mean: by their names and units, and by the steps of its times.
#pragma once

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/io/table.hpp"

namespace nfopidn::csv {

// What a column's name says: a quantity and the factor to its SI unit.
struct Meaning {
  std::string quantity;  // "t", "x", "y", "theta", "reverse", or as the file has it
  double factor = 1;
  int digits = 0;  // decimals that the factor adds
};

namespace detail {

struct Unit {
  const char* name;
  double factor;
  int digits;
};
inline constexpr Unit time_units[] = {
    {"s", 1, 0},     {"sec", 1, 0},   {"secs", 1, 0},  {"seconds", 1, 0},
    {"ms", 1e-3, 3}, {"us", 1e-6, 6}, {"ns", 1e-9, 9},
};
inline constexpr Unit length_units[] = {{"m", 1, 0}, {"cm", 1e-2, 2}, {"mm", 1e-3, 3}};
inline constexpr Unit angle_units[] = {
    {"rad", 1, 0}, {"deg", math<double>::pi / 180, 2}, {"degrees", math<double>::pi / 180, 2}};

inline constexpr const char* time_names[] = {"t",     "time", "timestamp", "time_stamp",
                                             "stamp", "sec",  "secs",      "seconds"};
inline constexpr const char* x_names[] = {"x", "pos_x", "position_x", "x_pos", "tx"};
inline constexpr const char* y_names[] = {"y", "pos_y", "position_y", "y_pos", "ty"};
inline constexpr const char* theta_names[] = {"theta", "yaw"};
inline constexpr const char* reverse_names[] = {"reverse"};
inline constexpr Unit force_units[] = {{"n", 1, 0}};
inline constexpr Unit moment_units[] = {{"nm", 1, 0}, {"n m", 1, 0}, {"n*m", 1, 0}};
inline constexpr const char* force_names[] = {"force"};
inline constexpr const char* moment_names[] = {"moment"};
inline constexpr Unit no_units[] = {{"", 1, 0}};

// "X [m]", "x (m)" and "x_m" are x in metres.
template <std::size_t units>
bool has_unit(std::string_view rest, const Unit (&known)[units], Meaning& meaning) {
  const auto inside = [&](char open, char close) {
    return rest.size() > 2 && rest.front() == open && rest.back() == close;
  };
  if (rest.empty()) return true;
  const bool bracketed = inside('[', ']') || inside('(', ')');
  if (!bracketed && rest.front() != '_') return false;
  rest = trimmed(bracketed ? rest.substr(1, rest.size() - 2) : rest.substr(1));
  for (const Unit& unit : known) {
    if (rest != unit.name) continue;
    meaning.factor = unit.factor;
    meaning.digits = unit.digits;
    return true;
  }
  return false;
}

template <std::size_t names, std::size_t units>
bool is_called(std::string_view name, const char* const (&known)[names], const Unit (&unit)[units],
               const char* quantity, Meaning& meaning) {
  for (const std::string_view word : known) {
    if (name.substr(0, word.size()) != word) continue;
    if (!has_unit(trimmed(name.substr(word.size())), unit, meaning)) continue;
    meaning.quantity = quantity;
    return true;
  }
  return false;
}

}  // namespace detail

NFOPIDN_HOST Meaning meaning_of(const std::string& name);

constexpr std::size_t no_column = static_cast<std::size_t>(-1);

// The column of a quantity. One that is called exactly so goes before others that mean it; of two
// others neither is taken.
NFOPIDN_HOST Outcome find(const std::string& path, const Table& table, const std::string& quantity,
                          std::size_t& result);

// Reads the column of a quantity in SI units; one that is not there leaves `result` empty.
NFOPIDN_HOST Outcome read(const std::string& path, const Table& table, const std::string& quantity,
                          Column& result);

// What is made of each column of a table, in a line for people.
NFOPIDN_HOST std::string use_text(const std::string& path, const Table& table,
                                  const std::vector<std::pair<std::string, std::string>>& used);

// A stamp's distance [s] from where equal steps put it that is no fault: what its text leaves open
// (but less than a missing sample makes, half a step), what a double does, a thousandth of a step.
NFOPIDN_HOST double stamp_tolerance(const Column& times, double dt);

// Whether the stamps are equal steps: of `wanted` [s], or where that is 0 of the mean step, which
// goes to `dt`.
NFOPIDN_HOST Outcome check_times(const std::string& path, const Table& table, const Column& times,
                                 double wanted, double& dt);

}  // namespace nfopidn::csv

#ifdef NFOPIDN_DEFINES_IO

namespace nfopidn::csv {

NFOPIDN_HOST Meaning meaning_of(const std::string& name) {
  std::string lower = name;
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  Meaning meaning;
  meaning.quantity = name;
  using namespace detail;
  if (is_called(lower, time_names, time_units, "t", meaning) ||
      is_called(lower, x_names, length_units, "x", meaning) ||
      is_called(lower, y_names, length_units, "y", meaning) ||
      is_called(lower, theta_names, angle_units, "theta", meaning) ||
      is_called(lower, reverse_names, no_units, "reverse", meaning) ||
      is_called(lower, force_names, force_units, "force", meaning) ||
      is_called(lower, moment_names, moment_units, "moment", meaning)) {
    return meaning;
  }
  return {name, 1, 0};
}

NFOPIDN_HOST Outcome find(const std::string& path, const Table& table, const std::string& quantity,
                          std::size_t& result) {
  result = no_column;
  std::vector<std::size_t> exact, others;
  for (std::size_t i = 0; i < table.names.size(); ++i) {
    if (table.names[i] == quantity) {
      exact.push_back(i);
    } else if (meaning_of(table.names[i]).quantity == quantity) {
      others.push_back(i);
    }
  }
  const std::vector<std::size_t>& found = exact.empty() ? others : exact;
  if (found.size() > 1) {
    return fault(path, table.header_line,
                 "columns " + table.names[found[0]] + " and " + table.names[found[1]] +
                     " both stand for " + quantity + "; rename one");
  }
  if (!found.empty()) result = found[0];
  return {};
}

NFOPIDN_HOST Outcome read(const std::string& path, const Table& table, const std::string& quantity,
                          Column& result) {
  std::size_t index = no_column;
  Outcome outcome = find(path, table, quantity, index);
  if (!outcome || index == no_column) return outcome;
  outcome = read_column(path, table, index, result);
  const Meaning meaning = meaning_of(result.name);
  if (meaning.factor != 1) {
    for (double& value : result.values) value *= meaning.factor;
  }
  result.decimals += meaning.digits;
  return outcome;
}

NFOPIDN_HOST std::string use_text(const std::string& path, const Table& table,
                                  const std::vector<std::pair<std::string, std::string>>& used) {
  std::string text = path + ": ";
  std::vector<bool> taken(table.names.size(), false);
  for (std::size_t i = 0; i < used.size(); ++i) {
    text += (i > 0 ? ", " : "") + used[i].first + " from column " + used[i].second;
    const auto place = std::find(table.names.begin(), table.names.end(), used[i].second);
    if (place != table.names.end()) {
      taken[static_cast<std::size_t>(place - table.names.begin())] = true;
    }
  }
  std::string others;
  for (std::size_t i = 0; i < table.names.size(); ++i) {
    if (taken[i]) continue;
    others += (others.empty() ? "; not used: " : ", ") +
              (table.names[i].empty() ? "(no name)" : table.names[i]);
  }
  return text + others;
}

NFOPIDN_HOST double stamp_tolerance(const Column& times, double dt) {
  const double largest = std::max(std::fabs(times.values.front()), std::fabs(times.values.back()));
  return std::min(std::pow(10.0, -times.decimals), 0.3 * dt) +
         4 * largest * std::numeric_limits<double>::epsilon() + 1e-3 * dt;
}

NFOPIDN_HOST Outcome check_times(const std::string& path, const Table& table, const Column& times,
                                 double wanted, double& dt) {
  const std::vector<double>& t = times.values;
  const std::size_t rows = t.size();
  for (std::size_t k = 1; k < rows; ++k) {
    if (!(t[k] > t[k - 1])) {
      return fault(path, table.lines[k], "column " + times.name + " does not rise");
    }
  }
  const double mean = (t.back() - t.front()) / static_cast<double>(rows - 1);
  dt = wanted > 0 ? wanted : mean;
  const double tolerance = stamp_tolerance(times, dt);
  for (std::size_t k = 1; k < rows; ++k) {
    const double off = t[k] - (t.front() + static_cast<double>(k) * dt);
    if (std::fabs(off) <= tolerance) continue;
    const std::string which =
        wanted > 0 ? "the dt given, " + number_text(wanted) : number_text(mean);
    std::string reason = "column " + times.name;
    reason += " does not rise in equal steps of " + which;
    reason += " s: this stamp is " + number_text(std::fabs(off)) + " s off";
    if (wanted > 0) reason += "; their mean step is " + number_text(mean) + " s";
    return fault(path, table.lines[k], reason);
  }
  return {};
}

}  // namespace nfopidn::csv

#endif  // NFOPIDN_DEFINES_IO
