#version 450
// SPDX-License-Identifier: MIT
// A press of nerve fibres of one kind: an invocation takes the endings of one fibre through all substeps. Spikes are
// appended to a list, in any order.
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

// Takes the ending with index i in a plane through a substep. Returns the share at which it fires, or less than 0.
float step_ending(int i, int part, FibreConstants k) {
    Fibre f;
    f.y0 = state[FIBRE_Y0 * dispatch.plane + i];
    f.y1 = state[FIBRE_Y1 * dispatch.plane + i];
    f.y2 = state[FIBRE_Y2 * dispatch.plane + i];
    f.membrane = state[FIBRE_MEMBRANE * dispatch.plane + i];
    f.rest = state[FIBRE_REST * dispatch.plane + i];
    f.after0 = state[FIBRE_AFTER0 * dispatch.plane + i];
    f.after1 = state[FIBRE_AFTER1 * dispatch.plane + i];
    float from = state[FIBRE_INPUT * dispatch.plane + i];
    Drive d = drive_of(from, change_of(from, inputs[i], k), part, k);
    Straight s = straight_step(f, d, k);
    Fired end;
    end.fibre = s.fibre;
    end.share = -1.0;
    if (s.eventful) end = through_events(f, d, k);
    state[FIBRE_Y0 * dispatch.plane + i] = end.fibre.y0;
    state[FIBRE_Y1 * dispatch.plane + i] = end.fibre.y1;
    state[FIBRE_Y2 * dispatch.plane + i] = end.fibre.y2;
    state[FIBRE_MEMBRANE * dispatch.plane + i] = end.fibre.membrane;
    state[FIBRE_REST * dispatch.plane + i] = end.fibre.rest;
    state[FIBRE_AFTER0 * dispatch.plane + i] = end.fibre.after0;
    state[FIBRE_AFTER1 * dispatch.plane + i] = end.fibre.after1;
    return end.share;
}

// Gives ending i what a spike of another ending of its fibre leaves behind.
void follow_ending(int i, int fires) {
    for (int p = FIBRE_MEMBRANE; p <= FIBRE_AFTER1; ++p)
        state[p * dispatch.plane + i] = state[p * dispatch.plane + fires];
}

void main() {
    uint number = gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * gl_NumWorkGroups.x * FIBRES_X;
    if (number >= uint(dispatch.fibres)) return;
    // Padded fibres between pads are stepped too; they never fire.
    int i = dispatch.first + int(number) / dispatch.of_pad * dispatch.pad + int(number) % dispatch.of_pad;
    FibreConstants k = constants[dispatch.kind];
    for (int part = 0; part < k.substeps; ++part) {
        float first = 2.0; // share of the substep at which an ending fires first
        int fires = -1;
        for (int e = 0; e < dispatch.endings; ++e) {
            float share = step_ending(i + e * dispatch.of_pad, part, k);
            if (share < 0.0 || !(share < first)) continue;
            first = share;
            fires = e;
        }
        if (fires < 0) continue;
        for (int e = 0; e < dispatch.endings; ++e)
            if (e != fires) follow_ending(i + e * dispatch.of_pad, i + fires * dispatch.of_pad);
        uint at = atomicAdd(fired, 1u);
        spikes[at].fibre = i;
        spikes[at].share = share_of(first, part, k);
    }
    for (int e = 0; e < dispatch.endings; ++e) {
        int j = i + e * dispatch.of_pad;
        state[FIBRE_INPUT * dispatch.plane + j] = inputs[j];
    }
}
