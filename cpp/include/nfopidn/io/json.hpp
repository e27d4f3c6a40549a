// L4. Settings as JSON documents. The one JSON parser of the project: files, the
// command line and Python keywords all pass through read_settings().
#pragma once

#include <stdexcept>

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/io/json_values.hpp"

namespace nfopidn {

constexpr int document_version = 1;

namespace json {

inline std::string join(const std::string& path, const std::string& key) {
  return path.empty() ? key : path + "." + key;
}

template <class Settings>
bool has_field(const std::string& key) {
  bool found = false;
  Settings::fields([&](const auto& field) { found = found || key == field.name; });
  return found;
}

NFOPIDN_HOST std::string list_text(const std::vector<std::string>& words);

template <class Settings>
std::string field_list() {
  std::vector<std::string> names;
  Settings::fields([&](const auto& field) { names.emplace_back(field.name); });
  return list_text(names);
}

// What an object may hold, but for the header that every document has.
template <class Settings>
std::vector<std::string> known_keys(const std::vector<std::string>& also) {
  std::vector<std::string> keys;
  for (const std::string& key : also) {
    if (key != "format" && key != "version") keys.push_back(key);
  }
  Settings::fields([&](const auto& field) { keys.emplace_back(field.name); });
  return keys;
}

// Settings within settings: an object with every one of their keys.
template <class Settings, std::enable_if_t<nfopidn::detail::has_fields<Settings>, int> = 0>
void read(const Json& value, const Context& context, std::optional<Settings>& result);

// `hint` names the key that was probably meant.
NFOPIDN_HOST Outcome unknown_key(const std::string& path, const std::string& known,
                                 const std::string& hint = "");

}  // namespace json

// Reads the object's keys into `settings`, which keeps what is not named. `path` prefixes names in
// messages; keys in `also` are left to the caller. On a fault the settings stay as they were.
template <class Settings>
Outcome read_settings(const Json& object, const std::string& path, Settings& settings,
                      const std::vector<std::string>& also = {}) {
  if (!object.is_object()) {
    return {Status::not_a_choice, (path.empty() ? "the document" : path) + " must be an object"};
  }
  for (const auto& item : object.items()) {
    const bool known = json::has_field<Settings>(item.key()) ||
                       std::find(also.begin(), also.end(), item.key()) != also.end();
    if (!known) {
      const std::vector<std::string> keys = json::known_keys<Settings>(also);
      return json::unknown_key(json::join(path, item.key()), json::list_text(keys),
                               suggestion(item.key(), keys));
    }
  }
  Outcome outcome;
  Settings result = settings;
  Settings::fields([&](const auto& field) {
    const auto found = object.find(field.name);
    if (found == object.end()) return;
    const json::Context context = {json::join(path, field.name), field.range, field.unit, &outcome};
    json::read(*found, context, result.*field.member);
  });
  if (outcome) settings = std::move(result);
  return outcome;
}

namespace json {

template <class Settings, std::enable_if_t<nfopidn::detail::has_fields<Settings>, int> = 0>
Json write(const std::optional<Settings>& value);

}  // namespace json

template <class Settings>
Json write_settings(const Settings& settings) {
  Json object = Json::object();
  Settings::fields(
      [&](const auto& field) { object[field.name] = json::write(settings.*field.member); });
  return object;
}

namespace json {

template <class Settings, std::enable_if_t<nfopidn::detail::has_fields<Settings>, int>>
Json write(const std::optional<Settings>& value) {
  return value ? write_settings(*value) : Json(nullptr);
}

template <class Settings, std::enable_if_t<nfopidn::detail::has_fields<Settings>, int>>
void read(const Json& value, const Context& context, std::optional<Settings>& result) {
  if (value.is_null()) {
    result.reset();
    return;
  }
  Settings settings;
  Outcome outcome = read_settings(value, context.path, settings);
  Settings::fields([&](const auto& field) {
    if (!outcome || value.contains(field.name)) return;
    outcome = {Status::wrong_size,
               join(context.path, field.name) +
                   " is missing; must be given with the others: " + field_list<Settings>()};
  });
  if (!outcome) return context.complain(outcome);
  result = settings;
}

// Documents of version 1 up to `newest` are read.
NFOPIDN_HOST Outcome check_header(const Json& document, const char* format,
                                  int newest = document_version);

}  // namespace json

namespace json {

constexpr int deepest = 16;  // levels of a document

// Refuses, while the text is parsed, what a document never has: a key that stands twice in an
// object, and nesting so deep that it could only be meant to exhaust the stack.
class Guard {
 public:
  bool operator()(int /*depth*/, Json::parse_event_t event, Json& parsed) {
    using Event = Json::parse_event_t;
    if (event == Event::object_start || event == Event::array_start) {
      keys_.emplace_back();
      if (keys_.size() > deepest) throw std::length_error("nested too deeply");
    } else if (event == Event::object_end || event == Event::array_end) {
      keys_.pop_back();
    } else if (event == Event::key) {
      const auto& key = parsed.get_ref<const std::string&>();
      auto& seen = keys_.back();
      if (std::find(seen.begin(), seen.end(), key) != seen.end()) {
        throw std::length_error("the key " + key + " stands twice");
      }
      seen.push_back(key);
    }
    return true;
  }

 private:
  std::vector<std::vector<std::string>> keys_;
};

}  // namespace json

// Text to JSON. NaN, infinities, trailing text and bad UTF-8 are refused.
NFOPIDN_HOST Outcome parse_json(const std::string& text, Json& result);

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_IO

namespace nfopidn::json {

NFOPIDN_HOST std::string list_text(const std::vector<std::string>& words) {
  std::string list;
  for (const std::string& word : words) list += (list.empty() ? "" : ", ") + word;
  return list;
}

NFOPIDN_HOST Outcome unknown_key(const std::string& path, const std::string& known,
                                 const std::string& hint) {
  return {Status::not_a_choice, path + " is unknown" + hint + "; known: " + known};
}

NFOPIDN_HOST Outcome check_header(const Json& document, const char* format, int newest) {
  if (!document.is_object()) return {Status::not_a_choice, "the document must be an object"};
  const auto found = document.find("format");
  if (found == document.end() || *found != format) {
    return {Status::not_a_choice, "format must be \"" + std::string(format) + "\""};
  }
  const auto version = document.find("version");
  const bool known = version != document.end() && version->is_number_integer() &&
                     within(*version, between(1, newest));
  if (!known) {
    return {Status::out_of_range,
            "version is " +
                (version == document.end()
                     ? "missing"
                     : version->dump(-1, ' ', true, Json::error_handler_t::replace)) +
                "; this library reads version " + (newest > 1 ? "1 to " : "") +
                std::to_string(newest)};
  }
  return {};
}

}  // namespace nfopidn::json

namespace nfopidn {

NFOPIDN_HOST Outcome parse_json(const std::string& text, Json& result) {
  const StandardArithmetic arithmetic;  // the conversion of decimals rounds
  try {
    result = Json::parse(text, json::Guard());
  } catch (const Json::exception& error) {
    return {Status::not_a_choice, std::string("not valid JSON: ") + error.what()};
  } catch (const std::length_error& error) {
    return {Status::not_a_choice, error.what()};
  }
  return {};
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_IO
