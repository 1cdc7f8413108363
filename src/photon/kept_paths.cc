#include "photon/kept_paths.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <utility>

#include "photon/photon_walk.h"

namespace glowworm {

namespace {

using Places = std::vector<PlaceOnPath>;

template <typename Array>
void append(Array& to, const Array& from) {
  if constexpr (requires { to.append(from); })
    to.append(from);
  else
    to.insert(to.end(), from.begin(), from.end());
}

/// Element i of the result is element order[i] of an array or batch.
template <typename Array>
Array in_order(Array& from, std::span<const std::uint32_t> order) {
  if constexpr (requires { from.permuted(order); }) {
    return from.permuted(order);
  } else {
    const auto out = permuted(std::span(from), order);
    return {out.begin(), out.end()};
  }
}

/// Joins what paths left at the moment before that stay with what others left now, in order of places.
/// @param before, places_before become empty
template <typename Array>
void join_left(Array& before, Places& places_before, const std::vector<bool>& stays, Array& now, Places& places) {
  std::vector<std::uint32_t> order;
  for (std::uint32_t i = 0; i < places_before.size(); ++i)
    if (stays[places_before[i].path]) order.push_back(i);
  for (std::uint32_t i = 0; i < places.size(); ++i)
    order.push_back(static_cast<std::uint32_t>(places_before.size()) + i);
  append(before, now);
  append(places_before, places);
  now = std::exchange(before, {});
  places = std::exchange(places_before, {});
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return places[a] < places[b]; });
  now = in_order(now, order);
  places = in_order(places, order);
}

/// The same for an array whose elements tell their places.
template <typename T, typename PlaceOf>
void join_left(std::vector<T>& before, const std::vector<bool>& stays, std::vector<T>& now, const PlaceOf& place_of) {
  Places places_before, places;
  std::transform(before.begin(), before.end(), std::back_inserter(places_before), place_of);
  std::transform(now.begin(), now.end(), std::back_inserter(places), place_of);
  join_left(before, places_before, stays, now, places);
}

}  // namespace

void KeptPaths::begin(const Tracer& tracer, const PhotonPassSettings& s, Guides guides, std::uint64_t most_bytes) {
  const Scene& scene = tracer.scene();
  Pass pass{s.seed, s.pass, s.max_bounces, s.on_all_surfaces, std::move(guides), {}};
  if (scene.crosses_media()) {
    const Box3 box = looked_at_box(scene, s.importance);
    pass.looked_at = {box.min, box.max};
  }
  std::optional<std::vector<Box3>> changed;
  if (pass_ == pass && moment_) changed = moment_->places_changed_in(scene);
  if (!changed) clear();
  changed_ = changed ? BoxTree(*changed) : BoxTree();
  pass_ = std::move(pass);
  kept_photons_ = 0;
  ++number_;
  most_bytes_ = most_bytes;
  keep_moment(scene);
}

void KeptPaths::keep_moment(const Scene& scene) {
  bytes_ -= std::exchange(moment_bytes_, 0);
  moment_.emplace(scene);
  if (bytes_ + moment_->bytes() > most_bytes_) chunks_.clear(), bytes_ = 0;
  if (take_room(moment_->bytes())) {
    moment_bytes_ = moment_->bytes();
  } else {
    moment_.reset();
    most_bytes_ = 0;
  }
}

void KeptPaths::clear() {
  chunks_.clear();
  pass_.reset();
  moment_.reset();
  bytes_ = moment_bytes_ = 0;
}

KeptChunk& KeptPaths::chunk(std::uint64_t number) {
  const std::scoped_lock lock(mutex_);
  if (number >= chunks_.size()) chunks_.resize(number + 1);
  if (!chunks_[number]) chunks_[number] = std::make_unique<KeptChunk>();
  return *chunks_[number];
}

bool KeptPaths::take_room(std::uint64_t bytes) {
  std::uint64_t taken = bytes_;
  do {
    if (taken + bytes > most_bytes_) return false;
  } while (!bytes_.compare_exchange_weak(taken, taken + bytes));
  return true;
}

bool KeptPaths::meets_nothing(Vec3 origin, std::span<const PathPart> parts) const {
  for (const PathPart& part : parts) {
    // A lamp may be far from all surfaces: the place of a hit is rounded as its distance from there.
    const float margin = kMarginOfChanges * std::max({std::abs(origin.x), std::abs(origin.y), std::abs(origin.z)});
    const bool meets = part.escapes() ? changed_.meets(origin, part.end, std::numeric_limits<float>::infinity(), margin)
                                      : changed_.meets(origin, part.end - origin, 1, margin);
    if (meets) return false;
    if (!part.is_aside()) origin = part.end;
  }
  return true;
}

std::vector<bool> KeptPaths::staying_paths(const KeptChunk& before, const std::vector<EmittedPath>& emitted) const {
  std::vector<bool> out(emitted.size());
  if (before.moment == 0 || before.moment + 1 != number_) return out;
  const std::span<const PathPart> parts = before.left.parts;
  for (std::size_t path = 0, first = 0; path < emitted.size(); ++path) {
    std::size_t end = first;
    while (end < parts.size() && parts[end].path() == path) ++end;
    out[path] = std::memcmp(&emitted[path], &before.emitted[path], sizeof(EmittedPath)) == 0 &&
                (changed_.empty() || meets_nothing(emitted[path].origin, parts.subspan(first, end - first)));
    first = end;
  }
  return out;
}

void KeptPaths::join(KeptChunk& before, const std::vector<bool>& stays, std::vector<EmittedPath> emitted,
                     PathPhotons& now) {
  bytes_ -= before.bytes();
  const std::uint64_t traced = now.count();
  PathPhotons& old = before.left;
  join_left(old.parts, stays, now.parts, [](const PathPart& p) { return PlaceOnPath{0, p.path()}; });
  join_left(old.photons, stays, now.photons, [](const ChunkPhoton& p) { return PlaceOnPath{p.bounce, p.path}; });
  join_left(old.in_media, old.in_media_place, stays, now.in_media, now.in_media_place);
  join_left(old.beams, old.beam_place, stays, now.beams, now.beam_place);
  kept_photons_ += now.count() - traced;
  KeptChunk next{number_, std::move(emitted), now};
  before = take_room(next.bytes()) ? std::move(next) : KeptChunk();
}

}  // namespace glowworm
