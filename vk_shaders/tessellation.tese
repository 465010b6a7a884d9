#version 460
// evaluate by fixed-function tessellation: a rational point and its normal by one pass of de Casteljau's scheme, down to the
// last 2 x 2 points, whose combination is the point and whose differences are the derivatives (Mann and DeRose 1995, Computing
// values and derivatives of Bezier and B-spline tensor products).
#extension GL_GOOGLE_include_directive : require
#include "tessellation.glsl"

layout(quads, equal_spacing, ccw) in;

// Of the patches of a draw: known when the pipeline is made, so that loops unroll and points stay in registers.
layout(constant_id = 1) const uint DEGREE_U = 3;
layout(constant_id = 2) const uint DEGREE_V = 3;
// Parameters are the grid's own; else the hardware's, which have 16 bits behind the point.
layout(constant_id = 3) const bool EXACT = true;

layout(location = 0) out vec3 normal_out;

// Levels inside as hardware takes them: 1 is 2 where any other level is larger.
uvec2 inner_levels(Piece piece) {
    uvec2 inner = uvec2(piece.inner[0], piece.inner[1]);
    uint outer = max(max(uint(piece.outer[0]), uint(piece.outer[1])), max(uint(piece.outer[2]), uint(piece.outer[3])));
    return max(max(inner.x, inner.y), outer) > 1 ? max(inner, uvec2(2)) : inner;
}

// Grid lines of the piece that cross at this vertex, among so many: of a border where it lies on one.
uvec2 lines(Piece piece, out uvec2 levels) {
    vec2 at = gl_TessCoord.xy;
    levels = inner_levels(piece);
    levels.y = at.x == 0.0 ? uint(piece.outer[0]) : at.x == 1.0 ? uint(piece.outer[1]) : levels.y;
    levels.x = at.y == 0.0 ? uint(piece.outer[2]) : at.y == 1.0 ? uint(piece.outer[3]) : levels.x;
    return uvec2(round(at * vec2(levels)));
}

// t and 1 - t along both axes of the patch. Both are quotients of whole numbers below 2^24: each is rounded once, and a border
// has the same pairs from both its sides.
mat2 parameters(Piece piece) {
    uvec2 low = uvec2(piece.low[0], piece.low[1]), size = uvec2(piece.size[0], piece.size[1]);
    uvec2 whole = uvec2(piece.whole[0], piece.whole[1]), levels;
    if (!EXACT) {
        vec2 t = (vec2(low) + gl_TessCoord.xy * vec2(size)) / vec2(whole);
        return mat2(vec2(t.x, 1.0 - t.x), vec2(t.y, 1.0 - t.y));
    }
    uvec2 line = lines(piece, levels), all = whole * levels, at = low * levels + line * size;
    vec2 t = vec2(at) / vec2(all), rest = vec2(all - at) / vec2(all);
    return mat2(vec2(t.x, rest.x), vec2(t.y, rest.y));
}

vec4 blend(vec4 a, vec4 b, vec2 t) { return a * t.y + b * t.x; }

// Two control points a row that are left of it, and then the two of both columns: at (u0, v0), (u1, v0), (u0, v1), (u1, v1).
vec4[4] last_points(uint net, vec2 u, vec2 v) {
    vec4 low[DEGREE_U + 1], high[DEGREE_U + 1];
    [[unroll]] for (uint i = 0; i <= DEGREE_U; i++) {
        vec4 row[DEGREE_V + 1];
        [[unroll]] for (uint j = 0; j <= DEGREE_V; j++) {
            row[j] = Nets(push.values).at[net + i * (DEGREE_V + 1) + j];
        }
        [[unroll]] for (uint left = DEGREE_V; left > 1; left--) {
            [[unroll]] for (uint j = 0; j < left; j++) {
                row[j] = blend(row[j], row[j + 1], v);
            }
        }
        low[i] = row[0];
        high[i] = row[1];
    }
    [[unroll]] for (uint left = DEGREE_U; left > 1; left--) {
        [[unroll]] for (uint i = 0; i < left; i++) {
            low[i] = blend(low[i], low[i + 1], u);
            high[i] = blend(high[i], high[i + 1], u);
        }
    }
    return vec4[4](low[0], low[1], high[0], high[1]);
}

// The unit vector along S_u x S_v; 0 where they are parallel. Their lengths do not matter, nor the degrees in them.
vec3 unit_normal(vec4 point, vec4 along_u, vec4 along_v) {
    vec3 position = point.xyz / point.w;
    vec3 n = cross(along_u.xyz - position * along_u.w, along_v.xyz - position * along_v.w);
    // Squares of short ones would vanish.
    float largest = max(max(abs(n.x), abs(n.y)), abs(n.z));
    return largest > 1e-37 ? normalize(n / largest) : vec3(0.0);
}

// Pixels about the patch's centre, and stored depth: `Projector::vertex` of src/stages/evaluate.rs, before it snaps.
vec3 project(Patch patch_, vec4 p) {
    bool perspective = push.perspective != 0;
    float denominator = perspective ? p.z + patch_.depth_origin * p.w : p.w;
    float depth = perspective ? push.near * p.w / denominator : patch_.depth_offset - push.depth_slope * (p.z / p.w);
    return vec3(p.xy / denominator, clamp(depth, 1.17549435e-38, 1.0));
}

// Where a vertex is stored: inner ones first, then those of each border, corners of both.
void store(Piece piece, vec3 position, vec3 normal, vec2 t) {
    uvec2 inner = inner_levels(piece), levels, line = lines(piece, levels);
    vec2 at = gl_TessCoord.xy;
    bool on[4] = bool[4](at.x == 0.0, at.x == 1.0, at.y == 0.0, at.y == 1.0);
    if (!on[0] && !on[1] && !on[2] && !on[3]) {
        keep(piece.samples + (line.x - 1) * (inner.y - 1) + line.y - 1, position, normal, t);
    }
    uint first = piece.samples + (inner.x - 1) * (inner.y - 1);
    for (int side = 0; side < 4; side++) {
        // A corner's number is 0 or all of the side's.
        uint number = side < 2 ? (on[2] ? 0 : on[3] ? uint(piece.outer[side]) : line.y)
                               : (on[0] ? 0 : on[1] ? uint(piece.outer[side]) : line.x);
        if (on[side]) {
            keep(first + number, position, normal, t);
        }
        first += uint(piece.outer[side]) + 1;
    }
}

void main() {
    Piece piece = Pieces(push.list).at[push.first + gl_PrimitiveID];
    Patch patch_ = push.patches.at[piece.patch_];
    mat2 t = parameters(piece);
    vec4 last[4] = last_points(patch_.net, t[0], t[1]);
    vec4 at_u0 = blend(last[0], last[2], t[1]), at_u1 = blend(last[1], last[3], t[1]);
    vec4 point = blend(at_u0, at_u1, t[0]);
    vec4 along_v = blend(last[2], last[3], t[0]) - blend(last[0], last[1], t[0]);
    vec3 normal = unit_normal(point, at_u1 - at_u0, along_v);
    vec3 position = project(patch_, point);
    gl_Position = clip_of(patch_, position.xy, position.z);
    normal_out = normal;
    if (!is_wanted(position, normal)) {
        return;
    }
    if (STORES) {
        store(piece, position, normal, vec2(t[0].x, t[1].x));
    } else {
        keep(0, position, normal, vec2(t[0].x, t[1].x));
    }
}
