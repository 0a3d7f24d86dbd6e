// SPDX-License-Identifier: MIT
// The state of a Cell (cell.h), by its planes in layout.h. The includer declares of its Cell:
//   real number_from(Cell, int plane)              of the state at the step's start
//   void store_number(Cell, int plane, real)       of the state at the step's end
int elements_of(Cell cell) { return ELEMENTS; }
bool has_spring(Cell cell) { return SPRING != 0; }
bool has_rate(Cell cell) { return CARRIES_RATE != 0; }
bool has_integral(Cell cell) { return INTEGRATED != 0; }
int is_compensated(Cell cell) { return COMPENSATED; }

Sum sum_from(Cell cell, int s) {
    return sum_of(number_from(cell, SUM_PLANE(s)), COMPENSATED != 0 ? number_from(cell, SUM_PLANE(s) + 1) : real(0.0));
}
void store(Cell cell, int s, Sum before, Sum after) {
    store_number(cell, SUM_PLANE(s), after.value);
    if (COMPENSATED != 0) store_number(cell, SUM_PLANE(s) + 1, after.lost);
}

real rate_from(Cell cell) { return number_from(cell, RATE); }
void store_rate(Cell cell, real rate) { store_number(cell, RATE, rate); }

bool has_past(Cell cell) { return HOLD != 0; }
real previous_from(Cell cell) { return number_from(cell, PREVIOUS); }
void store_previous(Cell cell, real p) { store_number(cell, PREVIOUS, p); }
