// Any bytes as a table, and the table as a trajectory.
#include <string>

#include "documents.hpp"
#include "nfopidn/io/csv.hpp"

using namespace nfopidn;

namespace {

// Every row has a cell for each name, and a column of numbers reads back as the same when written.
void check_table(const csv::Table& table) {
  fuzz::require(!table.names.empty(), "a table has a header");
  fuzz::require(table.rows.size() == table.lines.size(), "a line a row");
  for (std::size_t i = 0; i < table.names.size(); ++i) {
    csv::Column column;
    if (const Outcome outcome = csv::read_column("path.csv", table, i, column); !outcome) {
      fuzz::require_reason(outcome);
      continue;
    }
    fuzz::require(column.values.size() == table.rows.size(), "a cell a row");
    std::string text = "value,\n";
    for (const double value : column.values) {
      fuzz::require(std::isfinite(value), "cells are numbers");
      text += number_text(value) + ",\n";
    }
    csv::Table again;
    csv::Column same;
    fuzz::require(bool(csv::parse("again", text, again)), "what is written is accepted");
    fuzz::require(bool(csv::read_column("again", again, 0, same)), "and holds numbers");
    fuzz::require(same.values == column.values, "what is written reads back as the same");
  }
}

void check_trajectory(const csv::Table& table, std::uint8_t choices) {
  TableReading reading;
  TrajectorySettings& settings = reading.settings;
  reading.dt = choices % 3 == 0 ? 0.1 : 0;
  reading.closed = choices % 5 == 0;
  reading.heading_given = choices % 7 == 0;
  settings.heading =
      static_cast<HeadingChoice>(choices % std::size(ChoiceNames<HeadingChoice>::names));
  settings.laps = 1 + choices / 128;
  Trajectory trajectory;
  if (const Outcome outcome = trajectory_from_table("path.csv", table, reading, trajectory);
      !outcome) {
    fuzz::require_reason(outcome);
    fuzz::require(trajectory.size() == 0, "a refused table changes nothing");
    return;
  }
  const auto rows = static_cast<Eigen::Index>(table.lines.size());
  const Eigen::Index samples = trajectory.size();
  const bool open = samples == (rows - 1) * settings.laps + 1;
  fuzz::require(open || (reading.closed && samples == rows * settings.laps + 1),
                "a sample a row and lap");
  fuzz::require(trajectory.theta.isFinite().all(), "headings are numbers");
  fuzz::require(trajectory.v.isFinite().all(), "speeds are numbers");
  fuzz::require(trajectory.acceleration.isFinite().all(), "accelerations are numbers");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string text = fuzz::text_of(data, size);
  csv::Table table;
  if (const Outcome outcome = csv::parse("path.csv", text, table); !outcome) {
    fuzz::require_reason(outcome);
    return 0;
  }
  check_table(table);
  check_trajectory(table, data[size - 1]);
  return 0;
}
