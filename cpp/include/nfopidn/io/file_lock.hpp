// L4. A file that one search at a time may have.
#pragma once

#include <sys/stat.h>

#include <mutex>
#include <set>

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/io/files.hpp"

namespace nfopidn {

// Holds a file against other processes and other threads, by a lock on an empty file beside it with
// the suffix .lock. It goes with its holder, also with one that is killed; the empty file stays
// then.
class FileLock {
 public:
  FileLock() = default;
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;
  ~FileLock() { release(); }

  // Refused while another has it.
  Outcome take(const std::string& path);

  void release();

 private:
  // The names that this process has locked.
  class Names {
   public:
    bool add(const std::string& name) {
      const std::lock_guard<std::mutex> lock(mutex_);
      return names_.insert(name).second;
    }
    void drop(const std::string& name) {
      const std::lock_guard<std::mutex> lock(mutex_);
      names_.erase(name);
    }

   private:
    std::mutex mutex_;
    std::set<std::string> names_;
  };
  static Names& held();

  static Outcome in_use(const std::string& path, ::pid_t process);

  // Again where another has removed the file in between.
  Outcome lock(const std::string& path);

  std::string name_;  // empty: nothing is held
  int file_ = -1;
  ::pid_t process_ = 0;
};

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_IO

namespace nfopidn {

NFOPIDN_HOST Outcome FileLock::take(const std::string& path) {
  OutputTarget target;
  if (!find_target(path, target)) return unwritable(path);
  std::error_code failed;
  const std::filesystem::path place = std::filesystem::weakly_canonical(target.path, failed);
  const std::string name = (failed ? target.path : place.string()) + ".lock";
  // Threads first: a process that closes a file loses its locks on it, whoever took them.
  if (!held().add(name)) return in_use(path, ::getpid());
  name_ = name;
  process_ = ::getpid();
  Outcome outcome = lock(path);
  if (!outcome) release();
  return outcome;
}

NFOPIDN_HOST void FileLock::release() {
  if (name_.empty() || process_ != ::getpid()) return;  // a fork's copy holds nothing
  if (file_ >= 0) {
    std::remove(name_.c_str());
    ::close(std::exchange(file_, -1));
  }
  held().drop(std::exchange(name_, {}));
}

NFOPIDN_HOST Outcome FileLock::in_use(const std::string& path, ::pid_t process) {
  const std::string who =
      process == ::getpid() ? "another thread" : "process " + std::to_string(process);
  return {Status::inconsistent,
          path + ": is in use by " + who + "; give another path, or wait until that is done"};
}

NFOPIDN_HOST Outcome FileLock::lock(const std::string& path) {
  for (;;) {
    const int file = ::open(name_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (file < 0) return unwritable(path);
    struct flock whole = {};
    whole.l_type = F_WRLCK;
    whole.l_whence = SEEK_SET;
    const bool locked = ::fcntl(file, F_SETLK, &whole) == 0;
    const bool refused = !locked && (errno == EACCES || errno == EAGAIN);
    if (refused) {
      const bool told = ::fcntl(file, F_GETLK, &whole) == 0 && whole.l_type != F_UNLCK;
      ::close(file);
      if (told) return in_use(path, whole.l_pid);
      continue;  // let go meanwhile
    }
    struct stat own = {}, there = {};
    const bool same = ::fstat(file, &own) == 0 && ::stat(name_.c_str(), &there) == 0 &&
                      own.st_ino == there.st_ino && own.st_dev == there.st_dev;
    // On a file system without locks two searches can write one checkpoint.
    if (same) {
      file_ = file;
      return {};
    }
    ::close(file);
  }
}

NFOPIDN_HOST FileLock::Names& FileLock::held() {
  static Names names;
  return names;
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_IO
