// Stacks, the switch between them, and what sanitizers must be told about it.
#pragma once
#include <stddef.h>
#include <stdint.h>

#if defined(__SANITIZE_ADDRESS__)
#define HP_ASAN 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define HP_ASAN 1
#endif
#endif

namespace hp {

struct Stack {
  void *saved;  // stack pointer while it does not run
  char *low, *high;
  void *fake;      // AddressSanitizer's own stack
  void *race_id;   // ThreadSanitizer's name for what runs here
};

// `count` stacks with a guard page below each, in one mapping; null if the system refuses.
char *map_stacks(Stack *stacks, unsigned count);
void unmap_stacks(char *mapping, unsigned count);
// The next switch to this stack calls `entry`, which never returns.
void reset_stack(Stack *stack, void (*entry)());
void switch_stack(Stack *from, Stack *to);
// First thing on a new stack.
void arrived();
// `stack` becomes a name for the operating system's own stack.
void adopt_own_stack(Stack *stack);

// ThreadSanitizer sees fibers as threads. Order between them exists only where the runtime says so.
#ifdef HP_TSAN
constexpr bool RACE_DETECTION = true;
void race_release(void *what);
void race_acquire(void *what);
void race_create(Stack *stack);
void race_destroy(Stack *stack);
#else
constexpr bool RACE_DETECTION = false;
inline void race_release(void *) {}
inline void race_acquire(void *) {}
inline void race_create(Stack *) {}
inline void race_destroy(Stack *) {}
#endif

// AddressSanitizer: memory that nobody may touch until it is allowed again.
void forbid_memory(void *p, size_t bytes);
void allow_memory(void *p, size_t bytes);

}  // namespace hp
