#include "core/temporary_files.h"

#include <limits.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>

#include "core/error.h"

namespace glowworm {

// Entries form a list that only grows, and are reused, so a signal handler can walk it at any time without a lock.
struct TemporaryName::Entry {
  enum State : int { kFree, kClaimed, kLive };
  std::atomic<int> state{kClaimed};
  pid_t process = 0;  // a forked child must not remove its parent's files
  Entry* next = nullptr;
  char path[PATH_MAX];
  static std::atomic<Entry*> head;
};

std::atomic<TemporaryName::Entry*> TemporaryName::Entry::head{nullptr};
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<void*>::is_always_lock_free);

TemporaryName::TemporaryName(const std::string& path) {
  if (path.size() >= PATH_MAX) throw Error({path}, "the file name is too long", "Choose a shorter path.");
  for (entry_ = Entry::head.load(); entry_; entry_ = entry_->next) {
    int expected = Entry::kFree;
    if (entry_->state.compare_exchange_strong(expected, Entry::kClaimed)) break;
  }
  if (!entry_) {
    entry_ = new Entry;
    entry_->next = Entry::head.load();
    while (!Entry::head.compare_exchange_weak(entry_->next, entry_)) {
    }
  }
  entry_->process = getpid();
  std::memcpy(entry_->path, path.c_str(), path.size() + 1);
  entry_->state.store(Entry::kLive);
}

TemporaryName::~TemporaryName() { entry_->state.store(Entry::kFree); }

void remove_temporary_files() noexcept {
  const int saved_errno = errno;
  const pid_t process = getpid();
  for (TemporaryName::Entry* entry = TemporaryName::Entry::head.load(); entry; entry = entry->next) {
    if (entry->state.load() == TemporaryName::Entry::kLive && entry->process == process) unlink(entry->path);
  }
  errno = saved_errno;
}

namespace {
extern "C" void remove_and_end(int signal_number) {
  remove_temporary_files();
  // SA_RESETHAND has reset the handler, so this ends the program with the signal's own status.
  raise(signal_number);
}
}  // namespace

void remove_temporary_files_at_signals(std::initializer_list<int> signals) noexcept {
  for (const int number : signals) {
    struct sigaction old {};
    sigaction(number, nullptr, &old);
    if (old.sa_handler == SIG_IGN) continue;
    struct sigaction action {};
    action.sa_handler = remove_and_end;
    action.sa_flags = static_cast<int>(SA_RESETHAND);
    sigemptyset(&action.sa_mask);
    sigaction(number, &action, nullptr);
  }
}

void remove_temporary_files_at_signals() noexcept {
  remove_temporary_files_at_signals({SIGINT, SIGTERM, SIGHUP});
  signal(SIGXFSZ, SIG_IGN);
  signal(SIGPIPE, SIG_IGN);
}

}  // namespace glowworm
