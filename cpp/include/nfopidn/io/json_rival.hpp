// L4. Rivals as JSON documents.
#pragma once

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/io/json.hpp"
#include "nfopidn/rivals/rivals.hpp"

namespace nfopidn {

constexpr const char* rival_format = "nfopidn-rival";

NFOPIDN_HOST Json write_rival(const rivals::RivalDesign& design);

NFOPIDN_HOST Outcome find_law(const Json& name, std::size_t& law);

// Parameters that are left out keep the law's own values.
NFOPIDN_HOST Outcome read_rival_parameters(const Json& given, rivals::RivalDesign& design);

NFOPIDN_HOST Outcome read_rival(const Json& document, rivals::RivalDesign& result);

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_IO

namespace nfopidn {

NFOPIDN_HOST Json write_rival(const rivals::RivalDesign& design) {
  Json parameters = Json::object();
  const std::vector<ParameterBounds> bounds = rivals::law_bounds(design.law, design.integral);
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    parameters[bounds[i].name] = design.parameters[i];
  }
  Json document = {{"format", rival_format},
                   {"version", document_version},
                   {"law", rivals::law_name(design.law)},
                   {"parameters", parameters},
                   {"speeds", json::write(design.speeds)},
                   {"robot", write_settings(design.robot)}};
  // A document without it is of a rival without.
  if (design.integral) document["integral"] = true;
  return document;
}

NFOPIDN_HOST Outcome find_law(const Json& name, std::size_t& law) {
  std::vector<std::string> known;
  for (std::size_t i = 0; i < rivals::law_count; ++i) {
    known.push_back(rivals::law_name(i));
    if (name != known.back()) continue;
    law = i;
    return {};
  }
  const std::string hint = name.is_string() ? suggestion(name.get<std::string>(), known) : "";
  return refuse(Status::inconsistent, "law", name.dump() + hint,
                "one of " + json::list_text(known));
}

NFOPIDN_HOST Outcome read_rival_parameters(const Json& given, rivals::RivalDesign& design) {
  return rivals::with_law(design.law, [&](auto* own) {
    typename std::remove_pointer_t<decltype(own)>::Settings settings;
    rivals::IntegralGains<double> integral;
    std::vector<std::string> of_law, of_integral;
    decltype(settings)::fields([&](const auto& f) { of_law.emplace_back(f.name); });
    decltype(integral)::fields([&](const auto& f) { of_integral.emplace_back(f.name); });
    if (!design.integral) of_integral.clear();
    Outcome outcome = read_settings(given, "parameters", settings, of_integral);
    if (outcome && design.integral) {
      outcome = read_settings(given, "parameters", integral, of_law);
    }
    if (!outcome) return outcome;
    design.parameters.clear();
    decltype(settings)::fields(
        [&](const auto& f) { design.parameters.push_back(settings.*f.member); });
    if (design.integral) {
      decltype(integral)::fields(
          [&](const auto& f) { design.parameters.push_back(integral.*f.member); });
    }
    return outcome;
  });
}

NFOPIDN_HOST Outcome read_rival(const Json& document, rivals::RivalDesign& result) {
  if (Outcome outcome = json::check_header(document, rival_format); !outcome) return outcome;
  rivals::RivalDesign design;
  Outcome outcome;
  const auto find = [&](const char* key) {
    const auto found = document.find(key);
    return found == document.end() ? Json() : *found;
  };
  outcome = find_law(find("law"), design.law);
  if (outcome) {
    outcome = read_settings(document, "", design,
                            {"format", "version", "law", "parameters", "robot", "verdict"});
  }
  if (outcome)
    outcome = read_rival_parameters(document.value("parameters", Json::object()), design);
  if (outcome)
    outcome = read_settings(document.value("robot", Json::object()), "robot", design.robot);
  if (outcome) result = std::move(design);
  return outcome;
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_IO
