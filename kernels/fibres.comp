#version 450
// SPDX-License-Identifier: MIT
// Some substeps of a press of nerve fibres of one kind: an invocation takes the endings of one fibre through them. Spikes
// are appended to a list, in any order.
#extension GL_GOOGLE_include_directive : require
#define mask bool
bool both(bool a, bool b) { return a && b; }
bool either(bool a, bool b) { return a || b; }
bool differ(bool a, bool b) { return a != b; }
bool negated(bool a) { return !a; }
bool some(bool a) { return a; }
#include "prelude.h"
#include "layout.h"
#include "afferent.h"

layout(local_size_x = FIBRES_X) in;
layout(push_constant) uniform Push { FibreDispatch dispatch; };
layout(std430, binding = FIBRES_CONSTANTS) readonly restrict buffer Constants_ { FibreConstants constants[]; };
layout(std430, binding = FIBRES_STATE) restrict buffer State { float state[]; };
layout(std430, binding = FIBRES_INPUT) readonly restrict buffer Input { float inputs[]; };
layout(std430, binding = FIBRES_SPIKES) restrict buffer Spikes {
    uint fired;
    uint unused;
    FibreEntry spikes[];
};

// The ending with index i in a plane.
Fibre ending_at(int i) {
    Fibre f;
    f.y0 = state[FIBRE_Y0 * dispatch.plane + i];
    f.y1 = state[FIBRE_Y1 * dispatch.plane + i];
    f.y2 = state[FIBRE_Y2 * dispatch.plane + i];
    f.membrane = state[FIBRE_MEMBRANE * dispatch.plane + i];
    f.rest = state[FIBRE_REST * dispatch.plane + i];
    f.after0 = state[FIBRE_AFTER0 * dispatch.plane + i];
    f.after1 = state[FIBRE_AFTER1 * dispatch.plane + i];
    return f;
}

void put_ending(int i, Fibre f) {
    state[FIBRE_Y0 * dispatch.plane + i] = f.y0;
    state[FIBRE_Y1 * dispatch.plane + i] = f.y1;
    state[FIBRE_Y2 * dispatch.plane + i] = f.y2;
    state[FIBRE_MEMBRANE * dispatch.plane + i] = f.membrane;
    state[FIBRE_REST * dispatch.plane + i] = f.rest;
    state[FIBRE_AFTER0 * dispatch.plane + i] = f.after0;
    state[FIBRE_AFTER1 * dispatch.plane + i] = f.after1;
}

// Gives ending i what a spike of another ending of its fibre leaves behind.
void follow_ending(int i, int fires) {
    for (int p = FIBRE_MEMBRANE; p <= FIBRE_AFTER1; ++p)
        state[p * dispatch.plane + i] = state[p * dispatch.plane + fires];
}

void main() {
    int number = dispatch.from + int(gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * gl_NumWorkGroups.x * FIBRES_X);
    if (number >= dispatch.to) return;
    // Padded fibres between pads are stepped too; they never fire.
    int i = dispatch.first + number / dispatch.of_pad * dispatch.pad + number % dispatch.of_pad;
    FibreConstants k = constants[dispatch.kind];
    Fibre f = ending_at(i); // a single ending stays in registers
    bool single = dispatch.endings == 1;
    float first = 2.0; // share of the substep at which an ending fires first
    int fires = 0;
    if (dispatch.begin % dispatch.endings != 0) {
        first = state[FIBRE_FIRST * dispatch.plane + i];
        fires = int(state[FIBRE_FIRES * dispatch.plane + i]);
    }
    for (int n = dispatch.begin; n < dispatch.end; ++n) {
        int part = n / dispatch.endings;
        int e = n - part * dispatch.endings;
        int j = i + e * dispatch.of_pad;
        if (!single) f = ending_at(j);
        float from = state[FIBRE_INPUT * dispatch.plane + j];
        Drive d = drive_of(from, change_of(from, inputs[j], k), part, k);
        Straight s = straight_step(f, d, k);
        if (s.eventful) {
            Fired end = through_events(f, d, k);
            f = end.fibre;
            if (end.share >= 0.0 && end.share < first) {
                first = end.share;
                fires = e;
            }
        } else {
            f = s.fibre;
        }
        if (!single) put_ending(j, f);
        if (e + 1 < dispatch.endings || first > 1.0) continue;
        for (int other = 0; other < dispatch.endings; ++other)
            if (other != fires) follow_ending(i + other * dispatch.of_pad, i + fires * dispatch.of_pad);
        uint at = atomicAdd(fired, 1u);
        spikes[at].fibre = i;
        spikes[at].share = share_of(first, part, k);
        first = 2.0;
    }
    if (single) put_ending(i, f);
    state[FIBRE_FIRST * dispatch.plane + i] = first;
    state[FIBRE_FIRES * dispatch.plane + i] = float(fires);
}
