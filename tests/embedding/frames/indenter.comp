#version 450
// SPDX-License-Identifier: MIT
// The simulator's pressure: a dome around (x, y).
layout(local_size_x = 16, local_size_y = 4) in;
layout(push_constant) uniform Push {
    int width, height, pitch; // cells
    float x, y, radius;       // cells
    float peak;               // Pa
};
layout(std430, binding = 0) writeonly buffer Pressure { float pressure[]; };

void main() {
    ivec2 cell = ivec2(gl_GlobalInvocationID.xy);
    if (cell.x >= width || cell.y >= height) return;
    vec2 r = (vec2(cell) - vec2(x, y)) / radius;
    pressure[cell.y * pitch + cell.x] = peak * max(1.0 - dot(r, r), 0.0);
}
