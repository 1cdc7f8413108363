#include "program.h"

#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <thread>

#include "image/image.h"

namespace glowworm {

namespace {

std::string read_whole(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace

Running::Running(const std::filesystem::path& folder, const std::vector<std::string>& arguments,
                 const std::function<void()>& prepare) {
  static int runs = 0;
  const std::filesystem::path logs = folder.string() + "-logs";
  std::filesystem::create_directories(logs);
  out_ = logs / ("out" + std::to_string(++runs));
  err_ = logs / ("err" + std::to_string(runs));
  std::vector<std::string> texts = {GLOWWORM_PROGRAM};
  texts.insert(texts.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  process_ = fork();
  if (process_ != 0) return;
  // A test runner's shell may have had signals ignored, which a program inherits.
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) signal(number, SIG_DFL);
  const int out = open(out_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  const int err = open(err_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  if (out < 0 || err < 0 || dup2(out, STDOUT_FILENO) < 0 || dup2(err, STDERR_FILENO) < 0) _exit(99);
  if (chdir(folder.c_str()) != 0) _exit(99);
  if (prepare) prepare();
  execv(pointers[0], pointers.data());
  _exit(99);
}

Running::~Running() {
  if (process_ > 0) {
    kill(process_, SIGKILL);
    wait();
  }
}

void Running::send(int signal_number) const { kill(process_, signal_number); }

std::string Running::errors_so_far() const { return read_whole(err_); }

bool Running::wait_for_text(const std::string& text, double seconds) const {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (std::chrono::steady_clock::now() < end) {
    if (errors_so_far().find(text) != std::string::npos) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return false;
}

Outcome Running::wait() {
  Outcome outcome;
  int status = 0;
  if (waitpid(process_, &status, 0) == process_)
    outcome.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  process_ = -1;
  outcome.out = read_whole(out_);
  outcome.err = read_whole(err_);
  return outcome;
}

std::string ProgramTest::read(const std::filesystem::path& file) { return read_whole(file); }

nlohmann::json ProgramTest::read_json(const std::string& name) const {
  return nlohmann::json::parse(read(folder_ / name));
}

bool ProgramTest::wait_until(const std::function<bool()>& condition, double seconds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (std::chrono::steady_clock::now() < end) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return false;
}

bool ProgramTest::wait_for_file(const std::string& name, double seconds) const {
  return wait_until([&] { return std::filesystem::exists(folder_ / name); }, seconds);
}

void ProgramTest::write_scenes() const {
  Image image(3, 2);
  image.add_rgb("", std::vector<RGB>(6, RGB(0.5f)));
  write_png(path("wood.png"), image);
  write_exr(path("sky.exr"), image);
  write("part.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n-1 0 -1\n-1 0 1\n1 0 1\n3 0 1 2\n");
  write("inner.pbrt", "Shape \"plymesh\" \"string filename\" \"part.ply\"\n");
  write("a.pbrt",
        "Camera \"perspective\"\nWorldBegin\nLightSource \"infinite\" \"string filename\" \"sky.exr\"\n"
        "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"wood.png\"\n"
        "Material \"diffuse\" \"texture reflectance\" \"t\"\nInclude \"inner.pbrt\"\n");
  write("a.mtl", "newmtl m\nmap_Kd wood.png\n");
  write("a.obj", "mtllib a.mtl\nv -1 0 -1\nv -1 0 1\nv 1 0 1\nusemtl m\nf 1 2 3\n");
  write("a.bin", std::string(14, '\0') + "\x80\x3f" + std::string(14, '\0') + "\x80\x3f" + std::string(4, '\0'));
  write("a.gltf", R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
      "buffers": [{"uri": "a.bin", "byteLength": 36}], "bufferViews": [{"buffer": 0, "byteLength": 36}],
      "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                     "min": [0, 0, 0], "max": [1, 1, 0]}],
      "images": [{"uri": "wood.png"}], "textures": [{"source": 0}],
      "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
      "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}]})");
}

Outcome ProgramTest::run(const std::vector<std::string>& arguments, const std::function<void()>& prepare) const {
  return Running(folder_, arguments, prepare).wait();
}

Outcome ProgramTest::render(const std::string& scene, const std::vector<std::string>& more,
                            const std::function<void()>& prepare) const {
  std::vector<std::string> arguments = {"render", scene};
  const auto add_unless_given = [&](const std::string& option, const std::string& value) {
    if (std::find(more.begin(), more.end(), option) != more.end()) return;
    arguments.push_back(option);
    arguments.push_back(value);
  };
  add_unless_given("--size", "16x16");
  add_unless_given("--samples", "1");
  if (std::find(more.begin(), more.end(), "path") == more.end()) {
    add_unless_given("--gather", "4");
    // To learn where photons are needed takes longer than such a render.
    if (std::find(more.begin(), more.end(), "--photons") == more.end())
      arguments.insert(arguments.end(), {"--photons", "2k", "--no-guiding"});
  }
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run(arguments, prepare);
}

testing::AssertionResult refused(const Outcome& outcome, const std::vector<std::string>& texts, int status) {
  if (outcome.status != status)
    return testing::AssertionFailure() << "exit status " << outcome.status << ", not " << status << "; it said:\n"
                                       << outcome.err;
  if (outcome.err.find("glowworm: error: ") == std::string::npos)
    return testing::AssertionFailure() << "no message of the program's own, but:\n" << outcome.err;
  for (const std::string& text : texts)
    if (outcome.err.find(text) == std::string::npos)
      return testing::AssertionFailure() << "the message does not hold '" << text << "':\n" << outcome.err;
  return testing::AssertionSuccess();
}

}  // namespace glowworm
