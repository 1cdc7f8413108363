#include "photon/kept_paths.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <tuple>
#include <utility>

namespace glowworm {

std::uint64_t KeptChunk::bytes() const {
  return emitted.capacity() * sizeof(EmittedPath) + parts.capacity() * sizeof(Part) +
         photons.capacity() * sizeof(ChunkPhoton);
}

void KeptPaths::begin(const Tracer& tracer, const PhotonPassSettings& s, Guides guides, std::uint64_t most_bytes) {
  Pass pass{s.seed, s.pass, s.max_bounces, s.on_all_surfaces, std::move(guides)};
  std::optional<std::vector<Box3>> changed;
  if (pass_ == pass && moment_) changed = moment_->places_changed_in(tracer.scene());
  if (!changed) clear();
  changed_ = changed ? BoxTree(*changed) : BoxTree();
  pass_ = std::move(pass);
  kept_photons_ = 0;
  ++number_;
  most_bytes_ = most_bytes;
  keep_moment(tracer.scene());
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

bool KeptPaths::meets_nothing(Vec3 origin, std::span<const KeptChunk::Part> parts) const {
  for (const KeptChunk::Part& part : parts) {
    // A lamp may be far from all surfaces: the place of a hit is rounded as its distance from there.
    const float margin = kMarginOfChanges * std::max({std::abs(origin.x), std::abs(origin.y), std::abs(origin.z)});
    const bool meets = part.escapes() ? changed_.meets(origin, part.end, std::numeric_limits<float>::infinity(), margin)
                                      : changed_.meets(origin, part.end - origin, 1, margin);
    if (meets) return false;
    origin = part.end;
  }
  return true;
}

std::vector<bool> KeptPaths::staying_paths(const KeptChunk& before, const std::vector<EmittedPath>& emitted) const {
  std::vector<bool> out(emitted.size());
  if (before.moment == 0 || before.moment + 1 != number_) return out;
  const std::span<const KeptChunk::Part> parts = before.parts;
  for (std::size_t path = 0, first = 0; path < emitted.size(); ++path) {
    std::size_t end = first;
    while (end < parts.size() && parts[end].path() == path) ++end;
    out[path] = std::memcmp(&emitted[path], &before.emitted[path], sizeof(EmittedPath)) == 0 &&
                (changed_.empty() || meets_nothing(emitted[path].origin, parts.subspan(first, end - first)));
    first = end;
  }
  return out;
}

void KeptPaths::join(KeptChunk& before, const std::vector<bool>& stays, KeptChunk now, PhotonChunk& photons) {
  now.moment = number_;
  std::erase_if(before.parts, [&](const KeptChunk::Part& part) { return !stays[part.path()]; });
  now.parts.insert(now.parts.end(), before.parts.begin(), before.parts.end());
  std::stable_sort(now.parts.begin(), now.parts.end(),
                   [](const KeptChunk::Part& a, const KeptChunk::Part& b) { return a.path() < b.path(); });
  now.parts.shrink_to_fit();
  std::vector<ChunkPhoton> old;
  for (const ChunkPhoton& photon : before.photons)
    if (stays[photon.path]) old.push_back(photon);
  kept_photons_ += old.size();
  now.photons.resize(old.size() + photons.photons.size());
  std::merge(old.begin(), old.end(), photons.photons.begin(), photons.photons.end(), now.photons.begin(),
             [](const ChunkPhoton& a, const ChunkPhoton& b) {
               return std::tie(a.bounce, a.path) < std::tie(b.bounce, b.path);
             });
  photons.photons = now.photons;
  bytes_ -= before.bytes();
  before = take_room(now.bytes()) ? std::move(now) : KeptChunk();
}

}  // namespace glowworm
