// Does again what an emulated device recorded (src/emulated/recording.rs says how), for scripts/sanitize_kernels.sh: replay
// FILE. Every buffer must be the same after every launch. Exit status 2: one was not; 3: a fault, or no recording.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include "host/block.h"

// `message` and the place in a recording.
[[noreturn]] static void stop(int status, const std::string &message) {
  std::fprintf(stderr, "%s\n", message.c_str());
  std::exit(status);
}

struct Reader {
  const std::vector<char> &bytes;
  size_t at = 0;

  const char *take(size_t count) {
    if (bytes.size() - at < count) stop(3, "the recording ends within an event");
    at += count;
    return bytes.data() + at - count;
  }
  template <class T> T number() {
    T value;
    std::memcpy(&value, take(sizeof value), sizeof value);
    return value;
  }
};

// An allocation of its own, so that AddressSanitizer sees where it ends.
struct Allocation {
  uint64_t recorded = 0;
  char *first = nullptr;
  uint64_t bytes = 0;
};

struct Device {
  std::vector<Allocation> allocations{{}};
  unsigned launches = 0;
  std::set<std::string> kernels;

  Allocation &at(uint64_t number) {
    if (number >= allocations.size()) stop(3, "the recording names an allocation that it did not make");
    return allocations[number];
  }

  void allocate(Reader &in) {
    uint64_t bits = in.number<uint64_t>(), bytes = in.number<uint64_t>(), number = bits >> hp::ADDRESS_BITS;
    int fill = in.number<uint8_t>();
    if (number >= allocations.size()) allocations.resize(number + 1);
    void *memory = nullptr;
    if (posix_memalign(&memory, 256, bytes ? bytes : 1)) stop(3, "no memory for an allocation");
    std::memset(memory, fill, bytes);
    allocations[number] = {bits & hp::ADDRESS_MASK, static_cast<char *>(memory), bytes};
  }

  void write(Reader &in) {
    Allocation &a = at(in.number<uint32_t>());
    std::memcpy(a.first, in.take(a.bytes), a.bytes);
  }

  void release(Reader &in) {
    Allocation &a = at(in.number<uint32_t>());
    std::free(a.first);
    a = {};
  }

  // Addresses in an argument become those of here: they name their allocation, so nothing else looks like one.
  void relocate(std::vector<uint64_t> &words) {
    for (uint64_t &word : words) {
      uint64_t number = word >> hp::ADDRESS_BITS, address = word & hp::ADDRESS_MASK;
      if (!number || number >= allocations.size()) continue;
      const Allocation &a = allocations[number];
      if (a.first && address - a.recorded <= a.bytes)
        word = number << hp::ADDRESS_BITS | (reinterpret_cast<uint64_t>(a.first) + (address - a.recorded));
    }
  }

  void launch(Reader &in) {
    uint32_t length = in.number<uint32_t>();
    std::string name(in.take(length), length);
    hp_launch shape = in.number<hp_launch>();
    const hp::Kernel *kernel = hp_find(name.c_str());
    if (!kernel || hp_parameter_count(kernel) != in.number<uint32_t>()) stop(3, "no kernel " + name + " like the recorded one");
    std::vector<std::vector<uint64_t>> values(hp_parameter_count(kernel));
    std::vector<const void *> arguments;
    for (uint32_t k = 0; k < values.size(); k++) {
      uint32_t bytes = in.number<uint32_t>();
      if (bytes != hp_parameter_bytes(kernel, k)) stop(3, name + " has other parameters than the recorded one");
      values[k].resize((bytes + 15) / 16 * 2);
      std::memcpy(values[k].data(), in.take(bytes), bytes);
      relocate(values[k]);
      arguments.push_back(values[k].data());
    }
    run(name, kernel, shape, arguments);
    compare(in, name);
    launches++;
    kernels.insert(name);
  }

  void run(const std::string &name, const hp::Kernel *kernel, const hp_launch &shape, const std::vector<const void *> &arguments) {
    std::vector<hp::Range> ranges;
    for (const Allocation &a : allocations) ranges.push_back({reinterpret_cast<uintptr_t>(a.first), a.bytes});
    hp_fault fault{};
    // One thread: blocks come in the recorded order, and ThreadSanitizer sees none between them all the same.
    hp::Run *run = hp_begin(kernel, &shape, arguments.data(), ranges.data(), ranges.size(), &fault);
    if (run) {
      hp_work(run);
      hp_end(run, &fault);
    }
    if (fault.kind) stop(3, name + ": " + fault.file + ":" + std::to_string(fault.line) + ": " + fault.message);
  }

  void compare(Reader &in, const std::string &name) {
    for (uint32_t left = in.number<uint32_t>(); left; left--) {
      uint32_t number = in.number<uint32_t>();
      uint64_t expected = in.number<uint64_t>(), hash = 0xcbf29ce484222325;
      const Allocation &a = at(number);
      for (uint64_t i = 0; i < a.bytes; i += 8) {
        uint64_t word = 0;
        std::memcpy(&word, a.first + i, a.bytes - i < 8 ? a.bytes - i : 8);
        hash = (hash ^ word) * 0x100000001b3;
      }
      if (hash != expected) stop(2, "launch " + std::to_string(launches) + ", " + name + ", leaves another allocation " + std::to_string(number));
    }
  }
};

int main(int count, char **arguments) {
  if (count != 2) stop(3, "usage: replay FILE");
  std::ifstream file(arguments[1], std::ios::binary);
  std::vector<char> bytes((std::istreambuf_iterator<char>(file)), {});
  Reader in{bytes};
  Device device;
  while (in.at < bytes.size()) {
    char event = in.number<char>();
    if (event == 'A') device.allocate(in);
    else if (event == 'W') device.write(in);
    else if (event == 'F') device.release(in);
    else if (event == 'L') device.launch(in);
    else stop(3, "the recording has an unknown event");
  }
  if (!device.launches) stop(3, "the recording has no launch");
  std::printf("%u launches, %zu kernels\n", device.launches, device.kernels.size());
}
