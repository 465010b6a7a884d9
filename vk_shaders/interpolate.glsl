// The parameters of a pixel on its triangle or stroke, before refinement. Twin of kernels/interpolate.cuh.
#include "stroke.glsl"

// a / b as IEEE has it, where b is normal and positive and the quotient is normal or zero.
float divided(float a, float b) { return a == 0.0 ? a : a < 0.0 ? -quotient(-a, b) : quotient(a, b); }

// Patch parameters of a place in the meshlet's grid.
vec2 parameters_of(Meshlet m, ivec2 place) {
    uint quads[2] = uint[2](uint(push.patches.at[m.patch_].quads[0]), uint(push.patches.at[m.patch_].quads[1]));
    return vec2(divided(float(uint(m.first[0]) + place.x), float(quads[0])), divided(float(uint(m.first[1]) + place.y), float(quads[1])));
}

float weight_of(Meshlet m, ivec2 place) { return vertex_of(m, place).weight; }

// On a triangle: perspective-correct with the weights that the bound's interpolation asks for; from the nearest point where
// the centre is not inside.
vec2 in_triangle(Meshlet m, ivec2 given_places[3], Corners given, ivec2 pixel) {
    int64_t area = area_of(given);
    Corners c = turned(given, area);
    ivec2 places[3] = area < 0 ? ivec2[3](given_places[0], given_places[2], given_places[1]) : given_places;
    float weights[3];
    bool outside = area == 0;
    [[unroll]] for (int k = 0; k < 3; k++) {
        int64_t e = edge_at(c, k, center_of(pixel));
        outside = outside || e < 0;
        weights[(k + 2) % 3] = float(e);
    }
    if (outside) {
        weights = nearest_weights(c, pixel);
    }
    precise float x = weights[0] * weight_of(m, places[0]), y = weights[1] * weight_of(m, places[1]);
    precise float z = weights[2] * weight_of(m, places[2]);
    precise float sum = x + y + z;
    precise vec2 total = x * parameters_of(m, places[0]) + y * parameters_of(m, places[1]) + z * parameters_of(m, places[2]);
    return vec2(divided(total.x, sum), divided(total.y, sum));
}

vec2 on_edge(Meshlet m, ivec2 places[3], Corners c, ivec2 pixel) {
    i64vec2 way = i64vec2(c.at[1]) - i64vec2(c.at[0]), to = center_of(pixel) - i64vec2(c.at[0]);
    float s = nearest_on(way.x * to.x + way.y * to.y, way.x * way.x + way.y * way.y);
    // Linear on the screen with the weights of the ends, so that the parameter is linear in space.
    precise float from = (1.0 - s) * weight_of(m, places[0]), upto = s * weight_of(m, places[1]);
    precise float sum = from + upto;
    float t = divided(upto, sum);
    vec2 a = parameters_of(m, places[0]), b = parameters_of(m, places[1]);
    precise vec2 at = a + (b - a) * t;
    return at;
}
