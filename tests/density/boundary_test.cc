#include "density/boundary.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "core/parallel.h"
#include "density/kernel.h"
#include "scene/mesh_builder.h"
#include "scene/scene.h"

namespace glowworm {
namespace {

constexpr KernelShape kShapes[] = {KernelShape::box, KernelShape::cone, KernelShape::epanechnikov,
                                   KernelShape::gaussian};

/// Unit squares facing up, at the heights given.
Scene squares(std::initializer_list<float> heights) {
  SceneDescription d;
  d.name = "squares";
  d.materials.emplace_back();
  for (const float z : heights) {
    const auto first = static_cast<std::uint32_t>(d.geometry.positions.size());
    for (const Vec3 p : {Vec3{0, 0, z}, Vec3{1, 0, z}, Vec3{1, 1, z}, Vec3{0, 1, z}}) d.geometry.positions.push_back(p);
    d.geometry.normals.resize(d.geometry.positions.size());
    d.geometry.uvs.resize(d.geometry.positions.size());
    for (const auto& t : {std::array<std::uint32_t, 3>{0, 1, 2}, std::array<std::uint32_t, 3>{0, 2, 3}}) {
      d.geometry.triangles.push_back({first + t[0], first + t[1], first + t[2]});
      d.geometry.material.push_back(0);
      d.geometry.emission.push_back(kNone);
    }
  }
  return Scene(std::move(d));
}

/// Many photons at one place, so that the mean of their factors' inverses measures the mass there.
PhotonBatch photons_at(Vec3 place, std::size_t n) {
  PhotonBatch photons;
  for (std::size_t i = 0; i < n; ++i) photons.push_back(place, {0, 0, 1}, RGB(1.0f), {0, 0, 1});
  return photons;
}

double mean_mass(const Tracer& tracer, Vec3 place, KernelShape kernel, float radius) {
  RadiusPolicy policy;
  policy.kind = RadiusKind::fixed;
  policy.radius = radius;
  policy.kernel = kernel;
  const std::vector<float> factors = boundary_factors(tracer, photons_at(place, 2000), policy);
  double sum = 0;
  for (const float f : factors) sum += 1 / f;
  return sum / static_cast<double>(factors.size());
}

TEST(BoundaryTest, KernelDistancesFollowTheKernel) {
  for (const KernelShape shape : kShapes)
    for (int i = 1; i < 100; ++i) {
      // The share of the kernel's mass within the distance for u must be u: integrate 2 pi d K(d) by the midpoint rule.
      const double u = i / 100.0, end = sample_kernel_distance(shape, static_cast<float>(u));
      double mass = 0;
      constexpr int steps = 2000;
      for (int s = 0; s < steps; ++s) {
        const double d = end * (s + 0.5) / steps;
        mass += 2 * std::numbers::pi * d * kernel(shape, d * d) * end / steps;
      }
      EXPECT_NEAR(mass, u, 2e-6) << static_cast<int>(shape) << " " << u;
    }
}

TEST(BoundaryTest, PlainSurfaceLosesNothing) {
  const Scene scene = squares({0});
  const Tracer tracer(scene);
  for (const KernelShape shape : kShapes) EXPECT_EQ(mean_mass(tracer, {0.5f, 0.5f, 0}, shape, 0.3f), 1.0);
}

TEST(BoundaryTest, HalfOfTheDiscIsLostAtAnEdgeAndThreeQuartersAtACorner) {
  const Scene scene = squares({0});
  const Tracer tracer(scene);
  // 32 lines a photon, 2000 photons: the standard error of the share is under 0.002.
  for (const KernelShape shape : kShapes) {
    EXPECT_NEAR(mean_mass(tracer, {0.5f, 1e-4f, 0}, shape, 0.3f), 0.5, 0.008);
    EXPECT_NEAR(mean_mass(tracer, {1e-4f, 1e-4f, 0}, shape, 0.3f), 0.25, 0.008);
  }
}

TEST(BoundaryTest, ParallelSurfacesCountTogether) {
  const Scene scene = squares({0, 0.15f});
  const Tracer tracer(scene);
  // The box kernel over the other square: the part of its disc within the ball, 1 - (0.15 / 0.3)^2. Both squares face
  // up, so nothing is a solid's far side.
  EXPECT_NEAR(mean_mass(tracer, {0.5f, 0.5f, 0}, KernelShape::box, 0.3f), 1.75, 0.01);
}

/// A unit floor facing up, and a solid standing on it over the half with x > 0.5, which has no bottom of its own.
Scene floor_under_block() {
  SceneDescription d;
  d.name = "floor under block";
  d.materials.emplace_back();
  MeshBuilder mesh(d.geometry);
  mesh.set_material(0);
  mesh.quad({0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0});
  mesh.box({0.5f, -1, 0}, {2, 2, 0.2f}, MeshBuilder::kAllFaces & ~MeshBuilder::kMinZ);
  return Scene(std::move(d));
}

TEST(BoundaryTest, WhatASolidStandsOnDoesNotCount) {
  const Scene scene = floor_under_block();
  const Tracer tracer(scene);
  // The kernel reaches 0.1 into the block from a photon at its foot, over a floor that nobody sees; lines begin inside
  // the block as well as above it.
  for (const float radius : {0.1f, 0.3f})
    EXPECT_NEAR(mean_mass(tracer, {0.4995f, 0.5f, 0}, KernelShape::box, radius),
                radius < 0.2f ? 0.5 : 0.5 * (1 + 1 - 0.2 * 0.2 / 0.09), 0.01);
}

TEST(BoundaryTest, WhatLiesUnderALayerDoesNotCount) {
  SceneDescription d;
  d.name = "carpet";
  d.materials.emplace_back();
  MeshBuilder mesh(d.geometry);
  mesh.set_material(0);
  mesh.quad({0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0});
  mesh.box({0.1f, 0.1f, 0}, {0.9f, 0.9f, 0.01f}, MeshBuilder::kAllFaces & ~MeshBuilder::kMinZ);
  const Scene scene(std::move(d));
  const Tracer tracer(scene);
  EXPECT_NEAR(mean_mass(tracer, {0.5f, 0.5f, 0.01f}, KernelShape::epanechnikov, 0.2f), 1.0, 1e-6);
}

TEST(BoundaryTest, SameForAnyNumberOfThreads) {
  const Scene scene = squares({0});
  const Tracer tracer(scene);
  PhotonBatch photons;
  for (int i = 0; i < 3000; ++i)
    photons.push_back({0.001f * static_cast<float>(i % 1000), 0.02f, 0}, {0, 0, 1}, RGB(1.0f), {0, 0, 1});
  RadiusPolicy policy;
  policy.radii.assign(photons.size(), 0.05f);
  set_thread_count(1);
  const std::vector<float> one = boundary_factors(tracer, photons, policy);
  set_thread_count(2);
  EXPECT_EQ(one, boundary_factors(tracer, photons, policy));
  set_thread_count(0);
}

}  // namespace
}  // namespace glowworm
