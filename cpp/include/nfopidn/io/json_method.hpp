// L4. A search's method and its options as JSON.
#pragma once

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/io/json.hpp"
#include "nfopidn/search/method.hpp"

namespace nfopidn {

namespace json {

// What read_settings() does not know of: rules of several fields, or of more than a range.
template <class Options>
Outcome explain_options(const Options& options) {
  const Finding finding = check_options(options);
  if (finding.status != Status::inconsistent) return {};
  return refuse(finding.status, finding.field, number_text(finding.value), rule_of(options));
}

}  // namespace json

// Fills the options of the method of that name; what is not given has its default.
NFOPIDN_HOST Outcome read_method(const std::string& name, const Json& given, MethodOptions& result);

NFOPIDN_HOST Json write_options(const MethodOptions& options);

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_IO

namespace nfopidn {

NFOPIDN_HOST Outcome read_method(const std::string& name, const Json& given,
                                 MethodOptions& result) {
  const std::optional<MethodOptions> defaults = method_named(name);
  if (!defaults) {
    std::vector<std::string> names;
    for_each_method([&](auto* method) { names.emplace_back(MethodOf<decltype(method)>::name); });
    return refuse(Status::out_of_range, "method", name + suggestion(name, names),
                  "one of " + json::list_text(names));
  }
  result = *defaults;
  return std::visit(
      [&](auto& options) {
        const Outcome outcome = read_settings(given, "", options);
        return outcome ? json::explain_options(options) : outcome;
      },
      result);
}

NFOPIDN_HOST Json write_options(const MethodOptions& options) {
  return std::visit([](const auto& own) { return write_settings(own); }, options);
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_IO
