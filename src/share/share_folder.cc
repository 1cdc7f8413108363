#include "share/share_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <thread>
#include <utility>

#include "core/archive.h"
#include "core/atomic_file.h"
#include "core/content_hash.h"
#include "core/error.h"
#include "core/log.h"
#include "core/parallel.h"
#include "core/temporary_files.h"
#include "film/packed_file.h"

namespace glowworm {

namespace {

constexpr FileKind kShareFile = {'G', 'L', 'O', 'W', 'S', 'H', '0', '3'};

std::string subfolder(const std::string& key) {
  ContentHash hash;
  hash.add(std::string_view(key));
  return fmt::format("{:016x}", hash.value());
}

void tell_damaged(const std::string& path) {
  warn(fmt::format("{} is damaged, or of another version: what it should hold is made again", path));
}

}  // namespace

/// A claim of this process, touched by a thread of its own.
class ShareFolder::Claim {
 public:
  /// @param file open, and created by this process
  Claim(std::string path, int file, double touch_s)
      : path_(std::move(path)), file_(file), registered_(path_), thread_([this, touch_s] { keep_touching(touch_s); }) {}
  ~Claim() {
    {
      const std::lock_guard lock(mutex_);
      ended_ = true;
    }
    changed_.notify_all();
    thread_.join();
    // Another process that took this one for dead has a claim of the same name.
    struct stat own {
    }, there{};
    if (fstat(file_, &own) == 0 && stat(path_.c_str(), &there) == 0 && own.st_ino == there.st_ino)
      unlink(path_.c_str());
    close(file_);
  }
  Claim(const Claim&) = delete;
  Claim& operator=(const Claim&) = delete;

 private:
  void keep_touching(double touch_s) {
    std::unique_lock lock(mutex_);
    while (!changed_.wait_for(lock, std::chrono::duration<double>(touch_s), [this] { return ended_; }))
      futimens(file_, nullptr);
  }

  std::string path_;
  int file_;
  TemporaryName registered_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool ended_ = false;
  std::thread thread_;  // the last member, because it uses the others
};

/// One call of divide().
class ShareFolder::Division {
 public:
  Division(ShareFolder& share, const std::string& name, std::size_t count, const Make& make, const Take& take)
      : share_(share), name_(name), count_(count), make_(make), take_(take) {}

  void run() {
    for (int looks = 0; next_ < count_;) {
      check_cancelled();
      // Many processes may wait: nine of ten looks are for the next piece alone.
      if (take_next() || make_any(looks % 10 == 0 ? count_ : next_ + 1)) {
        looks = 0;
        continue;
      }
      ++looks;
      share_.waiting_ = true;
      std::this_thread::sleep_for(std::chrono::duration<double>(share_.times_.look));
    }
    share_.waiting_ = false;
  }

 private:
  std::string path_of(std::size_t piece, const char* ending) const {
    return fmt::format("{}/{}.{}-of-{}.{}", share_.folder_, name_, piece + 1, count_, ending);
  }
  /// What the file of a piece says of itself.
  std::string title_of(std::size_t piece) const {
    return fmt::format("{}\n{} {} of {}", share_.key_, name_, piece + 1, count_);
  }
  bool is_there(std::size_t piece) const {
    const std::string path = path_of(piece, "share");
    const std::optional<FileState> state = state_of(path);
    const auto damaged = share_.damaged_.find(path);
    return state && (damaged == share_.damaged_.end() || damaged->second != *state);
  }

  /// Takes the next piece if it is there.
  bool take_next() {
    if (const auto own = own_.find(next_); own != own_.end()) {
      take_(next_, own->second);
      own_.erase(own);
    } else {
      if (!is_there(next_)) return false;
      const auto bytes = share_.read_piece(path_of(next_, "share"), title_of(next_));
      if (!bytes) return false;
      try {
        take_(next_, *bytes);
      } catch (const InvalidArchive&) {
        const std::string path = path_of(next_, "share");
        tell_damaged(path);
        share_.damaged_[path] = state_of(path).value_or(FileState());
        return false;
      }
      ++share_.read_;
    }
    ++next_;
    return true;
  }

  /// Makes the first piece before `end` that no other process makes or has made. Returns whether there was one.
  bool make_any(std::size_t end) {
    for (std::size_t piece = next_; piece < end; ++piece) {
      if (own_.contains(piece) || is_there(piece)) continue;
      std::unique_ptr<Claim> claim;
      if (share_.writable_) claim = share_.claim(path_of(piece, "claim"));
      if (share_.writable_ && !claim) continue;
      // The claim's last holder may just have finished.
      if (!is_there(piece)) make(piece);
      return true;
    }
    return false;
  }

  void make(std::size_t piece) {
    share_.waiting_ = false;
    std::vector<std::byte> bytes = make_(piece);
    ++share_.made_;
    if (share_.writable_) share_.write_piece(path_of(piece, "share"), title_of(piece), bytes);
    own_[piece] = std::move(bytes);
  }

  ShareFolder& share_;
  const std::string& name_;
  std::size_t count_;
  const Make& make_;
  const Take& take_;
  std::size_t next_ = 0;                               // to take
  std::map<std::size_t, std::vector<std::byte>> own_;  // made here, and not yet taken
};

ShareFolder::ShareFolder(const std::string& folder, std::string key, Times times)
    : key_(std::move(key)), folder_(folder + "/" + subfolder(key_)), times_(times) {
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (error) fail(fmt::format("{}: cannot make the folder: {}", folder_, error.message()));
}

ShareFolder::~ShareFolder() = default;

void ShareFolder::divide(const std::string& name, std::size_t count, const Make& make, const Take& take) {
  Division(*this, name, count, make, take).run();
}

void ShareFolder::fail(const std::string& what) {
  if (writable_) warn(fmt::format("{}. The render goes on, but what it makes is not shared with others", what));
  writable_ = false;
}

std::unique_ptr<ShareFolder::Claim> ShareFolder::claim(const std::string& path) {
  // O_EXCL asks the server of a network file system, whatever this machine remembers of the folder.
  int file = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (file < 0 && errno == EEXIST && is_stale(path)) {
    if (unlink(path.c_str()) != 0 && errno != ENOENT)
      fail(fmt::format("{}: cannot be removed: {}", path, std::strerror(errno)));
    sights_.erase(path);
    file = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  }
  if (file >= 0) return std::make_unique<Claim>(path, file, times_.touch);
  if (errno != EEXIST) fail(fmt::format("{}: {}", path, std::strerror(errno)));
  return nullptr;
}

std::optional<ShareFolder::FileState> ShareFolder::state_of(const std::string& path) {
  // Opening asks a network file system for the file's present state.
  struct stat info {};
  const int file = open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  const bool known = (file >= 0 ? fstat(file, &info) : stat(path.c_str(), &info)) == 0;
  if (file >= 0) close(file);
  if (!known) return std::nullopt;
  return FileState{info.st_ino, info.st_mtim.tv_sec, info.st_mtim.tv_nsec};
}

bool ShareFolder::is_stale(const std::string& path) {
  const std::optional<FileState> state = state_of(path);
  if (!state) return false;
  const Clock::time_point now = Clock::now();
  Sight& before = sights_.try_emplace(path, Sight{*state, now}).first->second;
  if (before.state != *state) before = {*state, now};
  return std::chrono::duration<double>(now - before.since).count() >= times_.stale;
}

std::optional<std::vector<std::byte>> ShareFolder::read_piece(const std::string& path, const std::string& title) {
  std::error_code error;
  // A pipe would block.
  if (std::filesystem::is_regular_file(path, error)) {
    std::ifstream file(path, std::ios::binary);
    const std::optional<std::string> header = read_header(file, kShareFile, std::filesystem::file_size(path, error));
    PackedReader packed(file);
    std::uint64_t size = 0;
    if (header == title && packed.read(std::as_writable_bytes(std::span(&size, 1)))) {
      std::vector<std::byte> bytes;
      bool whole = true;
      // A damaged size may be anything.
      while (whole && bytes.size() < size) {
        const std::size_t before = bytes.size();
        bytes.resize(before + std::min<std::uint64_t>(size - before, std::uint64_t{1} << 24));
        whole = packed.read(std::span(bytes).subspan(before));
      }
      if (whole && packed.at_end()) return bytes;
    }
  }
  tell_damaged(path);
  damaged_[path] = state_of(path).value_or(FileState());
  return std::nullopt;
}

void ShareFolder::write_piece(const std::string& path, const std::string& title, std::span<const std::byte> bytes) {
  try {
    AtomicFile file(path);
    write_header(file, kShareFile, title);
    PackedWriter packed(file);
    const std::uint64_t size = bytes.size();
    packed.write(std::as_bytes(std::span(&size, 1)));
    packed.write(bytes);
    packed.finish();
    file.commit();
  } catch (const Error& error) {
    fail(error.what());
  }
}

}  // namespace glowworm
