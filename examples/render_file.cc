// Renders a scene file, or a built-in scene, to a picture: render_file SCENE OUTPUT
#include <glowworm/glowworm.h>

#include <exception>
#include <iostream>

namespace gw = glowworm::api;

int main(int argc, char** argv) {
  if (argc != 3) {
    std::cerr << "usage: render_file SCENE OUTPUT.exr|.png\n";
    return 2;
  }
  try {
    const gw::Scene scene = gw::Scene::load(argv[1]);
    for (const std::string& note : scene.notes()) std::cerr << "note: " << note << '\n';
    gw::RenderOptions options;
    options.width = 160;
    options.height = 120;
    options.samples = 4;
    gw::write_picture(argv[2], gw::render(scene, options));
    std::cout << scene.triangle_count() << " triangles rendered to " << argv[2] << '\n';
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
