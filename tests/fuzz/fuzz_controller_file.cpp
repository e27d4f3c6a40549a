// Any bytes as a controller file.
#include "documents.hpp"
#include "nfopidn/io/json_controller.hpp"

using namespace nfopidn;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  ControllerDesign start;
  start.memory = 3;
  start.gains[1][2] = 0.125;
  ControllerDesign design;
  if (fuzz::check_document(fuzz::text_of(data, size), read_controller, write_controller, start,
                           design)) {
    const std::size_t taps = design.taps.size();
    fuzz::require(design.validate() == Status::ok, "accepted settings are in range");
    fuzz::require(
        taps == 0 || taps == channel_count * (static_cast<std::size_t>(design.memory) + 2),
        "free taps are as many as the memory says");
    for (const double tap : design.taps) {
      fuzz::require(tap_range.contains(tap), "accepted taps are in range");
    }
  }
  return 0;
}
