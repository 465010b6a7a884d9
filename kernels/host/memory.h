// Global and shared memory that notices a wrong index where it is used.
#pragma once
#include "runtime.h"

namespace hp {

// An index and the place where it is used: the conversion from a number happens in the kernel's own line.
struct Index {
  int64_t value;
  Site at;
  template <class I>
    requires std::is_integral_v<I>
  Index(I i, Site at = Site::current()) : value((int64_t)i), at(at) {}
};

[[noreturn]] void fail_buffer(uint64_t address, uint64_t bytes, uint32_t allocation, size_t size, Site at);
[[noreturn]] void fail_span(int64_t index, int64_t count, size_t size, Site at);

// An address has 48 bits; the upper 16 number the allocation it was made from, so that a pointer that ran into the next
// allocation is found too. Number 0 is a plain pointer, not checked.
constexpr unsigned ADDRESS_BITS = 48;
constexpr uint64_t ADDRESS_MASK = (1ull << ADDRESS_BITS) - 1;

}  // namespace hp

template <class T> class Buffer {
  uint64_t bits;

 public:
  Buffer() = default;
  explicit Buffer(uint64_t bits) : bits(bits) {}
  Buffer(T *plain) : bits(reinterpret_cast<uint64_t>(plain)) {}
  operator Buffer<const T>() const { return Buffer<const T>(bits); }
  explicit operator bool() const { return bits != 0; }
  uint64_t tagged() const { return bits; }

  T *plain() const { return reinterpret_cast<T *>(bits & hp::ADDRESS_MASK); }
  T &operator[](hp::Index i) const { return *(*this + i.value).checked(i.at); }
  friend Buffer operator+(Buffer p, int64_t n) {
    return Buffer((p.bits & ~hp::ADDRESS_MASK) | ((p.bits + (uint64_t)n * sizeof(T)) & hp::ADDRESS_MASK));
  }
  friend Buffer operator-(Buffer p, int64_t n) { return p + -n; }
  Buffer &operator+=(int64_t n) { return *this = *this + n; }
  Buffer &operator-=(int64_t n) { return *this = *this + -n; }
  Buffer &operator++() { return *this += 1; }
  T *checked(hp::Site at) const {
    uint64_t address = bits & hp::ADDRESS_MASK, allocation = bits >> hp::ADDRESS_BITS;
    if (allocation) {
      const hp::Range *range = hp::grid.ranges + allocation;
      bool inside = allocation < hp::grid.range_count && address - range->first < range->bytes &&
                    range->bytes - (address - range->first) >= sizeof(T);
      if (!inside || address % alignof(T)) [[unlikely]] hp::fail_buffer(address, alignof(T), allocation, sizeof(T), at);
    }
    return reinterpret_cast<T *>(address);
  }
};

// A part of shared memory.
template <class T> class Span {
  T *first;
  int64_t count;

 public:
  Span() = default;
  Span(T *first, int64_t count) : first(first), count(count) {}
  operator Span<const T>() const { return {first, count}; }
  T *plain() const { return first; }
  int64_t size() const { return count; }
  T &operator[](hp::Index i) const {
    if ((uint64_t)i.value >= (uint64_t)count) [[unlikely]] hp::fail_span(i.value, count, sizeof(T), i.at);
    return first[i.value];
  }
  friend Span operator+(Span p, int64_t n) { return {p.first + n, p.count - n}; }
  Span &operator+=(int64_t n) { return *this = *this + n; }
};

namespace hp {

// An array in shared memory, of any number of dimensions.
template <class T> struct Array;
template <class T, size_t N> struct Array<T[N]> {
  T *first;
  decltype(auto) operator[](Index i) const {
    if ((uint64_t)i.value >= N) [[unlikely]] fail_span(i.value, N, sizeof(T), i.at);
    if constexpr (std::is_array_v<T>) return Array<T>{first[i.value]};
    else return (first[i.value]);
  }
  operator Span<T>() const { return {first, (int64_t)N}; }
  operator Span<const T>() const { return {first, (int64_t)N}; }
  friend Span<T> operator+(Array a, int64_t n) { return Span<T>(a) + n; }
};

// Names a shared variable; the running block finds the memory for it, poisoned when it is first met.
struct SharedVariable {
  uint32_t bytes, alignment;
  uint32_t number = 0;
};
void *shared_memory(SharedVariable *variable, Site at);
template <class T> auto shared(SharedVariable *variable, Site at) -> std::conditional_t<std::is_array_v<T>, Array<T>, T &> {
  void *memory = shared_memory(variable, at);
  if constexpr (std::is_array_v<T>) return Array<T>{*static_cast<T *>(memory)};
  else return *static_cast<T *>(memory);
}
template <class T> Span<T> dynamic_shared() {
  return {reinterpret_cast<T *>(grid.dynamic_shared), (int64_t)(grid.dynamic_bytes / sizeof(T))};
}

}  // namespace hp

#define SHARED(T, name, ...)                                                                \
  static hp::SharedVariable name##_variable{sizeof(T __VA_ARGS__), alignof(T __VA_ARGS__)}; \
  auto &&name = hp::shared<T __VA_ARGS__>(&name##_variable, hp::Site::current())
#define DYNAMIC_SHARED(T, name) Span<T> name = hp::dynamic_shared<T>()

template <class U, class T> Buffer<U> as(Buffer<T> p) { return Buffer<U>(p.tagged()); }
template <class U, class T> Span<U> as(Span<T> p) {
  return {reinterpret_cast<U *>(p.plain()), (int64_t)(p.size() * sizeof(T) / sizeof(U))};
}
template <class U, class T> U *as(T *p) { return reinterpret_cast<U *>(p); }
template <class T> T *raw(Buffer<T> p) { return p.plain(); }
template <class T> T *raw(Span<T> p) { return p.plain(); }
template <class T, size_t N> T *raw(hp::Array<T[N]> a) { return a.first; }
template <class T> T *raw(T *p) { return p; }
template <class T> T __ldg(const T *p) { return *p; }
template <class T> auto __ldg(Buffer<T> p, hp::Site at = hp::Site::current()) { return std::remove_const_t<T>(*p.checked(at)); }
template <class T> T __ldcg(const T *p) { return __ldg(p); }
template <class T> auto __ldcg(Buffer<T> p, hp::Site at = hp::Site::current()) { return __ldg(p, at); }
template <class T> T __ldca(const T *p) { return __ldg(p); }
template <class T> auto __ldca(Buffer<T> p, hp::Site at = hp::Site::current()) { return __ldg(p, at); }
