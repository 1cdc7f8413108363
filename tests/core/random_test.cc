#include "core/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "support/goodness_of_fit.h"

namespace glowworm {
namespace {

Vec2 pair_of(SamplerKind kind, std::uint32_t seed, std::uint32_t sequence, std::uint32_t index, int dimension) {
  Sampler sampler(kind, seed, sequence, index);
  Vec2 u;
  for (int d = 0; d <= dimension; ++d) u = sampler.next2();
  return u;
}

TEST(Sampler, SameArgumentsGiveTheSameNumbers) {
  for (const SamplerKind kind : {SamplerKind::sobol, SamplerKind::independent}) {
    Sampler a(kind, 3, 14, 15), b(kind, 3, 14, 15);
    for (int i = 0; i < 100; ++i) {
      const Vec2 x = a.next2(), y = b.next2();
      EXPECT_EQ(x.x, y.x);
      EXPECT_EQ(x.y, y.y);
    }
  }
}

TEST(Sampler, EveryArgumentMatters) {
  for (const SamplerKind kind : {SamplerKind::sobol, SamplerKind::independent}) {
    std::set<float> seen;
    for (const std::uint32_t seed : {0u, 1u})
      for (const std::uint32_t sequence : {0u, 1u})
        for (const std::uint32_t index : {0u, 1u})
          for (const int dimension : {0, 1}) seen.insert(pair_of(kind, seed, sequence, index, dimension).x);
    EXPECT_EQ(seen.size(), 16u);
  }
}

TEST(Sampler, NumbersStayBelowOne) {
  EXPECT_LT(to_unit_float(0xffffffffu), 1.0f);
  EXPECT_EQ(to_unit_float(0), 0.0f);
}

TEST(Sampler, SobolPointsFillEveryElementaryInterval) {
  // A (0, m, 2)-net in base 2: each elementary interval of area 2^-m holds exactly one of 2^m points (Niederreiter
  // 1992, definition 4.1), and Owen scrambling and the shuffle must keep that.
  constexpr int m = 10;
  constexpr std::uint32_t count = 1u << m;
  for (const std::uint32_t block : {0u, 3u})
    for (const int dimension : {0, 1, 7})
      for (int columns_log = 0; columns_log <= m; ++columns_log) {
        const std::uint32_t columns = 1u << columns_log, rows = count / columns;
        std::vector<int> cells(count, 0);
        for (std::uint32_t i = 0; i < count; ++i) {
          const Vec2 u = pair_of(SamplerKind::sobol, 7, 99, block * count + i, dimension);
          ++cells[static_cast<std::uint32_t>(u.x * columns) * rows + static_cast<std::uint32_t>(u.y * rows)];
        }
        EXPECT_TRUE(std::all_of(cells.begin(), cells.end(), [](int n) { return n == 1; }))
            << "dimension " << dimension << ", " << columns << " columns";
      }
}

TEST(Sampler, IndependentNumbersAreUniform) {
  constexpr int members = 4;
  for (int dimension = 0; dimension < members; ++dimension)
    expect_fit(chi_squared_square([&](int i) { return pair_of(SamplerKind::independent, 11, 5, i, dimension); },
                                  [](Vec2) { return 1.0f; }, 100000, 32, 32)
                   .p_value,
               members, "independent pairs");
}

TEST(Sampler, DimensionsAndSequencesAreIndependent) {
  // Number a of one kind against number b of another, over many samples: uniform over the square if independent.
  const auto cross = [](SamplerKind kind, int which) {
    return chi_squared_square(
               [&](int i) {
                 const auto n = static_cast<std::uint32_t>(i);
                 if (which == 0)  // first and third dimension pair of one sample
                   return Vec2{pair_of(kind, 1, 2, n, 0).x, pair_of(kind, 1, 2, n, 2).x};
                 if (which == 1)  // the same sample of neighbouring sequences
                   return Vec2{pair_of(kind, 1, 2 * n, 0, 0).x, pair_of(kind, 1, 2 * n + 1, 0, 0).x};
                 return Vec2{pair_of(kind, n, 2, 0, 0).y, pair_of(kind, n + 1000000, 2, 0, 0).y};  // other seeds
               },
               [](Vec2) { return 1.0f; }, 65536, 16, 16)
        .p_value;
  };
  constexpr int members = 6;
  for (const SamplerKind kind : {SamplerKind::sobol, SamplerKind::independent})
    for (int which = 0; which < 3; ++which) expect_fit(cross(kind, which), members, "independence");
}

TEST(Sampler, SobolIntegratesBetterThanIndependent) {
  // The integral of x y over the square, by 1024 points of 64 sequences each.
  const auto squared_error = [](SamplerKind kind) {
    double sum = 0;
    for (std::uint32_t sequence = 0; sequence < 64; ++sequence) {
      double mean = 0;
      for (std::uint32_t i = 0; i < 1024; ++i) {
        const Vec2 u = pair_of(kind, 0, sequence, i, 0);
        mean += u.x * u.y / 1024;
      }
      sum += (mean - 0.25) * (mean - 0.25);
    }
    return sum;
  };
  EXPECT_LT(squared_error(SamplerKind::sobol) * 100, squared_error(SamplerKind::independent));
}

TEST(Hash, EveryInputBitTurnsHalfOfTheOutputBits) {
  constexpr int trials = 2000;
  constexpr int members = 32;
  for (int bit = 0; bit < 32; ++bit) {
    RunningMean turned;
    for (std::uint32_t i = 0; i < trials; ++i) {
      const std::uint32_t x = i * 0x9e3779b9u;
      turned.add(__builtin_popcount(hash32(x) ^ hash32(x ^ (1u << bit))));
    }
    // The hash's own bias is some 1e-3 of a bit; half a bit in sixteen is what a broken one would miss by far.
    EXPECT_NEAR(turned.mean(), 16, 0.5) << bit << " of " << members;
  }
}

TEST(NestedUniformScramble, IsAPermutationThatKeepsDyadicIntervals) {
  // Owen scrambling: two numbers share their first k bits before if and only if they do after.
  for (std::uint32_t i = 0; i < 2000; ++i) {
    const std::uint32_t a = hash32(i), b = a ^ (hash32(i + 77) >> (i % 32));
    const std::uint32_t before = a ^ b;
    const std::uint32_t after = nested_uniform_scramble(a, 1234) ^ nested_uniform_scramble(b, 1234);
    if (before == 0) {
      EXPECT_EQ(after, 0u);
    } else {
      ASSERT_NE(after, 0u);
      EXPECT_EQ(__builtin_clz(before), __builtin_clz(after));
    }
  }
}

}  // namespace
}  // namespace glowworm
