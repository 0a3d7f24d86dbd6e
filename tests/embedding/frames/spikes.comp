#version 450
// SPDX-License-Identifier: MIT
// An afferent for each receptor: it integrates the response and fires whenever it is full.
layout(local_size_x = 64) in;
layout(push_constant) uniform Push {
    int fa1_first, fa1_count, sa1_first, sa1_count;
    float fa1_gain, sa1_gain; // spikes per s and response
    float dt;                 // s
};
struct Reading {
    float response;
    uint spikes;
};
layout(std430, binding = 0) readonly buffer Responses { float responses[]; };
layout(std430, binding = 1) buffer Charges { float charges[]; };               // FA1, then SA1
layout(std430, binding = 2) writeonly buffer Readings { Reading readings[]; }; // the same

void main() {
    int i = int(gl_GlobalInvocationID.x);
    if (i >= fa1_count + sa1_count) return;
    bool fast = i < fa1_count;
    float response = responses[fast ? fa1_first + i : sa1_first + i - fa1_count];
    float drive = fast ? fa1_gain * abs(response) : sa1_gain * max(response, 0.0);
    float charge = charges[i] + drive * dt;
    charges[i] = fract(charge);
    readings[i] = Reading(response, uint(charge));
}
