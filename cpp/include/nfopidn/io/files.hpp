// L4. Files: read as a whole, written atomically.
#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/io/json_controller.hpp"
#include "nfopidn/io/json_scenario.hpp"

namespace nfopidn {

NFOPIDN_HOST Outcome file_fault(const std::string& path, const char* what);

NFOPIDN_HOST bool file_exists(const std::string& path);

// No document or table that is meant is as large: 10 million samples take some 0.6 GB.
constexpr std::size_t largest_file = std::size_t{1} << 30;  // [bytes]

// A text, from a file or a pipe. What has no end, such as /dev/zero, is refused before it fills the
// memory: it holds bytes 0, which no text has, or is too large.
NFOPIDN_HOST Outcome read_file(const std::string& path, std::string& text,
                               std::size_t largest = largest_file);

// Which of this process's descriptors a name such as /dev/stdout or /dev/fd/3 stands for, -1 if it
// is another file's. What it leads to, such as a log, must be appended to, not replaced.
NFOPIDN_HOST int descriptor_of(const std::string& path);

// Where what is written to a name goes.
struct OutputTarget {
  std::string path;         // of a link the file that it points to, which is replaced
  int descriptor = -1;      // of a name such as /dev/stdout, which is written on
  bool is_special = false;  // a pipe or a device, written directly
  std::string draft;        // once it is open, the file that is written in its stead

  bool is_direct() const { return descriptor >= 0 || is_special; }
  // For what is not written directly, a draft of a name that nobody else has, in no process.
  std::FILE* open();
  // The draft takes the name, and the mode of what had it, which is kept under another name if one
  // is given: the name itself always stands for one of the two.
  bool replace(const std::string& previous) const;

 private:
  // Best effort: what is new must not be lost for it.
  void keep_as(const std::string& previous) const;
};

// On failure errno tells why, as after write_file() and check_writable().
NFOPIDN_HOST bool find_target(const std::string& path, OutputTarget& target);

NFOPIDN_HOST Outcome unwritable(const std::string& path);

// Whether write_file() could write a file, before the work that it is to hold. Leaves nothing.
NFOPIDN_HOST Outcome check_writable(const std::string& path);

// Writes a file atomically: it takes its name when all of it is there, and what had the
// name before then goes. A name that stands for no regular file, or for an open one (a pipe,
// /dev/stdout), is written directly. With `previous`, what had the name before is kept as that.
NFOPIDN_HOST Outcome write_file(const std::string& path, const std::string& content,
                                const std::string& previous = {});

// A document from a file; messages begin with the file's name.
template <class Settings, class Reader>
Outcome load_document(const std::string& path, const Reader& reader, Settings& result) {
  std::string text;
  if (Outcome outcome = read_file(path, text); !outcome) return outcome;
  Json document;
  Outcome outcome = parse_json(text, document);
  if (outcome) outcome = reader(document, result);
  if (!outcome) outcome.message = path + ": " + outcome.message;
  return outcome;
}

NFOPIDN_HOST Outcome load_controller(const std::string& path, ControllerDesign& result);

NFOPIDN_HOST Outcome load_scenario(const std::string& path, Scenario& result);

NFOPIDN_HOST std::string document_text(const Json& document);

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_IO

namespace nfopidn {

NFOPIDN_HOST Outcome file_fault(const std::string& path, const char* what) {
  return {Status::inconsistent, path + ": " + what + ": " + std::strerror(errno)};
}

NFOPIDN_HOST bool file_exists(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

NFOPIDN_HOST Outcome read_file(const std::string& path, std::string& text, std::size_t largest) {
  errno = 0;
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) errno = EISDIR;
  std::ifstream stream(path, std::ios::binary);
  if (errno == EISDIR || !stream) return file_fault(path, "cannot be read");
  text.clear();
  std::vector<char> piece(std::size_t{1} << 16);
  while (stream) {
    stream.read(piece.data(), static_cast<std::streamsize>(piece.size()));
    const auto count = static_cast<std::size_t>(stream.gcount());
    if (stream.bad()) return file_fault(path, "cannot be read");
    if (std::memchr(piece.data(), 0, count) != nullptr) {
      const std::string start = text.append(piece.data(), count).substr(0, 2);
      if (start == "\xFF\xFE" || start == "\xFE\xFF") {
        return {Status::not_a_choice,
                path + ": is text in UTF-16, as some spreadsheets write it; must be in UTF-8"};
      }
      return {Status::not_a_choice, path + ": holds a byte 0; must be text in UTF-8"};
    }
    if (text.size() + count > largest) {
      return {Status::out_of_range, path + ": is larger than " + std::to_string(largest) +
                                        " bytes, the most that is read"};
    }
    text.append(piece.data(), count);
  }
  return {};
}

NFOPIDN_HOST int descriptor_of(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code failed;
  const fs::path own = "/proc/" + std::to_string(::getpid()) + "/fd";
  fs::path name = fs::absolute(path, failed);
  for (int links = 0; links < 40 && !failed; ++links) {
    const fs::path folder = fs::canonical(name.parent_path(), failed);
    const std::string last = name.filename().string();
    if (!failed && folder == own) {
      const bool is_number = last.find_first_not_of("0123456789") == std::string::npos;
      return is_number && !last.empty() && last.size() < 10 ? std::stoi(last) : -1;
    }
    if (failed || !fs::is_symlink(folder / last, failed)) return -1;
    const fs::path target = fs::read_symlink(folder / last, failed);
    name = target.is_absolute() ? target : folder / target;
  }
  return -1;
}

NFOPIDN_HOST std::FILE* OutputTarget::open() {
  if (descriptor >= 0) {
    const int own = ::dup(descriptor);
    return own < 0 ? nullptr : ::fdopen(own, "wb");
  }
  if (is_special) return std::fopen(path.c_str(), "wb");
  static std::atomic<unsigned> drafts{0};
  for (;;) {
    draft = path + ".part" + std::to_string(::getpid()) + "-" + std::to_string(drafts++);
    const int own = ::open(draft.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (own >= 0) return ::fdopen(own, "wb");
    if (errno != EEXIST) return nullptr;
  }
}

NFOPIDN_HOST bool OutputTarget::replace(const std::string& previous) const {
  std::error_code ignored;
  const auto before = std::filesystem::status(path, ignored);
  if (std::filesystem::exists(before)) {
    std::filesystem::permissions(draft, before.permissions(), ignored);
    if (!previous.empty()) keep_as(previous);
  }
  return std::rename(draft.c_str(), path.c_str()) == 0;
}

NFOPIDN_HOST void OutputTarget::keep_as(const std::string& previous) const {
  const std::string linked = draft + "p";
  std::error_code failed;
  std::filesystem::create_hard_link(path, linked, failed);
  if (failed) std::filesystem::copy_file(path, linked, failed);
  if (failed || std::rename(linked.c_str(), previous.c_str()) != 0) std::remove(linked.c_str());
}

NFOPIDN_HOST bool find_target(const std::string& path, OutputTarget& target) {
  namespace fs = std::filesystem;
  target.path = path;
  target.descriptor = descriptor_of(path);
  if (target.descriptor >= 0) {
    const int flags = ::fcntl(target.descriptor, F_GETFL);
    if (flags >= 0 && (flags & O_ACCMODE) == O_RDONLY) errno = EBADF;
    return flags >= 0 && (flags & O_ACCMODE) != O_RDONLY;
  }
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  if (fs::is_directory(status)) {
    errno = EISDIR;
    return false;
  }
  if (fs::exists(status) && ::access(path.c_str(), W_OK) != 0) return false;
  target.is_special = fs::exists(status) && !fs::is_regular_file(status);
  if (target.is_special || !fs::is_symlink(fs::symlink_status(path, ignored))) return true;
  std::error_code failed;
  target.path = fs::weakly_canonical(path, failed).string();
  errno = failed.value();  // of links that lead to each other
  return !failed;
}

NFOPIDN_HOST Outcome unwritable(const std::string& path) {
  return file_fault(path, "cannot be written");
}

NFOPIDN_HOST Outcome check_writable(const std::string& path) {
  OutputTarget target;
  if (!find_target(path, target)) return unwritable(path);
  if (target.is_direct()) return {};
  std::FILE* const file = target.open();
  if (file == nullptr) return unwritable(path);
  std::fclose(file);
  std::remove(target.draft.c_str());
  return {};
}

NFOPIDN_HOST Outcome write_file(const std::string& path, const std::string& content,
                                const std::string& previous) {
  OutputTarget target;
  if (!find_target(path, target)) return unwritable(path);
  std::FILE* const file = target.open();
  if (file == nullptr) return unwritable(path);
  const bool written = std::fwrite(content.data(), 1, content.size(), file) == content.size() &&
                       std::fflush(file) == 0 &&
                       (target.is_direct() || ::fsync(::fileno(file)) == 0);
  const int reason = errno;
  const bool closed = std::fclose(file) == 0;
  if (!written) errno = reason;
  const bool done = written && closed && (target.is_direct() || target.replace(previous));
  if (done) return {};
  const int why = errno;
  if (!target.is_direct()) std::remove(target.draft.c_str());
  errno = why;
  return unwritable(path);
}

NFOPIDN_HOST Outcome load_controller(const std::string& path, ControllerDesign& result) {
  return load_document(path, read_controller, result);
}

NFOPIDN_HOST Outcome load_scenario(const std::string& path, Scenario& result) {
  return load_document(path, read_scenario, result);
}

NFOPIDN_HOST std::string document_text(const Json& document) { return document.dump(2) + "\n"; }

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_IO
