// Shared memory of the running block: dynamic first, then each static variable behind a gap when the block first meets it.
#include <sys/mman.h>

#include "block.h"

namespace hp {

constexpr unsigned GAP = 32;                             // between variables; AddressSanitizer watches it
constexpr size_t BYTES = MAX_SHARED + MAX_SHARED_VARIABLES * (GAP + 128);
constexpr int POISON = 0xff;                             // NaN as a float, -1 as an integer

// Not memset: the race detector would take it for a write of the running thread, and this is no part of the kernel.
static void fill(void *memory, int byte, size_t bytes) {
  char *p = static_cast<char *>(memory), *end = p + bytes;
  uint64_t word = 0x0101010101010101ull * (unsigned char)byte;
  for (; end - p >= 8; p += 8) {
    __builtin_memcpy(p, &word, 8);
    asm volatile("" ::: "memory");
  }
  for (; p < end; p++) *static_cast<volatile char *>(p) = (char)byte;
}

bool map_shared(Block *b) {
  if (b->shared) return true;
  void *memory = mmap(nullptr, BYTES, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  b->shared = memory == MAP_FAILED ? nullptr : static_cast<char *>(memory);
  return b->shared != nullptr;
}

void start_shared(Block *b) {
  unsigned dynamic = b->run->launch.dynamic_bytes;
  forbid_memory(b->shared, BYTES);
  allow_memory(b->shared, dynamic);
  fill(b->shared, POISON, dynamic);
  fill(b->offset, 0, sizeof b->offset);
  b->static_bytes = 0;
  b->shared_end = dynamic;
  grid.dynamic_shared = b->shared;
  grid.dynamic_bytes = dynamic;
}

static uint32_t number_of(SharedVariable *v) {
  static uint32_t last = 0;
  uint32_t number = __atomic_load_n(&v->number, __ATOMIC_RELAXED);
  if (number) return number;
  uint32_t fresh = __atomic_add_fetch(&last, 1, __ATOMIC_RELAXED);
  // Another operating system thread may have numbered it meanwhile.
  bool mine = __atomic_compare_exchange_n(&v->number, &number, fresh, false, __ATOMIC_RELAXED, __ATOMIC_RELAXED);
  return mine ? fresh : number;
}

void *shared_memory(SharedVariable *v, Site at) {
  Block *b = self()->block;
  uint32_t number = number_of(v);
  if (number >= MAX_SHARED_VARIABLES)
    fail(FaultKind::shared_memory, at, "all kernels together declare more than %u shared variables", MAX_SHARED_VARIABLES - 1);
  unsigned *offset = &b->offset[number];
  if (!*offset) {
    unsigned alignment = v->alignment < 16 ? 16 : v->alignment;
    b->static_bytes += (v->bytes + alignment - 1) & ~(alignment - 1);
    unsigned total = b->static_bytes + b->run->launch.dynamic_bytes;
    if (b->static_bytes > MAX_STATIC_SHARED || total > MAX_SHARED)
      fail(FaultKind::shared_memory, at, "a block declares %u bytes of shared memory and has %u dynamic ones; there are %u and %u",
           b->static_bytes, b->run->launch.dynamic_bytes, MAX_STATIC_SHARED, MAX_SHARED);
    *offset = (b->shared_end + GAP + alignment - 1) & ~(alignment - 1);
    b->shared_end = *offset + v->bytes;
    allow_memory(b->shared + *offset, v->bytes);
    fill(b->shared + *offset, POISON, v->bytes);
  }
  return b->shared + *offset;
}

}  // namespace hp
