// The process that reads pictures: crashes, kills, many threads.
#include "image/image_reader.h"

#include <gmock/gmock.h>
#include <signal.h>
#include <sys/wait.h>

#include <filesystem>
#include <set>
#include <thread>

#include "core/archive.h"
#include "core/parallel.h"
#include "image/image_files.h"
#include "image/reader_messages.h"

namespace glowworm {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class ImageReaders : public ImageFiles {
 protected:
  static constexpr int kSide = 1024;  // several bands

  void SetUp() override {
    ImageFiles::SetUp();
    std::vector<std::uint8_t> samples(kSide * kSide * 3);
    for (std::size_t i = 0; i < samples.size(); ++i)
      samples[i] = static_cast<std::uint8_t>(hash32(static_cast<std::uint32_t>(i)));
    write_foreign("a.tif", kSide, kSide, 3, samples);
    write_png(path("b.png"), make_image());
  }

  /// The running processes of glowworm-reader that this one has started.
  static std::set<pid_t> readers() {
    std::set<pid_t> found;
    for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
      std::ifstream file(entry.path() / "stat");  // proc(5): number (name) state parent
      std::string id, name, state;
      pid_t parent = 0;
      if (file >> id >> name >> state >> parent && name == "(glowworm-reader)" && state != "Z" && parent == getpid())
        found.insert(std::stoi(id));
    }
    return found;
  }
  static void send_all(int number) {
    for (const pid_t id : readers()) kill(id, number);
  }

  /// What is said where the process gets a signal after the first band of a.tif.
  std::string message_after(int number) const {
    return message_of([&] {
      int bands = 0;
      scan_image_file(path("a.tif"), false, [&](const ImageFileHeader&, const std::vector<std::byte>&) {
        if (++bands == 1) send_all(number);
      });
    });
  }
};

TEST_F(ImageReaders, ACrashNamesTheFileAndTheNextIsRead) {
  const std::vector<std::byte> whole = read_image_file(path("a.tif")).samples;
  EXPECT_THAT(message_after(SIGSEGV), AllOf(HasSubstr(path("a.tif")), HasSubstr("crashed on this file (SIGSEGV)")));
  EXPECT_EQ(read_image(path("b.png")).width(), kWidth);
  EXPECT_THAT(message_after(SIGKILL), AllOf(HasSubstr(path("a.tif")), HasSubstr("was killed")));
  EXPECT_EQ(read_image(path("b.png")).width(), kWidth);
  EXPECT_TRUE(read_image_file(path("a.tif")).samples == whole);
}

TEST_F(ImageReaders, AProcessThatEndsBetweenFilesIsReplaced) {
  read_image(path("b.png"));
  for (const pid_t id : readers()) {
    kill(id, SIGKILL);
    siginfo_t ended;
    waitid(P_PID, static_cast<id_t>(id), &ended, WEXITED | WNOWAIT);
  }
  EXPECT_EQ(message_of([&] { read_image(path("b.png")); }), "");
}

TEST_F(ImageReaders, OneProcessServesManyFiles) {
  read_image(path("b.png"));
  const std::set<pid_t> first = readers();
  for (int i = 0; i < 20; ++i) read_image(path("b.png"));
  EXPECT_EQ(readers(), first);
}

TEST_F(ImageReaders, IsCancelledWithItsProcess) {
  read_image(path("b.png"));
  const std::set<pid_t> first = readers();
  Interrupt interrupt;
  const CancellationScope scope(interrupt);
  EXPECT_THROW(scan_image_file(path("a.tif"), false,
                               [&](const ImageFileHeader&, const std::vector<std::byte>&) {
                                 send_all(SIGSTOP);
                                 interrupt.request();
                               }),
               Cancelled);
  EXPECT_LT(readers().size(), first.size());
  send_all(SIGCONT);
}

TEST_F(ImageReaders, ThreadsReadAtOnce) {
  const std::vector<RGB> a = read_image(path("a.tif")).rgb(), b = read_image(path("b.png")).rgb();
  constexpr std::size_t kThreads = 4;
  std::vector<int> same(kThreads, 0);
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < kThreads; ++t)
    threads.emplace_back([&, t] {
      for (std::size_t i = t; i < t + 4; ++i) {
        const bool first = i % 2 == 0;
        same[t] += read_image(path(first ? "a.tif" : "b.png")).rgb() == (first ? a : b);
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_THAT(same, testing::Each(4));
  EXPECT_LE(readers().size(), kThreads);
}

TEST_F(ImageReaders, AnswersAreChecked) {
  ReaderAnswer answer;
  answer.done = true;
  answer.header.width = 5;
  answer.header.channels = 2;
  answer.header.channel_names = {"Y", "A"};
  answer.header.alpha_channel = 1;
  answer.header.metadata["Software"] = "test";
  const std::string bytes = encode_answer(answer);
  EXPECT_EQ(decode_answer(bytes).header.metadata, answer.header.metadata);
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_THROW(decode_answer(std::string_view(bytes).substr(0, size)), InvalidArchive);
  EXPECT_THROW(decode_answer(bytes + '\0'), InvalidArchive);
  for (std::size_t i = 0; i < 8 * bytes.size(); ++i) {
    std::string flipped = bytes;
    flipped[i / 8] = static_cast<char>(flipped[i / 8] ^ (1 << i % 8));
    try {
      const ImageFileHeader header = decode_answer(flipped).header;
      EXPECT_EQ(static_cast<std::size_t>(header.channels), header.channel_names.size());
      EXPECT_LT(header.alpha_channel, header.channels);
    } catch (const InvalidArchive&) {
    }
  }
  for (int channels : {-1, 1, 3}) {
    answer.header.channels = channels;
    EXPECT_THROW(decode_answer(encode_answer(answer)), InvalidArchive);
  }
}

}  // namespace
}  // namespace glowworm
