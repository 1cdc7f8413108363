#include "gather/camera_rays.h"

#include <algorithm>
#include <limits>

#include "kernels/sobol.h"

namespace glowworm {

namespace {

/// Slot of the first sample of a pixel; kNone if it is not of the task.
std::uint32_t slot_of(const CameraTask& task, std::size_t first_slot, int x, int y) {
  if (x < task.x0 || x >= task.x1 || y < task.y0 || y >= task.y1 || !task.has(x, y)) return kNone;
  return static_cast<std::uint32_t>(first_slot) +
         static_cast<std::uint32_t>((y - task.y0) * (task.x1 - task.x0) + (x - task.x0));
}

}  // namespace

Ray ray_through(const Camera& camera, const CameraPassSettings& settings, Vec2 film, Vec2 lens) {
  const CameraRay ray = generate_ray(camera, film, settings.width, settings.height, lens);
  return {ray.origin, 0, ray.direction, ray.is_blind() ? -1 : std::numeric_limits<float>::infinity()};
}

void CameraRays::create(const Camera& camera, const CameraTask& task, std::size_t first_slot,
                        const CameraPassSettings& settings, const CameraSequence& sequence, int x0, int y0,
                        const BlockPixels& without) {
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
                   std::min(y + kSquare, y1), without);
    create(camera, settings, sequence, first, task.first_sample + s);
  }
}

void CameraRays::add_square(const CameraTask& task, std::size_t first_slot, int width, int x0, int y0, int x1, int y1,
                            const BlockPixels& without) {
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) {
      slot.push_back(without[index_in_block(x, y)] ? kNone : slot_of(task, first_slot, x, y));
      pixel.push_back(static_cast<std::uint32_t>(y) * static_cast<std::uint32_t>(width) +
                      static_cast<std::uint32_t>(x));
    }
}

void CameraRays::create_at(const BlockPixels& at, const Camera& camera, const CameraTask& task, std::size_t first_slot,
                           const CameraPassSettings& settings, int x0, int y0) {
  rays.clear();
  slot.clear();
  pixel.clear();
  for (int y = y0; y < std::min(y0 + CameraTask::kBlock, settings.height); ++y)
    for (int x = x0; x < std::min(x0 + CameraTask::kBlock, settings.width); ++x) {
      const std::uint32_t here = slot_of(task, first_slot, x, y);
      if (!at[index_in_block(x, y)] || here == kNone) continue;
      slot.resize(slot.size() + kSurfaceSamplesAtEdges, here);
      pixel.resize(slot.size(), static_cast<std::uint32_t>(y) * static_cast<std::uint32_t>(settings.width) +
                                    static_cast<std::uint32_t>(x));
    }
  for (std::size_t i = 0; i < slot.size(); ++i) {
    const CameraSequence sequence = sequence_at(i);
    Sampler sampler(SamplerKind::sobol, settings.seed, sequence.stream_of(pixel[i]),
                    sequence.place_of(task.first_sample));
    const Vec2 in_pixel = sampler.next2();
    add_ray(camera, settings, pixel[i], in_pixel, sampler.next2());
  }
}

void CameraRays::add_ray(const Camera& camera, const CameraPassSettings& settings, std::uint32_t at, Vec2 in_pixel,
                         Vec2 lens) {
  const auto width = static_cast<std::uint32_t>(settings.width);
  const Vec2 film{static_cast<float>(at % width) + in_pixel.x, static_cast<float>(at / width) + in_pixel.y};
  rays.push_back(ray_through(camera, settings, film, lens));
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
  for (std::size_t i = 0; i < n; ++i)
    add_ray(camera, settings, pixel[first + i], {film_x_[i], film_y_[i]},
            has_lens ? Vec2{lens_x_[i], lens_y_[i]} : Vec2());
}

}  // namespace glowworm
