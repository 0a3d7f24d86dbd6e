// SPDX-License-Identifier: MIT
// Maps that a kernel only reads. TEXELS is the variant for software drivers: lavapipe fetches a texel of four cells as one
// load, but loads a storage buffer cell by cell and checks each for its bounds. Texels are integers, so that the bits of
// every float arrive. FOUR is the vec4 i of a map, ONE its cell i.
#ifdef TEXELS
#define MAP(number, block, name) layout(binding = number) uniform utextureBuffer name
#define FOUR(map, i) uintBitsToFloat(texelFetch(map, i))
#define ONE(map, i) FOUR(map, (i) >> 2)[(i) & 3]
#else
#define MAP(number, block, name) layout(std430, binding = number) readonly restrict buffer block { vec4 name[]; }
#define FOUR(map, i) map[i]
#define ONE(map, i) map[(i) >> 2][(i) & 3]
#endif
