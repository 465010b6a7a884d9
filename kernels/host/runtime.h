// What the headers that kernels include know of the runtime. A CUDA thread is a fiber; a collective is a rendezvous, and the
// last lane that arrives computes the result for all of them.
#pragma once
#include <source_location>
#include <type_traits>
#include <utility>

namespace hp {

using Site = std::source_location;  // file, line and column of a call in a kernel

// The part of a CUDA thread that kernels see.
struct Thread {
  uint3 index;
  unsigned lane;
};

// An allocation of the device. Pointers name it in their upper 16 bits (see memory.h).
struct Range {
  uintptr_t first;
  uint64_t bytes;
};

// The running block, as its threads see it.
struct Grid {
  uint3 block_index, block_size, size;
  char *dynamic_shared;
  unsigned dynamic_bytes;
  const Range *ranges;
  size_t range_count;
};

// A block stays on one operating system thread from its first instruction to its last. `__thread` needs no set-up call.
extern __thread Thread *current;
extern __thread Grid grid;

enum class FaultKind : int {
  none,
  deadlock,            // nobody can run
  mismatch,            // lanes that should meet are at different collectives
  not_in_mask,         // a lane is not in the mask it passes
  source_lane,         // a shuffle reads a lane that takes no part
  incomplete_warp,     // a matrix product without all 32 lanes
  out_of_bounds,       // of a buffer or of shared memory
  misaligned,          // an address that the GPU would refuse
  shared_memory,       // more of it than there is
  bad_launch,          // sizes that CUDA refuses
};
// Ends the launch with this diagnosis.
[[noreturn]] __attribute__((format(printf, 3, 4))) void fail(FaultKind kind, Site at, const char *format, ...);

// ---- collectives

enum class Op : uint8_t {
  syncwarp, shuffle, shuffle_up, shuffle_down, shuffle_xor, ballot, any, all, match_any, match_all,
  add, bit_and, bit_or, bit_xor, min_unsigned, max_unsigned, min_signed, max_signed, mma,
  syncthreads, syncthreads_count, syncthreads_and, syncthreads_or,
};
// Waits for the lanes of `mask`; `extra` is the source lane of a shuffle.
uint64_t collective(Op op, unsigned mask, uint64_t value, unsigned extra, Site at);
// Waits for all threads of the block.
int barrier(Op op, int predicate, Site at);
// Lets other threads run, as a loop that waits for them must.
void yield();
void fence();

enum class Tile { f16_k8, f16_k16, f16_k16_sparse, tf32_k8 };
void mma(Tile tile, float (&d)[4], const uint32_t *a, const uint32_t *b, const float (&c)[4], Site at, uint32_t metadata = 0);

// ---- kernels, found by name

struct Parameter {
  uint32_t bytes;
  bool plain_pointer;  // T * where Buffer<T> would be checked
};
struct Kernel {
  const char *name;
  void (*call)(const void *const *arguments);
  const Parameter *parameters;
  uint32_t parameter_count;
  const Kernel *next;
};
void add_kernel(Kernel *kernel);

template <auto kernel, class... P, size_t... I>
void call_kernel(void (*)(P...), const void *const *arguments, std::index_sequence<I...>) {
  kernel(*static_cast<const std::remove_cvref_t<P> *>(arguments[I])...);
}
template <class... P> struct Parameters {
  static constexpr uint32_t count = sizeof...(P);
  static constexpr Parameter list[count + 1] = {{sizeof(P), std::is_pointer_v<P>}..., {0, false}};
};
template <class... P> Parameters<std::remove_cvref_t<P>...> parameters_of(void (*)(P...));
template <class... P> std::index_sequence_for<P...> indices_of(void (*)(P...));

template <auto kernel> struct Registration {
  Kernel entry;
  explicit Registration(const char *name)
      : entry{name,
              [](const void *const *arguments) { call_kernel<kernel>(kernel, arguments, decltype(indices_of(kernel))()); },
              decltype(parameters_of(kernel))::list, decltype(parameters_of(kernel))::count, nullptr} {
    add_kernel(&entry);
  }
};

}  // namespace hp

#define KERNEL(name) static const hp::Registration<name> name##_registration(#name);
