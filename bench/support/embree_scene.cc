#include "support/embree_scene.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <utility>

namespace glowworm::bench {

namespace {

/// Corners of a quadrilateral as Embree divides it: triangles (0, 1, 3) and (2, 3, 1).
using Quad = std::array<std::uint32_t, 4>;

/// The triangles of a scene in pairs that share an edge; one that has no partner is a quadrilateral with a side of no
/// length. The same surfaces, hit at the same places.
std::vector<Quad> quads_of(const Geometry& geometry) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> by_edge;  // of triangles without a partner so far
  std::vector<Quad> quads;
  std::vector<std::uint8_t> paired(geometry.triangles.size());
  const auto corner = [&](std::size_t t, int i) { return geometry.triangles[t][static_cast<std::size_t>(i % 3)]; };
  for (std::size_t t = 0; t < geometry.triangles.size(); ++t) {
    for (int e = 0; e < 3 && !paired[t]; ++e) {
      const auto found = by_edge.find({corner(t, e + 1), corner(t, e)});
      if (found == by_edge.end() || paired[found->second]) continue;
      const std::size_t other = found->second;
      for (int o = 0; o < 3; ++o)
        if (corner(other, o) == corner(t, e + 1))
          quads.push_back({corner(other, o + 2), corner(other, o), corner(t, e + 2), corner(other, o + 1)});
      paired[t] = paired[other] = 1;
    }
    for (int e = 0; e < 3 && !paired[t]; ++e) by_edge[{corner(t, e), corner(t, e + 1)}] = t;
  }
  for (std::size_t t = 0; t < geometry.triangles.size(); ++t)
    if (!paired[t]) quads.push_back({corner(t, 0), corner(t, 1), corner(t, 2), corner(t, 2)});
  return quads;
}

template <std::size_t kCount>
void stream(RTCScene world, const std::vector<Ray>& rays, std::vector<Hit>& hits, RTCIntersectContext& context) {
  std::vector<RTCRayHit> queries(kCount);
  for (std::size_t first = 0; first < rays.size(); first += kCount) {
    const std::size_t n = std::min(kCount, rays.size() - first);
    for (std::size_t i = 0; i < n; ++i) {
      const Ray& r = rays[first + i];
      queries[i].ray = {r.origin.x, r.origin.y, r.origin.z, r.t_min, r.direction.x, r.direction.y, r.direction.z, 0,
                        r.t_max,    ~0u,        0,          0};
      queries[i].hit.geomID = RTC_INVALID_GEOMETRY_ID;
      queries[i].hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    }
    if constexpr (kCount == 1)
      rtcIntersect1(world, &context, queries.data());
    else
      rtcIntersect1M(world, &context, queries.data(), static_cast<unsigned>(n), sizeof(RTCRayHit));
    for (std::size_t i = 0; i < n; ++i)
      hits[first + i] = {queries[i].ray.tfar,
                         queries[i].hit.geomID == RTC_INVALID_GEOMETRY_ID ? kNone : queries[i].hit.primID,
                         {queries[i].hit.u, queries[i].hit.v}};
  }
}

void call(const int* v, RTCScene s, RTCIntersectContext* c, RTCRayHit4* p) { rtcIntersect4(v, s, c, p); }
void call(const int* v, RTCScene s, RTCIntersectContext* c, RTCRayHit8* p) { rtcIntersect8(v, s, c, p); }
void call(const int* v, RTCScene s, RTCIntersectContext* c, RTCRayHit16* p) { rtcIntersect16(v, s, c, p); }

template <typename Packet, std::size_t kWidth>
void packets(RTCScene world, const std::vector<Ray>& rays, std::vector<Hit>& hits, RTCIntersectContext& context) {
  for (std::size_t first = 0; first < rays.size(); first += kWidth) {
    const std::size_t n = std::min(kWidth, rays.size() - first);
    Packet p;
    alignas(64) int valid[kWidth];
    for (std::size_t i = 0; i < kWidth; ++i) {
      const Ray& r = rays[first + std::min(i, n - 1)];
      valid[i] = i < n ? -1 : 0;
      p.ray.org_x[i] = r.origin.x;
      p.ray.org_y[i] = r.origin.y;
      p.ray.org_z[i] = r.origin.z;
      p.ray.tnear[i] = r.t_min;
      p.ray.dir_x[i] = r.direction.x;
      p.ray.dir_y[i] = r.direction.y;
      p.ray.dir_z[i] = r.direction.z;
      p.ray.tfar[i] = r.t_max;
      p.ray.time[i] = 0;
      p.ray.mask[i] = ~0u;
      p.ray.flags[i] = 0;
      p.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    }
    call(valid, world, &context, &p);
    for (std::size_t i = 0; i < n; ++i)
      hits[first + i] = {p.ray.tfar[i],
                         p.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID ? kNone : p.hit.primID[i],
                         {p.hit.u[i], p.hit.v[i]}};
  }
}

}  // namespace

const char* name(Way way) {
  static constexpr const char* names[] = {"single", "packets of 4", "packets of 8", "packets of 16", "stream of 1024"};
  return names[static_cast<std::size_t>(way)];
}

EmbreeScene::EmbreeScene(const Scene& scene, const char* config, RTCBuildQuality quality, RTCSceneFlags flags,
                         bool as_quads)
    : device_(rtcNewDevice(config)), world_(rtcNewScene(device_)) {
  const Geometry& g = scene.geometry();
  RTCGeometry geometry = rtcNewGeometry(device_, as_quads ? RTC_GEOMETRY_TYPE_QUAD : RTC_GEOMETRY_TYPE_TRIANGLE);
  std::memcpy(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3), g.positions.size()),
      g.positions.data(), g.positions.size() * sizeof(Vec3));
  if (as_quads) {
    const std::vector<Quad> quads = quads_of(g);
    std::memcpy(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, sizeof(Quad), quads.size()),
        quads.data(), quads.size() * sizeof(Quad));
  } else {
    std::memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, g.triangles.size()),
                g.triangles.data(), g.triangles.size() * 12);
  }
  rtcSetGeometryBuildQuality(geometry, quality);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(world_, geometry);
  rtcReleaseGeometry(geometry);
  rtcSetSceneBuildQuality(world_, quality);
  rtcSetSceneFlags(world_, flags);
  rtcCommitScene(world_);
}

EmbreeScene::~EmbreeScene() {
  rtcReleaseScene(world_);
  rtcReleaseDevice(device_);
}

void EmbreeScene::trace(const std::vector<Ray>& rays, std::vector<Hit>& hits, Way way, bool coherent) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  switch (way) {
    case Way::single:
      return stream<1>(world_, rays, hits, context);
    case Way::stream:
      return stream<1024>(world_, rays, hits, context);
    case Way::packet4:
      return packets<RTCRayHit4, 4>(world_, rays, hits, context);
    case Way::packet8:
      return packets<RTCRayHit8, 8>(world_, rays, hits, context);
    case Way::packet16:
      return packets<RTCRayHit16, 16>(world_, rays, hits, context);
  }
}

}  // namespace glowworm::bench
