// L4. A search on disk: what the objective has answered so far, from which the search is repeated
// to the last bit without asking again.
#pragma once

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/io/crc64.hpp"
#include "nfopidn/io/file_lock.hpp"
#include "nfopidn/search/session.hpp"

namespace nfopidn {

constexpr const char* checkpoint_format = "nfopidn-checkpoint";

namespace checkpoint {

// JSON has no infinity.
NFOPIDN_HOST Json number(double value);

NFOPIDN_HOST bool read_number(const Json& value, double& result);

// What follows the other keys of a document, with the digest of all that stands before.
NFOPIDN_HOST std::string seal_of(std::string_view before);

// An object as text that ends with its seal.
NFOPIDN_HOST std::string sealed(const Json& object);

// Whether a file is as it was written, to the last byte.
NFOPIDN_HOST bool is_whole(std::string_view text);

// The state before the newest.
NFOPIDN_HOST std::string previous(const std::string& path);

NFOPIDN_HOST Outcome damage(const std::string& path);

// A file that is whole, as a document. `damaged` tells whether it is there and is not whole.
NFOPIDN_HOST Outcome read(const std::string& path, Json& document, bool& damaged);

// Gives a document's record to a search of the same problem.
NFOPIDN_HOST Outcome resume(const Json& document, const Json& problem, SearchSession& search);

}  // namespace checkpoint

// A search's file, and beside it the state before, with the suffix .previous, from which the search
// goes on when the newest is damaged.
class CheckpointFile {
 public:
  // `problem` describes everything that the search's course depends on.
  CheckpointFile(std::string path, Json problem)
      : path_(std::move(path)), problem_(std::move(problem)) {}

  const std::string& path() const { return path_; }

  // Keeps it from other searches for as long as this lives.
  Outcome lock() { return lock_.take(path_); }

  // A file that is not there is a search that has not begun. `note` tells what was not as it should
  // be where the search can go on all the same; empty if nothing.
  Outcome load(SearchSession& search, std::string& note);

  // The record holds no NaN.
  Outcome save(const SearchSession& search);

 private:
  Outcome resume(const std::string& path, const Json& document, SearchSession& search) const;

  std::string path_;
  Json problem_;
  FileLock lock_;
  bool is_damaged_ = false;  // what has the name: it must not take the place of the state before
};

// What the search of a checkpoint is of: the newest file's if it is whole, else that of the one
// before; null if neither is.
NFOPIDN_HOST Json checkpoint_problem(const std::string& path);

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_IO

namespace nfopidn::checkpoint {

NFOPIDN_HOST Json number(double value) {
  if (std::isfinite(value)) return value;
  return value > 0 ? "inf" : "-inf";
}

NFOPIDN_HOST bool read_number(const Json& value, double& result) {
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

NFOPIDN_HOST std::string seal_of(std::string_view before) {
  char digits[17];
  std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(crc64(before)));
  return ",\"crc64\":\"" + std::string(digits) + "\"}\n";
}

NFOPIDN_HOST std::string sealed(const Json& object) {
  std::string text = object.dump();
  text.pop_back();  // the brace
  return text + seal_of(text);
}

NFOPIDN_HOST bool is_whole(std::string_view text) {
  const std::size_t size = seal_of("").size();
  if (text.size() < size) return false;
  const std::string_view before = text.substr(0, text.size() - size);
  return text.substr(before.size()) == seal_of(before);
}

NFOPIDN_HOST std::string previous(const std::string& path) {
  OutputTarget target;
  return (find_target(path, target) ? target.path : path) + ".previous";
}

NFOPIDN_HOST Outcome damage(const std::string& path) {
  return {Status::inconsistent,
          path +
              ": is damaged, or no checkpoint of this version: the digest at its end is not that "
              "of its content; give another path, or remove it"};
}

NFOPIDN_HOST Outcome read(const std::string& path, Json& document, bool& damaged) {
  damaged = false;
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored) &&
      !std::filesystem::is_directory(path, ignored)) {
    return {Status::not_a_choice, path + ": must be a file, not a device or a pipe"};
  }
  std::string text;
  if (Outcome outcome = read_file(path, text); !outcome) return outcome;
  damaged = !is_whole(text);
  if (damaged) return damage(path);
  Outcome outcome = parse_json(text, document);
  if (!outcome) outcome.message = path + ": " + outcome.message;
  return outcome;
}

NFOPIDN_HOST Outcome resume(const Json& document, const Json& problem, SearchSession& search) {
  if (Outcome outcome = json::check_header(document, checkpoint_format); !outcome) return outcome;
  const auto has = [&](const char* key) { return document.contains(key); };
  if (!has("problem") || !has("elapsed") || !has("record") || !document["elapsed"].is_number() ||
      !document["record"].is_array()) {
    return {Status::not_a_choice, "problem, elapsed and record must be there"};
  }
  if (!has("course") || document["course"] != search_course) {
    return {Status::inconsistent,
            "was written by a version of nfopidn whose searches take another course; give another "
            "path, or remove it"};
  }
  if (document["problem"] != problem) {
    return {Status::inconsistent,
            "is the checkpoint of another search; give another path, or remove it"};
  }
  std::vector<double> record;
  for (const Json& value : document["record"]) {
    record.push_back(0);
    if (!read_number(value, record.back())) {
      return {Status::not_a_choice, "record must hold numbers"};
    }
  }
  search.resume(std::move(record));
  search.add_elapsed(document["elapsed"].get<double>());
  return {};
}

}  // namespace nfopidn::checkpoint

namespace nfopidn {

NFOPIDN_HOST Outcome CheckpointFile::load(SearchSession& search, std::string& note) {
  if (!file_exists(path_)) return {};
  Json document;
  const Outcome newest = checkpoint::read(path_, document, is_damaged_);
  if (newest) return resume(path_, document, search);
  if (!is_damaged_) return newest;
  const std::string before = checkpoint::previous(path_);
  bool also = false;
  if (!file_exists(before) || !checkpoint::read(before, document, also) ||
      !resume(before, document, search)) {
    return newest;
  }
  note = path_ + ": is damaged; the search goes on from the state before, " + before;
  return {};
}

NFOPIDN_HOST Outcome CheckpointFile::save(const SearchSession& search) {
  Json document = {{"format", checkpoint_format},
                   {"version", document_version},
                   {"course", search_course},
                   {"problem", problem_},
                   {"elapsed", search.elapsed()}};
  Json record = Json::array();
  for (const double answer : search.record()) record.push_back(checkpoint::number(answer));
  document["record"] = std::move(record);
  const std::string before = checkpoint::previous(path_);
  // What lies beside a search that begins is another's.
  if (!file_exists(path_)) std::remove(before.c_str());
  Outcome outcome =
      write_file(path_, checkpoint::sealed(document), is_damaged_ ? std::string() : before);
  if (outcome) is_damaged_ = false;
  return outcome;
}

NFOPIDN_HOST Outcome CheckpointFile::resume(const std::string& path, const Json& document,
                                            SearchSession& search) const {
  Outcome outcome = checkpoint::resume(document, problem_, search);
  if (!outcome) outcome.message = path + ": " + outcome.message;
  return outcome;
}

NFOPIDN_HOST Json checkpoint_problem(const std::string& path) {
  for (const std::string& name : {path, checkpoint::previous(path)}) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path, ignored)) return nullptr;
    Json document;
    bool damaged = false;
    if (checkpoint::read(name, document, damaged)) return document.value("problem", Json());
    if (!damaged) return nullptr;
  }
  return nullptr;
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_IO
