// Work divided among processes that see one folder and cannot talk.
#pragma once
#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/shared_work.h"

namespace glowworm {

/// Keeps each piece of the work as a file of the folder. A process that makes a piece holds a claim: a file that it
/// touches again and again, and removes at the end. A claim whose time of change stays the same while another process
/// waits belongs to a dead process, and the other takes it over; clocks are not compared. Two processes may still make
/// the same piece: claims save work, and pieces are the same bytes whatever process makes them.
///
/// Files that are damaged are made again, with a warning. If the folder cannot be written, the first failure is a
/// warning, and this process makes what it does not find.
class ShareFolder : public SharedWork {
 public:
  /// Seconds between touches of a claim, until a claim that does not change is taken over, and between looks at it.
  struct Times {
    double touch, stale, look;
  };
  static constexpr Times kTimes{2, 10, 0.2};

  /// @param folder is made if it does not exist
  /// @param key    of all that determines the pieces; other keys have other subfolders
  ShareFolder(const std::string& folder, std::string key, Times times = kTimes);
  ~ShareFolder() override;

  /// Makes a piece again for which `take` throws InvalidArchive.
  void divide(const std::string& name, std::size_t count, const Make& make, const Take& take) override;

  /// Whether divide() waits for other processes; any thread may ask.
  bool is_waiting() const { return waiting_; }
  /// Pieces that this process has made, and that it has read.
  std::uint64_t made() const { return made_; }
  std::uint64_t read() const { return read_; }
  /// The subfolder of this key.
  const std::string& folder() const { return folder_; }

 private:
  using Clock = std::chrono::steady_clock;
  class Claim;
  class Division;
  /// What changes with a file's content.
  struct FileState {
    std::uint64_t inode = 0;
    std::int64_t seconds = 0, nanoseconds = 0;  // of its time of change
    bool operator==(const FileState&) const = default;
  };
  /// A claim of another process, and when this process first saw it in this state.
  struct Sight {
    FileState state;
    Clock::time_point since;
  };

  /// The claim, unless a living process holds it.
  std::unique_ptr<Claim> claim(const std::string& path);
  static std::optional<FileState> state_of(const std::string& path);
  /// Whether the claim of another process has not changed for too long.
  bool is_stale(const std::string& path);
  std::optional<std::vector<std::byte>> read_piece(const std::string& path, const std::string& title);
  void write_piece(const std::string& path, const std::string& title, std::span<const std::byte> bytes);
  void fail(const std::string& what);

  std::string key_, folder_;
  Times times_;
  bool writable_ = true;
  std::map<std::string, Sight> sights_;
  std::map<std::string, FileState> damaged_;
  std::atomic<bool> waiting_{false};
  std::uint64_t made_ = 0, read_ = 0;
};

}  // namespace glowworm
