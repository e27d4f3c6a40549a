// The command: runs a scenario under a controller. The executable nfopidn_sim and the Python
// command `nfopidn simulate` are this function under two names.
#pragma once

#include <string>
#include <vector>

namespace nfopidn::commands {

// Does what the words of the command line ask for, under the program's name; the exit code. While
// it searches, it handles SIGINT and SIGTERM of the process.
int run_simulate(const std::string& program, const std::vector<std::string>& words);

}  // namespace nfopidn::commands
