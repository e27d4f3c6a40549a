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

// A file that appears under its name only when commit() has written all of it: a run that is
// interrupted leaves the old file. open() finds out before the work whether it can be written.
// A name that stands for no regular file (/dev/stdout, a pipe) is written directly.
class OutputFile {
 public:
  OutputFile() = default;
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  ~OutputFile() {
    if (file_ != nullptr) std::fclose(file_);
    if (!temporary_.empty()) std::remove(temporary_.c_str());
  }

  Outcome open(const std::string& path) {
    path_ = path;
    std::error_code ignored;
    const auto status = std::filesystem::status(path, ignored);
    const bool special =
        std::filesystem::exists(status) && !std::filesystem::is_regular_file(status);
    std::string target = path;
    if (!special) {
      // A link is followed, so that the file it points to is replaced, and not the link.
      if (std::filesystem::is_symlink(std::filesystem::symlink_status(path, ignored))) {
        path_ = std::filesystem::weakly_canonical(path, ignored).string();
        if (path_.empty()) path_ = path;
      }
      target = path_ + ".part" + std::to_string(::getpid());
    }
    errno = 0;
    if (std::filesystem::exists(status) && ::access(path.c_str(), W_OK) != 0) {
      return file_fault(path, "cannot be written");
    }
    file_ = std::fopen(target.c_str(), "wb");
    if (file_ == nullptr) return file_fault(path, "cannot be written");
    if (!special) {
      temporary_ = target;
      if (std::filesystem::exists(status)) {
        std::filesystem::permissions(target, status.permissions(), ignored);
      }
    }
    return {};
  }

  Outcome commit(const std::string& content) {
    errno = 0;
    const bool written = std::fwrite(content.data(), 1, content.size(), file_) == content.size() &&
                         std::fflush(file_) == 0 &&
                         (temporary_.empty() || ::fsync(::fileno(file_)) == 0);
    const bool closed = std::fclose(file_) == 0;
    file_ = nullptr;
    if (!written || !closed) return file_fault(path_, "cannot be written");
    if (temporary_.empty()) return {};
    if (std::rename(temporary_.c_str(), path_.c_str()) != 0) {
      return file_fault(path_, "cannot be written");
    }
    temporary_.clear();
    return {};
  }

 private:
  std::string path_;
  std::string temporary_;
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
