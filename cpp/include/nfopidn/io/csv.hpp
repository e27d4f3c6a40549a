// L4. Trajectories and disturbances from tables, run tables to them.
#pragma once

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/io/columns.hpp"
#include "nfopidn/simulation/metrics.hpp"

namespace nfopidn {

NFOPIDN_HOST std::string run_table_csv(const RunTable& table);

// How a trajectory is read from a table.
struct TableReading {
  TrajectorySettings settings;  // heading, laps, standstill_speed
  double dt = 0;                // [s]; 0: that of the table's times
  bool heading_given = false;   // by the caller: a table's column theta is not used
  bool closed = false;          // the table leaves out the point that closes the path
};

namespace csv {

// The columns of a path, as far as a table has them.
struct PathColumns {
  Column x, y, t, theta, reverse;
};

NFOPIDN_HOST Outcome read_path_columns(const std::string& path, const Table& table,
                                       bool heading_given, PathColumns& columns);

// The sample time: that of the times, or the one that was given.
NFOPIDN_HOST Outcome read_sample_time(const std::string& path, const Table& table, const Column& t,
                                      double given, TrajectorySettings& settings);

NFOPIDN_HOST Outcome read_flags(const std::string& path, const Table& table, const Column& reverse,
                                std::vector<unsigned char>& flags);

}  // namespace csv

// A trajectory from a table with the columns x and y, a time in equal steps unless dt is given, and
// perhaps theta or reverse. `path` stands in messages; what is made of each column goes to the
// trajectory's notes.
NFOPIDN_HOST Outcome trajectory_from_table(const std::string& path, const csv::Table& table,
                                           const TableReading& reading, Trajectory& result);

NFOPIDN_HOST Outcome load_trajectory(const std::string& path, const TableReading& reading,
                                     Trajectory& result);

// A scenario's disturbance, a pair a sample. Where the table has times, they must be the
// scenario's.
NFOPIDN_HOST Outcome load_disturbance(const std::string& path, double dt,
                                      std::vector<std::array<double, 2>>& result);

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_IO

namespace nfopidn {

NFOPIDN_HOST std::string run_table_csv(const RunTable& table) {
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

}  // namespace nfopidn

namespace nfopidn::csv {

NFOPIDN_HOST Outcome read_path_columns(const std::string& path, const Table& table,
                                       bool heading_given, PathColumns& columns) {
  for (const auto& [column, quantity] : {std::pair{&columns.x, "x"}, std::pair{&columns.y, "y"}}) {
    std::size_t index = no_column;
    if (Outcome outcome = find(path, table, quantity, index); !outcome) return outcome;
    if (index == no_column) {
      return fault(path, table.header_line,
                   "no columns x and y in the header; its columns are " + columns_text(table));
    }
    if (Outcome outcome = read(path, table, quantity, *column); !outcome) return outcome;
  }
  const std::size_t rows = table.rows.size();
  if (rows < minimum_samples) {
    return {Status::wrong_size, path + ": " + std::to_string(rows) +
                                    " samples; a trajectory needs at least " +
                                    std::to_string(minimum_samples)};
  }
  if (Outcome outcome = read(path, table, "t", columns.t); !outcome) return outcome;
  if (!heading_given) {
    if (Outcome outcome = read(path, table, "theta", columns.theta); !outcome) return outcome;
  }
  return read(path, table, "reverse", columns.reverse);
}

NFOPIDN_HOST Outcome read_sample_time(const std::string& path, const Table& table, const Column& t,
                                      double given, TrajectorySettings& settings) {
  settings.dt = given;
  if (t.values.empty()) {
    if (given != 0) return {};
    return fault(path, table.header_line,
                 "no column of times (t, time, timestamp, ...); give dt. The columns are " +
                     columns_text(table));
  }
  if (Outcome outcome = check_times(path, table, t, given, settings.dt); !outcome) return outcome;
  Outcome outcome = read_settings({{"dt", settings.dt}}, "", settings);
  if (!outcome) outcome.message = path + ": the step of " + t.name + ", " + outcome.message;
  return outcome;
}

NFOPIDN_HOST Outcome read_flags(const std::string& path, const Table& table, const Column& reverse,
                                std::vector<unsigned char>& flags) {
  for (std::size_t k = 0; k < reverse.values.size(); ++k) {
    const double flag = reverse.values[k];
    if (flag != 0 && flag != 1) {
      return fault(path, table.lines[k],
                   number_text(flag) + " in column " + reverse.name + " must be 0 or 1");
    }
    flags.push_back(flag != 0 ? 1 : 0);
  }
  return {};
}

}  // namespace nfopidn::csv

namespace nfopidn {

NFOPIDN_HOST Outcome trajectory_from_table(const std::string& path, const csv::Table& table,
                                           const TableReading& reading, Trajectory& result) {
  csv::PathColumns columns;
  if (Outcome outcome = csv::read_path_columns(path, table, reading.heading_given, columns);
      !outcome) {
    return outcome;
  }
  const auto& [x, y, t, theta, reverse] = columns;
  TrajectorySettings settings = reading.settings;
  settings.name = Curve::samples;
  if (Outcome outcome = csv::read_sample_time(path, table, t, reading.dt, settings); !outcome) {
    return outcome;
  }
  Samples samples;
  const auto array = [](const std::vector<double>& column) {
    return Eigen::ArrayXd(
        Eigen::Map<const Eigen::ArrayXd>(column.data(), static_cast<Eigen::Index>(column.size())));
  };
  samples.x = array(x.values);
  samples.y = array(y.values);
  samples.theta = array(theta.values);
  if (Outcome outcome = csv::read_flags(path, table, reverse, samples.reverse); !outcome) {
    return outcome;
  }
  if (reading.closed) close_path(samples);
  Outcome outcome = build_trajectory(settings, samples, "", result);
  if (!outcome) {
    outcome.message = path + ": " + outcome.message;
    return outcome;
  }
  std::vector<std::pair<std::string, std::string>> used;
  for (const auto& [column, quantity] :
       {std::pair{&t, "t"}, std::pair{&x, "x"}, std::pair{&y, "y"}, std::pair{&theta, "theta"},
        std::pair{&reverse, "reverse"}}) {
    if (!column->values.empty()) used.emplace_back(quantity, column->name);
  }
  result.notes.insert(result.notes.begin(), csv::use_text(path, table, used));
  return outcome;
}

NFOPIDN_HOST Outcome load_trajectory(const std::string& path, const TableReading& reading,
                                     Trajectory& result) {
  std::string text;
  if (Outcome outcome = read_file(path, text); !outcome) return outcome;
  csv::Table table;
  if (Outcome outcome = csv::parse(path, text, table); !outcome) return outcome;
  return trajectory_from_table(path, table, reading, result);
}

NFOPIDN_HOST Outcome load_disturbance(const std::string& path, double dt,
                                      std::vector<std::array<double, 2>>& result) {
  std::string text;
  if (Outcome outcome = read_file(path, text); !outcome) return outcome;
  csv::Table table;
  if (Outcome outcome = csv::parse(path, text, table); !outcome) return outcome;
  csv::Column force, moment, t;
  for (const auto& [column, quantity] :
       {std::pair{&force, "force"}, std::pair{&moment, "moment"}, std::pair{&t, "t"}}) {
    if (Outcome outcome = csv::read(path, table, quantity, *column); !outcome) return outcome;
  }
  if (force.name.empty() || moment.name.empty()) {
    return csv::fault(
        path, table.header_line,
        "no columns force and moment in the header; its columns are " + csv::columns_text(table));
  }
  if (t.values.size() > 1) {
    double step = 0;
    if (Outcome outcome = csv::check_times(path, table, t, dt, step); !outcome) return outcome;
  }
  result.resize(force.values.size());
  for (std::size_t k = 0; k < result.size(); ++k) result[k] = {force.values[k], moment.values[k]};
  return {};
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_IO
