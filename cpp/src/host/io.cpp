// JSON documents, tables, checkpoints and other files.
#define NFOPIDN_DEFINES_IO
#include "nfopidn/io/checkpoint.hpp"
#include "nfopidn/io/json_method.hpp"
#include "nfopidn/io/json_rival.hpp"
#include "nfopidn/io/options.hpp"

namespace nfopidn {

template Json write_settings(const ControllerSettings<double>&);
template Outcome read_settings(const Json&, const std::string&, ControllerSettings<double>&,
                               const std::vector<std::string>&);
template Json write_settings(const Robot<double>&);
template Outcome read_settings(const Json&, const std::string&, Robot<double>&,
                               const std::vector<std::string>&);
template Json write_settings(const Scenario&);
template Outcome read_settings(const Json&, const std::string&, Scenario&,
                               const std::vector<std::string>&);
template Json write_settings(const TrajectorySettings&);
template Outcome read_settings(const Json&, const std::string&, TrajectorySettings&,
                               const std::vector<std::string>&);

}  // namespace nfopidn
