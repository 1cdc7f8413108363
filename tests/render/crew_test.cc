// One render by several ranks, which are threads here.
#include "share/crew.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <future>
#include <mutex>
#include <thread>

#include "builtin/builtin.h"
#include "core/archive.h"
#include "core/error.h"
#include "core/parallel.h"
#include "film/part.h"
#include "kernels/simd.h"
#include "render/render_testing.h"
#include "share/task_queue.h"
#include "trace/instruction_set.h"

namespace glowworm {
namespace {

using testing::HasSubstr;

/// The mail of ranks in one process.
struct Mail {
  explicit Mail(int count) : boxes(static_cast<std::size_t>(count)) {}
  std::mutex mutex;
  std::condition_variable arrived;
  std::vector<std::deque<Message>> boxes;
  std::size_t largest = 0;  // message, bytes
};

class ThreadRanks : public Ranks {
 public:
  ThreadRanks(std::shared_ptr<Mail> mail, int rank) : mail_(std::move(mail)), rank_(rank) {}
  int rank() const override { return rank_; }
  int count() const override { return static_cast<int>(mail_->boxes.size()); }
  std::string host(int) const override { return "node"; }
  bool send(int to, std::vector<std::byte> bytes, double) override {
    const std::lock_guard lock(mail_->mutex);
    mail_->largest = std::max(mail_->largest, bytes.size());
    mail_->boxes[static_cast<std::size_t>(to)].push_back({rank_, std::move(bytes)});
    mail_->arrived.notify_all();
    return true;
  }
  std::optional<Message> receive(double seconds) override {
    std::unique_lock lock(mail_->mutex);
    std::deque<Message>& box = mail_->boxes[static_cast<std::size_t>(rank_)];
    mail_->arrived.wait_for(lock, std::chrono::duration<double>(seconds), [&] { return !box.empty(); });
    if (box.empty()) return std::nullopt;
    Message message = std::move(box.front());
    box.pop_front();
    return message;
  }
  void abort(int) override { std::abort(); }

 private:
  std::shared_ptr<Mail> mail_;
  int rank_;
};

std::vector<std::shared_ptr<Ranks>> ranks_of(int count) {
  const auto mail = std::make_shared<Mail>(count);
  std::vector<std::shared_ptr<Ranks>> out;
  for (int rank = 0; rank < count; ++rank) out.push_back(std::make_shared<ThreadRanks>(mail, rank));
  return out;
}

std::unique_ptr<Job> job_of(const Stage& stage, const RenderSettings& settings, std::shared_ptr<Ranks> ranks,
                            const Checkpoint* resume = nullptr) {
  return std::make_unique<Job>(stage.scene, stage.tracer, settings, resume, 0, nullptr, std::move(ranks));
}

/// Renders by so many ranks.
Film render(const Stage& stage, const RenderSettings& settings, int count, const Checkpoint* resume = nullptr) {
  const std::vector<std::shared_ptr<Ranks>> ranks = ranks_of(count);
  std::vector<std::unique_ptr<Job>> jobs;
  // Only rank 0 has the film.
  Checkpoint key_alone;
  if (resume) key_alone.key = resume->key;
  const Checkpoint* const of_others = resume ? &key_alone : nullptr;
  for (int rank = 0; rank < count; ++rank)
    jobs.push_back(job_of(stage, settings, ranks[static_cast<std::size_t>(rank)], rank == 0 ? resume : of_others));
  jobs.front()->wait();
  EXPECT_TRUE(jobs.front()->crew()->dismiss(60));
  EXPECT_THAT(jobs.front()->crew()->failures(), testing::IsEmpty());
  for (auto& job : jobs) job->wait();
  return jobs.front()->snapshot();
}

RenderSettings small_picture() {
  RenderSettings s = by_photons(40, 5, 4, 1000, "auto");
  s.filter = Filtering::automatic;
  s.aovs = aov_names();
  s.guiding = false;  // which takes most of the time of a small picture
  return s;
}

TEST(SharedRender, HasTheBitsOfOneProcess) {
  const Stage stage(builtin_scene("cornell"));
  const RenderSettings settings = small_picture();
  RenderSettings progressive = settings, path = settings, noise = settings, reverse = settings, part = settings;
  RenderSettings more_photons = settings, guided = settings;
  guided.guiding = true;
  progressive.progressive = true;
  path.integrator = Integrator::path;
  path.samples = 20;
  noise.noise_target = 0.2;
  more_photons.noise_target = more_photons.photon_target = 0.02;
  reverse.engine = "reverse";
  part.part = {2, 2};
  for (const RenderSettings& s : {guided, progressive, path, noise, more_photons, reverse, part}) {
    Job job(stage.scene, stage.tracer, s);
    job.wait();
    EXPECT_EQ(job.has_more_photons(), s.photon_target > 0);
    const std::vector<std::uint32_t> alone = job.film().save();
    for (const int count : {1, 3}) EXPECT_TRUE(render(stage, s, count).save() == alone) << count;
  }
}

TEST(SharedRender, GoesOnFromACheckpoint) {
  const Stage stage(builtin_scene("cornell"));
  const RenderSettings settings = small_picture();
  const std::vector<std::shared_ptr<Ranks>> ranks = ranks_of(2);
  const auto first = job_of(stage, settings, ranks[0]), second = job_of(stage, settings, ranks[1]);
  while (first->tasks() < 3 && !first->done()) std::this_thread::yield();
  first->cancel();
  first->wait();
  EXPECT_EQ(first->ending(), Ending::cancelled);
  EXPECT_TRUE(first->crew()->dismiss(60));
  const Checkpoint checkpoint = first->checkpoint();
  EXPECT_TRUE(render(stage, settings, 3, &checkpoint).save() == stage.render(settings).save());
}

TEST(SharedRender, GoesOnWithTheNumbersOfACheckpoint) {
  const Stage stage(builtin_scene("cornell"));
  RenderSettings settings = small_picture();
  settings.samples = 2;
  Job begun(stage.scene, stage.tracer, settings);
  begun.wait();
  const Checkpoint checkpoint = begun.checkpoint();
  settings.samples = 5;
  const std::vector<std::uint32_t> whole = stage.render(settings).save();
  // By default there are more gather rays.
  settings.gather = 0;
  settings.time_limit_s = 1000;
  EXPECT_TRUE(render(stage, settings, 3, &checkpoint).save() == whole);
}

/// Pixels see more objects than the film of a task has room for.
TEST(SharedRender, RoundsCountTheSamplesOfManyObjects) {
  SceneDescription description = builtin_scene("atrium");
  std::vector<ObjectStart>& objects = description.geometry.objects;
  objects.clear();
  while (objects.size() < description.geometry.triangle_count())
    objects.push_back({static_cast<std::uint32_t>(objects.size()), ""});
  const Stage stage(std::move(description));
  RenderSettings settings = by_photons(48, 32, 4, 1000, "auto");
  settings.guiding = false;
  settings.noise_target = 1e-3;
  settings.aovs = {"object-id"};
  EXPECT_TRUE(render(stage, settings, 3).save() == stage.render(settings).save());
}

/// As after a kill where tiles were others.
TEST(SharedRender, GoesOnWhereRowsHaveDifferentNumbersOfSamples) {
  const Stage stage(builtin_scene("cornell"));
  RenderSettings settings = small_picture(), fewer = settings;
  settings.samples = 16;
  settings.aovs = {"direct"};  // tasks of four samples
  fewer = settings;
  fewer.samples = 1;
  Job job(stage.scene, stage.tracer, fewer);
  job.wait();
  Film film = job.snapshot();
  for (const auto& [rows, samples] : {std::pair{3, 7u}, {1, 4u}}) {
    fewer.samples = samples;
    film.take_rows(stage.render(fewer).rows(0, rows));
  }
  const Checkpoint checkpoint{key_text(job.key()), 1, film.save(), {}};
  EXPECT_TRUE(render(stage, settings, 3, &checkpoint).save() == stage.render(settings).save());
}

TEST(SharedRender, SendsSumsOfSamples) {
  const Stage stage(builtin_scene("cornell"));
  RenderSettings settings = small_picture();
  settings.aovs.clear();
  settings.samples = 80;
  const auto mail = std::make_shared<Mail>(2);
  const auto first = job_of(stage, settings, std::make_shared<ThreadRanks>(mail, 0));
  const auto second = job_of(stage, settings, std::make_shared<ThreadRanks>(mail, 1));
  first->wait();
  EXPECT_TRUE(first->crew()->dismiss(60));
  // A tile of 20 samples a pixel takes less than one sample of each pixel of the picture.
  EXPECT_LT(mail->largest, 40 * 40 * (5 * sizeof(RGB) + sizeof(Vec3) + sizeof(float)));
}

const TaskBytes kOneTask(3);

TEST(SharedRender, ResultsThatHaveArrivedAreAddedAtOnce) {
  set_thread_count(2);
  const std::vector<std::shared_ptr<Ranks>> ranks = ranks_of(3);
  for (const std::size_t rank : {1u, 2u}) ranks[rank]->send(0, archived(std::uint8_t{5}, kOneTask, TaskBytes()), 1);
  std::mutex mutex;
  std::condition_variable both;
  int begun = 0, together = 0;
  const auto put = [&](const TaskBytes&, std::span<const std::byte>) {
    std::unique_lock lock(mutex);
    ++begun;
    both.notify_all();
    together += both.wait_for(lock, std::chrono::seconds(20), [&] { return begun == 2; });
  };
  Crew(ranks[0]).serve({[] { return std::nullopt; }, put, [](const TaskBytes&) {}, [&] { return begun == 2; }});
  EXPECT_EQ(together, 2);
  set_thread_count(0);
}

TEST(SharedRender, FilmsOfOtherTasksAreRefused) {
  const RenderSettings s = small_picture();
  const Film kind({0, 0, 16, 16}, false, true, s.place_layers(), true);
  const CameraTask task{0, 0, 16, 16, 0, 1}, none{0, 0, 16, 16, 0, 0};
  std::vector<std::byte> bytes = packed_film(kind);
  Film film = kind;
  EXPECT_NO_THROW(unpack_film(bytes, none, film));
  EXPECT_THROW(unpack_film(bytes, task, film), Error);  // it has no sample
  bytes.pop_back();
  EXPECT_THROW(unpack_film(bytes, none, film), Error);
}

TEST(SharedRender, RanksThatFailLeaveTheirTasksToOthers) {
  const Stage stage(builtin_scene("cornell"));
  const RenderSettings settings = small_picture();
  const std::vector<std::shared_ptr<Ranks>> ranks = ranks_of(3);
  const auto first = job_of(stage, settings, ranks[0]), second = job_of(stage, settings, ranks[1]);
  // A rank that takes a task and fails.
  std::thread third([&] {
    RankWorker member(ranks[2]);
    member.introduce(render_key(*stage.scene, first->settings()));
    const auto fail = [](const TaskBytes&) -> TaskBytes { throw Error("no more power"); };
    EXPECT_THROW(member.work([] {}, fail, [] { return false; }, 2), Error);
    report_failure(*ranks[2], "told twice");
  });
  first->wait();
  third.join();
  EXPECT_TRUE(first->crew()->dismiss(60));
  ASSERT_EQ(first->crew()->failures().size(), 1u);
  EXPECT_THAT(first->crew()->failures().front(), HasSubstr("rank 2: no more power"));
  EXPECT_TRUE(first->snapshot().save() == stage.render(settings).save());
}

constexpr std::byte kAsk{3}, kTask{4}, kStop{7}, kBye{8}, kAlive{9};
/// Turns of Crew::serve() without messages that take longer than 0.02 s.
constexpr int kLateTurns = 50;

/// Serves ranks one task until `ended`. Returns how often it came back.
int serve_one_task(Crew& crew, const std::function<bool()>& ended) {
  bool given = false;
  int back = 0;
  crew.serve({[&]() -> std::optional<TaskBytes> {
                if (std::exchange(given, true)) return std::nullopt;
                return kOneTask;
              },
              [](const TaskBytes&, std::span<const std::byte>) {}, [&](const TaskBytes&) { ++back; }, ended});
  return back;
}

/// As one whose process is stopped.
TEST(SharedRender, ALateRankIsNamedAndNotWaitedFor) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  for (const bool has_begun : {true, false}) {
    const std::vector<std::shared_ptr<Ranks>> ranks = ranks_of(2);
    if (has_begun) ranks[1]->send(0, {kAsk}, 1);
    Crew crew(ranks[0], 0.02);
    testing::internal::CaptureStderr();
    const int back = serve_one_task(crew, [turns = 0]() mutable { return ++turns > kLateTurns; });
    EXPECT_EQ(back, has_begun) << "others do its tasks";
    EXPECT_FALSE(crew.dismiss(60));
    EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("rank 1 on node has not answered for 0.02 s"));
  }
  EXPECT_LT(Clock::now() - start, std::chrono::seconds(30));
}

TEST(SharedRender, ARankAtLongWorkIsNotLate) {
  const std::vector<std::shared_ptr<Ranks>> ranks = ranks_of(2);
  ranks[1]->send(0, {kAsk}, 1);
  Crew crew(ranks[0], 0.02);
  testing::internal::CaptureStderr();
  const int back = serve_one_task(crew, [&, turns = 0]() mutable {
    ranks[1]->send(0, {kAlive}, 1);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    return ++turns > kLateTurns;
  });
  EXPECT_EQ(back, 0);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

/// As one that traces photons.
TEST(SharedRender, ARankWhoseWorkTakesLongSaysThatItIsNotLost) {
  const std::vector<std::shared_ptr<Ranks>> ranks = ranks_of(2);
  constexpr double kLate = 1, kAliveAfter = 0.1;
  const auto work_long = [] { std::this_thread::sleep_for(std::chrono::milliseconds(2500)); };
  for (const bool at_once : {true, false}) {
    std::thread other([&] {
      const auto compute = [&](const TaskBytes& task) {
        if (!at_once) work_long();
        return task;
      };
      RankWorker(ranks[1], kAliveAfter)
          .work(
              [&] {
                if (at_once) work_long();
              },
              compute, [] { return false; }, 1);
    });
    Crew crew(ranks[0], kLate);
    testing::internal::CaptureStderr();
    std::vector<TaskBytes> tasks = {kOneTask};
    bool done = false;
    crew.serve({[&]() -> std::optional<TaskBytes> {
                  if (tasks.empty()) return std::nullopt;
                  return std::exchange(tasks, {}).front();
                },
                [&](const TaskBytes&, std::span<const std::byte>) { done = true; },
                [&](const TaskBytes& task) { tasks.push_back(task); }, [&] { return done; }});
    EXPECT_TRUE(crew.dismiss(60));
    other.join();
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  }
}

/// As one that loads the scene for a while, and prepares the render then.
TEST(SharedRender, ARankThatHasToldItsRenderIsNotYetLate) {
  const std::vector<std::shared_ptr<Ranks>> ranks = ranks_of(2);
  constexpr double kLate = 1;
  const RenderKey key = {{"version", "1"}};
  Crew crew(ranks[0], kLate);
  const auto wait = [] { std::this_thread::sleep_for(std::chrono::milliseconds(700)); };
  std::thread other([&] {
    wait();
    RankWorker(ranks[1]).introduce(key);
    wait();
    ranks[1]->send(0, {kAsk}, 1);
  });
  testing::internal::CaptureStderr();
  crew.check(key);
  serve_one_task(crew, [&] { return ranks[1]->receive(0).has_value(); });
  other.join();
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(SharedRender, ALateRankThatAnswersIsNamedAgain) {
  const std::vector<std::shared_ptr<Ranks>> ranks = ranks_of(2);
  Crew crew(ranks[0], 0.02);
  std::string told;
  testing::internal::CaptureStderr();
  serve_one_task(crew, [&, turns = 0]() mutable {
    if (++turns == kLateTurns) {
      told = testing::internal::GetCapturedStderr();
      testing::internal::CaptureStderr();
      ranks[1]->send(0, {kAsk}, 1);
    }
    return turns > kLateTurns;
  });
  EXPECT_THAT(told, HasSubstr("rank 1 on node has not answered"));
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("rank 1 on node answers again"));
}

TEST(SharedRender, ARankThatIsSilentAtTheEndIsNamed) {
  Crew crew(ranks_of(2)[0]);
  testing::internal::CaptureStderr();
  EXPECT_FALSE(crew.dismiss(0.1));
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("rank 1 on node has not answered for 0.1 s"));
}

/// Rank 0 of a process that is stopped once while it waits for a message.
struct StoppedRanks : ThreadRanks {
  using ThreadRanks::ThreadRanks;
  std::optional<Message> receive(double seconds) override {
    if (!std::exchange(stops, false)) return ThreadRanks::receive(seconds);
    std::this_thread::sleep_for(std::chrono::milliseconds(2500));
    return std::nullopt;
  }
  bool stops = false;
};

TEST(SharedRender, OthersAreNotLateBecauseRank0WasStopped) {
  const auto mail = std::make_shared<Mail>(2);
  const auto rank0 = std::make_shared<StoppedRanks>(mail, 0);
  ThreadRanks other(mail, 1);
  other.send(0, {kAsk}, 1);
  Crew crew(rank0, 2);
  testing::internal::CaptureStderr();
  serve_one_task(crew, [&, turns = 0]() mutable {
    rank0->stops = ++turns == 3;
    return turns == 6;
  });
  rank0->stops = true;
  other.send(0, {kBye}, 1);
  EXPECT_TRUE(crew.dismiss(2));
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

/// Rank 0, whose first message no other rank takes.
struct RefusedRanks : ThreadRanks {
  using ThreadRanks::ThreadRanks;
  bool send(int to, std::vector<std::byte> bytes, double seconds) override {
    return refused++ > 0 && ThreadRanks::send(to, std::move(bytes), seconds);
  }
  int refused = 0;
};

TEST(SharedRender, ARankThatTookNoTaskIsToldToEndIfItAnswersLater) {
  for (const bool answers : {true, false}) {
    const auto mail = std::make_shared<Mail>(2);
    ThreadRanks other(mail, 1);
    other.send(0, {kAsk}, 1);
    Crew crew(std::make_shared<RefusedRanks>(mail, 0));
    testing::internal::CaptureStderr();
    std::vector<TaskBytes> tasks = {kOneTask};
    crew.serve({[&]() -> std::optional<TaskBytes> {
                  if (tasks.empty()) return std::nullopt;
                  return std::exchange(tasks, {}).front();
                },
                [](const TaskBytes&, std::span<const std::byte>) {},
                [&](const TaskBytes& task) { tasks.push_back(task); },
                [&, turns = 0]() mutable {
                  if (++turns == 3 && answers) other.send(0, {kAsk}, 1);
                  return turns == 6;
                }});
    EXPECT_EQ(tasks.empty(), answers) << "it has the task, or others have it";
    if (answers) other.send(0, {kBye}, 1);
    EXPECT_EQ(crew.dismiss(2), answers);
    std::vector<std::byte> kinds;
    while (const std::optional<Message> message = other.receive(0)) kinds.push_back(message->bytes.front());
    EXPECT_EQ(kinds, answers ? std::vector({kTask, kStop}) : std::vector({kStop}));
    EXPECT_EQ(testing::internal::GetCapturedStderr(), answers ? "rank 1 on node answers again\n" : "");
    EXPECT_THAT(crew.failures(), testing::ElementsAre("rank 1 on node does not answer"));
  }
}

/// Pieces of a crew of so many ranks, each its own number, and the ranks that made them. Other ranks call `help`.
struct DividedPieces {
  static constexpr std::size_t kCount = 20;
  std::vector<std::size_t> taken;
  std::set<int> makers;
  std::vector<std::string> failures, thrown;

  DividedPieces(int count, const std::function<void(std::size_t piece, int rank)>& help) {
    const std::vector<std::shared_ptr<Ranks>> ranks = ranks_of(count);
    std::mutex mutex;
    std::condition_variable changed;
    const auto make_by = [&](int rank) {
      return [&, rank](std::size_t piece) {
        std::unique_lock lock(mutex);
        makers.insert(rank);
        changed.notify_all();
        // So that nobody makes all.
        changed.wait_for(lock, std::chrono::seconds(60), [&] { return static_cast<int>(makers.size()) == count; });
        if (rank > 0) help(piece, rank);
        return archived(piece);
      };
    };
    const auto take = [&](std::size_t piece, std::span<const std::byte> bytes) {
      taken.emplace_back();
      unarchive(bytes, taken.back());
      EXPECT_EQ(taken.back(), piece);
    };
    std::vector<std::thread> others;
    for (int rank = 1; rank < count; ++rank)
      others.emplace_back([&, rank] {
        try {
          RankWorker(ranks[static_cast<std::size_t>(rank)]).divide("pieces", kCount, make_by(rank), take);
        } catch (const Error& error) {
          const std::lock_guard lock(mutex);
          thrown.emplace_back(error.what());
        }
      });
    Crew crew(ranks[0]);
    crew.divide("pieces", kCount, make_by(0), take);
    EXPECT_TRUE(crew.dismiss(60));
    for (std::thread& other : others) other.join();
    failures = crew.failures();
  }
};

TEST(SharedPieces, AreTakenInOrderByRank0) {
  for (const int count : {1, 2, 5}) {
    const DividedPieces pieces(count, [](std::size_t piece, int) { EXPECT_GT(piece, 0u); });
    EXPECT_EQ(pieces.taken.size(), DividedPieces::kCount);
    EXPECT_EQ(pieces.makers.size(), static_cast<std::size_t>(count));
    EXPECT_THAT(pieces.failures, testing::IsEmpty());
  }
}

TEST(SharedPieces, OfRanksThatFailAreMadeByOthers) {
  const DividedPieces pieces(3, [](std::size_t, int rank) {
    if (rank == 2) throw Error("no more power");
  });
  EXPECT_EQ(pieces.taken.size(), DividedPieces::kCount);
  EXPECT_THAT(pieces.failures, testing::ElementsAre("rank 2: no more power"));
  EXPECT_THAT(pieces.thrown, testing::ElementsAre("no more power"));
}

TEST(SharedPieces, OfARankThatIsInterruptedAreMadeByOthers) {
  const std::vector<std::shared_ptr<Ranks>> ranks = ranks_of(2);
  std::promise<void> leaves;
  std::thread other([&] {
    const auto cancel = [](std::size_t) -> TaskBytes { throw Cancelled(); };
    EXPECT_THROW(RankWorker(ranks[1]).divide("pieces", 3, cancel, {}), Cancelled);
    leaves.set_value();
  });
  Crew crew(ranks[0]);
  std::vector<std::size_t> taken;
  const auto make = [&](std::size_t piece) {
    if (piece == 0) leaves.get_future().wait();
    return archived(piece);
  };
  crew.divide("pieces", 3, make, [&](std::size_t piece, std::span<const std::byte>) { taken.push_back(piece); });
  other.join();
  EXPECT_THAT(taken, testing::ElementsAre(0, 1, 2));
  EXPECT_TRUE(crew.dismiss(60));
  EXPECT_THAT(crew.failures(), testing::IsEmpty());
}

TEST(SharedPieces, ThatAreThereAreTakenBeforeAnInterruptedCrewEnds) {
  const std::vector<std::shared_ptr<Ranks>> ranks = ranks_of(2);
  Interrupt interrupt;
  const CancellationScope scope(interrupt);
  std::promise<void> all_but_last, ended;
  std::thread other([&] {
    const auto make = [&](std::size_t piece) {
      if (piece == 3) all_but_last.set_value();  // rank 0 has the results before
      if (piece == 4) ended.get_future().wait();
      return archived(piece);
    };
    RankWorker(ranks[1]).divide("pieces", 5, make, {});
  });
  Crew crew(ranks[0]);
  std::vector<std::size_t> taken;
  const auto make = [&](std::size_t piece) {
    EXPECT_EQ(piece, 0u);
    all_but_last.get_future().wait();
    interrupt.request();
    return archived(piece);
  };
  const auto take = [&](std::size_t piece, std::span<const std::byte>) { taken.push_back(piece); };
  EXPECT_THROW(crew.divide("pieces", 5, make, take), Cancelled);
  ended.set_value();
  EXPECT_TRUE(crew.dismiss(60));
  other.join();
  ASSERT_GE(taken.size(), 3u);
  for (std::size_t i = 0; i < taken.size(); ++i) EXPECT_EQ(taken[i], i);
}

TEST(SharedPieces, OfARankThatIsLateAreMadeByOthers) {
  const std::vector<std::shared_ptr<Ranks>> ranks = ranks_of(2);
  ranks[1]->send(0, {kAsk}, 1);
  Crew crew(ranks[0], 0.02);
  testing::internal::CaptureStderr();
  std::vector<std::size_t> made, taken;
  const auto make = [&](std::size_t piece) {
    // Rank 1 has got a piece now, and is silent.
    EXPECT_TRUE(piece > 0 || ranks[1]->receive(60));
    made.push_back(piece);
    return archived(piece);
  };
  crew.divide("pieces", 3, make, [&](std::size_t piece, std::span<const std::byte>) { taken.push_back(piece); });
  EXPECT_THAT(made, testing::UnorderedElementsAre(0, 1, 2));
  EXPECT_THAT(taken, testing::ElementsAre(0, 1, 2));
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("rank 1 on node has not answered for 0.02 s"));
}

TEST(Watch, CallsIfItIsNotDestroyedInTime) {
  std::atomic<int> calls = 0;
  const auto start = std::chrono::steady_clock::now();
  {
    const std::jthread patient = watch(60, [&] { calls += 100; });
    const std::jthread short_one = watch(0.05, [&] { ++calls; });
    while (calls == 0 && std::chrono::steady_clock::now() < start + std::chrono::seconds(20))
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(calls, 1);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(30));
}

TEST(RunningClock, DoesNotCountTimeInWhichTheProcessIsStopped) {
  RunningClock clock;
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));  // as a stop is seen
  EXPECT_LT(clock.seconds(), 1.1);
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_GE(clock.seconds(), 1.1);
}

TEST(SharedRender, ARankThatComesLateTakesPart) {
  const std::vector<std::shared_ptr<Ranks>> ranks = ranks_of(2);
  const RenderKey key = {{"version", "1"}};
  Crew crew(ranks[0], 0.01);
  testing::internal::CaptureStderr();
  agree_on_instruction_sets(*ranks[0], 0.01);
  crew.check(key);
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              HasSubstr("rank 1 on node has not answered for 0.01 s; others begin"));
  std::thread rank([&] {
    agree_on_instruction_sets(*ranks[1]);
    RankWorker member(ranks[1]);
    member.introduce(key);
    member.work([] {}, [](const TaskBytes& task) { return task; }, [] { return false; }, 2);
  });
  bool given = false, taken = false;
  crew.serve({[&]() -> std::optional<TaskBytes> {
                if (std::exchange(given, true)) return std::nullopt;
                return kOneTask;
              },
              [&](const TaskBytes&, std::span<const std::byte>) { taken = true; }, [](const TaskBytes&) {},
              [&] { return taken; }});
  EXPECT_TRUE(crew.dismiss(60));
  rank.join();
}

TEST(SharedRender, RanksWithAnotherSceneAreRefused) {
  const Stage stage(builtin_scene("cornell")), other(builtin_scene("ajar"));
  const std::vector<std::shared_ptr<Ranks>> ranks = ranks_of(2);
  const auto first = job_of(stage, small_picture(), ranks[0]), second = job_of(other, small_picture(), ranks[1]);
  try {
    first->wait();
    ADD_FAILURE() << "the other scene was taken";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::AllOf(HasSubstr("rank 0"), HasSubstr("rank 1"), HasSubstr("geometry")));
  }
  first->crew()->dismiss(60);
}

TEST(InstructionSets, AreTheBestThatAllRanksHave) {
  const std::vector<std::shared_ptr<Ranks>> ranks = ranks_of(2);
  // A machine that can do less.
  std::thread other(
      [&] { ranks[1]->send(0, archived(std::uint8_t{0}, std::string("sse4 ssse3 sse2 scalar\nsse")), 1); });
  const std::string before = simd_name(), rays_before = ray_instruction_set();
  const std::string chosen = agree_on_instruction_sets(*ranks[0]);
  other.join();
  EXPECT_EQ(simd_name(), "sse4");
  EXPECT_THAT(ray_instruction_set(), HasSubstr(", sse"));
  EXPECT_THAT(chosen, HasSubstr("kernels by sse4, rays by sse"));
  const std::optional<Message> told = ranks[1]->receive(1);
  ASSERT_TRUE(told);
  EXPECT_EQ(told->bytes, archived(std::uint8_t{1}, std::string("sse4\nsse")));
  set_simd(before);
  set_ray_instruction_set(ray_instruction_sets().front());
  EXPECT_EQ(ray_instruction_set(), rays_before);
}

TEST(TaskQueue, GivesTheSamplesOfATileInOrder) {
  const std::vector<CameraTask> tiles = {{0, 0, 16, 16, 2, 5}, {16, 0, 20, 16, 2, 5}};
  TaskQueue queue(tiles, 2);
  EXPECT_EQ(queue.slots(), 20u * 16 * 5);
  const CameraTask a = *queue.take(), b = *queue.take();
  EXPECT_EQ(a, (CameraTask{0, 0, 16, 16, 2, 2}));
  EXPECT_FALSE(queue.take());
  EXPECT_TRUE(queue.finish(a));
  EXPECT_FALSE(queue.finish(a));
  EXPECT_EQ(queue.take()->first_sample, 4u);
  queue.give_back(b);
  EXPECT_EQ(*queue.take(), b);
  EXPECT_TRUE(queue.finish(b));
  EXPECT_EQ(queue.whole_samples(), 4u);
  EXPECT_EQ(queue.slots_done(), 20u * 16 * 2);
  EXPECT_TRUE(queue.finish({0, 0, 16, 16, 4, 2}));
  std::uint32_t last = 0;
  while (!queue.done()) {
    const CameraTask task = *queue.take();
    EXPECT_LE(task.sample_count, 2u);
    last = std::max(last, task.first_sample + task.sample_count);
    EXPECT_TRUE(queue.finish(task));
  }
  EXPECT_EQ(last, 7u);
  EXPECT_EQ(queue.slots_done(), queue.slots());
  EXPECT_EQ(queue.whole_samples(), 7u);
}

TEST(TaskQueue, BeginsWithFewSamples) {
  TaskQueue queue({{0, 0, 16, 16, 0, 20}}, 8);
  std::vector<std::uint32_t> counts;
  while (!queue.done()) {
    CameraTask task = *queue.take();
    if (counts.size() == 3) task = queue.shorten(task);
    counts.push_back(task.sample_count);
    EXPECT_TRUE(queue.finish(task));
  }
  EXPECT_EQ(counts, std::vector<std::uint32_t>({1, 1, 2, 1, 5, 8, 2}));
}

}  // namespace
}  // namespace glowworm
