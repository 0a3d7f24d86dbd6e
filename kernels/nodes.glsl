// SPDX-License-Identifier: MIT
// Maps of nodes, for the kernels halve and spread (see spread.h): four nodes at a time, from a node x that is a multiple of
// 4. `pad` is the invocation's pad.
layout(local_size_x_id = SPREAD_GROUP_X, local_size_y_id = SPREAD_GROUP_Y, local_size_z_id = SPREAD_GROUP_Z) in;
layout(constant_id = SPREAD_OF_PADS) const int PADS = 0;
// SpreadConstants with the members of its two NodeMaps: HLSL packs no struct of 8 bytes behind another.
layout(push_constant) uniform Push {
    int fine_pitch, fine_pad, coarse_pitch, coarse_pad;
    int x_low, x_high, y_low, y_high;
    int weights, quantity, height, pitch;
    float gain_plus, gain_minus;
} c;
#define FINE NodeMap(c.fine_pitch, c.fine_pad)
#define COARSE NodeMap(c.coarse_pitch, c.coarse_pad)
MAP(SPREAD_FINE, Fine, fine);
layout(std430, binding = SPREAD_PADS) readonly buffer List { PadEntry pads[]; };

int pad = 0;
int place(NodeMap map, int x, int y) {
    return (pad * map.pad + (y + SPREAD_MARGIN) * map.pitch + x + SPREAD_MARGIN) >> 2;
}
vec4 fine_at(int x, int y) { return FOUR(fine, place(FINE, x, y)); }

// The first of the invocation's nodes; the last ones may be beyond x_high.
ivec2 own_nodes() {
    return ivec2((int(gl_GlobalInvocationID.x) << 2) + (c.x_low & ~3), int(gl_GlobalInvocationID.y) + c.y_low);
}
// Whether the invocation has nodes; then `pad` is set.
bool has_nodes(ivec2 node) {
    if (node.x > c.x_high || node.y > c.y_high) return false;
    if (PADS != 0) pad = pads[gl_GlobalInvocationID.z].pad;
    return pad >= 0;
}
// 0 where nodes are outside the level.
vec4 of_level(vec4 v, int x) {
    ivec4 node = ivec4(x, x + 1, x + 2, x + 3);
    bvec4 outside = notEqual(uvec4(lessThan(node, ivec4(c.x_low))) | uvec4(greaterThan(node, ivec4(c.x_high))), uvec4(0));
    return mix(v, vec4(0.0), outside);
}
