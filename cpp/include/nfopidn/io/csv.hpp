// L4. Comma-separated tables: trajectories in, run tables out.
#pragma once

#include <string_view>

#include "nfopidn/io/files.hpp"

namespace nfopidn {

inline std::string run_table_csv(const RunTable& table) {
  std::string text;
  text.reserve(static_cast<std::size_t>(table.size() + column_count) * 20);
  for (int column = 0; column < column_count; ++column) {
    text += column_names[column];
    text += column + 1 < column_count ? ',' : '\n';
  }
  for (Eigen::Index row = 0; row < table.rows(); ++row) {
    for (int column = 0; column < column_count; ++column) {
      text += number_text(table(row, column));
      text += column + 1 < column_count ? ',' : '\n';
    }
  }
  return text;
}

namespace csv {

inline std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> cells;
  for (;;) {
    const std::size_t comma = line.find(',');
    std::string_view cell = line.substr(0, comma);
    while (!cell.empty() && (cell.front() == ' ' || cell.front() == '\t')) cell.remove_prefix(1);
    while (!cell.empty() && (cell.back() == ' ' || cell.back() == '\t')) cell.remove_suffix(1);
    cells.push_back(cell);
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

inline bool parse_number(std::string_view cell, double& value) {
  if (!cell.empty() && cell.front() == '+') cell.remove_prefix(1);
  const char* end = cell.data() + cell.size();
  const auto result = std::from_chars(cell.data(), end, value);
  return result.ec == std::errc() && result.ptr == end && std::isfinite(value);
}

struct Table {
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;
  std::vector<std::size_t> lines;  // of each row in the file
};

inline Outcome fault(const std::string& path, std::size_t line, const std::string& message) {
  return {Status::wrong_size, path + ":" + std::to_string(line) + ": " + message};
}

inline Outcome read_header(const std::string& path, std::size_t line, std::string_view text,
                           Table& table) {
  for (const std::string_view cell : split(text)) {
    double number = 0;
    if (cell.empty() || parse_number(cell, number)) {
      return fault(path, line, "no header; the first line names the columns, such as t,x,y");
    }
    for (const std::string& name : table.names) {
      if (name == cell) return fault(path, line, "column " + name + " stands twice");
    }
    table.names.emplace_back(cell);
  }
  table.columns.resize(table.names.size());
  return {};
}

inline Outcome read_row(const std::string& path, std::size_t line, std::string_view text,
                        Table& table) {
  const std::vector<std::string_view> cells = split(text);
  if (cells.size() != table.names.size()) {
    return fault(path, line,
                 std::to_string(cells.size()) + " cells; the header has " +
                     std::to_string(table.names.size()));
  }
  for (std::size_t i = 0; i < cells.size(); ++i) {
    double number = 0;
    if (!parse_number(cells[i], number)) {
      return fault(path, line,
                   "\"" + std::string(cells[i].substr(0, 40)) + "\" in column " + table.names[i] +
                       " is no finite number");
    }
    table.columns[i].push_back(number);
  }
  table.lines.push_back(line);
  return {};
}

// A header line and rows of numbers. Empty lines are passed over.
inline Outcome parse(const std::string& path, std::string_view text, Table& table) {
  constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
  if (text.substr(0, 3) == byte_order_mark) text.remove_prefix(3);
  for (std::size_t line = 1; !text.empty(); ++line) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view row = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (!row.empty() && row.back() == '\r') row.remove_suffix(1);
    if (row.find_first_not_of(" \t") == std::string_view::npos) continue;
    Outcome outcome = table.names.empty() ? read_header(path, line, row, table)
                                          : read_row(path, line, row, table);
    if (!outcome) return outcome;
  }
  if (table.names.empty()) return fault(path, 1, "no header; the file is empty");
  return {};
}

inline const std::vector<double>* find(const Table& table, const char* name) {
  for (std::size_t i = 0; i < table.names.size(); ++i) {
    if (table.names[i] == name) return &table.columns[i];
  }
  return nullptr;
}

}  // namespace csv

// A trajectory from a table with the columns x and y [m], and t [s] in equal steps or, without t,
// settings.dt apart. Uses dt, heading and laps of the settings. `path` stands in messages.
inline Outcome trajectory_from_table(const std::string& path, const csv::Table& table,
                                     TrajectorySettings settings, Trajectory& result) {
  const std::vector<double>* columns[] = {csv::find(table, "x"), csv::find(table, "y")};
  if (columns[0] == nullptr || columns[1] == nullptr) {
    return csv::fault(path, 1, "no columns x and y in the header");
  }
  const std::size_t rows = table.lines.size();
  if (rows < minimum_samples) {
    return {Status::wrong_size, path + ": " + std::to_string(rows) +
                                    " samples; a trajectory needs at least " +
                                    std::to_string(minimum_samples)};
  }
  if (const std::vector<double>* t = csv::find(table, "t"); t != nullptr) {
    const double first = (*t)[1] - (*t)[0];
    for (std::size_t k = 1; k < rows; ++k) {
      const double step = (*t)[k] - (*t)[k - 1];
      if (!(step > 0)) return csv::fault(path, table.lines[k], "t does not rise");
      if (!(std::fabs(step - first) <= 1e-3 * first)) {
        return csv::fault(path, table.lines[k], "t does not rise in equal steps");
      }
    }
    settings.dt = (t->back() - t->front()) / static_cast<double>(rows - 1);
    Outcome outcome = read_settings({{"dt", settings.dt}}, "", settings);
    if (!outcome) {
      outcome.message = path + ": the step of t, " + outcome.message;
      return outcome;
    }
  }
  settings.name = Curve::samples;
  const auto array = [&](const std::vector<double>& column) {
    return Eigen::ArrayXd(
        Eigen::Map<const Eigen::ArrayXd>(column.data(), static_cast<Eigen::Index>(rows)));
  };
  Outcome outcome = build_trajectory(settings, array(*columns[0]), array(*columns[1]), "", result);
  if (!outcome) outcome.message = path + ": " + outcome.message;
  return outcome;
}

inline Outcome load_trajectory(const std::string& path, const TrajectorySettings& settings,
                               Trajectory& result) {
  std::string text;
  if (Outcome outcome = read_file(path, text); !outcome) return outcome;
  csv::Table table;
  if (Outcome outcome = csv::parse(path, text, table); !outcome) return outcome;
  return trajectory_from_table(path, table, settings, result);
}

}  // namespace nfopidn
