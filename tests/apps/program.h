// Runs the program as a user does, in its own folder.
#pragma once
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "support/temporary_folder.h"

namespace glowworm {

/// How a run ended.
struct Outcome {
  int status = -1;  ///< exit status; 128 and the signal's number where a signal ended it
  std::string out, err;
};

/// A child process running the program; its output goes to files of the folder.
class Running {
 public:
  /// @param prepare is called in the child before the program starts; it may only call what is safe after a fork
  Running(const std::filesystem::path& folder, const std::vector<std::string>& arguments,
          const std::function<void()>& prepare = {});
  ~Running();
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;

  void send(int signal_number) const;
  pid_t id() const { return process_; }
  /// What it has written to standard error so far.
  std::string errors_so_far() const;
  /// Whether standard error holds the text before the time is over.
  bool wait_for_text(const std::string& text, double seconds) const;
  Outcome wait();

 private:
  std::filesystem::path out_, err_;
  pid_t process_ = -1;
};

/// A test whose program runs in its folder. Logs lie apart, so that names() holds what the program made alone.
class ProgramTest : public FolderTest {
 protected:
  ~ProgramTest() override { std::filesystem::remove_all(folder_.string() + "-logs"); }

  static std::string read(const std::filesystem::path& file);
  nlohmann::json read_json(const std::string& name) const;
  /// Whether the condition holds before the time is over.
  static bool wait_until(const std::function<bool()>& condition, double seconds);
  /// Whether the file is there before the time is over.
  bool wait_for_file(const std::string& name, double seconds) const;

  Outcome run(const std::vector<std::string>& arguments, const std::function<void()>& prepare = {}) const;
  /// Runs `render` in a size that takes no time: 16x16 pixels, 1 sample, 4 gather rays, 2000 photons without guides;
  /// with guides if `more` gives the number of photons.
  Outcome render(const std::string& scene, const std::vector<std::string>& more,
                 const std::function<void()>& prepare = {}) const;

  /// Writes scenes of several files: a.pbrt with inner.pbrt, part.ply, wood.png and sky.exr; a.obj with a.mtl and
  /// wood.png; a.gltf with a.bin and wood.png.
  void write_scenes() const;
};

/// The program refused: "glowworm: error:" with all of the texts, and status 1, or 2 for command lines without sense.
testing::AssertionResult refused(const Outcome& outcome, const std::vector<std::string>& texts, int status = 1);

}  // namespace glowworm
