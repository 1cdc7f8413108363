// Large arrays without initial values.
#pragma once
#include <cstddef>
#include <memory>
#include <new>
#include <span>
#include <type_traits>
#include <vector>

namespace glowworm {

/// Allocates memory for large arrays. It is not cleared, is aligned to at least 64 bytes, and uses huge pages if the
/// system offers them, so that scattered access causes fewer TLB misses. Throws std::bad_alloc if memory runs out.
void* allocate_large(std::size_t bytes);
void free_large(void* memory);

/// Makes std::vector take its memory from allocate_large().
template <typename T>
struct LargeAllocator {
  using value_type = T;
  LargeAllocator() = default;
  template <typename U>
  LargeAllocator(const LargeAllocator<U>&) {}
  T* allocate(std::size_t n) {
    if (n > static_cast<std::size_t>(-1) / sizeof(T)) throw std::bad_alloc();
    return static_cast<T*>(allocate_large(n * sizeof(T)));
  }
  void deallocate(T* memory, std::size_t) { free_large(memory); }
  template <typename U>
  bool operator==(const LargeAllocator<U>&) const {
    return true;
  }
};

/// A vector that may grow large.
template <typename T>
using LargeVector = std::vector<T, LargeAllocator<T>>;

/// A move-only array of n elements without initial values.
template <typename T>
class LargeArray {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);

 public:
  LargeArray() = default;
  explicit LargeArray(std::size_t n) : data_(static_cast<T*>(allocate_large(n * sizeof(T)))), size_(n) {}

  std::size_t size() const { return size_; }
  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }
  T& operator[](std::size_t i) { return data_.get()[i]; }
  const T& operator[](std::size_t i) const { return data_.get()[i]; }
  T* begin() { return data_.get(); }
  T* end() { return data_.get() + size_; }
  const T* begin() const { return data_.get(); }
  const T* end() const { return data_.get() + size_; }
  std::span<T> span() { return {data_.get(), size_}; }
  std::span<const T> span() const { return {data_.get(), size_}; }

 private:
  struct Free {
    void operator()(T* memory) const { free_large(memory); }
  };
  std::unique_ptr<T, Free> data_;
  std::size_t size_ = 0;
};

}  // namespace glowworm
