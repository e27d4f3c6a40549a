// Any bytes as a table, and the table as a trajectory.
#include "documents.hpp"
#include "nfopidn/io/csv.hpp"

using namespace nfopidn;

namespace {

// A name may begin like a byte order mark, which only the first line has, and end with a carriage
// return, of which a line's end takes one.
std::string text_of(const csv::Table& table) {
  std::string text = "\r\n";
  for (std::size_t i = 0; i < table.names.size(); ++i) text += (i > 0 ? "," : "") + table.names[i];
  text += "\r\n";
  for (std::size_t row = 0; row < table.lines.size(); ++row) {
    for (std::size_t i = 0; i < table.columns.size(); ++i) {
      text += (i > 0 ? "," : "") + number_text(table.columns[i][row]);
    }
    text += "\r\n";
  }
  return text;
}

void check_table(const csv::Table& table) {
  fuzz::require(!table.names.empty(), "a table has a header");
  fuzz::require(table.columns.size() == table.names.size(), "a column a name");
  for (const std::vector<double>& column : table.columns) {
    fuzz::require(column.size() == table.lines.size(), "a cell a row");
    for (const double value : column) fuzz::require(std::isfinite(value), "cells are numbers");
  }
  csv::Table again;
  fuzz::require(bool(csv::parse("again", text_of(table), again)), "what is written is accepted");
  fuzz::require(again.names == table.names && again.columns == table.columns,
                "what is written reads back as the same");
}

void check_trajectory(const csv::Table& table, std::uint8_t choices) {
  TrajectorySettings settings;
  settings.heading =
      static_cast<HeadingChoice>(choices % std::size(ChoiceNames<HeadingChoice>::names));
  settings.laps = 1 + choices / 128;
  Trajectory trajectory;
  if (const Outcome outcome = trajectory_from_table("path.csv", table, settings, trajectory);
      !outcome) {
    fuzz::require_reason(outcome);
    fuzz::require(trajectory.size() == 0, "a refused table changes nothing");
    return;
  }
  const auto rows = static_cast<Eigen::Index>(table.lines.size());
  fuzz::require(trajectory.size() == (rows - 1) * settings.laps + 1, "a sample a row and lap");
  fuzz::require(trajectory.theta.isFinite().all(), "headings are numbers");
  fuzz::require(trajectory.v.isFinite().all(), "speeds are numbers");
  fuzz::require(trajectory.acceleration.isFinite().all(), "accelerations are numbers");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  csv::Table table;
  if (const Outcome outcome = csv::parse("path.csv", fuzz::text_of(data, size), table); !outcome) {
    fuzz::require_reason(outcome);
    return 0;
  }
  check_table(table);
  check_trajectory(table, data[size - 1]);
  return 0;
}
