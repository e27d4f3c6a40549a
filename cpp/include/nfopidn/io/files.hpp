// L4. Files: read whole, written whole or not at all.
#pragma once

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>

#include "nfopidn/io/json_controller.hpp"

namespace nfopidn {

inline Outcome file_fault(const std::string& path, const char* what) {
  return {Status::inconsistent, path + ": " + what + ": " + std::strerror(errno)};
}

inline bool file_exists(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

inline Outcome read_file(const std::string& path, std::string& text) {
  errno = 0;
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) errno = EISDIR;
  std::ifstream stream(path, std::ios::binary);
  if (errno == EISDIR || !stream) return file_fault(path, "cannot be read");
  std::ostringstream content;
  content << stream.rdbuf();
  if (stream.bad()) return file_fault(path, "cannot be read");
  text = content.str();
  return {};
}

// Which of this process's descriptors a name such as /dev/stdout or /dev/fd/3 stands for, -1 if it
// is another file's. What it leads to, a log perhaps, must be written on and not anew.
inline int descriptor_of(const std::string& path) {
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

// A file that appears under its name only when commit() has written all of it: a run that is
// interrupted leaves the old file. open() finds out before the work whether it can be written.
// A name that stands for no regular file, or for an open one (a pipe, /dev/stdout), is written
// directly.
class OutputFile {
 public:
  OutputFile() = default;
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  ~OutputFile() {
    if (file_ != nullptr) std::fclose(file_);
    if (!draft_.empty()) std::remove(draft_.c_str());
  }

  Outcome open(const std::string& path) {
    namespace fs = std::filesystem;
    path_ = path;
    std::error_code ignored;
    errno = 0;
    if (const int descriptor = descriptor_of(path); descriptor >= 0) {
      const int own = ::dup(descriptor);
      file_ = own < 0 ? nullptr : ::fdopen(own, "wb");
      if (file_ == nullptr && own >= 0) ::close(own);
      return file_ == nullptr ? fault() : Outcome{};
    }
    const fs::file_status status = fs::status(path, ignored);
    if (fs::exists(status) && ::access(path.c_str(), W_OK) != 0) return fault();
    if (fs::exists(status) && !fs::is_regular_file(status)) {
      file_ = std::fopen(path.c_str(), "wb");
      return file_ == nullptr ? fault() : Outcome{};
    }
    // A link is followed, so that the file it points to is replaced, and not the link.
    if (fs::is_symlink(fs::symlink_status(path, ignored))) {
      const std::string target = fs::weakly_canonical(path, ignored).string();
      if (!target.empty()) path_ = target;
    }
    // Only tried here: a process that is killed during its work leaves nothing behind.
    return begin_draft() ? end_draft() : fault();
  }

  Outcome commit(const std::string& content) {
    errno = 0;
    const bool direct = file_ != nullptr;
    if (!direct && !begin_draft()) return fault();
    const bool written = std::fwrite(content.data(), 1, content.size(), file_) == content.size() &&
                         std::fflush(file_) == 0 && (direct || ::fsync(::fileno(file_)) == 0);
    const bool closed = std::fclose(std::exchange(file_, nullptr)) == 0;
    if (!written || !closed) return fault();
    if (direct) return {};
    std::error_code ignored;
    const auto status = std::filesystem::status(path_, ignored);
    if (std::filesystem::exists(status)) {
      std::filesystem::permissions(draft_, status.permissions(), ignored);
    }
    if (std::rename(draft_.c_str(), path_.c_str()) != 0) return fault();
    draft_.clear();
    return {};
  }

 private:
  Outcome fault() const { return file_fault(path_, "cannot be written"); }

  bool begin_draft() {
    const std::string name = path_ + ".part" + std::to_string(::getpid());
    file_ = std::fopen(name.c_str(), "wb");
    if (file_ != nullptr) draft_ = name;
    return file_ != nullptr;
  }
  Outcome end_draft() {
    std::fclose(std::exchange(file_, nullptr));
    std::remove(std::exchange(draft_, {}).c_str());
    return {};
  }

  std::string path_;
  std::string draft_;
  std::FILE* file_ = nullptr;
};

inline Outcome write_file(const std::string& path, const std::string& content) {
  OutputFile file;
  if (Outcome outcome = file.open(path); !outcome) return outcome;
  return file.commit(content);
}

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

inline Outcome load_controller(const std::string& path, ControllerDesign& result) {
  return load_document(path, read_controller, result);
}

inline Outcome load_scenario(const std::string& path, Scenario& result) {
  return load_document(path, read_scenario, result);
}

inline std::string document_text(const Json& document) { return document.dump(2) + "\n"; }

}  // namespace nfopidn
