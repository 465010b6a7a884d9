#version 460
// The levels of a piece. u = 0 is outer level 0, v = 0 is 1, u = 1 is 2, v = 1 is 3.
#extension GL_GOOGLE_include_directive : require
#include "tessellation.glsl"

layout(vertices = 1) out;

void main() {
    Piece piece = Pieces(push.list).at[push.first + gl_PrimitiveID];
    gl_TessLevelInner[0] = float(piece.inner[0]);
    gl_TessLevelInner[1] = float(piece.inner[1]);
    gl_TessLevelOuter[0] = float(piece.outer[0]);
    gl_TessLevelOuter[1] = float(piece.outer[2]);
    gl_TessLevelOuter[2] = float(piece.outer[1]);
    gl_TessLevelOuter[3] = float(piece.outer[3]);
}
