// Runs one test kernel without Rust, for scripts/sanitize_kernels.sh: sanitize NAME. Exit status 2 is a wrong result.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <thread>
#include <vector>

#include "host/api.h"

template <class... A> static int launch(const char *name, unsigned blocks, unsigned threads, unsigned dynamic, A... values) {
  const hp::Kernel *kernel = hp_find(name);
  if (!kernel || hp_parameter_count(kernel) != sizeof...(A)) {
    std::fprintf(stderr, "no kernel %s with %zu parameters\n", name, sizeof...(A));
    return 3;
  }
  const void *arguments[] = {&values...};
  hp_launch shape{{blocks, 1, 1}, {threads, 1, 1}, dynamic, 1, 2, 3, 0, 0};  // random lanes and warps
  hp_fault fault{};
  hp::Run *run = hp_begin(kernel, &shape, arguments, nullptr, 0, &fault);
  if (run) {
    std::thread other([run] { hp_work(run); });
    hp_work(run);
    other.join();
    hp_end(run, &fault);
  }
  if (fault.kind) std::fprintf(stderr, "%s:%u: %s\n", fault.file, fault.line, fault.message);
  return fault.kind ? 3 : 0;
}

static int block() {
  std::vector<int> in(4 * 256, 1), sums(4), votes(4);
  int status = launch("selftest_block", 4, 256, 0, in.data(), sums.data(), votes.data());
  for (int sum : sums) status |= sum == 256 ? 0 : 2;
  return status;
}

static int numbers(const char *name, unsigned blocks, unsigned threads, unsigned dynamic) {
  std::vector<unsigned> out(blocks * threads * 4);
  return launch(name, blocks, threads, dynamic, out.data());
}

static int run(const char *name) {
  if (!std::strcmp(name, "selftest_block")) return block();
  if (!std::strcmp(name, "sanitize_beyond_buffer") || !std::strcmp(name, "sanitize_beyond_shared") ||
      !std::strcmp(name, "sanitize_within")) {
    std::vector<unsigned> out(64);
    return launch(name, 1, 64, 0, out.data(), 64);
  }
  if (!std::strcmp(name, "selftest_poison")) return numbers(name, 3, 32, 128);
  return numbers(name, 2, 64, 0);
}

int main(int count, char **arguments) {
  if (count == 2) return run(arguments[1]);
  std::fprintf(stderr, "usage: sanitize KERNEL\n");
  return 3;
}
