// L4. Controllers as JSON documents.
#pragma once

#include "nfopidn/control/controller_design.hpp"
#include "nfopidn/foundation/host.hpp"
#include "nfopidn/io/json.hpp"

namespace nfopidn {

constexpr const char* controller_format = "nfopidn-controller";
// Version 2 has sample_time. In a document of version 1 it is unknown.
constexpr int controller_version = 2;

// A scenario's robot that differs by more than this share from the one that gains are made for is
// warned about.
constexpr double robot_tolerance = 0.2;

// Settings from which taps are fused: a controller of free taps has none.
constexpr const char* fused_fields[] = {"gains", "alpha", "sigma", "generator"};

NFOPIDN_HOST Json write_controller(const ControllerDesign& design);

// Free taps, [3][memory + 2]; their number gives the memory.
NFOPIDN_HOST Outcome read_taps(const Json& value, ControllerDesign& design);

// Memory beyond that of taps, which searches have no modes for.
NFOPIDN_HOST Outcome explain_memory_to_tune(const Memory& memory);

// What the tracking law demands of a setting that is at odds with another one.
NFOPIDN_HOST Outcome explain_tracking_law(const Finding& finding);

// Long memory needs operators whose tail is made of modes.
NFOPIDN_HOST Outcome explain_consistency(const ControllerDesign& design);

// A controller that knows its sample time runs at that one alone.
NFOPIDN_HOST Outcome explain_sample_time(const ControllerSettings<double>& settings, double dt);

// What of a robot is off the one that the gains are made for; empty: nothing, or that one is not
// known.
NFOPIDN_HOST std::string explain_robot(const ControllerDesign& design, const Robot<double>& robot);

// Of a document without one it is not known.
NFOPIDN_HOST Outcome read_design_robot(const Json& document, std::optional<Robot<double>>& robot);

NFOPIDN_HOST Outcome read_controller(const Json& document, ControllerDesign& result);

#ifdef NFOPIDN_COMPILED
extern template Json write_settings(const ControllerSettings<double>&);
extern template Json write_settings(const Robot<double>&);
extern template Outcome read_settings(const Json&, const std::string&, ControllerSettings<double>&,
                                      const std::vector<std::string>&);
extern template Outcome read_settings(const Json&, const std::string&, Robot<double>&,
                                      const std::vector<std::string>&);
#endif

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_IO

namespace nfopidn {

NFOPIDN_HOST Json write_controller(const ControllerDesign& design) {
  Json document = {{"format", controller_format}, {"version", controller_version}};
  document.update(write_settings<ControllerSettings<double>>(design));
  if (design.robot) document["robot"] = write_settings(*design.robot);
  if (design.taps.empty()) return document;
  for (const char* key : fused_fields) document.erase(key);
  document["taps"] = Json::array();
  for (int channel = 0; channel < channel_count; ++channel) {
    const double* taps = design.channel_taps(channel);
    document["taps"].push_back(std::vector<double>(taps, taps + design.memory + 2));
  }
  return document;
}

NFOPIDN_HOST Outcome read_taps(const Json& value, ControllerDesign& design) {
  const std::string rule =
      "3 lists of 2 to " + std::to_string(maximum_memory + 2) + " numbers, all of one length";
  const auto is_row = [&](const Json& row) {
    return row.is_array() && row.size() >= 2 && row.size() <= maximum_memory + 2 &&
           row.size() == value[0].size();
  };
  if (!value.is_array() || value.size() != channel_count ||
      !std::all_of(value.begin(), value.end(), is_row)) {
    return {Status::wrong_size, "taps must be " + rule};
  }
  Outcome outcome;
  const json::Context context = {"taps", tap_range, "", &outcome};
  std::vector<double> taps;
  for (std::size_t channel = 0; channel < channel_count; ++channel) {
    for (std::size_t j = 0; j < value[channel].size(); ++j) {
      taps.push_back(0);
      json::read(value[channel][j], context.at(channel).at(j), taps.back());
    }
  }
  const int memory = static_cast<int>(value[0].size()) - 2;
  if (outcome && design.memory != memory) {
    outcome = {Status::inconsistent, "memory is " + std::to_string(design.memory) + "; " +
                                         std::to_string(value[0].size()) +
                                         " taps a channel make it " + std::to_string(memory)};
  }
  if (outcome) design.taps = std::move(taps);
  return outcome;
}

NFOPIDN_HOST Outcome explain_memory_to_tune(const Memory& memory) {
  if (!memory.is_long()) return {};
  const double samples =
      memory.is_infinite() ? std::numeric_limits<double>::infinity() : static_cast<double>(memory);
  return refuse_number("memory", samples, between(0, maximum_memory), "samples to tune");
}

NFOPIDN_HOST Outcome explain_tracking_law(const Finding& finding) {
  const std::string field = finding.field;
  const bool speed_gain = field.rfind("speed_gain", 0) == 0;
  const bool amplitude = field.rfind("amplitude", 0) == 0;
  if (field == "frame") {
    return refuse(finding.status, field, "\"world\"", "\"robot\" with net \"speed-errors\"");
  }
  std::string rule = number_text(finding.range.low);
  if (field == "gains") {
    rule += " for ki and kd of x and theta with net \"speed-errors\"";
  } else if (speed_gain) {
    rule += " unless net is \"speed-errors\"";
  } else if (amplitude) {
    rule += " with activation \"linear\"";
  } else {
    rule += " unless form is \"positional\" and allocation \"decoupled\"";
  }
  return refuse(finding.status, field, number_text(finding.value), rule);
}

NFOPIDN_HOST Outcome explain_consistency(const ControllerDesign& design) {
  const Finding tracking = check_tracking_law<double>(design);
  if (tracking.status != Status::ok) return explain_tracking_law(tracking);
  const Finding finding = check_consistency(design);
  if (finding.status == Status::ok) return {};
  if (design.needs_tracking_law()) {
    return {finding.status,
            "free taps and a memory beyond " + std::to_string(maximum_memory) +
                " run eq. 34 alone; net, amplitudes, poles and integrals must be at their "
                "defaults, and lateral must not be \"scheduled\""};
  }
  return refuse(
      finding.status, finding.field, number_text(finding.value),
      range_text(finding.range) + " with a memory beyond " + std::to_string(maximum_memory));
}

NFOPIDN_HOST Outcome explain_sample_time(const ControllerSettings<double>& settings, double dt) {
  const Finding finding = check_sample_time(settings, dt);
  if (finding.status == Status::ok) return {};
  return {finding.status, "sample_time of the controller is " + number_text(finding.value) +
                              " s; must be the scenario's dt, " + number_text(dt) +
                              " s (nfopidn.fractional.retune converts gains)"};
}

NFOPIDN_HOST std::string explain_robot(const ControllerDesign& design, const Robot<double>& robot) {
  std::string text;
  if (!design.robot) return text;
  Robot<double>::fields([&](const auto& field) {
    const double own = (*design.robot).*field.member;
    const double there = robot.*field.member;
    if (std::abs(there / own - 1) <= robot_tolerance + 1e-9) return;
    text += (text.empty() ? "the controller is made for another robot: its " : ", its ") +
            std::string(field.name) + " is " + number_text(own) + " " + field.unit +
            ", the scenario's " + number_text(there);
  });
  return text;
}

NFOPIDN_HOST Outcome read_design_robot(const Json& document, std::optional<Robot<double>>& robot) {
  robot.reset();
  const auto found = document.find("robot");
  if (found == document.end() || found->is_null()) return {};
  Robot<double> given;
  Outcome outcome = read_settings(*found, "robot", given);
  if (outcome) robot = given;
  return outcome;
}

NFOPIDN_HOST Outcome read_controller(const Json& document, ControllerDesign& result) {
  if (Outcome outcome = json::check_header(document, controller_format, controller_version);
      !outcome) {
    return outcome;
  }
  ControllerDesign design = result;
  design.taps.clear();
  design.sample_time = {};  // a document's gains are not those of `result`
  const auto taps = document.find("taps");
  if (taps != document.end()) {
    for (const char* key : fused_fields) {
      if (document.contains(key)) {
        return {Status::inconsistent, std::string(key) + " stands beside taps; leave out one"};
      }
    }
    if (taps->is_array() && !taps->empty() && (*taps)[0].is_array()) {
      design.memory = static_cast<int>((*taps)[0].size()) - 2;
    }
  }
  if (document["version"] == 1 && document.contains("sample_time")) {
    return {Status::inconsistent, "sample_time is known from version 2 on; version is 1"};
  }
  ControllerSettings<double>& settings = design;
  // What a verdict says of the controller is for those who ask for it: nfopidn.robustness.
  Outcome outcome =
      read_settings(document, "", settings, {"format", "version", "taps", "robot", "verdict"});
  if (outcome) outcome = read_design_robot(document, design.robot);
  if (outcome && taps != document.end()) outcome = read_taps(*taps, design);
  if (outcome) outcome = explain_consistency(design);
  if (outcome) result = std::move(design);
  return outcome;
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_IO
