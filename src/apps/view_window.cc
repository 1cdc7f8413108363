// The window: GLFW, OpenGL and Dear ImGui around a session. It contains no rendering.
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <utility>

#include "apps/commands.h"
#include "apps/interrupt.h"
#include "apps/view_input.h"
#include "apps/view_model.h"
#include "apps/view_options.h"
#include "apps/view_panel.h"
#include "core/error.h"
#include "core/log.h"

namespace glowworm {

namespace {

constexpr double kIdleSeconds = 0.1;       ///< interval between checks for signals, while nothing happens
constexpr double kBusySeconds = 1.0 / 60;  ///< interval while a key is held
/// Maximum time for which a script waits for a frame, in case the window is hidden or the state cannot be shown.
constexpr double kPatience = 0.2;

std::string last_glfw_error() {
  const char* text = nullptr;
  glfwGetError(&text);
  return text ? text : "no reason given";
}

/// Initialises GLFW, and terminates it at the end.
class GlfwLibrary {
 public:
  GlfwLibrary() {
    if (glfwInit() != GLFW_TRUE)
      throw Error(fmt::format("no window can be opened: {}", last_glfw_error()),
                  "Start it where there is a display (DISPLAY), or give --out FOLDER to render frames without one.");
  }
  ~GlfwLibrary() { glfwTerminate(); }
  GlfwLibrary(const GlfwLibrary&) = delete;
  GlfwLibrary& operator=(const GlfwLibrary&) = delete;
};

class Window {
 public:
  Window(const ViewOptions& options, const Script& script)
      : options_(options), script_(script), model_(options, script, [] { glfwPostEmptyEvent(); }) {
    create(1024, 640);
    model_.open(options.scene);
  }
  ~Window() { destroy(); }
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  int run();

 private:
  void create(int width, int height);
  void destroy();
  void fit_to_picture();
  void follow_size();
  void upload();
  void draw();
  void screenshot(const std::string& path);
  bool step_script();
  void act(const ScriptMove& move);
  bool hidden() const;
  bool context_lost() const;
  void recreate();

  const ViewOptions& options_;
  const Script& script_;
  GlfwLibrary library_;
  GLFWwindow* window_ = nullptr;
  ViewModel model_;
  ViewInput input_;
  Display display_;
  PictureArea area_;
  unsigned texture_ = 0;
  int texture_width_ = 0, texture_height_ = 0;
  bool busy_ = false, fitted_ = false;
  std::uint32_t script_frame_ = 0;  // next frame to play
  bool playing_ = false;            // a frame of the script is played, but not yet shown
  std::chrono::steady_clock::time_point played_;
  std::string shot_;           // screenshot to take after the next drawing
  bool shots_written_ = true;  // every screenshot so far
};

/// Set while a window is open. If the X server goes away, Xlib ends the program by exit(). Nothing may be destroyed
/// then, because the session's thread is still running.
bool window_is_open = false;

void end_at_once() {
  if (window_is_open) std::_Exit(1);
}

void Window::create(int width, int height) {
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 2);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  // Set before the window is created, so that the program notices a reset of the graphics driver and can recover.
  glfwWindowHint(GLFW_CONTEXT_ROBUSTNESS, GLFW_LOSE_CONTEXT_ON_RESET);
  window_ = glfwCreateWindow(std::max(width, 64), std::max(height, 64), "glowworm", nullptr, nullptr);
  glfwWindowHint(GLFW_CONTEXT_ROBUSTNESS, GLFW_NO_ROBUSTNESS);
  if (!window_) window_ = glfwCreateWindow(std::max(width, 64), std::max(height, 64), "glowworm", nullptr, nullptr);
  if (!window_)
    throw Error(fmt::format("no window with OpenGL 3.2 can be opened: {}", last_glfw_error()),
                "Install Mesa's drivers (libgl1-mesa-dri), or give --out FOLDER to render frames without a window.");
  glfwSetWindowUserPointer(window_, &model_);
  glfwMakeContextCurrent(window_);
  glfwSwapInterval(1);
  glfwSetDropCallback(window_, [](GLFWwindow* handle, int count, const char** paths) {
    if (count > 0) static_cast<ViewModel*>(glfwGetWindowUserPointer(handle))->open(paths[0]);
  });
  // Before ImGui's own callback, which calls it. ImGui would lose a key that is pressed and released between two
  // frames.
  glfwSetKeyCallback(window_, [](GLFWwindow* handle, int key, int, int action, int) {
    if (action != GLFW_PRESS) return;
    auto& model = *static_cast<ViewModel*>(glfwGetWindowUserPointer(handle));
    const bool help = key == GLFW_KEY_F1 || (key == GLFW_KEY_H && !ImGui::GetIO().WantTextInput);
    model.help = model.help != help;
    model.screenshot = model.screenshot || key == GLFW_KEY_F12;
    model.plays = model.plays != (key == GLFW_KEY_SPACE && !ImGui::GetIO().WantTextInput);
  });
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;  // write no settings file
  ImGui::StyleColorsDark();
  ImGui_ImplGlfw_InitForOpenGL(window_, true);
  ImGui_ImplOpenGL3_Init("#version 150");
  texture_width_ = texture_height_ = 0;
  glGenTextures(1, &texture_);
  model_.new_frame = model_.shown.has_value();
  window_is_open = true;
}

void Window::destroy() {
  if (!window_) return;
  glDeleteTextures(1, &texture_);
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
  glfwDestroyWindow(window_);
  window_ = nullptr;
  window_is_open = false;
}

/// Resizes the window for the first picture, within the limits of the screen.
void Window::fit_to_picture() {
  fitted_ = true;
  int width = model_.state.width + model_.panel_width, height = model_.state.height;
  if (GLFWmonitor* monitor = glfwGetPrimaryMonitor()) {
    int x, y, room_x = 0, room_y = 0;
    glfwGetMonitorWorkarea(monitor, &x, &y, &room_x, &room_y);
    if (room_x > 0 && room_y > 0) {
      width = std::min(width, room_x);
      height = std::min(height, room_y);
    }
  }
  glfwSetWindowSize(window_, width, height);
}

bool Window::hidden() const {
  int width = 0, height = 0;
  glfwGetWindowSize(window_, &width, &height);
  return glfwGetWindowAttrib(window_, GLFW_ICONIFIED) || width <= model_.panel_width || height < 1;
}

/// Fits the picture to the area beside the panel. A window of zero size renders nothing.
void Window::follow_size() {
  int width = 0, height = 0;
  glfwGetWindowSize(window_, &width, &height);
  const int room = width - model_.panel_width;
  model_.worker.pause(hidden());
  if (hidden() || !fitted_) return;
  model_.state.width = room;
  model_.state.height = height;
  area_ = {0, 0, static_cast<float>(room), static_cast<float>(height)};
}

void Window::upload() {
  if (!model_.shown || !(model_.new_frame || model_.picture_changed)) return;
  const ViewImage& image = model_.shown->frame.image;
  const std::vector<std::uint8_t>& bytes =
      display_.bytes(model_.shown->frame, model_.tone, model_.exposure, model_.options.color.view.get());
  glBindTexture(GL_TEXTURE_2D, texture_);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  if (image.width != texture_width_ || image.height != texture_height_) {
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, 0x812F);  // GL_CLAMP_TO_EDGE, of OpenGL 1.2
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, 0x812F);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, image.width, image.height, 0, GL_RGBA, GL_UNSIGNED_BYTE, bytes.data());
    texture_width_ = image.width;
    texture_height_ = image.height;
  } else {
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, image.width, image.height, GL_RGBA, GL_UNSIGNED_BYTE, bytes.data());
  }
  model_.new_frame = model_.picture_changed = false;
}

void Window::draw() {
  upload();
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
  int width = 0, height = 0;
  glfwGetWindowSize(window_, &width, &height);
  if (texture_width_ > 0 && area_.width > 0)
    ImGui::GetBackgroundDrawList()->AddImage(reinterpret_cast<ImTextureID>(static_cast<std::intptr_t>(texture_)),
                                             ImVec2(area_.x, area_.y),
                                             ImVec2(area_.x + area_.width, area_.y + area_.height));
  busy_ = input_.handle(model_, area_);
  input_.draw_gizmo(model_, area_);
  busy_ = draw_panel(model_, static_cast<float>(width), static_cast<float>(height)) || busy_;
  busy_ = model_.advance(double{ImGui::GetIO().DeltaTime}) || busy_;
  if (std::exchange(model_.screenshot, false)) shot_ = "screenshot.png";
  ImGui::Render();
  int pixels_x = 0, pixels_y = 0;
  glfwGetFramebufferSize(window_, &pixels_x, &pixels_y);
  glViewport(0, 0, pixels_x, pixels_y);
  glClearColor(0.1f, 0.1f, 0.1f, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  if (!shot_.empty()) screenshot(std::exchange(shot_, {}));
  glfwSwapBuffers(window_);
}

/// Writes the window as last drawn.
void Window::screenshot(const std::string& path) {
  int width = 0, height = 0;
  glfwGetFramebufferSize(window_, &width, &height);
  if (width < 1 || height < 1) return;
  const auto w = static_cast<std::size_t>(width), h = static_cast<std::size_t>(height);
  std::vector<std::uint8_t> bytes(3 * w * h);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, bytes.data());
  std::vector<RGB> pixels(w * h);
  for (std::size_t y = 0; y < h; ++y)
    for (std::size_t x = 0; x < w; ++x) {
      const std::uint8_t* from = &bytes[3 * ((h - 1 - y) * w + x)];
      pixels[y * w + x] = {srgb_decode(from[0]), srgb_decode(from[1]), srgb_decode(from[2])};
    }
  try {
    Image image(width, height);
    image.add_rgb("", pixels);
    write_image(path, image, ToneCurve::srgb);
    inform(fmt::format("wrote {}", path));
  } catch (const std::exception& error) {
    model_.say(error.what());
    shots_written_ = false;
  }
}

void Window::act(const ScriptMove& move) {
  if (move.drop) {
    // Simulates a drop on the window.
    const char* path = move.drop->c_str();
    const GLFWdropfun callback = glfwSetDropCallback(window_, nullptr);
    glfwSetDropCallback(window_, callback);
    callback(window_, 1, &path);
  }
  if (!move.window) return;
  const std::string& command = move.window->command;
  if (command == "resize") glfwSetWindowSize(window_, move.window->width, move.window->height);
  if (command == "minimise") glfwIconifyWindow(window_);
  if (command == "restore") glfwRestoreWindow(window_);
  if (command == "close") glfwSetWindowShouldClose(window_, GLFW_TRUE);
  if (command == "lose-context") recreate();
}

bool Window::context_lost() const {
  using Status = GLenum (*)();
  static const auto status = reinterpret_cast<Status>(glfwGetProcAddress("glGetGraphicsResetStatusARB"));
  return status && status() != GL_NO_ERROR;
}

/// Recreates the window and all objects of the graphics driver. The session is not affected.
void Window::recreate() {
  int width = 0, height = 0;
  glfwGetWindowSize(window_, &width, &height);
  destroy();
  create(width, height);
}

/// Plays one frame of the script when the previous one is shown. Returns false at the end of the script.
bool Window::step_script() {
  const bool bounded = options_.frames > 0 || !options_.script.empty();
  if (bounded && !model_.scene && model_.failed) return false;
  if (!bounded || !model_.scene || model_.worker.loading() || !fitted_) return true;
  const double waited = std::chrono::duration<double>(std::chrono::steady_clock::now() - played_).count();
  if (playing_) {
    if (!model_.shows_newest() && !((hidden() || model_.failed) && waited > kPatience)) return true;
    playing_ = false;
    for (const ScriptMove& move : script_.moves)
      if (move.screenshot && move.from == script_frame_) shot_ = *move.screenshot;
    ++script_frame_;
    return true;  // draw the present frame before it changes
  }
  if (script_frame_ >= (options_.frames > 0 ? options_.frames : script_length(script_))) return false;
  try {
    play(script_, script_frame_, *model_.scene->scene, *model_.rig, model_.shown ? &model_.shown->frame : nullptr,
         model_.state);
  } catch (const Error& error) {
    model_.say(error.what());
  }
  for (const ScriptMove& move : script_.moves)
    if (move.from == script_frame_) act(move);
  playing_ = true;
  played_ = std::chrono::steady_clock::now();
  model_.expect_frame();
  return true;
}

int Window::run() {
  while (!glfwWindowShouldClose(window_) && !caught_interrupt()) {
    glfwWaitEventsTimeout(busy_ ? kBusySeconds : kIdleSeconds);
    if (context_lost()) recreate();
    model_.take();
    if (model_.scene && !fitted_) fit_to_picture();
    follow_size();
    if (!step_script()) break;
    if (!hidden()) draw();
    model_.post(busy_);
  }
  if (model_.longest_latency > 0)
    detail(fmt::format("longest time from input to picture: {:.0f} ms", 1e3 * model_.longest_latency));
  if (caught_interrupt()) return kExitSignalled + caught_interrupt();
  return model_.scene && shots_written_ ? 0 : 1;
}

}  // namespace

int run_window_view(const ViewOptions& options, const Script& script) {
  std::atexit(end_at_once);
  Window window(options, script);
  catch_interrupts();
  return window.run();
}

}  // namespace glowworm
