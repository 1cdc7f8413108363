#include "core/radix_sort.h"

#include <algorithm>

#include "core/parallel.h"

namespace glowworm {

namespace {

constexpr int kMaxDigitBits = 11;
constexpr std::size_t kMinPiece = std::size_t{1} << 14;
constexpr std::size_t kMaxPieces = 64;

/// One stable pass over a digit. Every piece of the input counts its digits; the counts are summed in order of (digit,
/// piece); then every piece writes to its own range.
template <typename Key>
class DigitPass {
 public:
  explicit DigitPass(std::size_t n)
      : piece_(std::max(kMinPiece, (n + kMaxPieces - 1) / kMaxPieces)), pieces_((n + piece_ - 1) / piece_) {}

  void run(const std::vector<KeyedIndex<Key>>& in, std::vector<KeyedIndex<Key>>& out, int shift, int bits) {
    const std::size_t digits = std::size_t{1} << bits;
    const Key mask = static_cast<Key>(digits - 1);
    places_.assign(pieces_ * digits, 0);
    parallel_for(0, in.size(), piece_, [&](std::size_t first, std::size_t last) {
      std::size_t* count = &places_[first / piece_ * digits];
      for (std::size_t i = first; i < last; ++i) ++count[in[i].key >> shift & mask];
    });
    std::size_t sum = 0;
    for (std::size_t digit = 0; digit < digits; ++digit)
      for (std::size_t piece = 0; piece < pieces_; ++piece) {
        std::size_t& place = places_[piece * digits + digit];
        const std::size_t count = place;
        place = sum;
        sum += count;
      }
    parallel_for(0, in.size(), piece_, [&](std::size_t first, std::size_t last) {
      std::size_t* place = &places_[first / piece_ * digits];
      for (std::size_t i = first; i < last; ++i) out[place[in[i].key >> shift & mask]++] = in[i];
    });
  }

 private:
  std::size_t piece_, pieces_;
  std::vector<std::size_t> places_;
};

/// The bits in which any keys differ.
template <typename Key>
Key differing_bits(const std::vector<KeyedIndex<Key>>& pairs) {
  Key differing = 0;
  for (const KeyedIndex<Key>& pair : pairs) differing |= static_cast<Key>(pair.key ^ pairs.front().key);
  return differing;
}

template <typename Key>
void sort(std::vector<KeyedIndex<Key>>& pairs, int bits) {
  if (pairs.size() < 2) return;
  Key differing = differing_bits(pairs);
  if (bits < static_cast<int>(8 * sizeof(Key))) differing &= static_cast<Key>((Key{1} << bits) - 1);
  std::vector<KeyedIndex<Key>> other(pairs.size());
  DigitPass<Key> pass(pairs.size());
  int shift = 0;
  while (shift < bits && differing >> shift != 0) {
    if ((differing >> shift & 1) == 0) {
      ++shift;
      continue;
    }
    // Splits the remaining bits into the fewest passes, of equal width.
    int left = 0;
    while (left < bits - shift && differing >> (shift + left) != 0) ++left;
    const int passes = (left + kMaxDigitBits - 1) / kMaxDigitBits;
    const int width = (left + passes - 1) / passes;
    pass.run(pairs, other, shift, width);
    pairs.swap(other);
    shift += width;
  }
}

}  // namespace

void radix_sort(std::vector<KeyedIndex<std::uint32_t>>& pairs, int bits) { sort(pairs, bits); }
void radix_sort(std::vector<KeyedIndex<std::uint64_t>>& pairs, int bits) { sort(pairs, bits); }

}  // namespace glowworm
