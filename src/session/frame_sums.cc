#include "session/frame_sums.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "film/filtered.h"

namespace glowworm {

namespace {

ViewImage empty_image(const Camera& camera, int width, int height) {
  ViewImage out;
  out.camera = camera;
  out.width = width;
  out.height = height;
  const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  out.light.resize(pixels);
  out.albedo.resize(pixels);
  out.normal.resize(pixels);
  out.depth.resize(pixels);
  return out;
}

Vec3 unit(Vec3 normal) {
  const float squared = length_squared(normal);
  return squared > 0 ? normal / std::sqrt(squared) : Vec3{0, 0, 0};
}

RGB light_of(const SlotRadiance& r, LightPart part, std::size_t i) {
  switch (part) {
    case LightPart::all:
      return r.emitted[i] + r.direct[i] + r.indirect[i] + r.caustic[i] + (r.medium.empty() ? RGB() : r.medium[i]);
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

ViewImage pass_image(const PassResult& pass, const Camera& camera, int width, int height, LightPart part,
                     float factor) {
  ViewImage out = empty_image(camera, width, height);
  parallel_for_each(out.size(), 4096, [&](std::size_t i) {
    out.light[i] = light_of(pass.radiance, part, i) * factor;
    out.albedo[i] = pass.first_hit.albedo[i];
    out.normal[i] = unit(pass.first_hit.normal[i]);
    out.depth[i] = pass.first_hit.depth[i];
  });
  return out;
}

void FrameSums::clear() {
  film_.reset();
  reservation_.reset();
  diagnosis_.clear();
  count_ = 0;
}

void FrameSums::add(PassResult&& pass, int width, int height, LightPart part) {
  if (count_ == Film::kMaxSamples) return;
  if (!film_) {
    const PixelBounds bounds{0, 0, width, height};
    // With moments in any case, so that the filter may be turned on while the view rests.
    const PlaceLayers places{.surface_samples = true, .medium = !pass.radiance.medium.empty()};
    reservation_ = std::make_unique<Reservation>(budget_, "image", Film::bytes(bounds, true, places, true));
    film_.emplace(bounds, part == LightPart::indirect, true, places, true);
    diagnosis_.assign(pass.diagnosis.size(), RGB());
  }
  SlotRadiance& light = pass.radiance;
  const auto leave_out = [](std::vector<RGB>& layer) { std::fill(layer.begin(), layer.end(), RGB()); };
  // The film itself knows indirect light as a part.
  if (part == LightPart::direct || part == LightPart::caustic) {
    leave_out(light.emitted);
    leave_out(light.surface_emitted);
    leave_out(light.indirect);
    leave_out(light.medium);
    leave_out(part == LightPart::direct ? light.caustic : light.direct);
    if (part == LightPart::caustic) leave_out(light.sun);
  }
  film_->add(CameraTask{0, 0, width, height, count_, 1}, light, pass.first_hit, Geometry());
  parallel_for_each(diagnosis_.size(), 4096, [&](std::size_t i) { diagnosis_[i] += pass.diagnosis[i]; });
  ++count_;
}

ViewImage FrameSums::image(const Camera& camera, LightPart part, float factor, bool filtered) const {
  using Layer = Film::Layer;
  const bool indirect_only = part == LightPart::indirect;
  ViewImage out = empty_image(camera, film_->width(), film_->height());
  const Reservation memory(budget_, "filter", filtered ? out.size() * kFilterBytes : 0);
  if (filtered) out.light = filtered_picture(*film_, indirect_only).radiance;
  parallel_for_each(out.size(), 4096, [&](std::size_t i) {
    out.light[i] = (filtered ? out.light[i] : film_->radiance(i, indirect_only)) * factor;
    out.albedo[i] = film_->mean(Layer::albedo, i);
    const RGB n = film_->mean(Layer::normal, i);
    out.normal[i] = unit({n.r, n.g, n.b});
    out.depth[i] = film_->depth(i);
  });
  return out;
}

std::vector<RGB> FrameSums::diagnosis() const {
  std::vector<RGB> means = diagnosis_;
  for (RGB& mean : means) mean *= 1.0f / static_cast<float>(count_);
  return means;
}

}  // namespace glowworm
