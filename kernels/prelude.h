// SPDX-License-Identifier: MIT
// One language for GLSL and C++. In C++ the includer opens a struct or a namespace, defines the types `real` and `scalar`
// (float and float, double and double, or glm::vec4 and float: four cells at a time) and provides the GLSL functions
// abs, min, max, mix, lessThan. In GLSL real is float unless it is defined before, as vec4. Every function of kernels/*.h
// keeps these rules (a build check counts them): only + - * compare and select, each intermediate a `precise` local,
// both factors of type real (what translates a vector times a scalar drops `precise`), literals real(...), structs
// filled member by member.
#ifdef __cplusplus
#define precise
// Begins a function of a Cell that the includer declares (cell.h): always inlined, because a call would load all of the
// cell's coefficients again.
#define OF_ANY_CELL template <class Cell> __attribute__((always_inline)) inline
#else
#define OF_ANY_CELL
#define inline
#define scalar float
#ifndef real
#define real float
bool lessThan(float a, float b) { return a < b; }
#endif
#endif

// The least magnitude that is stored: 2^-64 in float; on the host also 2^-340, 4e-103, in double, and any in long double.
#ifdef __cplusplus
inline scalar least_stored() {
    return scalar(sizeof(scalar) == 4 ? 5.421010862427522e-20 : sizeof(scalar) == 8 ? 4.464794497196387e-103 : 0.0);
}
#else
#define least_stored() 5.421010862427522e-20
#endif
// Every stored value passes here: what is smaller becomes +0, so no denormal and no -0 is ever kept.
inline real flush(real x) { return mix(x, real(0.0), lessThan(abs(x), real(least_stored()))); }
