// L4. Tables of text as people have them: any common separator, names quoted or in a comment, units
// in the names. Only the columns that are asked for need to hold numbers.
#pragma once

#include <string>
#include <string_view>
#include <type_traits>

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/io/files.hpp"

namespace nfopidn::csv {

NFOPIDN_HOST std::string_view trimmed(std::string_view cell);

// What stands between cells; ' ' for any number of blanks.
NFOPIDN_HOST char find_separator(std::string_view line);

// Takes the next cell off a line, without blanks and quotes around it. False when there is none.
NFOPIDN_HOST bool next_cell(std::string_view& rest, bool& ended, char separator,
                            std::string_view& cell);

NFOPIDN_HOST std::vector<std::string_view> split(std::string_view line, char separator = ',');

NFOPIDN_HOST bool parse_number(std::string_view cell, double& value);

// A header and rows of cells. It looks into the text that it was parsed from.
struct Table {
  char separator = ',';
  std::vector<std::string> names;  // "" where the header's cell is empty
  std::size_t header_line = 1;
  std::vector<std::string_view> rows;
  std::vector<std::size_t> lines;  // of each row in the file
};

NFOPIDN_HOST Outcome fault(const std::string& path, std::size_t line, const std::string& message);

// "columns a, b and 3 more"; names end where a message would.
NFOPIDN_HOST std::string columns_text(const Table& table);

namespace detail {

struct Lines {
  std::string_view text;
  std::size_t number = 0;

  // Lines end as on Unix, Windows or an old Mac. A comment mark is left to the caller.
  bool next(std::string_view& line) {
    if (text.empty()) return false;
    ++number;
    const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
    line = text.substr(0, end);
    const bool two = end + 1 < text.size() && text[end] == '\r' && text[end + 1] == '\n';
    text.remove_prefix(std::min(end + (two ? 2 : 1), text.size()));
    return true;
  }
};

inline bool is_comment(std::string_view line) { return line.front() == '#' || line.front() == '%'; }

inline std::string_view without_mark(std::string_view line) {
  const std::size_t first = line.find_first_not_of("#% \t");
  return first == std::string_view::npos ? std::string_view() : line.substr(first);
}

inline bool holds_numbers_alone(std::string_view line, char separator) {
  double number = 0;
  for (const std::string_view cell : split(line, separator)) {
    if (!cell.empty() && !parse_number(cell, number)) return false;
  }
  return true;
}

inline void take_header(std::string_view text, std::size_t line, Table& table) {
  table.separator = find_separator(text);
  table.header_line = line;
  for (const std::string_view cell : split(text, table.separator)) table.names.emplace_back(cell);
}

inline Outcome add_row(const std::string& path, std::size_t line, std::string_view text,
                       Table& table) {
  std::string_view rest = text, cell;
  std::size_t count = 0, filled = 0;
  bool ended = false;
  while (next_cell(rest, ended, table.separator, cell)) {
    ++count;
    if (!cell.empty()) filled = count;
  }
  // A separator at the end of each row is common, and begins no cell.
  const std::size_t wanted = table.names.size();
  if (count < wanted || filled > wanted) {
    return fault(path, line,
                 std::to_string(count) + " cells; the header has " + std::to_string(wanted) + ": " +
                     columns_text(table));
  }
  table.rows.push_back(text);
  table.lines.push_back(line);
  return {};
}

}  // namespace detail

namespace detail {

// The last comment before the first row, which is the header where no other line is.
struct CommentHeader {
  std::string_view text;
  std::size_t line = 0;

  void see(std::string_view line_text, std::size_t number) {
    if (without_mark(line_text).empty()) return;
    text = without_mark(line_text);
    line = number;
  }
};

// Takes the names of the columns from the first line that is no comment, or from the comment before
// it where the line holds numbers alone. `is_row` says which it was.
inline Outcome begin_table(const std::string& path, std::string_view line, std::size_t number,
                           const CommentHeader& comment, Table& table, bool& is_row) {
  is_row = holds_numbers_alone(line, find_separator(line));
  if (is_row && comment.text.empty()) {
    return fault(path, number, "no header; the first line names the columns, such as t,x,y");
  }
  take_header(is_row ? comment.text : line, is_row ? comment.line : number, table);
  return {};
}

}  // namespace detail

// The cells of a table are views of its text, which must outlive it: a temporary is refused.
template <class Text, std::enable_if_t<std::is_same_v<Text, std::string>, int> = 0>
Outcome parse(const std::string& path, Text&& text, Table& table) = delete;

// A header line and rows. Empty lines and comments (# or %) are passed over; where the first line
// that is neither holds numbers alone, the last comment before it is the header, as NumPy writes
// it.
NFOPIDN_HOST Outcome parse(const std::string& path, std::string_view text, Table& table);

// Digits of a number's text behind its point, exponent included: "1.50e-3" has 5.
NFOPIDN_HOST int decimals(std::string_view cell);

// A column of numbers.
struct Column {
  std::string name;  // as the file has it
  std::vector<double> values;
  int decimals = 0;  // of the number with the most
};

NFOPIDN_HOST Outcome read_column(const std::string& path, const Table& table, std::size_t index,
                                 Column& result);

}  // namespace nfopidn::csv

#ifdef NFOPIDN_DEFINES_IO

namespace nfopidn::csv {

NFOPIDN_HOST std::string_view trimmed(std::string_view cell) {
  constexpr std::string_view blanks = " \t";
  const std::size_t first = cell.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return cell.substr(first, cell.find_last_not_of(blanks) - first + 1);
}

NFOPIDN_HOST char find_separator(std::string_view line) {
  char best = ' ';
  std::ptrdiff_t most = 0;
  for (const char candidate : {';', '\t', ','}) {
    const std::ptrdiff_t count = std::count(line.begin(), line.end(), candidate);
    if (count > most) {
      most = count;
      best = candidate;
    }
  }
  return best;
}

NFOPIDN_HOST bool next_cell(std::string_view& rest, bool& ended, char separator,
                            std::string_view& cell) {
  if (ended) return false;
  if (separator == ' ') rest = trimmed(rest);
  std::size_t from = rest.find_first_not_of(" \t");
  const char quote = from < rest.size() ? rest[from] : '\0';
  if (quote == '"' || quote == '\'') {
    from = rest.find(quote,
                     from + 1);  // a separator between quotes separates nothing
  }
  const std::size_t end = from >= rest.size() ? std::string_view::npos
                                              : (separator == ' ' ? rest.find_first_of(" \t", from)
                                                                  : rest.find(separator, from));
  cell = trimmed(rest.substr(0, end));
  ended = end == std::string_view::npos;
  if (!ended) rest.remove_prefix(end + 1);
  if (cell.size() > 1 && (cell.front() == '"' || cell.front() == '\'') &&
      cell.back() == cell.front()) {
    cell = trimmed(cell.substr(1, cell.size() - 2));
  }
  return true;
}

NFOPIDN_HOST std::vector<std::string_view> split(std::string_view line, char separator) {
  std::vector<std::string_view> cells;
  std::string_view cell;
  bool ended = false;
  while (next_cell(line, ended, separator, cell)) cells.push_back(cell);
  return cells;
}

NFOPIDN_HOST bool parse_number(std::string_view cell, double& value) {
  if (!cell.empty() && cell.front() == '+') cell.remove_prefix(1);
  const char* end = cell.data() + cell.size();
  const auto result = std::from_chars(cell.data(), end, value);
  return result.ec == std::errc() && result.ptr == end && std::isfinite(value);
}

NFOPIDN_HOST Outcome fault(const std::string& path, std::size_t line, const std::string& message) {
  return {Status::wrong_size, path + ":" + std::to_string(line) + ": " + message};
}

NFOPIDN_HOST std::string columns_text(const Table& table) {
  constexpr std::size_t most = 12;
  std::string text;
  for (std::size_t i = 0; i < std::min(most, table.names.size()); ++i) {
    const std::string& name = table.names[i];
    text += (i > 0 ? ", " : "") + (name.empty() ? "(no name)" : name.substr(0, 40));
  }
  if (table.names.size() > most) {
    text += " and " + std::to_string(table.names.size() - most) + " more";
  }
  return text;
}

NFOPIDN_HOST Outcome parse(const std::string& path, std::string_view text, Table& table) {
  constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
  if (text.substr(0, 3) == byte_order_mark) text.remove_prefix(3);
  if (text.substr(0, 4).find('\0') != std::string_view::npos) {
    return fault(path, 1,
                 "not a table in ASCII or UTF-8; UTF-16, as some spreadsheets "
                 "write it?");
  }
  detail::Lines lines{text};
  std::string_view line;
  detail::CommentHeader comment;
  while (lines.next(line)) {
    line = trimmed(line);
    if (line.empty()) continue;
    if (detail::is_comment(line)) {
      if (table.names.empty()) comment.see(line, lines.number);
      continue;
    }
    if (table.names.empty()) {
      bool is_row = false;
      Outcome outcome = detail::begin_table(path, line, lines.number, comment, table, is_row);
      if (!outcome) return outcome;
      if (!is_row) continue;
    }
    if (Outcome outcome = detail::add_row(path, lines.number, line, table); !outcome) {
      return outcome;
    }
  }
  if (table.names.empty() && !comment.text.empty()) {
    detail::take_header(comment.text, comment.line, table);
  }
  if (table.names.empty()) return fault(path, 1, "no header; the file is empty");
  return {};
}

NFOPIDN_HOST int decimals(std::string_view cell) {
  const std::size_t exponent = cell.find_first_of("eE");
  const std::string_view mantissa = cell.substr(0, exponent);
  const std::size_t point = mantissa.find('.');
  int digits = point == std::string_view::npos ? 0 : static_cast<int>(mantissa.size() - point) - 1;
  if (exponent != std::string_view::npos) {
    std::string_view power = cell.substr(exponent + 1);
    if (!power.empty() && power.front() == '+') power.remove_prefix(1);
    int value = 0;
    std::from_chars(power.data(), power.data() + power.size(), value);
    digits -= std::max(-400, std::min(400, value));  // beyond, a double has no digits
  }
  return digits;
}

NFOPIDN_HOST Outcome read_column(const std::string& path, const Table& table, std::size_t index,
                                 Column& result) {
  result.name = table.names[index];
  result.values.reserve(table.rows.size());
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    std::string_view rest = table.rows[row], cell;
    bool ended = false;
    for (std::size_t i = 0; i <= index; ++i) next_cell(rest, ended, table.separator, cell);
    double number = 0;
    if (!parse_number(cell, number)) {
      const bool comma = cell.find(',') != std::string_view::npos;
      return fault(path, table.lines[row],
                   "\"" + std::string(cell.substr(0, 40)) + "\" in column " + result.name +
                       " is no finite number" + (comma ? "; decimals need a point" : ""));
    }
    result.values.push_back(number);
    result.decimals = std::max(result.decimals, decimals(cell));
  }
  return {};
}

}  // namespace nfopidn::csv

#endif  // NFOPIDN_DEFINES_IO
