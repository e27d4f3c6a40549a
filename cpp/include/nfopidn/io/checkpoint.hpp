// L4. A search on disk: what the objective has answered so far, from which the search is repeated
// to the last bit without asking again.
#pragma once

#include "nfopidn/io/files.hpp"
#include "nfopidn/search.hpp"

namespace nfopidn {

constexpr const char* checkpoint_format = "nfopidn-checkpoint";

namespace checkpoint {

// JSON has no infinity.
inline Json number(double value) {
  if (std::isfinite(value)) return value;
  return value > 0 ? "inf" : "-inf";
}

inline bool read_number(const Json& value, double& result) {
  if (value.is_number()) {
    result = value.get<double>();
    return true;
  }
  if (value == "inf" || value == "-inf") {
    result = (value == "inf" ? 1 : -1) * std::numeric_limits<double>::infinity();
    return true;
  }
  return false;
}

}  // namespace checkpoint

// The record holds no NaN. `problem` describes everything that the search's course depends on.
inline Outcome save_checkpoint(const std::string& path, const Json& problem, const Search& search) {
  Json document = {{"format", checkpoint_format},
                   {"version", document_version},
                   {"course", search_course},
                   {"problem", problem},
                   {"elapsed", search.elapsed()}};
  Json record = Json::array();
  for (const double answer : search.record()) record.push_back(checkpoint::number(answer));
  document["record"] = std::move(record);
  return write_file(path, document.dump() + "\n");
}

// A file that is not there is a search that has not begun.
inline Outcome load_checkpoint(const std::string& path, const Json& problem, Search& search) {
  if (!file_exists(path)) return {};
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored) &&
      !std::filesystem::is_directory(path, ignored)) {
    return {Status::not_a_choice, path + ": must be a file, not a device or a pipe"};
  }
  const auto reader = [&problem](const Json& document, Search& result) -> Outcome {
    if (Outcome outcome = json::check_header(document, checkpoint_format); !outcome) {
      return outcome;
    }
    const auto has = [&](const char* key) { return document.contains(key); };
    if (!has("problem") || !has("elapsed") || !has("record") || !document["elapsed"].is_number() ||
        !document["record"].is_array()) {
      return {Status::not_a_choice, "problem, elapsed and record must be there"};
    }
    if (!has("course") || document["course"] != search_course) {
      return {Status::inconsistent,
              "was written by a version of nfopidn whose searches take another course; give "
              "another path, or remove it"};
    }
    if (document["problem"] != problem) {
      return {Status::inconsistent,
              "is the checkpoint of another search; give another path, or remove it"};
    }
    std::vector<double> record;
    for (const Json& value : document["record"]) {
      record.push_back(0);
      if (!checkpoint::read_number(value, record.back())) {
        return {Status::not_a_choice, "record must hold numbers"};
      }
    }
    result.resume(std::move(record));
    result.add_elapsed(document["elapsed"].get<double>());
    return {};
  };
  return load_document(path, reader, search);
}

}  // namespace nfopidn
