// The blocked engine: runs of nearby query points against blocks of nearby photons. Many points share the cost of
// finding photons; the rest is straight-line vector code (kernels/blocked.h).
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "core/parallel.h"
#include "density/blocked_index.h"
#include "density/blocked_queries.h"
#include "density/engines.h"
#include "density/glossy.h"
#include "density/shading.h"

namespace glowworm {

namespace {

// Batch size of query points. Larger batches are denser; smaller batches take less memory.
constexpr std::size_t kPartPoints = DensityEngine::kMaxPointsAtOnce;
// Below this number, points are too far apart to share a search: a run holds only the points that are tested together.
constexpr std::size_t kFewPoints = std::size_t{1} << 15;
// Below this number of points per photon, a run holds one point: sixteen points would be tested against hundreds of
// times the photons that they use. The sums do not depend on the runs.
constexpr std::size_t kSparsePhotons = 24;

/// Processes one bucket after another. Holds the memory of one thread.
class BucketWorker {
 public:
  BucketWorker(const BlockedIndex& index, const QueryPoints& points, QueryBuckets& buckets)
      : index_(index), tree_(index.tree()), points_(points), buckets_(buckets) {}

  void work(const QueryBuckets::Bucket& bucket) {
    order_.sort(buckets_.points(bucket));
    for (std::size_t g = 0; g < kNotLambertianGroup; ++g) {
      std::span<const std::uint32_t> indices = order_.group(g);
      while (!indices.empty()) {
        sum(bucket, indices);
        indices = indices.subspan(std::min(indices.size(), run_points_));
      }
    }
    shade_group(bucket, order_.group(kNotLambertianGroup));
  }

  BlockedCounts counts;

 private:
  /// A run of points from the front of the indices: Lambertian ones, or those with numbers in `glossy`.
  void sum(const QueryBuckets::Bucket& bucket, std::span<const std::uint32_t> indices,
           const GlossyPoints* glossy = nullptr) {
    const std::span<const BucketPoint> points = buckets_.points(bucket);
    QueryRun run;
    run.count = std::min(indices.size(), run_points_);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      run.position[axis] = in_[axis];
      run.normal[axis] = in_[axis + 3];
      run.sum[axis] = out_[axis];
    }
    const std::size_t padded = (run.count + kTileWidth - 1) / kTileWidth * kTileWidth;
    for (std::size_t i = 0; i < padded; ++i) {
      const BucketPoint& p = points[indices[std::min(i, run.count - 1)]];
      in_[0][i] = p.position.x;
      in_[1][i] = p.position.y;
      in_[2][i] = p.position.z;
      in_[3][i] = p.normal.x;
      in_[4][i] = p.normal.y;
      in_[5][i] = p.normal.z;
    }
    if (glossy)
      blocked_sum_glossy(tree_, run, *glossy, scratch_, counts);
    else
      blocked_sum(tree_, run, scratch_, counts);
    for (std::size_t i = 0; i < run.count; ++i)
      buckets_.answer(bucket, indices[i]) = RGB(out_[0][i], out_[1][i], out_[2][i]);
  }

  /// The points that are not Lambertian: those with a model of the kernels in runs of one model and similar normals,
  /// the others one by one.
  void shade_group(const QueryBuckets::Bucket& bucket, std::span<const std::uint32_t> indices) {
    const std::span<const BucketPoint> points = buckets_.points(bucket);
    for (std::vector<std::uint32_t>& run : runs_) run.clear();
    for (const std::uint32_t i : indices) {
      if (const std::optional<GlossyModel> model = glossy_model(points_.bsdfs[points[i].bsdf].bsdf))
        runs_[static_cast<std::size_t>(*model) * kFacings + facing(points[i].normal)].push_back(i);
      else
        buckets_.answer(bucket, i) = shade(points[i]);
    }
    for (std::size_t r = 0; r < runs_.size(); ++r) {
      std::span<const std::uint32_t> left = runs_[r];
      while (!left.empty()) {
        const auto run = left.first(std::min(left.size(), run_points_));
        prepare(points, run, static_cast<GlossyModel>(r / kFacings));
        sum(bucket, run, &glossy_);
        left = left.subspan(run.size());
      }
    }
  }

  /// Fills in the numbers of a run.
  void prepare(std::span<const BucketPoint> points, std::span<const std::uint32_t> run, GlossyModel model) {
    preparer_.clear();
    numbers_.resize(kGlossyFields * kRunPoints);
    const std::size_t padded = (run.size() + kTileWidth - 1) / kTileWidth * kTileWidth;
    GlossyNumbers numbers{};
    for (std::size_t i = 0; i < padded; ++i) {
      // Padding repeats the last point: its numbers are read, but the results are not used.
      if (i < run.size()) numbers = preparer_.prepare(points_.bsdfs[points[run[i]].bsdf], model);
      for (std::size_t field = 0; field < kGlossyFields; ++field) numbers_[field * kRunPoints + i] = numbers[field];
    }
    glossy_ = {numbers_.data(), kRunPoints, preparer_.tables(), model};
  }

  /// Main direction of a normal: 2 axis + 1 if it points down the axis.
  static std::size_t facing(Vec3 n) {
    const Vec3 a{std::abs(n.x), std::abs(n.y), std::abs(n.z)};
    const std::size_t axis = a.z > std::max(a.x, a.y) ? 2 : a.y > a.x ? 1 : 0;
    return 2 * axis + (n[axis] < 0);
  }

  /// Finds the photons whose support contains one point.
  void find(const BucketPoint& point) {
    const float position[3] = {point.position.x, point.position.y, point.position.z};
    const float normal[3] = {point.normal.x, point.normal.y, point.normal.z};
    blocked_find(tree_, position, normal, scratch_, found_, counts);
  }

  /// A point with its own BSDF: finds its photons, then shades them in one batch.
  RGB shade(const BucketPoint& point) {
    find(point);
    gathered_.clear();
    for (const BlockedPhoton& found : found_) {
      const PhotonBlock& block = tree_.blocks[found.place / kBlockWidth];
      const std::size_t lane = found.place % kBlockWidth;
      // The blocks hold flux for Lambertian surfaces, divided by pi.
      gathered_.push_back(index_.directions()[found.place],
                          RGB(block.r[lane], block.g[lane], block.b[lane]) * (found.profile * kPi));
    }
    return shader_.shade(points_.bsdfs[point.bsdf], gathered_);
  }

  const BlockedIndex& index_;
  BlockTree tree_;
  const QueryPoints& points_;
  QueryBuckets& buckets_;
  BucketOrder order_;
  BlockedScratch scratch_;
  std::vector<BlockedPhoton> found_;
  GatheredPhotons gathered_;
  BatchShader shader_;
  static constexpr std::size_t kFacings = 6;
  std::array<std::vector<std::uint32_t>, kGlossyModels * kFacings> runs_;
  GlossyPreparer preparer_;
  std::vector<float> numbers_;
  GlossyPoints glossy_;
  const std::size_t run_points_ = points_.size() * kSparsePhotons < index_.size() ? 1
                                  : points_.size() < kFewPoints                   ? kTileWidth
                                                                                  : kRunPoints;
  alignas(64) float in_[6][kRunPoints];
  alignas(64) float out_[3][kRunPoints];
};

/// Memory of earlier calls. All engines share it, because a render may have one for each group of lights.
class IdleMemory {
 public:
  /// Lives as long as an engine.
  static std::shared_ptr<IdleMemory> of_all_engines() {
    static std::mutex mutex;
    static std::weak_ptr<IdleMemory> known;
    const std::lock_guard lock(mutex);
    std::shared_ptr<IdleMemory> memory = known.lock();
    if (!memory) known = memory = std::make_shared<IdleMemory>();
    return memory;
  }

  std::unique_ptr<QueryMemory> take() {
    const std::lock_guard lock(mutex_);
    if (idle_.empty()) return std::make_unique<QueryMemory>();
    std::unique_ptr<QueryMemory> memory = std::move(idle_.back());
    idle_.pop_back();
    return memory;
  }
  void give(std::unique_ptr<QueryMemory> memory) {
    const std::lock_guard lock(mutex_);
    idle_.push_back(std::move(memory));
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<QueryMemory>> idle_;
};

class BlockedEngine final : public DensityEngine {
 public:
  std::string name() const override { return "blocked"; }

  std::uint64_t index_bytes(std::size_t photons) const override {
    return BlockedIndex::bytes(photons) + index_.cut_bytes();
  }

  void build(const PhotonBatch& photons, std::span<const RGB> flux, const RadiusPolicy& policy,
             Statistics& statistics) override {
    PhaseTimer timer(statistics, Phase::build_photon_map);
    check_policy(photons, policy, "blocked");
    index_ = BlockedIndex();
    index_ = BlockedIndex(photons, flux, policy);
  }

  void estimate(const QueryPoints& points, std::span<RGB> radiance, Statistics& statistics) const override {
    statistics.add(Counter::query_points, points.size());
    if (index_.size() == 0) return;
    const std::size_t parts = (points.size() + kPartPoints - 1) / kPartPoints;
    std::unique_ptr<QueryMemory> memory = idle_->take();
    for (std::size_t part = 0; part < parts; ++part)
      estimate_part(points, points.size() * part / parts, points.size() * (part + 1) / parts, radiance, *memory,
                    statistics);
    idle_->give(std::move(memory));
  }

 private:
  void estimate_part(const QueryPoints& points, std::size_t first, std::size_t last, std::span<RGB> radiance,
                     QueryMemory& memory, Statistics& statistics) const {
    std::optional<PhaseTimer> timer(std::in_place, statistics, Phase::reorder);
    QueryBuckets buckets(points, first, last, memory);
    timer.emplace(statistics, Phase::density);
    const std::size_t grain = last - first < kFewPoints ? 1 : kBucketGrain;
    parallel_for(0, buckets.buckets().size(), grain, [&](std::size_t begin, std::size_t end) {
      const auto worker = std::make_unique<BucketWorker>(index_, points, buckets);
      for (std::size_t i = begin; i < end; ++i) worker->work(buckets.buckets()[i]);
      statistics.add(Counter::shader_operations, worker->counts.evaluated);
      statistics.add(Counter::pairs_tested, worker->counts.tested);
      statistics.add(Counter::packet_steps, worker->counts.steps);
      statistics.add(Counter::packet_active_lanes, worker->counts.evaluated);
    });
    buckets.add_answers(points, radiance);
  }

  // Buckets in one piece of parallel work.
  static constexpr std::size_t kBucketGrain = 4;

  BlockedIndex index_;
  std::shared_ptr<IdleMemory> idle_ = IdleMemory::of_all_engines();
};

}  // namespace

std::unique_ptr<DensityEngine> make_blocked_engine() { return std::make_unique<BlockedEngine>(); }

}  // namespace glowworm
