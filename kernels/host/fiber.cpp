#include "fiber.h"

#include <string.h>
#include <sys/mman.h>

#ifdef HP_ASAN
#include <sanitizer/asan_interface.h>
#include <sanitizer/common_interface_defs.h>
#endif

// Saves the registers that a call must keep and the stack pointer, and takes those of another stack. Control registers of
// the floating-point unit stay as they are: kernels have no way to change them. It ends in a plain return, so that calls and
// returns stay paired: lanes wait in the same functions, and the processor predicts where each of them goes on.
#if defined(__x86_64__)
extern "C" void hp_switch(void **save, void *load);
asm(R"(
.pushsection .text
.globl hp_switch
.type hp_switch,@function
hp_switch:
  push %rbp
  push %rbx
  push %r12
  push %r13
  push %r14
  push %r15
  mov %rsp,(%rdi)
  mov %rsi,%rsp
  pop %r15
  pop %r14
  pop %r13
  pop %r12
  pop %rbx
  pop %rbp
  ret
.size hp_switch,.-hp_switch
.popsection
)");
static void *first_frame(char *top, void (*entry)()) {
  void **sp = reinterpret_cast<void **>(reinterpret_cast<uintptr_t>(top) & ~15ull);
  *--sp = nullptr;  // the return address of `entry`: none
  *--sp = reinterpret_cast<void *>(entry);
  for (int i = 0; i < 6; i++) *--sp = nullptr;
  return sp;
}
#elif defined(__aarch64__)
extern "C" void hp_switch(void **save, void *load);
asm(R"(
.pushsection .text
.globl hp_switch
.type hp_switch,%function
hp_switch:
  sub sp,sp,#160
  stp x19,x20,[sp]
  stp x21,x22,[sp,#16]
  stp x23,x24,[sp,#32]
  stp x25,x26,[sp,#48]
  stp x27,x28,[sp,#64]
  stp x29,x30,[sp,#80]
  stp d8,d9,[sp,#96]
  stp d10,d11,[sp,#112]
  stp d12,d13,[sp,#128]
  stp d14,d15,[sp,#144]
  mov x9,sp
  str x9,[x0]
  mov sp,x1
  ldp x19,x20,[sp]
  ldp x21,x22,[sp,#16]
  ldp x23,x24,[sp,#32]
  ldp x25,x26,[sp,#48]
  ldp x27,x28,[sp,#64]
  ldp x29,x30,[sp,#80]
  ldp d8,d9,[sp,#96]
  ldp d10,d11,[sp,#112]
  ldp d12,d13,[sp,#128]
  ldp d14,d15,[sp,#144]
  add sp,sp,#160
  ret
.size hp_switch,.-hp_switch
.popsection
)");
static void *first_frame(char *top, void (*entry)()) {
  void **sp = reinterpret_cast<void **>(reinterpret_cast<uintptr_t>(top) & ~15ull) - 20;
  memset(sp, 0, 160);
  sp[11] = reinterpret_cast<void *>(entry);
  return sp;
}
#else
#error "kernels/host/fiber.cpp: no context switch for this processor (x86-64 and AArch64 have one)"
#endif

namespace hp {

constexpr size_t STACK_BYTES = 128 << 10, GUARD_BYTES = 64 << 10;  // a guard is a whole page on every system
constexpr size_t EACH = STACK_BYTES + GUARD_BYTES;

char *map_stacks(Stack *stacks, unsigned count) {
  void *all = mmap(nullptr, count * EACH, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (all == MAP_FAILED) return nullptr;
  for (unsigned i = 0; i < count; i++) {
    char *low = static_cast<char *>(all) + i * EACH;
    mprotect(low, GUARD_BYTES, PROT_NONE);
    // Tops are staggered: at equal offsets all stacks would share a few cache sets.
    stacks[i] = {nullptr, low + GUARD_BYTES, low + EACH - i % 32 * 704, nullptr, nullptr};
  }
  return static_cast<char *>(all);
}
void unmap_stacks(char *mapping, unsigned count) { munmap(mapping, count * EACH); }

void reset_stack(Stack *stack, void (*entry)()) {
  allow_memory(stack->low, (size_t)(stack->high - stack->low));
  stack->fake = nullptr;
  stack->saved = first_frame(stack->high, entry);
}

// ---- sanitizers

#ifdef HP_ASAN
static __thread Stack *running, *left;
void forbid_memory(void *p, size_t bytes) { __asan_poison_memory_region(p, bytes); }
void allow_memory(void *p, size_t bytes) { __asan_unpoison_memory_region(p, bytes); }
void arrived() {
  const void *low;
  size_t bytes;
  __sanitizer_finish_switch_fiber(running->fake, &low, &bytes);
  if (left && !left->low) left->low = (char *)low, left->high = left->low + bytes;  // the system's own stack
}
__attribute__((no_sanitize("address"))) void switch_stack(Stack *from, Stack *to) {
  running = to;
  left = from;
  __sanitizer_start_switch_fiber(&from->fake, to->low, (size_t)(to->high - to->low));
  hp_switch(&from->saved, to->saved);
  arrived();
}
void adopt_own_stack(Stack *stack) { *stack = {}; }
#else
void forbid_memory(void *, size_t) {}
void allow_memory(void *, size_t) {}
void arrived() {}

#ifdef HP_TSAN
extern "C" {
void *__tsan_get_current_fiber();
void *__tsan_create_fiber(unsigned flags);
void __tsan_destroy_fiber(void *fiber);
void __tsan_switch_to_fiber(void *fiber, unsigned flags);
void __tsan_acquire(void *address);
void __tsan_release(void *address);
}
void race_release(void *what) { __tsan_release(what); }
void race_acquire(void *what) { __tsan_acquire(what); }
void race_create(Stack *stack) { stack->race_id = __tsan_create_fiber(0); }
void race_destroy(Stack *stack) { __tsan_destroy_fiber(stack->race_id); }
void adopt_own_stack(Stack *stack) {
  *stack = {};
  stack->race_id = __tsan_get_current_fiber();
}
void switch_stack(Stack *from, Stack *to) {
  __tsan_switch_to_fiber(to->race_id, 1 /* this switch orders nothing */);
  hp_switch(&from->saved, to->saved);
}
#else
void adopt_own_stack(Stack *stack) { *stack = {}; }
void switch_stack(Stack *from, Stack *to) { hp_switch(&from->saved, to->saved); }
#endif
#endif

}  // namespace hp
