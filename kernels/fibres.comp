#version 450
// SPDX-License-Identifier: MIT
// A press of nerve fibres of one kind: an invocation takes one fibre through all substeps. Spikes are appended to a list,
// in any order.
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

void main() {
    uint number = gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * gl_NumWorkGroups.x * FIBRES_X;
    if (number >= uint(dispatch.fibres)) return;
    // Padded fibres between pads are stepped too; they never fire.
    int i = dispatch.first + int(number) / dispatch.of_pad * dispatch.pad + int(number) % dispatch.of_pad;
    FibreConstants k = constants[dispatch.kind];
    Fibre f;
    f.y0 = state[FIBRE_Y0 * dispatch.plane + i];
    f.y1 = state[FIBRE_Y1 * dispatch.plane + i];
    f.y2 = state[FIBRE_Y2 * dispatch.plane + i];
    f.membrane = state[FIBRE_MEMBRANE * dispatch.plane + i];
    f.rest = state[FIBRE_REST * dispatch.plane + i];
    f.after0 = state[FIBRE_AFTER0 * dispatch.plane + i];
    f.after1 = state[FIBRE_AFTER1 * dispatch.plane + i];
    float from = state[FIBRE_INPUT * dispatch.plane + i];
    float change = change_of(from, inputs[i], k);
    for (int part = 0; part < k.substeps; ++part) {
        Drive d = drive_of(from, change, part, k);
        Straight s = straight_step(f, d, k);
        if (!s.eventful) {
            f = s.fibre;
            continue;
        }
        Fired end = through_events(f, d, k);
        f = end.fibre;
        if (end.share < 0.0) continue;
        uint at = atomicAdd(fired, 1u);
        spikes[at].fibre = i;
        spikes[at].share = share_of(end.share, part, k);
    }
    state[FIBRE_Y0 * dispatch.plane + i] = f.y0;
    state[FIBRE_Y1 * dispatch.plane + i] = f.y1;
    state[FIBRE_Y2 * dispatch.plane + i] = f.y2;
    state[FIBRE_MEMBRANE * dispatch.plane + i] = f.membrane;
    state[FIBRE_REST * dispatch.plane + i] = f.rest;
    state[FIBRE_AFTER0 * dispatch.plane + i] = f.after0;
    state[FIBRE_AFTER1 * dispatch.plane + i] = f.after1;
    state[FIBRE_INPUT * dispatch.plane + i] = inputs[i];
}
