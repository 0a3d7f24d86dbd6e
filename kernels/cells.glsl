// SPDX-License-Identifier: MIT
// Specialization constants of the kernel press, and the check of pressures that a host gives.
layout(constant_id = VARIANT_STENCIL) const int STENCIL = STENCIL_FIVE_POINT;
layout(constant_id = VARIANT_EDGES) const int EDGES = EDGES_MIRROR;
layout(constant_id = VARIANT_COMPENSATED) const int COMPENSATED = 0;
layout(constant_id = VARIANT_MATERIALS) const int MATERIALS = 0;
layout(constant_id = VARIANT_FRAMES) const int FRAMES = 0;
layout(constant_id = VARIANT_RESPONSES) const int RESPONSES = (1 << RESPONSE_MAPS) - 1;
layout(constant_id = VARIANT_ELEMENTS) const int ELEMENTS = 1;
layout(constant_id = VARIANT_SPRING) const int SPRING = 0;
layout(constant_id = VARIANT_STRAIN) const int STRAIN = 0;
layout(constant_id = VARIANT_PADS) const int PADS = 0;
layout(constant_id = VARIANT_HOLD) const int HOLD = 0;
// Planes of a cell's state: their number; of sum s, the strain of element s or the integral; of the spring's rate; of the
// frame before.
#define PLANES STATE_PLANES(ELEMENTS, COMPENSATED, STRAIN, INTEGRATED, CARRIES_RATE, HOLD)
#define SUM_PLANE(s) STATE_SUM(s, COMPENSATED, STRAIN)
#define RATE STATE_RATE(ELEMENTS, COMPENSATED, STRAIN, INTEGRATED)
#define PREVIOUS STATE_PREVIOUS(ELEMENTS, COMPENSATED, STRAIN, INTEGRATED, CARRIES_RATE)
#define INTEGRATED ((RESPONSES >> (QUANTITY_SA2 - 1)) & 1)
#define CARRIES_RATE (SPRING & FRAMES & (RESPONSES >> (QUANTITY_FA2 - 1)))

// Whether the coefficients are in a table. Otherwise the constants hold the coefficients of the only element.
bool tabled() { return ELEMENTS + SPRING + MATERIALS + PADS / 2 + HOLD > 1; }
// The index, in a table, of the first Coefficients of the element with this index.
#define IN_TABLE(element) ((1 + HOLD) * (element))

bool asked(int quantity) { return (RESPONSES & RESPONSE_BIT(quantity)) != 0; }

// A pressure that is not finite counts as 0.
bvec4 finite(vec4 p) { return notEqual(floatBitsToUint(p) & 0x7f800000u, uvec4(0x7f800000u)); }
vec4 valid(vec4 p) { return mix(vec4(0.0), p, finite(p)); }
