// What holds for every reader of text: a refusal says why in one line.
#pragma once

#include <algorithm>
#include <string>

#include "fuzz.hpp"
#include "nfopidn/io/json_scenario.hpp"

namespace nfopidn::fuzz {

inline std::string text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

inline void require_reason(const Outcome& outcome) {
  const std::string line = printable(outcome.message);
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; };
  require(outcome.status != Status::ok, "a refusal has a status");
  require(!line.empty(), "a refusal has a message");
  require(std::none_of(line.begin(), line.end(), is_control), "a message is one line");
}

// The properties of a kind of document. `read` is its reader, `write` its writer; `start` is what
// is read into. Returns whether the text was accepted, with what it says in `result`.
template <class Value, class Read, class Write>
bool check_document(const std::string& text, const Read& read, const Write& write,
                    const Value& start, Value& result) {
  Json document;
  if (const Outcome outcome = parse_json(text, document); !outcome) {
    require_reason(outcome);
    return false;
  }
  result = start;
  if (const Outcome outcome = read(document, result); !outcome) {
    require_reason(outcome);
    require(write(result) == write(start), "a refused document changes nothing");
    return false;
  }
  const std::string written = write(result).dump(2);
  Json parsed;
  Value again = start;
  require(bool(parse_json(written, parsed)), "what is written is JSON");
  require(bool(read(parsed, again)), "what is written is accepted");
  require(write(again).dump(2) == written, "what is written reads back as the same");
  return true;
}

}  // namespace nfopidn::fuzz
