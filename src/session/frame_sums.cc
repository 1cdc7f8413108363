#include "session/frame_sums.h"

#include <cmath>
#include <limits>
#include <utility>

#include "core/parallel.h"

namespace glowworm {

namespace {

constexpr std::size_t kSummedAtOnce = 8192;

void add_to(std::vector<RGB>& sum, const std::vector<RGB>& more, std::size_t first, std::size_t last) {
  for (std::size_t i = first; i < last && i < more.size(); ++i) sum[i] += more[i];
}

RGB light_of(const SlotRadiance& r, LightPart part, std::size_t i) {
  switch (part) {
    case LightPart::all:
      return r.emitted[i] + r.direct[i] + r.indirect[i] + r.caustic[i];
    case LightPart::direct:
      return r.direct[i];
    case LightPart::indirect:
      return r.indirect[i];
    case LightPart::caustic:
      return r.caustic[i];
  }
  return RGB();
}

}  // namespace

void FrameSums::add(PassResult&& pass) {
  const std::size_t pixels = pass.first_hit.depth.size();
  if (count_ == 0) {
    sum_ = std::move(pass);
    hits_.assign(pixels, 0);
    for (std::size_t i = 0; i < pixels; ++i) {
      float& depth = sum_.first_hit.depth[i];
      hits_[i] = std::isfinite(depth) ? 1 : 0;
      if (!hits_[i]) depth = 0;
    }
  } else {
    parallel_for(0, pixels, kSummedAtOnce, [&](std::size_t first, std::size_t last) {
      add_to(sum_.radiance.emitted, pass.radiance.emitted, first, last);
      add_to(sum_.radiance.direct, pass.radiance.direct, first, last);
      add_to(sum_.radiance.indirect, pass.radiance.indirect, first, last);
      add_to(sum_.radiance.caustic, pass.radiance.caustic, first, last);
      add_to(sum_.first_hit.albedo, pass.first_hit.albedo, first, last);
      add_to(sum_.diagnosis, pass.diagnosis, first, last);
      for (std::size_t i = first; i < last; ++i) {
        sum_.first_hit.normal[i] += pass.first_hit.normal[i];
        if (!std::isfinite(pass.first_hit.depth[i])) continue;
        sum_.first_hit.depth[i] += pass.first_hit.depth[i];
        ++hits_[i];
      }
    });
  }
  ++count_;
}

ViewImage FrameSums::image(const Camera& camera, int width, int height, LightPart part, float factor) const {
  ViewImage out;
  out.camera = camera;
  out.width = width;
  out.height = height;
  const std::size_t pixels = hits_.size();
  out.light.resize(pixels);
  out.albedo.resize(pixels);
  out.normal.resize(pixels);
  out.depth.resize(pixels);
  const float share = 1.0f / static_cast<float>(count_);
  parallel_for(0, pixels, kSummedAtOnce, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      out.light[i] = light_of(sum_.radiance, part, i) * (share * factor);
      out.albedo[i] = sum_.first_hit.albedo[i] * share;
      const Vec3 normal = sum_.first_hit.normal[i];
      const float squared = length_squared(normal);
      out.normal[i] = squared > 0 ? normal / std::sqrt(squared) : Vec3{0, 0, 0};
      out.depth[i] =
          hits_[i] ? sum_.first_hit.depth[i] / static_cast<float>(hits_[i]) : std::numeric_limits<float>::infinity();
    }
  });
  return out;
}

std::vector<RGB> FrameSums::diagnosis() const {
  std::vector<RGB> means = sum_.diagnosis;
  for (RGB& mean : means) mean *= 1.0f / static_cast<float>(count_);
  return means;
}

}  // namespace glowworm
