// Points and boxes against trim trees.
#include "trim_tree.cuh"

// inside[i]: the i-th point (u, v); regions[i]: the box about points 2 i and 2 i + 1.
extern "C" __global__ void selftest_trims(trims::Trims t, uint32_t tree, Buffer<const double> points, uint32_t count,
                                          Buffer<uint32_t> inside, Buffer<uint32_t> regions) {
  const uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= count) return;
  auto point = [&](uint32_t k) { return trims::PlanePoint{points[2 * k], points[2 * k + 1]}; };
  inside[i] = trims::contains(t, tree, point(i));
  if (2 * i + 1 < count) regions[i] = trims::classify(t, tree, trims::box_around(point(2 * i), point(2 * i + 1)));
}
KERNEL(selftest_trims)
