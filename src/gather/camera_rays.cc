#include "gather/camera_rays.h"

#include <algorithm>
#include <limits>

#include "kernels/sobol.h"

namespace glowworm {

void CameraRays::create(const Camera& camera, const CameraTask& task, std::size_t first_slot,
                        const CameraPassSettings& settings, const CameraSequence& sequence, int x0, int y0) {
  rays.clear();
  slot.clear();
  pixel.clear();
  constexpr int kBlock = CameraTask::kBlock, kSquare = CameraTask::kSquare;
  const int x1 = std::min(x0 + kBlock, settings.width), y1 = std::min(y0 + kBlock, settings.height);
  for (std::uint32_t s = 0; s < task.sample_count; ++s) {
    const std::size_t first = slot.size();
    for (int y = y0; y < y1; y += kSquare)
      for (int x = x0; x < x1; x += kSquare)
        add_square(task, first_slot + s * task.pixel_count(), settings.width, x, y, std::min(x + kSquare, x1),
                   std::min(y + kSquare, y1));
    create(camera, settings, sequence, first, task.first_sample + s);
  }
}

void CameraRays::add_square(const CameraTask& task, std::size_t first_slot, int width, int x0, int y0, int x1, int y1) {
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) {
      const bool inside = x >= task.x0 && x < task.x1 && y >= task.y0 && y < task.y1 && task.has(x, y);
      const auto in_tile = static_cast<std::size_t>((y - task.y0) * (task.x1 - task.x0) + (x - task.x0));
      slot.push_back(inside ? static_cast<std::uint32_t>(first_slot + in_tile) : kNone);
      pixel.push_back(static_cast<std::uint32_t>(y) * static_cast<std::uint32_t>(width) +
                      static_cast<std::uint32_t>(x));
    }
}

void CameraRays::create(const Camera& camera, const CameraPassSettings& settings, const CameraSequence& sequence,
                        std::size_t first, std::uint32_t sample) {
  const std::size_t n = pixel.size() - first;
  stream_.resize(n);
  for (auto* numbers : {&film_x_, &film_y_, &lens_x_, &lens_y_}) numbers->resize(n);
  for (std::size_t i = 0; i < n; ++i) stream_[i] = sequence.stream_of(pixel[first + i]);
  const std::uint32_t place = sequence.place_of(sample);
  sobol_pairs_of(settings.seed, stream_.data(), n, place, 0, film_x_.data(), film_y_.data());
  const bool has_lens = camera.lens_radius > 0;
  if (has_lens) sobol_pairs_of(settings.seed, stream_.data(), n, place, 1, lens_x_.data(), lens_y_.data());
  const auto width = static_cast<std::uint32_t>(settings.width);
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint32_t at = pixel[first + i];
    const Vec2 film{static_cast<float>(at % width) + film_x_[i], static_cast<float>(at / width) + film_y_[i]};
    const Vec2 lens = has_lens ? Vec2{lens_x_[i], lens_y_[i]} : Vec2();
    const CameraRay ray = generate_ray(camera, film, settings.width, settings.height, lens);
    // A ray that ends before it starts meets nothing.
    rays.push_back({ray.origin, 0, ray.direction, ray.is_blind() ? -1 : std::numeric_limits<float>::infinity()});
  }
}

}  // namespace glowworm
