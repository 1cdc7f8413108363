#include "share/crew.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <deque>
#include <future>
#include <limits>
#include <mutex>
#include <thread>

#include "core/archive.h"
#include "core/error.h"
#include "core/lines.h"
#include "core/log.h"
#include "core/parallel.h"
#include "kernels/simd.h"
#include "trace/instruction_set.h"

namespace glowworm {

namespace {

/// First byte of a message.
enum class Kind : std::uint8_t { sets, chosen, key, ask, task, result, failure, stop, bye, alive };

/// Seconds that a rank may take to load the scene, or to accept a message.
constexpr double kPatience = 600, kSendSeconds = 120;
/// Rank 0 checks the state of the render at this interval, in seconds.
constexpr double kTurn = 0.002;

template <typename... Values>
std::vector<std::byte> packed(Kind kind, const Values&... values) {
  return archived(static_cast<std::uint8_t>(kind), values...);
}

/// Reads a message. Its kind comes first.
class Unpacker {
 public:
  explicit Unpacker(const Message& message) : from_(message.from), archive_(message.bytes) {
    read([&] { transfer_enum(archive_, kind_, Kind::alive); });
  }

  Kind kind() const { return kind_; }
  template <typename T>
  T take() {
    T value{};
    read([&] { transfer(archive_, value); });
    return value;
  }

 private:
  template <typename F>
  void read(const F& f) const {
    try {
      f();
    } catch (const InvalidArchive& damage) {
      throw Error(fmt::format("a message of rank {} is damaged: {}", from_, damage.what()),
                  "Run one version of the program on all machines.");
    }
  }

  int from_;
  ArchiveReader archive_;
  Kind kind_{};
};

/// Number and machine of a rank, for messages.
std::string name_of(const Ranks& ranks, int rank) { return fmt::format("rank {} on {}", rank, ranks.host(rank)); }

/// A rank may be stopped, or its network cut. @param others what they do without it
void warn_of_late_rank(const Ranks& ranks, int rank, double seconds, const char* others) {
  warn(
      fmt::format("{} has not answered for {:g} s; others {}. Check whether its machine is overloaded or "
                  "disconnected, or its process is stopped",
                  name_of(ranks, rank), seconds, others));
}

/// Puts a result; ignores other messages.
void put_result(const Message& message, const Crew::Work& work) {
  Unpacker in(message);
  if (in.kind() != Kind::result) return;
  const auto task = in.take<TaskBytes>();
  work.put(task, in.take<TaskBytes>());
}

/// One message of a kind from every other rank, by rank; empty for ranks that report a failure instead. If none comes
/// for `late_after` seconds, warns of the ranks that are missing and leaves them empty, too.
/// @param other takes messages of other kinds
std::vector<std::string> texts_of_all(Ranks& ranks, Kind kind, double late_after,
                                      const std::function<void(const Message&)>& other) {
  std::vector<std::string> texts(static_cast<std::size_t>(ranks.count()));
  std::set<int> missing;
  for (int rank = 1; rank < ranks.count(); ++rank) missing.insert(rank);
  while (!missing.empty()) {
    const std::optional<Message> message = ranks.receive(late_after);
    if (!message) break;
    Unpacker in(*message);
    if (in.kind() == kind)
      texts[static_cast<std::size_t>(message->from)] = in.take<std::string>();
    else
      other(*message);
    if (in.kind() == kind || in.kind() == Kind::failure) missing.erase(message->from);
  }
  for (const int rank : missing) warn_of_late_rank(ranks, rank, late_after, "begin without it");
  return texts;
}

/// Callbacks of a render that takes no results.
const Crew::Work kNoWork{[] { return std::nullopt; }, [](const TaskBytes&, std::span<const std::byte>) {},
                         [](const TaskBytes&) {}, [] { return true; }};

/// The instruction sets that this rank supports, fastest first: kernels, then rays.
std::string own_sets() {
  const std::vector<std::string> all = simd_names();
  const auto first = std::find(all.begin(), all.end(), simd_name());
  return fmt::format("{}\n{}", fmt::join(first, all.end(), " "), fmt::join(ray_instruction_sets(), " "));
}

void use_sets(const std::string& chosen) {
  const std::size_t cut = chosen.find('\n');
  set_simd(chosen.substr(0, cut));
  set_ray_instruction_set(chosen.substr(cut + 1));
}

/// Tells a rank the sets that this one uses.
void tell_sets(Ranks& ranks, int rank) {
  const std::string rays = ray_instruction_set();  // its last word is the name
  ranks.send(rank, packed(Kind::chosen, simd_name() + "\n" + rays.substr(rays.rfind(' ') + 1)), kSendSeconds);
}

/// The first of the words that all texts have.
std::string best_of_all(const std::vector<std::string>& texts) {
  for (const std::string_view word : words_of(texts.front())) {
    const auto has = [&](const std::string& text) {
      const std::vector<std::string_view> words = words_of(text);
      return std::find(words.begin(), words.end(), word) != words.end();
    };
    if (std::all_of(texts.begin(), texts.end(), has)) return std::string(word);
  }
  throw Error("the ranks have no instruction set in common", "Start ranks on machines of one kind.");
}

}  // namespace

std::string agree_on_instruction_sets(Ranks& ranks, double late_after) {
  if (ranks.rank() > 0) {
    ranks.send(0, packed(Kind::sets, own_sets()), kSendSeconds);
    const std::optional<Message> message = ranks.receive(kPatience);
    if (!message) throw Error("rank 0 does not answer");
    Unpacker in(*message);
    if (in.kind() != Kind::chosen) throw Error("rank 0 did not choose an instruction set");
    use_sets(in.take<std::string>());
    return "";
  }
  const auto no_other = [](const Message& message) {
    Unpacker in(message);
    if (in.kind() == Kind::failure) throw Error(fmt::format("rank {}: {}", message.from, in.take<std::string>()));
    throw Error(fmt::format("rank {} did not tell its instruction sets", message.from));
  };
  std::vector<std::string> texts = texts_of_all(ranks, Kind::sets, late_after, no_other), kernels, rays;
  texts.front() = own_sets();
  for (const std::string& text : texts) {
    if (text.empty()) continue;
    const std::size_t cut = std::min(text.find('\n'), text.size());
    kernels.push_back(text.substr(0, cut));
    rays.push_back(text.substr(std::min(cut + 1, text.size())));
  }
  const std::string kernel = best_of_all(kernels), ray = best_of_all(rays);
  use_sets(kernel + "\n" + ray);
  for (int rank = 1; rank < ranks.count(); ++rank)
    if (!texts[static_cast<std::size_t>(rank)].empty()) tell_sets(ranks, rank);
  return fmt::format("{} ranks, kernels by {}, rays by {}", ranks.count(), kernel, ray);
}

void Crew::check(const RenderKey& key) {
  key_ = key;
  // Ranks that are ready ask for work while others still load the scene.
  const std::vector<std::string> texts =
      texts_of_all(*ranks_, Kind::key, late_after_, [&](const Message& message) { take_message(message, kNoWork); });
  for (int rank = 1; rank < count(); ++rank) {
    if (gone_.contains(rank)) continue;
    const std::string& text = texts[static_cast<std::size_t>(rank)];
    if (text.empty()) {
      late_.insert(rank);
    } else {
      check_key(rank, text);
      heard_[rank] = clock_.seconds();
    }
  }
}

void Crew::check_key(int rank, const std::string& text) const {
  check_same_whole({"rank 0", key_}, {fmt::format("rank {}", rank), parse_key(text)}, false);
}

void Crew::take_message(const Message& message, const Work& work) {
  if (gone_.contains(message.from)) return;
  heard_[message.from] = clock_.seconds();
  if (late_.erase(message.from) > 0) inform(name_of(*ranks_, message.from) + " answers again");
  Unpacker in(message);
  switch (in.kind()) {
    // Of ranks that were late.
    case Kind::sets:
      tell_sets(*ranks_, message.from);
      return;
    case Kind::key:
      check_key(message.from, in.take<std::string>());
      return;
    case Kind::result:
      std::erase(tasks_[message.from], in.take<TaskBytes>());
      [[fallthrough]];
    case Kind::ask:
      begun_.insert(message.from);
      waiting_.push_back(message.from);
      return;
    case Kind::alive:
      return;
    case Kind::failure:
      failures_.push_back(fmt::format("rank {}: {}", message.from, in.take<std::string>()));
      [[fallthrough]];
    default:
      gone_.insert(message.from);
      std::erase(waiting_, message.from);
      take_tasks_back(message.from, work);
  }
}

void Crew::take_tasks_back(int rank, const Work& work) {
  for (const TaskBytes& task : tasks_[rank]) work.give_back(task);
  tasks_.erase(rank);
}

void Crew::look_for_late(const Work& work) {
  const double now = clock_.seconds();
  if (now - looked_ < late_after_ / 1000) return;  // ranks may be thousands
  looked_ = now;
  for (int rank = 1; rank < count(); ++rank) {
    const auto heard = heard_.find(rank);
    const bool owes = !begun_.contains(rank) || !tasks_[rank].empty();
    const double silent = now - (heard == heard_.end() ? 0 : heard->second);
    if (!owes || silent < late_after_ || gone_.contains(rank) || !late_.insert(rank).second) continue;
    warn_of_late_rank(*ranks_, rank, late_after_, "do its tasks");
    take_tasks_back(rank, work);
  }
}

void Crew::serve(const Work& work) {
  // A longer result keeps all threads busy alone.
  constexpr std::size_t kMostAtOnce = std::size_t{8} << 20;
  while (!work.ended()) {
    std::vector<Message> messages;
    std::size_t bytes = 0;
    while (std::optional<Message> message = ranks_->receive(messages.empty() ? kTurn : 0)) {
      bytes += message->bytes.size();
      messages.push_back(*std::move(message));
      if (bytes >= kMostAtOnce) break;
    }
    parallel_for_each(messages.size(), 1, [&](std::size_t i) { put_result(messages[i], work); });
    for (const Message& message : messages) take_message(message, work);
    look_for_late(work);
    while (true) {
      const auto ready =
          std::find_if(waiting_.begin(), waiting_.end(), [this](int rank) { return !late_.contains(rank); });
      const std::optional<TaskBytes> task = ready == waiting_.end() ? std::nullopt : work.take();
      if (!task) break;
      const int rank = *ready;
      waiting_.erase(ready);
      if (tasks_[rank].empty()) heard_[rank] = clock_.seconds();
      tasks_[rank].push_back(*task);
      if (ranks_->send(rank, packed(Kind::task, *task), kSendSeconds)) continue;
      failures_.push_back(name_of(*ranks_, rank) + " does not answer");
      late_.insert(rank);  // it may answer again
      take_tasks_back(rank, work);
    }
  }
}

void Crew::share(const Work& work, const std::function<bool()>& compute) {
  std::atomic<bool> ended = false;
  Work own = work;
  own.ended = [&] { return ended || work.ended(); };
  std::future<void> server = std::async(std::launch::async, [&] { serve(own); });  // its destructor waits
  try {
    while (!own.ended() && server.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
      if (!compute()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  } catch (...) {
    ended = true;
    throw;
  }
  ended = true;
  server.get();
}

void Crew::divide(const std::string&, std::size_t count, const Make& make, const Take& take) {
  std::mutex mutex;
  std::set<std::uint64_t> free;              // to make
  std::map<std::uint64_t, TaskBytes> ready;  // made, and not yet taken
  std::atomic<std::uint64_t> next = 0;       // to take
  for (std::uint64_t piece = 0; piece < count; ++piece) free.insert(piece);
  const auto claim = [&]() -> std::optional<std::uint64_t> {
    const std::lock_guard lock(mutex);
    if (free.empty()) return std::nullopt;
    return free.extract(free.begin()).value();
  };
  const auto put = [&](std::uint64_t piece, TaskBytes bytes) {
    const std::lock_guard lock(mutex);
    free.erase(piece);
    if (piece >= next) ready.try_emplace(piece, std::move(bytes));
  };
  const auto give_back = [&](const TaskBytes& task) {
    const std::lock_guard lock(mutex);
    const auto piece = unarchived<std::uint64_t>(task);
    if (piece >= next && !ready.contains(piece)) free.insert(piece);
  };
  const auto hand_out = [&]() -> std::optional<TaskBytes> {
    const std::optional<std::uint64_t> piece = claim();
    return piece ? std::optional(archived(*piece)) : std::nullopt;
  };
  const auto next_ready = [&]() -> std::optional<TaskBytes> {
    const std::lock_guard lock(mutex);
    auto found = ready.extract(next);
    if (found.empty()) return std::nullopt;
    ++next;
    return std::move(found.mapped());
  };
  std::optional<std::uint64_t> own = claim();
  share({hand_out,
         [&](const TaskBytes& task, auto bytes) {
           put(unarchived<std::uint64_t>(task), {bytes.begin(), bytes.end()});
         },
         give_back, [&] { return next == count; }},
        [&] {
          if (const std::optional<TaskBytes> bytes = next_ready()) {
            take(next - 1, *bytes);
            return true;
          }
          check_cancelled();
          if (!own) own = claim();
          if (!own) return false;
          put(*own, make(*own));
          own.reset();
          return true;
        });
}

void Crew::stop(double seconds) {
  for (int rank = 1; rank < count(); ++rank) {
    if (gone_.contains(rank) || stopped_.contains(rank)) continue;
    if (ranks_->send(rank, packed(Kind::stop), late_.contains(rank) ? 1 : seconds)) stopped_.insert(rank);
  }
}

bool Crew::dismiss(double seconds) {
  RunningClock clock;
  stop(seconds);
  const auto missing = [&] {
    std::vector<int> ranks;
    for (int rank = 1; rank < count(); ++rank)
      if (!gone_.contains(rank) && !late_.contains(rank)) ranks.push_back(rank);
    return ranks;
  };
  // Results that are on their way come too late.
  while (!missing().empty() && clock.seconds() < seconds)
    if (const std::optional<Message> message = ranks_->receive(0.05)) take_message(*message, kNoWork);
  for (const int rank : missing()) warn_of_late_rank(*ranks_, rank, seconds, "have done its tasks");
  return gone_.size() + 1 == static_cast<std::size_t>(count());
}

void report_failure(Ranks& ranks, const std::string& message) {
  ranks.send(0, packed(Kind::failure, message), kSendSeconds);
}

void RankWorker::introduce(const RenderKey& key) { ranks_->send(0, packed(Kind::key, key_text(key)), kSendSeconds); }

void RankWorker::work(const std::function<void()>& begin, const std::function<TaskBytes(const TaskBytes&)>& compute,
                      const std::function<bool()>& ended, int at_once) {
  try {
    // No message of it follows the last one.
    const std::jthread alive = repeat(alive_interval_, [this] { ranks_->send(0, packed(Kind::alive), kSendSeconds); });
    begin();
    do_tasks(compute, ended, at_once);
  } catch (const Cancelled&) {
    ranks_->send(0, packed(Kind::bye), kSendSeconds);
    throw;
  } catch (const std::exception& error) {
    report_failure(*ranks_, error.what());
    throw;
  }
  ranks_->send(0, packed(Kind::bye), kSendSeconds);
}

void RankWorker::do_tasks(const std::function<TaskBytes(const TaskBytes&)>& compute, const std::function<bool()>& ended,
                          int at_once) {
  for (int i = 0; i < at_once; ++i) ranks_->send(0, packed(Kind::ask), kSendSeconds);
  std::deque<TaskBytes> tasks;
  bool stopped = false;
  while (!stopped && !ended()) {
    // A stop that has come already makes tasks before it needless.
    while (const std::optional<Message> message = ranks_->receive(tasks.empty() && !stopped ? 0.1 : 0)) {
      Unpacker in(*message);
      stopped = in.kind() != Kind::task;
      if (stopped) break;
      tasks.push_back(in.take<TaskBytes>());
    }
    if (stopped || tasks.empty()) continue;
    std::vector<std::byte> result = packed(Kind::result, tasks.front(), compute(tasks.front()));
    if (result.size() > std::numeric_limits<int>::max())
      throw Error(fmt::format("a result of {} bytes is too long for a message", result.size()),
                  "Divide the render by --part.");
    ranks_->send(0, std::move(result), kSendSeconds);
    tasks.pop_front();
  }
}

void RankWorker::divide(const std::string&, std::size_t count, const Make& make, const Take&) {
  const auto compute = [&](const TaskBytes& task) {
    const auto piece = unarchived<std::uint64_t>(task);
    require(piece < count);
    return make(piece);
  };
  work([] {}, compute, [] { return false; }, 1);
}

}  // namespace glowworm
