// L3. What a search is told besides its objective and its box.
#pragma once

#include "nfopidn/search/method.hpp"

namespace nfopidn {

struct SearchSettings {
  MethodOptions method = {};  // bfoa+ with its default options
  SearchLimits limits = {default_budget({})};
  std::uint64_t seed = 0;
};

}  // namespace nfopidn
