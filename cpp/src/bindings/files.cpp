// Files that the Python side writes, as the core writes its own.
#include "nfopidn/io/files.hpp"

#include "bindings.hpp"

namespace nfopidn::python {

namespace {

// Raises OSError with what errno was after action(path), if that failed.
template <class Action>
void with_os_error(const py::object& path, const Action& action) {
  const std::string name = file_name(path);
  int reason = 0;
  {
    const py::gil_scoped_release release;
    if (!action(name)) reason = errno;
  }
  if (reason == 0) return;
  errno = reason;
  PyErr_SetFromErrnoWithFilenameObject(PyExc_OSError, path.ptr());
  throw py::error_already_set();
}

}  // namespace

void bind_files(py::module_& module) {
  module.def(
      "check_writable", [](const py::object& path) { with_os_error(path, check_writable); },
      py::arg("path"));
  module.def(
      "read_text",
      [](const py::object& path) {
        std::string text;
        const Outcome outcome = read_file(file_name(path), text);
        if (outcome.status == Status::inconsistent)
          with_os_error(path, [](auto&&) { return false; });
        check("read_text", outcome);
        return text;
      },
      py::arg("path"));
  module.def(
      "write_file",
      [](const py::object& path, const std::string& content) {
        with_os_error(path, [&](const std::string& name) { return write_file(name, content); });
      },
      py::arg("path"), py::arg("content"));
}

}  // namespace nfopidn::python
