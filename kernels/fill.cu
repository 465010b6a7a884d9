// fill: where a spare fragment closes a crack, it takes the pixel (DESIGN section 4; ETER's CRK). Twin of src/stages/fill.rs.
#include "stroke.cuh"

namespace fill {

// Entries of the 3x3 neighbourhood that may show what N shows here for the vote to fill.
constexpr int VOTE = 3;
// Cosine beyond which a neighbour counts as outward of a stroke.
constexpr float OUTWARD = 0.3f;
constexpr uint32_t BACKGROUND = 0xffffffffu;

struct Rule {
    const View &view;
    const Geometry &in;
    Buffer<const Word> near;

    // The piece of surface a word shows.
    __device__ uint32_t patch_of(Word word) const {
        return word == 0 ? BACKGROUND : in.meshlets[topology::meshlet_of(word)].patch;
    }

    // Calls visit(dx, dy, word) for the nine pixels about one that the image has.
    template <class Visit> __device__ void neighbours(uint32_t pixel, Visit visit) const {
        const int width = view.size[0], height = view.size[1];
        const int x = pixel % width, y = pixel / width;
        for (int dy = -1; dy <= 1; dy++) {
            for (int dx = -1; dx <= 1; dx++) {
                if (x + dx >= 0 && x + dx < width && y + dy >= 0 && y + dy < height) {
                    visit(dx, dy, near[(y + dy) * width + x + dx]);
                }
            }
        }
    }

    // Unit normal of a stroke's edge on the screen, away from its triangle; false where it has none.
    __device__ bool outward(Word spare, float2 &normal) const {
        const Meshlet m = in.meshlets[topology::meshlet_of(spare)];
        const topology::Primitive p = topology::primitive(m, in.patches[m.patch].diagonal, topology::index_of(spare));
        if (!p.is_edge) {
            return false;
        }
        const Corners c = topology::corners(in, m, p);
        const i64 dx = c.v[1].x - c.v[0].x, dy = c.v[1].y - c.v[0].y;
        const i64 area = dx * i64(c.v[2].y - c.v[0].y) - dy * i64(c.v[2].x - c.v[0].x);
        const float length = sqrtf(float(dx * dx + dy * dy)), turn = float(sign(area));
        normal = make_float2(turn * float(dy) / length, -turn * float(dx) / length);
        return area != 0;
    }

    // Rule 5a: some neighbour outward of the stroke continues the surface: it is nearer than the midpoint of what the stroke
    // shows and what lies behind it.
    __device__ bool continues(uint32_t pixel, Word spare, Word here) const {
        const float middle = (topology::depth_of(spare) + topology::depth_of(here)) * 0.5f;
        float2 normal = make_float2(0.0f, 0.0f);
        const bool directed = outward(spare, normal);
        bool found = false;
        neighbours(pixel, [&](int dx, int dy, Word word) {
            const bool towards = !directed || float(dx) * normal.x + float(dy) * normal.y > OUTWARD;
            found = found || ((dx != 0 || dy != 0) && towards && topology::depth_of(word) > middle);
        });
        return found;
    }

    // Rule 5b and ETER section 6.1: few of the nine pixels show what N shows here. Background counts as a patch.
    __device__ bool vote(uint32_t pixel, Word here) const {
        const uint32_t patch = patch_of(here);
        int same = 0;
        neighbours(pixel, [&](int, int, Word word) { same += patch_of(word) == patch; });
        return same <= VOTE;
    }

    __device__ bool wants(uint32_t pixel, Word spare, Word here) const {
        if (!(topology::depth_of(spare) > topology::depth_of(here))) {
            return false;
        }
        switch (view.fill) {
        // Shading asks the exact surface (settle.cu); without it the neighbours have to tell.
        case FILL_STROKE: return view.refine > 0 || continues(pixel, spare, here) || vote(pixel, here);
        case FILL_ETER: return patch_of(spare) != patch_of(here) && vote(pixel, here);
        case FILL_CONSERVATIVE: return true;
        default: return false;
        }
    }
};

} // namespace fill

// Counts the pixels that the spare buffer takes and, where there is room for them, lists them in any order.
extern "C" __global__ void __launch_bounds__(THREADS)
    fill_list(GEOMETRY, Buffer<const Word> near, Buffer<const Word> spare, uint32_t room, Buffer<Filled> filled,
              Buffer<uint64_t> counted) {
    const Geometry in = GEOMETRY_ARGUMENTS;
    const uint32_t pixel = blockIdx.x * blockDim.x + threadIdx.x;
    if (pixel >= view.size[0] * view.size[1] || spare[pixel] == 0) {
        return;
    }
    const fill::Rule rule = {view, in, near};
    if (!rule.wants(pixel, spare[pixel], near[pixel])) {
        return;
    }
    const uint64_t place = counts::next(counted[0]);
    if (place < room) {
        Filled f = {};
        f.near = near[pixel];
        f.pixel = pixel;
        filled[place] = f;
    }
}
KERNEL(fill_list)

// They show what the spare buffer has, once all are decided.
extern "C" __global__ void __launch_bounds__(THREADS)
    fill_take(Buffer<Word> near, Buffer<const Word> spare, Buffer<const Filled> filled, Count count) {
    const uint32_t k = blockIdx.x * blockDim.x + threadIdx.x;
    if (k < count.get()) {
        const uint32_t pixel = filled[k].pixel;
        near[pixel] = spare[pixel];
    }
}
KERNEL(fill_take)
