// Shows progress, and stops a render after a time: progress [SECONDS]
#include <glowworm/glowworm.h>

#include <chrono>
#include <cstdlib>
#include <iostream>
#include <thread>

namespace gw = glowworm::api;

int main(int argc, char** argv) {
  const double seconds = argc > 1 ? std::atof(argv[1]) : 2;
  const gw::Scene scene = gw::Scene::load("builtin:cornell");
  gw::RenderOptions options;
  options.width = options.height = 128;
  options.samples = 1024;
  gw::Render render(scene, options);
  const auto start = std::chrono::steady_clock::now();
  while (!render.done()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    std::cout << static_cast<int>(100 * render.progress()) << "% " << std::flush;
    if (std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() > seconds) render.cancel();
  }
  render.wait();
  // What was done until then is a picture of fewer samples.
  gw::write_picture("progress.png", render.picture());
  std::cout << (render.cancelled() ? "\ncancelled" : "\ndone") << ": the picture is in progress.png\n";
}
