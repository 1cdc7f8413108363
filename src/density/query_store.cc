#include "density/query_store.h"

#include <algorithm>
#include <numeric>

#include "core/error.h"

namespace glowworm {

namespace {

// Records copied at a time.
constexpr std::size_t kRecordsAtOnce = 4096;

}  // namespace

void QueryStore::append(const QueryPoints& portion) {
  if (portion.size() > most_points_ - size_) throw Error("more query points than there was room made for");
  std::vector<std::uint16_t> cells(portion.size());
  Portion& entry = portions_.emplace_back();
  entry.first = entry.next = size_;
  entry.cell_counts.resize(kCells);
  for (std::size_t i = 0; i < portion.size(); ++i) {
    cells[i] = static_cast<std::uint16_t>(hilbert_key_of_morton(grid_.morton(portion.position[i]), kGridBits));
    ++entry.cell_counts[cells[i]];
  }
  std::vector<std::uint32_t> next(kCells), order(portion.size());
  std::exclusive_scan(entry.cell_counts.begin(), entry.cell_counts.end(), next.begin(), 0u);
  for (std::size_t i = 0; i < portion.size(); ++i) order[next[cells[i]]++] = static_cast<std::uint32_t>(i);
  for (std::size_t first = 0; first < order.size(); first += kRecordsAtOnce) {
    records_.clear();
    some_bsdfs_.clear();
    for (std::size_t i = first; i < std::min(first + kRecordsAtOnce, order.size()); ++i) {
      const std::uint32_t p = order[i];
      Record record{portion.position[p],
                    portion.normal[p],
                    portion.reflectance[p],
                    portion.weight[p],
                    portion.gather_point[p],
                    portion.bsdf[p],
                    p};
      if (record.bsdf != kLambertianQuery) {
        some_bsdfs_.push_back(portion.bsdfs[record.bsdf]);
        record.bsdf = static_cast<std::uint32_t>(bsdf_count_ + some_bsdfs_.size() - 1);
      }
      records_.push_back(record);
    }
    points_.write(size_, records_, traffic_);
    bsdfs_.write(bsdf_count_, some_bsdfs_, traffic_);
    size_ += records_.size();
    bsdf_count_ += some_bsdfs_.size();
  }
}

void QueryStore::complete(std::size_t most_points, const LookUp& look_up, std::span<RGB> target) {
  look_up_all(most_points, look_up);
  for (const Portion& portion : portions_) add_answers(portion, target);
  portions_.clear();
  size_ = bsdf_count_ = 0;
}

void QueryStore::look_up_all(std::size_t most_points, const LookUp& look_up) {
  std::vector<std::size_t> totals(kCells, 0);
  for (const Portion& portion : portions_)
    for (std::size_t c = 0; c < kCells; ++c) totals[c] += portion.cell_counts[c];
  QueryPoints run;
  run.reserve(std::min(most_points, size_));
  LargeVector<RGB> radiance;
  std::vector<Piece> pieces;
  const auto hand_out = [&] {
    if (run.size() == 0) return;
    radiance.assign(run.size(), RGB());
    look_up(run, radiance);
    answer(pieces, run, radiance);
    pieces.clear();
    numbers_.clear();
    run.clear();
  };
  for (std::size_t first = 0; first < kCells;) {
    std::size_t last = first + 1, count = totals[first];
    for (; last < kCells && count + totals[last] <= most_points; ++last) count += totals[last];
    for (Portion& portion : portions_) {
      const auto from = portion.cell_counts.begin();
      std::size_t left = std::accumulate(from + static_cast<std::ptrdiff_t>(first),
                                         from + static_cast<std::ptrdiff_t>(last), std::size_t{0});
      // One cell may hold more points than a run.
      while (left > 0) {
        if (run.size() >= most_points) hand_out();
        const Piece piece{portion.next, std::min(left, most_points - run.size())};
        read(piece, run);
        pieces.push_back(piece);
        portion.next += piece.count;
        left -= piece.count;
      }
    }
    hand_out();
    first = last;
  }
}

void QueryStore::read(const Piece& piece, QueryPoints& to) {
  const std::size_t end = piece.first + piece.count;
  for (std::size_t first = piece.first; first < end; first += records_.size()) {
    records_.resize(std::min(kRecordsAtOnce, end - first));
    points_.read(first, records_, traffic_);
    // The BSDFs of adjacent points are adjacent, too.
    const auto has_bsdf = [](const Record& r) { return r.bsdf != kLambertianQuery; };
    const auto with_bsdf = std::find_if(records_.begin(), records_.end(), has_bsdf);
    some_bsdfs_.resize(static_cast<std::size_t>(std::count_if(with_bsdf, records_.end(), has_bsdf)));
    if (!some_bsdfs_.empty()) bsdfs_.read(with_bsdf->bsdf, some_bsdfs_, traffic_);
    for (const Record& r : records_) {
      if (r.bsdf == kLambertianQuery)
        to.push_back(r.position, r.normal, r.reflectance, r.weight, r.gather_point);
      else
        to.push_back(r.position, r.normal, some_bsdfs_[r.bsdf - with_bsdf->bsdf], r.weight, r.gather_point);
      numbers_.push_back(r.number);
    }
  }
}

/// Writes the results of a run's points.
void QueryStore::answer(std::span<const Piece> pieces, const QueryPoints& run, std::span<const RGB> radiance) {
  std::size_t at = 0;
  for (const Piece& piece : pieces) {
    some_answers_.clear();
    for (const std::size_t end = at + piece.count; at < end; ++at)
      some_answers_.push_back({run.weight[at] * radiance[at], run.gather_point[at], numbers_[at]});
    answers_.write(piece.first, some_answers_, traffic_);
  }
}

/// Adds the results of a portion's points, in the order in which they were appended.
void QueryStore::add_answers(const Portion& portion, std::span<RGB> target) {
  std::vector<Answer> in_order(portion.next - portion.first);
  for (std::size_t first = portion.first; first < portion.next; first += some_answers_.size()) {
    some_answers_.resize(std::min(kRecordsAtOnce, portion.next - first));
    answers_.read(first, some_answers_, traffic_);
    for (const Answer& a : some_answers_) in_order[a.number] = a;
  }
  for (const Answer& a : in_order) target[a.target] += a.light;
}

}  // namespace glowworm
