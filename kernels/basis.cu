// Bernstein values on uniform grids, a table for each degree and number of quads that occurs, in this order. Twin of
// src/stages/basis.rs: computed in f64, rounded once.
#include "abi.h"
#include "count.cuh"

namespace basis {

// The place of a degree and a number of quads in the list of tables.
static __device__ __forceinline__ uint32_t key(uint32_t degree, uint32_t quads) {
    return degree * BASIS_SIDES + quads;
}

} // namespace basis

// A thread a leaf: the sizes of the tables it needs.
extern "C" __global__ void __launch_bounds__(128)
    basis_sizes(Count count, Buffer<const Patch> patches, Buffer<uint32_t> sizes) {
    const uint32_t k = blockIdx.x * blockDim.x + threadIdx.x;
    if (k >= count.get()) {
        return;
    }
    for (int axis = 0; axis < 2; axis++) {
        const uint32_t degree = patches[k].degree[axis], quads = patches[k].quads[axis];
        uint32_t *size = &sizes[basis::key(degree, quads)];
        if (racy_load(size) == 0) {
            atomicExch(size, (degree + 1) * (quads + 1));
        }
    }
}
KERNEL(basis_sizes)

// A block a table, a thread a line: all Bernstein polynomials by the triangular recurrence. `rows`: room in f64.
extern "C" __global__ void __launch_bounds__(32)
    basis_tables(Buffer<const uint32_t> sizes, Buffer<const uint32_t> places, Count all, Buffer<double> rows,
                 Buffer<float> tables) {
    const uint32_t degree = blockIdx.x / BASIS_SIDES, quads = blockIdx.x % BASIS_SIDES;
    if (sizes[blockIdx.x] == 0 || !all.fits()) {
        return;
    }
    for (uint32_t line = threadIdx.x; line <= quads; line += 32) {
        const double t = double(line) / double(quads);
        const uint32_t first = places[blockIdx.x] + line * (degree + 1);
        const Buffer<double> row = rows + first;
        row[0] = 1.0;
        for (uint32_t d = 1; d <= degree; d++) {
            double carried = 0.0;
            for (uint32_t k = 0; k < d; k++) {
                const double old = row[k];
                row[k] = carried + (1.0 - t) * old;
                carried = t * old;
            }
            row[d] = carried;
        }
        for (uint32_t k = 0; k <= degree; k++) {
            tables[first + k] = float(row[k]);
        }
    }
}
KERNEL(basis_tables)

// A thread a leaf: where its tables are.
extern "C" __global__ void __launch_bounds__(128)
    basis_places(Count count, Buffer<Patch> patches, Buffer<const uint32_t> places) {
    const uint32_t k = blockIdx.x * blockDim.x + threadIdx.x;
    if (k >= count.get()) {
        return;
    }
    for (int axis = 0; axis < 2; axis++) {
        patches[k].basis[axis] = places[basis::key(patches[k].degree[axis], patches[k].quads[axis])];
    }
}
KERNEL(basis_places)
