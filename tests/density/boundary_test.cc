#include "maps/boundary.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>

#include "builtin/mesh_builder.h"
#include "core/parallel.h"
#include "maps/kernel_cuts.h"
#include "maps/nearby_surface.h"
#include "scene/scene.h"

namespace glowworm {
namespace {

/// So many copies of a scene stand in a grid, with one photon each: every mass is measured by lines of its own. All are
/// near the origin, where floats resolve far less than the thickness of their parts.
constexpr int kCopiesAlong = 32, kCopies = kCopiesAlong * kCopiesAlong;
constexpr float kSpacing = 8;

Vec3 place_of(int copy) {
  const auto at = [](int cell) { return kSpacing * static_cast<float>(cell % kCopiesAlong - kCopiesAlong / 2); };
  return {at(copy), at(copy / kCopiesAlong), 0};
}

/// Materials other than diffuse.
constexpr std::uint32_t kInterface = 1, kPane = 2, kMirror = 3;

/// Copies of what `build` makes.
Scene copies(const char* name, const std::function<void(MeshBuilder&)>& build) {
  SceneDescription d;
  d.name = name;
  d.materials.resize(4);
  d.materials[kInterface].kind = MaterialKind::interface;
  d.materials[kPane].kind = MaterialKind::thin_dielectric;
  d.materials[kMirror].kind = MaterialKind::conductor;
  MeshBuilder mesh(d.geometry);
  for (int i = 0; i < kCopies; ++i) {
    mesh.set_material(0);
    Transform place;
    place.translation = place_of(i);
    mesh.set_transform(place);
    build(mesh);
  }
  return Scene(std::move(d));
}

/// Unit squares facing up, at the heights given.
Scene squares(std::initializer_list<float> heights) {
  return copies("squares", [&](MeshBuilder& mesh) {
    for (const float z : heights) mesh.quad({0, 0, z}, {1, 0, z}, {1, 1, z}, {0, 1, z});
  });
}

/// A mean and its standard error.
struct Measured {
  double mean = 0, error = 0;
};

/// The mass at a place of every copy: one over the factor there.
Measured measure(const Tracer& tracer, Vec3 place, KernelShape kernel, float radius, const LitSides& sides = {}) {
  RadiusPolicy policy;
  policy.kind = RadiusKind::fixed;
  policy.radius = radius;
  policy.kernel = kernel;
  PhotonBatch photons;
  for (int i = 0; i < kCopies; ++i) photons.push_back(place + place_of(i), {0, 0, 1}, RGB(1.0f), {0, 0, 1});
  double sum = 0, squares = 0;
  for (const float f : boundary_factors(tracer, photons, policy, sides)) {
    sum += 1 / f;
    squares += 1 / (double(f) * f);
  }
  const double mean = sum / kCopies;
  return {mean, std::sqrt(std::max(0.0, squares / kCopies - mean * mean) / kCopies)};
}

/// The mean lies within four standard errors of what is expected, and that is no empty statement.
void expect_mass(const Tracer& tracer, Vec3 place, KernelShape kernel, float radius, double expected,
                 const LitSides& sides = {}) {
  const Measured found = measure(tracer, place, kernel, radius, sides);
  EXPECT_NEAR(found.mean, expected, 4 * found.error + 1e-3) << static_cast<int>(kernel);
  EXPECT_LT(found.error, 0.005);
}

/// A square of material 0, and others of the same winding at the heights given. @param fine the square has so many
/// triangles that rays are traced
Scene covered(std::uint32_t material, std::initializer_list<float> heights, bool fine) {
  return copies("covered", [&](MeshBuilder& mesh) {
    const int parts = fine ? 16 : 1;
    mesh.patch([](float u, float v) { return Vec3{u, v, 0}; }, parts, parts);
    mesh.set_material(material);
    for (const float z : heights) mesh.quad({0, 0, z}, {1, 0, z}, {1, 1, z}, {0, 1, z});
  });
}

/// The border of a medium close to a surface has no photons, be it as close as it may, and neither have panes and
/// mirrors.
TEST(BoundaryTest, InterfacesPanesAndMirrorsHoldNoFlux) {
  for (const bool fine : {false, true}) {
    for (const std::uint32_t material : {kInterface, kPane, kMirror}) {
      const Scene scene = covered(material, {-0.05f, -1e-4f, 1e-4f, 0.05f}, fine);
      const Tracer tracer(scene);
      SCOPED_TRACE(testing::Message() << material << fine);
      expect_mass(tracer, {0.5f, 0.5f, 0}, KernelShape::epanechnikov, 0.45f, 1);
    }
    const Scene scene = covered(kInterface, {0}, fine);
    const Tracer tracer(scene);
    expect_mass(tracer, {0.5f, 0.5f, 0}, KernelShape::epanechnikov, 0.45f, 1);
  }
  const Scene scene = covered(kPane, {0}, false);
  const Tracer tracer(scene);
  expect_mass(tracer, {0.5f, 0.5f, 0}, KernelShape::epanechnikov, 0.45f, 1);
}

/// Photons on a floor beside a mirror in its plane have half a disc, but irradiance counts on mirrors, too.
TEST(BoundaryTest, MirrorsHoldFluxWherePhotonsLieOnAllSurfaces) {
  const Scene scene = copies("inlaid", [&](MeshBuilder& mesh) {
    mesh.quad({0, 0, 0}, {0.5f, 0, 0}, {0.5f, 1, 0}, {0, 1, 0});
    mesh.set_material(kMirror);
    mesh.quad({0.5f, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0.5f, 1, 0});
  });
  const Tracer tracer(scene);
  const Vec3 place{0.4999f, 0.5f, 0};
  expect_mass(tracer, place, KernelShape::epanechnikov, 0.3f, 0.5);
  PhotonBatch photons;
  photons.push_back(place + place_of(0), {0, 0, 1}, RGB(1.0f), {0, 0, 1});
  RadiusPolicy policy;
  policy.kind = RadiusKind::fixed;
  policy.radius = 0.3f;
  EXPECT_EQ(boundary_factors(tracer, photons, policy, {}, nullptr, nullptr, "", true), std::vector<float>{1});
}

/// A solid that stands apart from a surface takes nothing from it.
TEST(BoundaryTest, SolidsThatHoldNoFluxTakeNoneFromBelow) {
  for (const bool fine : {false, true})
    for (const float radius : {0.1f, 0.2f, 0.45f}) {
      const Scene scene = copies("slab above floor", [&](MeshBuilder& mesh) {
        const int parts = fine ? 16 : 1;
        mesh.patch([](float u, float v) { return Vec3{u, v, 0}; }, parts, parts);
        mesh.set_material(kPane);
        mesh.box({0, 0, 0.05f}, {1, 1, 0.25f}, MeshBuilder::kAllFaces);
      });
      const Tracer tracer(scene);
      SCOPED_TRACE(testing::Message() << fine << ' ' << radius);
      expect_mass(tracer, {0.5f, 0.5f, 0}, KernelShape::epanechnikov, radius, 1);
    }
}

/// What lies in a solid mirror has no photons either.
TEST(BoundaryTest, MirrorsHideWhatLiesWithinThem) {
  for (const bool fine : {false, true}) {
    const Scene scene = copies("mirror on floor", [&](MeshBuilder& mesh) {
      const int parts = fine ? 16 : 1;
      mesh.patch([](float u, float v) { return Vec3{u, v, 0}; }, parts, parts);
      mesh.set_material(kMirror);
      mesh.box({0.5f, -1, 0}, {2, 2, 0.05f}, MeshBuilder::kAllFaces & ~MeshBuilder::kMinZ);
    });
    const Tracer tracer(scene);
    expect_mass(tracer, {0.4999f, 0.5f, 0}, KernelShape::epanechnikov, 0.45f, 0.5);
  }
}

TEST(BoundaryTest, FlatSurfaceLosesNothing) {
  const Scene scene = squares({0});
  const Tracer tracer(scene);
  for (const KernelShape shape : kKernelShapes) EXPECT_EQ(measure(tracer, {0.5f, 0.5f, 0}, shape, 0.3f).mean, 1.0);
}

TEST(BoundaryTest, HalfOfTheDiscIsLostAtAnEdgeAndThreeQuartersAtACorner) {
  const Scene scene = squares({0});
  const Tracer tracer(scene);
  for (const KernelShape shape : kKernelShapes) {
    expect_mass(tracer, {0.5f, 1e-4f, 0}, shape, 0.3f, 0.5);
    expect_mass(tracer, {1e-4f, 1e-4f, 0}, shape, 0.3f, 0.25);
  }
}

TEST(BoundaryTest, ThinPartsKeepTheirFlux) {
  // The share of the disc that the strip covers, which is nearly width * diameter; few lines find it.
  for (const float width : {0.03f, 0.008f}) {
    const Scene scene = copies("strips", [&](MeshBuilder& mesh) {
      mesh.quad({0, 0, 0}, {2, 0, 0}, {2, width, 0}, {0, width, 0});
    });
    const Tracer tracer(scene);
    RadiusPolicy policy;
    policy.kind = RadiusKind::fixed;
    policy.radius = 0.4f;
    policy.kernel = KernelShape::box;
    PhotonBatch photons;
    for (int i = 0; i < kCopies; ++i)
      photons.push_back(Vec3{1, width / 2, 0} + place_of(i), {0, 0, 1}, RGB(1.0f), {0, 0, 1});
    double sum = 0, squares = 0;
    for (const float f : boundary_factors(tracer, photons, policy, {})) {
      sum += f;
      squares += double(f) * f;
    }
    const double mean = sum / kCopies, error = std::sqrt((squares / kCopies - mean * mean) / kCopies);
    const double expected = kPi * policy.radius / (2 * width);
    EXPECT_NEAR(mean, expected, 4 * error + 0.05 * expected) << width;
    EXPECT_LT(error, 0.02 * expected);
  }
}

/// Estimates of 1 at places of every copy, for kernels of one radius.
std::vector<RGB> corrected(const Tracer& tracer, Vec3 place, KernelShape kernel, float radius, int count = kCopies) {
  QueryPoints points;
  for (int i = 0; i < count; ++i) points.push_back(place + place_of(i), {0, 0, 1}, RGB(1.0f), RGB(1.0f), 0);
  std::vector<RGB> estimates(points.size(), RGB(1.0f));
  correct_estimates(tracer, points, std::vector<float>(points.size(), radius), kernel, {}, estimates);
  return estimates;
}

TEST(BoundaryTest, EstimatesAreDoubledAtAnEdgeAndFourfoldAtACorner) {
  const Scene scene = squares({0});
  const Tracer tracer(scene);
  const auto expect_mean = [&](Vec3 place, KernelShape shape, double expected) {
    double sum = 0, squares = 0;
    for (const RGB& e : corrected(tracer, place, shape, 0.3f)) {
      sum += e.g;
      squares += double{e.g} * e.g;
    }
    const double mean = sum / kCopies;
    EXPECT_NEAR(mean, expected, 0.05 * expected) << static_cast<int>(shape);
    EXPECT_LT(std::sqrt(squares / kCopies - mean * mean), 0.25 * expected) << static_cast<int>(shape);
  };
  for (const KernelShape shape : kKernelShapes) {
    expect_mean({0.5f, 0.5f, 0}, shape, 1);
    expect_mean({0.5f, 1e-4f, 0}, shape, 2);
    expect_mean({1e-4f, 1e-4f, 0}, shape, 4);
  }
}

TEST(BoundaryTest, TheCorrectionOfAPointDependsOnThatPointAlone) {
  const Scene scene = squares({0});
  const Tracer tracer(scene);
  const Vec3 place{0.02f, 0.4f, 0};
  const std::vector<RGB> all = corrected(tracer, place, KernelShape::cone, 0.3f);
  const std::vector<RGB> one = corrected(tracer, place, KernelShape::cone, 0.3f, 1);
  EXPECT_EQ(one[0], all[0]);
  EXPECT_NE(all[0].g, 1);
}

TEST(BoundaryTest, PointsWithoutPhotonsStayBlack) {
  const Scene scene = squares({0});
  const Tracer tracer(scene);
  QueryPoints points;
  for (int i = 0; i < 2; ++i) points.push_back(place_of(0), {0, 0, 1}, RGB(1.0f), RGB(1.0f), 0);
  std::vector<RGB> estimates = {RGB(0.0f), RGB(1.0f)};
  correct_estimates(tracer, points, std::vector<float>{0.3f, 0}, KernelShape::box, {}, estimates);
  EXPECT_EQ(estimates[0], RGB(0.0f));
  EXPECT_EQ(estimates[1], RGB(1.0f)) << "no radius is known there";
}

TEST(BoundaryTest, ParallelSurfacesCountTogether) {
  const Scene scene = squares({0, 0.15f});
  const Tracer tracer(scene);
  // The box kernel over the other square: the part of its disc within the ball, 1 - (0.15 / 0.3)^2. Both squares face
  // up, so nothing is a solid's far side.
  expect_mass(tracer, {0.5f, 0.5f, 0}, KernelShape::box, 0.3f, 1.75);
}

TEST(BoundaryTest, AllSlatsOfABlindCountTogether) {
  constexpr float kGap = 0.04f, kRadius = 0.1f;
  const Scene scene = copies("blind", [](MeshBuilder& mesh) {
    for (int i = -5; i <= 5; ++i) {
      const float z = kGap * static_cast<float>(i);
      mesh.box({0, 0, z - 0.002f}, {1, 1, z});
    }
  });
  const Tracer tracer(scene);
  // Over a plane at a height of h radii the kernel's integral is (1 - h^2)^2.
  double expected = 1;
  for (int i = 1; i <= 2; ++i) {
    const double h = kGap * i / kRadius, plane = 1 - h * h;
    expected += 2 * plane * plane;
  }
  expect_mass(tracer, {0.5f, 0.5f, 0}, KernelShape::epanechnikov, kRadius, expected);
}

TEST(BoundaryTest, LinesThroughCountlessSurfacesEnd) {
  SceneDescription d;
  d.materials.emplace_back();
  MeshBuilder mesh(d.geometry);
  mesh.set_material(0);
  constexpr int kSheets = 2000;
  for (int i = 0; i < kSheets; ++i) {
    const float z = 1e-4f * static_cast<float>(i);
    mesh.quad({-1, -1, z}, {1, -1, z}, {1, 1, z}, {-1, 1, z});
  }
  const Scene scene(std::move(d));
  const Tracer tracer(scene);
  const LitSides sides;
  NearbySurface surface(tracer, false, sides);
  BoundaryCluster cluster;
  cluster.normal = {0, 0, 1};
  cluster.reach = cluster.high = 0.1f;
  surface.approach(cluster);
  Segments segments;
  for (std::size_t i = 0; i < kMostSegments; ++i) segments.push_back({0, 0, 0.1f}, {0, 0, -0.1f});
  EXPECT_LT(surface.meetings(segments, 0, 1e-5f).size(), (kMostHitsOfSegment + 1) * kMostSegments);
  EXPECT_TRUE(surface.crowded());
  PhotonBatch photons;
  photons.push_back({0, 0, 0.05f}, {0, 0, 1}, RGB(1.0f), {0, 0, 1});
  RadiusPolicy policy;
  policy.kind = RadiusKind::fixed;
  policy.radius = 0.1f;
  EXPECT_EQ(boundary_factors(tracer, photons, policy, {}), std::vector<float>{0.25f});
}

TEST(BoundaryTest, ManyTrianglesGiveTheMassOfFew) {
  // The same half disc, of so many triangles that rays are traced instead.
  const Scene scene = copies("dense", [](MeshBuilder& mesh) {
    mesh.patch([](float u, float v) { return Vec3{u, v, 0}; }, 16, 16);
  });
  const Tracer tracer(scene);
  for (const KernelShape shape : kKernelShapes) {
    expect_mass(tracer, {0.5f, 1e-4f, 0}, shape, 0.45f, 0.5);
    EXPECT_EQ(measure(tracer, {0.5f, 0.5f, 0}, shape, 0.45f).mean, 1.0);
  }
}

TEST(BoundaryTest, SurfaceUnderASolidDoesNotCount) {
  // A floor, and a block without a bottom on the half of it beyond x = 0.5.
  const Scene scene = copies("floor under block", [](MeshBuilder& mesh) {
    mesh.quad({0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0});
    mesh.box({0.5f, -1, 0}, {2, 2, 0.2f}, MeshBuilder::kAllFaces & ~MeshBuilder::kMinZ);
  });
  const Tracer tracer(scene);
  // Half of the disc is under the block, at whose side the kernel ends.
  const Vec3 foot{0.4995f, 0.5f, 0};
  for (const float radius : {0.1f, 0.3f})
    expect_mass(tracer, foot, KernelShape::box, radius, 0.5 + 2 * 0.0005 * radius / (kPi * radius * radius));
}

TEST(BoundaryTest, SurfaceBehindAWallDoesNotCount) {
  constexpr float kRadius = 0.3f;
  for (const bool flipped : {false, true}) {
    // A floor, and a wall of one sheet on it at x = 0.5.
    const Scene scene = copies("floor under wall", [&](MeshBuilder& mesh) {
      mesh.quad({0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0});
      if (flipped)
        mesh.quad({0.5f, 0, 0}, {0.5f, 0, 1}, {0.5f, 1, 1}, {0.5f, 1, 0});
      else
        mesh.quad({0.5f, 0, 0}, {0.5f, 1, 0}, {0.5f, 1, 1}, {0.5f, 0, 1});
    });
    const Tracer tracer(scene);
    for (const KernelShape shape : kKernelShapes) {
      expect_mass(tracer, {0.49999f, 0.5f, 0}, shape, kRadius, 0.5);
      EXPECT_EQ(measure(tracer, {0.15f, 0.5f, 0}, shape, 0.14f).mean, 1.0);
    }
    // The same planes by both functions that find them.
    PhotonBatch photons;
    for (const float x : {0.1f, 0.4f, 0.55f, 0.9f}) photons.push_back({x, 0.5f, 0}, {0, 0, 1}, RGB(1.0f), {0, 0, 1});
    RadiusPolicy policy;
    policy.radii.assign(photons.size(), kRadius);
    std::vector<PhotonCuts> cuts;
    boundary_factors(tracer, photons, policy, {}, &cuts);
    for (const auto& found : {cuts, kernel_cuts(tracer, photons, policy.radii)}) {
      ASSERT_EQ(found.size(), 2);
      for (std::uint32_t i = 0; i < 2; ++i) {
        EXPECT_EQ(found[i].photon, i + 1);
        EXPECT_NEAR(found[i].cuts[0].normal.x, i == 0 ? -1 : 1, 1e-5);
        EXPECT_NEAR(found[i].cuts[0].distance, i == 0 ? 0.1f : 0.05f, 1e-5);
        EXPECT_EQ(length(found[i].cuts[1].normal), 0);
      }
    }
  }
}

TEST(BoundaryTest, SurfaceUnderALayerDoesNotCount) {
  const Scene scene = copies("carpet", [](MeshBuilder& mesh) {
    mesh.quad({0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0});
    mesh.box({0.1f, 0.1f, 0}, {0.9f, 0.9f, 0.01f}, MeshBuilder::kAllFaces & ~MeshBuilder::kMinZ);
  });
  const Tracer tracer(scene);
  EXPECT_EQ(measure(tracer, {0.5f, 0.5f, 0.01f}, KernelShape::epanechnikov, 0.2f).mean, 1.0);
}

/// A unit square of a single sheet, which faces up or, flipped, down.
void add_sheet(MeshBuilder& mesh, float z, bool flipped) {
  if (flipped)
    mesh.quad({0, 0, z}, {0, 1, z}, {1, 1, z}, {1, 0, z});
  else
    mesh.quad({0, 0, z}, {1, 0, z}, {1, 1, z}, {0, 1, z});
}

/// Photons all over a side of each copy of a sheet. @param up 1 or -1
void light_sheets(PhotonBatch& photons, float z, float up) {
  for (int i = 0; i < kCopies; ++i)
    for (int x = 0; x < 4; ++x)
      for (int y = 0; y < 8; ++y)
        photons.push_back(
            place_of(i) + Vec3{0.2f + 0.2f * static_cast<float>(x), 0.05f + 0.12f * static_cast<float>(y), z},
            {0, 0, up}, RGB(1.0f), {0, 0, up});
}

/// A rug that is one sheet, of either winding, on a floor.
TEST(BoundaryTest, SurfaceUnderASheetDoesNotCount) {
  for (const bool flipped : {false, true}) {
    const Scene scene = copies("rug", [&](MeshBuilder& mesh) {
      add_sheet(mesh, 0, flipped);
      add_sheet(mesh, 0.01f, flipped);
    });
    const Tracer tracer(scene);
    PhotonBatch photons;
    light_sheets(photons, 0.01f, 1);
    const LitSides sides(tracer, photons);
    EXPECT_EQ(measure(tracer, {0.5f, 0.5f, 0.01f}, KernelShape::epanechnikov, 0.2f, sides).mean, 1.0) << flipped;
  }
}

TEST(BoundaryTest, AllSheetsThatAreLitOnBothSidesCountTogether) {
  constexpr float kGap = 0.04f, kRadius = 0.1f;
  for (const bool flipped : {false, true}) {
    const Scene scene = copies("blind of sheets", [&](MeshBuilder& mesh) {
      for (int i = -5; i <= 5; ++i) add_sheet(mesh, kGap * static_cast<float>(i), flipped);
    });
    const Tracer tracer(scene);
    PhotonBatch photons;
    for (int i = -5; i <= 5; ++i)
      for (const float up : {1.0f, -1.0f}) light_sheets(photons, kGap * static_cast<float>(i), up);
    double expected = 1;
    for (int i = 1; i <= 2; ++i) {
      const double h = kGap * i / kRadius, plane = 1 - h * h;
      expected += 2 * plane * plane;
    }
    SCOPED_TRACE(flipped);
    expect_mass(tracer, {0.5f, 0.5f, 0}, KernelShape::epanechnikov, kRadius, expected, LitSides(tracer, photons));
  }
}

/// Most triangles of a fine mesh have no photons, and a few have one.
TEST(LitSides, OfFineMeshesAreThoseOfTheirObject) {
  SceneDescription d;
  d.materials.emplace_back();
  MeshBuilder mesh(d.geometry);
  mesh.set_material(0);
  for (const char* name : {"from below", "from above", "dark"}) {
    d.geometry.begin_object(name);
    const float x = 2 * static_cast<float>(d.geometry.objects.size());
    mesh.patch([&](float u, float v) { return Vec3{x + u, v, 0}; }, 16, 16);
  }
  const Scene scene(std::move(d));
  const Tracer tracer(scene);
  PhotonBatch photons;
  for (int i = 0; i < 12; ++i) {
    const Vec3 place{0.05f + 0.07f * static_cast<float>(i), 0.03f, 0};
    photons.push_back(place + Vec3{2, 0, 0}, {0, 0, -1}, RGB(1.0f), {0, 0, -1});
    photons.push_back(place + Vec3{4, 0, 0}, {0, 0, 1}, RGB(1.0f), {0, 0, 1});
  }
  const LitSides sides(tracer, photons);
  const std::uint32_t each = static_cast<std::uint32_t>(scene.geometry().triangles.size() / 3);
  const bool faces_up = scene.geometry().normal(0).z > 0;
  EXPECT_EQ(sides.of(scene.geometry(), each - 1), faces_up ? LitSide::back : LitSide::front);
  EXPECT_EQ(sides.of(scene.geometry(), 2 * each - 1), faces_up ? LitSide::front : LitSide::back);
  EXPECT_EQ(sides.of(scene.geometry(), 3 * each - 1), LitSide::front);
}

TEST(BoundaryTest, NeighboursOnACurvedSurfaceShareTheirLines) {
  // A quarter of a cylinder of radius 1 around the y axis: each photon's own mass, though their cluster is bent.
  const Scene scene = copies("cylinder", [](MeshBuilder& mesh) {
    mesh.patch(
        [](float u, float v) {
          const float angle = 2 * u - 1;
          return Vec3{std::sin(angle), 4 * v - 2, std::cos(angle) - 1};
        },
        64, 1);
  });
  const Tracer tracer(scene);
  PhotonBatch photons;
  for (int i = 0; i < kCopies; ++i)
    for (int j = 0; j < 20; ++j) {
      const float angle = 0.02f * static_cast<float>(j - 10);
      const Vec3 n{std::sin(angle), 0, std::cos(angle)};
      photons.push_back(place_of(i) + Vec3{0, 0.01f * static_cast<float>(j % 3), -1} + n, n, RGB(1.0f), n);
    }
  RadiusPolicy policy;
  policy.kind = RadiusKind::fixed;
  policy.radius = 0.2f;
  double sum = 0;
  for (const float f : boundary_factors(tracer, photons, policy, {})) sum += 1 / f;
  // The ball cuts nearly its disc's area out of the cylinder: r^2 / 8 more for the chord, as much less for the bend.
  EXPECT_NEAR(sum / static_cast<double>(photons.size()), 1, 0.01);
}

TEST(BoundaryTest, SameForAnyNumberOfThreads) {
  const Scene scene = squares({0});
  const Tracer tracer(scene);
  PhotonBatch photons;
  for (int i = 0; i < 3000; ++i)
    photons.push_back(place_of(i % kCopies) + Vec3{0.5f, 0.02f, 0}, {0, 0, 1}, RGB(1.0f), {0, 0, 1});
  RadiusPolicy policy;
  policy.radii.assign(photons.size(), 0.05f);
  set_thread_count(1);
  const std::vector<float> one = boundary_factors(tracer, photons, policy, {});
  set_thread_count(2);
  EXPECT_EQ(one, boundary_factors(tracer, photons, policy, {}));
  set_thread_count(0);
}

}  // namespace
}  // namespace glowworm
