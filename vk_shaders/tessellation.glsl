// What the tessellation pipeline's shaders are told. No frame uses them: they are what ETER's table 3 compares with.
#extension GL_EXT_buffer_reference2 : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_explicit_arithmetic_types : require
#extension GL_EXT_control_flow_attributes : require
#include "abi.glsl"

// `Piece` of src/vulkan/tessellation_pieces.rs: [low, low + size] of `whole`, along both axes.
struct Piece {
    uint patch_;
    uint samples;
    uint16_t low[2];
    uint16_t size[2];
    uint16_t whole[2];
    uint16_t inner[2];
    uint16_t outer[4];
};

// `Sample` of src/vulkan/tessellation.rs.
struct Sample {
    float position[3];
    float normal[3];
    float parameters[2];
};

layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Patches { Patch at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Pieces { Piece at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Meshlets { Meshlet at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Nets { vec4 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Points { SurfacePoint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer Samples { Sample at[]; };

// `TessellationPush` of src/vulkan/tessellation_pipelines.rs.
layout(push_constant, scalar) uniform Pushed {
    Patches patches;
    // Tessellation reads pieces and nets, the mesh shader meshlets and points.
    uint64_t list;
    uint64_t values;
    Samples samples;
    uint first;
    uint count;
    int middle[2];
    int half_viewport;
    uint perspective;
    float near;
    float depth_slope;
    float sentinel;
} push;

// Whether what is emitted is stored too, where tests read it.
layout(constant_id = 0) const bool STORES = false;

// Clip coordinates of a place in pixels about its patch's centre.
vec4 clip_of(Patch patch_, vec2 place, float depth) {
    vec2 base = vec2(patch_.base[0], patch_.base[1]) / float(SUBPIXELS) - vec2(push.middle[0], push.middle[1]);
    return vec4((base + place) / float(push.half_viewport), depth, 1.0);
}

// A driver may drop the work of a shader whose primitives are discarded. So all of a vertex goes into a question whose answer is
// never yes: no sum is as large as the sentinel, and no compiler knows that.
bool is_wanted(vec3 position, vec3 normal) {
    return STORES || dot(position, vec3(1.0)) + dot(normal, vec3(1.0)) == push.sentinel;
}

void keep(uint place, vec3 position, vec3 normal, vec2 parameters) {
    push.samples.at[place] = Sample(float[3](position.x, position.y, position.z),
                                                 float[3](normal.x, normal.y, normal.z), float[2](parameters.x, parameters.y));
}
