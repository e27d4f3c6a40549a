// L3. The methods of search: the one list from which Python, the executable and the tests have
// their names, options and defaults.
//
// A method M has
//   M::name                      what it is called in calls, options and files
//   M::Options                   settings with fields(), of a type of their own
//   M::default_budget            evaluations where none are given; unlimited_budget if it has a
//                                schedule that ends
//   M(search, options).run()     searches until search.done(), or until its schedule is complete
// and, where its options have rules beyond the ranges of single fields, two functions beside them:
//   check_options(options)       what is wrong
//   rule_of(options)             what must be, in words, where that finding is `inconsistent`
#pragma once

#include <optional>
#include <string_view>
#include <tuple>
#include <variant>

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/search/bfoa.hpp"
#include "nfopidn/search/bfoa_plus.hpp"
#include "nfopidn/search/cma_es.hpp"

namespace nfopidn {

// The first one is the default.
using Methods = std::tuple<BfoaPlus, Bfoa, CmaEs>;

template <class Options>
Finding check_options(const Options& options) {
  return check_ranges(options);
}
template <class Options>
const char* rule_of(const Options& /*options*/) {
  return "";
}

namespace detail {

template <class List>
struct MethodList;
template <class... Each>
struct MethodList<std::tuple<Each...>> {
  using Options = std::variant<typename Each::Options...>;
  template <class Visit>
  static void visit(const Visit& visit) {
    (visit(static_cast<const Each*>(nullptr)), ...);
  }
};

}  // namespace detail

// The options of a method, which tell which one it is. By default those of the first method.
using MethodOptions = detail::MethodList<Methods>::Options;

// Calls visit() with a null pointer to each method, in order: only its type counts.
template <class Visit>
void for_each_method(const Visit& visit) {
  detail::MethodList<Methods>::visit(visit);
}
template <class Pointer>
using MethodOf = std::remove_cv_t<std::remove_pointer_t<Pointer>>;

// Calls act(null pointer to the method, its options).
template <class Act, std::size_t index = 0>
decltype(auto) with_method(const MethodOptions& options, const Act& act) {
  if constexpr (index + 1 < std::tuple_size_v<Methods>) {
    if (options.index() != index) return with_method<Act, index + 1>(options, act);
  }
  return act(static_cast<const std::tuple_element_t<index, Methods>*>(nullptr),
             std::get<index>(options));
}

// The default options of the method of that name, if there is one.
NFOPIDN_HOST std::optional<MethodOptions> method_named(std::string_view name);

NFOPIDN_HOST const char* name_of(const MethodOptions& options);

NFOPIDN_HOST std::int64_t default_budget(const MethodOptions& options);

NFOPIDN_HOST void run_method(SearchSession& search, const MethodOptions& options);

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_SEARCH

namespace nfopidn {

NFOPIDN_HOST std::optional<MethodOptions> method_named(std::string_view name) {
  std::optional<MethodOptions> found;
  for_each_method([&](auto* method) {
    using Method = MethodOf<decltype(method)>;
    if (name == Method::name) found = typename Method::Options{};
  });
  return found;
}

NFOPIDN_HOST const char* name_of(const MethodOptions& options) {
  return with_method(options,
                     [](auto* method, const auto&) { return MethodOf<decltype(method)>::name; });
}

NFOPIDN_HOST std::int64_t default_budget(const MethodOptions& options) {
  return with_method(options, [](auto* method, const auto&) {
    return MethodOf<decltype(method)>::default_budget;
  });
}

NFOPIDN_HOST void run_method(SearchSession& search, const MethodOptions& options) {
  with_method(options, [&](auto* method, const auto& own) {
    MethodOf<decltype(method)>(search, own).run();
  });
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_SEARCH
