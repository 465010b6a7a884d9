#version 460
// Nothing: a piece is a patch of one control point, which says no more than its number.

void main() {}
