// SPDX-License-Identifier: MIT
// One substep of a nerve fibre (include/dermis/afferents.hpp), over which its input q runs along a straight line. Where
// nothing happens, filter and membrane take one linear step. Where something may happen - a derivative of the filter's
// output changes sign, the membrane reaches 1, a refractory time ends - they follow their Taylor polynomials from event
// to event, and bisection finds when each event is. Times inside a substep are shares of it, from 0 to 1. The includer
// declares
//   mask                                   what lessThan() returns
//   mask both(mask, mask), either(mask, mask), differ(mask, mask), negated(mask)
//   bool some(mask)                        whether it holds in some lane

// A fibre: the filter's output and its derivatives (s-1, s-2), the membrane, the refractory time that is left (s), and
// the currents after the last spike.
struct Fibre {
    real y0, y1, y2, membrane, rest, after0, after1;
};

// The drive w = value*q + rate*q' at the start of a substep, and what it gains until its end.
struct Drive {
    real w, gained;
};

// part: the substep, of k.substeps. from, change: q at the press's start, and what it gains in a substep.
inline Drive drive_of(real from, real change, int part, FibreConstants k) {
    precise real q = from + real(part) * change;
    Drive d;
    precise real w = real(k.value) * q + real(k.rate) * change;
    precise real gained = real(k.value) * change;
    d.w = w;
    d.gained = gained;
    return d;
}

// What q gains in a substep of a press from q = from to q = to; and the share of the press at a share of a substep.
inline real change_of(real from, real to, FibreConstants k) {
    precise real change = (to - from) * real(k.per_substeps);
    return change;
}
inline real share_of(real share, int part, FibreConstants k) {
    precise real of_press = (real(part) + share) * real(k.per_substeps);
    return of_press;
}

// Row `row` of a matrix, applied to the drive and the filter's state.
#define FIBRE_ROW(matrix, row, f, d) row_of(k.matrix[5 * (row)], k.matrix[5 * (row) + 1], k.matrix[5 * (row) + 2], \
    k.matrix[5 * (row) + 3], k.matrix[5 * (row) + 4], f, d, k.poles)
inline real row_of(scalar w, scalar gained, scalar y0, scalar y1, scalar y2, Fibre f, Drive d, int poles) {
    precise real sum = real(w) * d.w + real(gained) * d.gained + real(y0) * f.y0;
    if (poles > 1) sum = sum + real(y1) * f.y1;
    if (poles > 2) sum = sum + real(y2) * f.y2;
    return sum;
}

// The filter at a substep's end; everything else as it was.
inline Fibre filtered(Fibre f, Drive d, FibreConstants k) {
    precise real y0 = FIBRE_ROW(filter_step, 0, f, d);
    Fibre end = f;
    end.y0 = flush(y0);
    if (k.poles > 1) {
        precise real y1 = FIBRE_ROW(filter_step, 1, f, d);
        end.y1 = flush(y1);
    }
    if (k.poles > 2) {
        precise real y2 = FIBRE_ROW(filter_step, 2, f, d);
        end.y2 = flush(y2);
    }
    return end;
}

// Derivatives 0 to COURSE_DERIVATIVES - 1 of the filter's output, in shares of a substep.
struct Derivatives {
    real at[COURSE_DERIVATIVES];
};

inline Derivatives derivatives_of(Fibre f, Drive d, FibreConstants k) {
    Derivatives y;
    precise real y0 = FIBRE_ROW(start, 0, f, d);
    precise real y1 = FIBRE_ROW(start, 1, f, d);
    precise real y2 = FIBRE_ROW(start, 2, f, d);
    y.at[0] = y0;
    y.at[1] = y1;
    y.at[2] = y2;
    precise real now = real(k.driven[0]) * d.w + real(k.driven[1]) * d.gained;
    precise real then = real(k.driven[2]) * d.gained;
    for (int i = 3; i < COURSE_DERIVATIVES; ++i) {
        precise real next = now - real(k.back[2]) * y.at[i - 1] - real(k.back[1]) * y.at[i - 2] -
                            real(k.back[0]) * y.at[i - 3];
        y.at[i] = next;
        now = then;
        then = real(0.0);
    }
    return y;
}

// A polynomial in the share of a substep, of degree COURSE_DEGREE = 10. Its terms are added in pairs, so that few
// additions wait for each other.
struct Course {
    real c[COURSE_DEGREE + 1];
};

inline real course_at(Course p, real s) {
    precise real s2 = s * s;
    precise real s4 = s2 * s2;
    precise real low = (p.c[0] + p.c[1] * s) + (p.c[2] + p.c[3] * s) * s2;
    precise real middle = (p.c[4] + p.c[5] * s) + (p.c[6] + p.c[7] * s) * s2;
    precise real high = (p.c[8] + p.c[9] * s) + p.c[10] * s2;
    precise real sum = low + (middle + high * s4) * s4;
    return sum;
}

inline Course slope_of(Course p) {
    Course slope;
    for (int i = 0; i < COURSE_DEGREE; ++i) {
        precise real c = real(i + 1) * p.c[i + 1];
        slope.c[i] = c;
    }
    slope.c[COURSE_DEGREE] = real(0.0);
    return slope;
}

// The course of derivative j, times a factor.
inline Course course_of(Derivatives y, int j, real factor, FibreConstants k) {
    Course p;
    for (int i = 0; i <= COURSE_DEGREE; ++i) {
        precise real c = factor * y.at[i + j] * real(k.per_factorial[i]);
        p.c[i] = c;
    }
    return p;
}

// The share at which a course that begins at 0 or above first falls below 0, if it does so before `to`. Within a
// substep a course has one minimum at most.
struct Fall {
    real at;
    mask found;
};

// Halves the share from 0 to `to` until the course has fallen below 0 in the second of its halves alone.
inline real fall_between(Course p, real to, int bisections) {
    precise real from = real(0.0);
    precise real width = to;
    for (int i = 0; i < bisections; ++i) {
        width = width * real(0.5);
        precise real middle = from + width;
        from = mix(middle, from, lessThan(course_at(p, middle), real(0.0)));
    }
    precise real found = from + width * real(0.5);
    return found;
}

inline Fall first_fall(Course p, real to, int bisections) {
    Fall fall;
    Course slope = slope_of(p);
    fall.found = lessThan(course_at(p, to), real(0.0));
    real before = to;
    mask dips = both(lessThan(p.c[1], real(0.0)), lessThan(real(0.0), course_at(slope, to)));
    if (some(both(dips, negated(fall.found)))) {
        for (int i = 0; i <= COURSE_DEGREE; ++i) { // falls where the course rises again
            precise real c = -slope.c[i];
            slope.c[i] = c;
        }
        real lowest = fall_between(slope, to, bisections);
        mask reaches = both(both(dips, negated(fall.found)), lessThan(course_at(p, lowest), real(0.0)));
        before = mix(before, lowest, reaches);
        fall.found = either(fall.found, reaches);
    }
    fall.at = to;
    if (some(fall.found)) fall.at = mix(to, fall_between(p, before, bisections), fall.found);
    return fall;
}

// The factor of derivative j where it has the sign `side`.
inline real gain_of(int j, real side, FibreConstants k) {
    return mix(real(k.gain[2 * j]), real(k.gain[2 * j + 1]), lessThan(side, real(0.0)));
}

// The sign of a number; of 0 the sign of what it becomes.
inline real side_of(real now, real then) {
    mask zero = both(negated(lessThan(now, real(0.0))), negated(lessThan(real(0.0), now)));
    return mix(real(1.0), real(-1.0), either(lessThan(now, real(0.0)), both(zero, lessThan(then, real(0.0)))));
}

// The course of the membrane under the current of the derivatives, each with the gain of its side. after0, after1: the
// courses of the currents after a spike.
inline Course membrane_course(real membrane, Derivatives y, real side[FIBRE_OUTPUTS], Course after0, Course after1,
                              FibreConstants k) {
    Course v;
    v.c[0] = membrane;
    real gain[FIBRE_OUTPUTS];
    for (int j = 0; j < FIBRE_OUTPUTS; ++j) {
        precise real in_shares = gain_of(j, side[j], k) * real(k.per_scale[j]);
        gain[j] = in_shares;
    }
    for (int i = 0; i < COURSE_DEGREE; ++i) {
        precise real current = gain[0] * y.at[i] + gain[1] * y.at[i + 1] + gain[2] * y.at[i + 2];
        precise real driven = current * real(k.per_factorial[i]) + after0.c[i] + after1.c[i] - v.c[i];
        precise real next = real(k.loss) * driven * real(k.per_next[i]);
        v.c[i + 1] = next;
    }
    return v;
}

// The course of a current that decays.
inline Course decay_course(real current, scalar loss, FibreConstants k) {
    Course p;
    p.c[0] = current;
    for (int i = 0; i < COURSE_DEGREE; ++i) {
        precise real next = -(real(loss) * p.c[i]) * real(k.per_next[i]);
        p.c[i + 1] = next;
    }
    return p;
}

// The state of the filter at share s of a substep, from its derivatives.
inline Fibre filter_at(Fibre f, Derivatives y, real s, FibreConstants k) {
    precise real y0 = course_at(course_of(y, 0, real(1.0), k), s);
    f.y0 = y0;
    if (k.poles > 1) {
        precise real y1 = course_at(course_of(y, 1, real(k.per_scale[1]), k), s);
        f.y1 = y1;
    }
    if (k.poles > 2) {
        precise real y2 = course_at(course_of(y, 2, real(k.per_scale[2]), k), s);
        f.y2 = y2;
    }
    return f;
}

// a in lanes that are not `second`, b in those that are.
inline Fibre either_fibre(Fibre a, Fibre b, mask second) {
    a.y0 = mix(a.y0, b.y0, second);
    a.y1 = mix(a.y1, b.y1, second);
    a.y2 = mix(a.y2, b.y2, second);
    a.membrane = mix(a.membrane, b.membrane, second);
    a.after0 = mix(a.after0, b.after0, second);
    a.after1 = mix(a.after1, b.after1, second);
    return a;
}

// A fibre within a substep, at the share `at`: the refractory time that is left, in substeps; the signs of its
// derivatives; and the share at which it fired, negative if it has not.
struct Within {
    Fibre fibre;
    real at, rest, share;
    real side[FIBRE_OUTPUTS];
};

// The end of the refractory time, or the first change of a sign, whichever comes first, as a share from `at` on; the
// substep's end where neither comes. side: the signs after it.
struct Turn {
    real at;
    mask found;
    real side[FIBRE_OUTPUTS];
};

inline Turn first_turn(Within f, Derivatives y, FibreConstants k) {
    Turn turn;
    precise real left = real(1.0) - f.at;
    turn.found = both(lessThan(real(0.0), f.rest), lessThan(f.rest, left));
    turn.at = mix(left, f.rest, turn.found);
    for (int j = 0; j < FIBRE_OUTPUTS; ++j) {
        turn.side[j] = f.side[j];
        if ((k.outputs & (1 << j)) == 0) continue;
        Fall change = first_fall(course_of(y, j, f.side[j], k), turn.at, k.turn_bisections);
        turn.at = change.at;
        turn.found = either(turn.found, change.found);
        for (int i = 0; i < j; ++i) turn.side[i] = mix(turn.side[i], f.side[i], change.found); // these come later
        precise real other = -f.side[j];
        turn.side[j] = mix(f.side[j], other, change.found);
    }
    return turn;
}

// 1 - V.
inline Course below_threshold(Course v) {
    precise real first = real(1.0) - v.c[0];
    v.c[0] = first;
    for (int i = 1; i <= COURSE_DEGREE; ++i) {
        precise real c = -v.c[i];
        v.c[i] = c;
    }
    return v;
}

// The fibre at its next event, or at the substep's end. d: the drive of the substep.
inline Within at_next_event(Within f, Drive d, FibreConstants k) {
    mask going = lessThan(f.at, real(1.0));
    mask quiet = lessThan(real(0.0), f.rest);
    Drive here = d;
    precise real w = d.w + d.gained * f.at;
    here.w = w;
    Derivatives y = derivatives_of(f.fibre, here, k);
    Turn turn = first_turn(f, y, k);
    Course after0 = decay_course(f.fibre.after0, k.after_loss[0], k);
    Course after1 = decay_course(f.fibre.after1, k.after_loss[1], k);
    Course v = membrane_course(f.fibre.membrane, y, f.side, after0, after1, k);
    Fall crossing = first_fall(below_threshold(v), turn.at, k.bisections);
    mask fires = both(both(crossing.found, going), negated(quiet));
    real s = mix(turn.at, crossing.at, fires);
    Fibre next = filter_at(f.fibre, y, s, k);
    next.membrane = mix(mix(course_at(v, s), real(k.reset), quiet), real(k.reset), fires);
    next.after0 = mix(course_at(after0, s), real(k.amplitude[0]), fires);
    next.after1 = mix(course_at(after1, s), real(k.amplitude[1]), fires);
    precise real when = f.at + s;
    precise real remains = f.rest - s;
    real rest = mix(mix(real(0.0), remains, lessThan(real(0.0), remains)), real(k.refractory), fires);
    f.share = mix(f.share, when, fires);
    f.rest = mix(f.rest, rest, going);
    for (int j = 0; j < FIBRE_OUTPUTS; ++j) f.side[j] = mix(f.side[j], turn.side[j], both(going, negated(fires)));
    f.fibre = either_fibre(f.fibre, next, going);
    f.at = mix(f.at, mix(real(1.0), when, either(turn.found, fires)), going);
    return f;
}

// A fibre at a substep's end, and the share at which it fired: negative if it did not.
struct Fired {
    Fibre fibre;
    real share;
};

// One substep, from event to event.
inline Fired through_events(Fibre begin, Drive d, FibreConstants k) {
    Fibre end = filtered(begin, d, k);
    Within f;
    f.fibre = begin;
    f.at = real(0.0);
    precise real rest = begin.rest * real(k.per_step);
    f.rest = rest;
    f.share = real(-1.0);
    f.side[0] = side_of(begin.y0, end.y0);
    f.side[1] = side_of(begin.y1, end.y1);
    f.side[2] = side_of(begin.y2, end.y2);
    for (int event = 0; event < k.events && some(lessThan(f.at, real(1.0))); ++event) f = at_next_event(f, d, k);
    precise real seconds = f.rest * real(k.step);
    end.membrane = flush(f.fibre.membrane); // the filter's state is that of one linear step
    end.rest = flush(seconds);
    end.after0 = flush(f.fibre.after0);
    end.after1 = flush(f.fibre.after1);
    Fired fired;
    fired.fibre = end;
    fired.share = f.share;
    return fired;
}

inline real greater(real a, real b) { return mix(a, b, lessThan(a, b)); }

// A fibre after a substep in which nothing happens, and whether something may, so that the substep must be taken by
// through_events().
struct Straight {
    Fibre fibre;
    mask eventful;
};

// Whether a derivative may be 0 within a substep: where its ends have other signs, or where it comes near 0 and leaves
// again.
inline mask may_change_sign(real now, real later, real slope, real slope_later) {
    precise real falls = now * slope;
    precise real rises = later * slope_later;
    precise real reach = real(2.0) * abs(slope);
    mask dips = both(both(lessThan(falls, real(0.0)), lessThan(real(0.0), rises)), lessThan(abs(now), reach));
    return either(dips, differ(lessThan(now, real(0.0)), lessThan(later, real(0.0))));
}

// Derivative j of the filter's output, and what it changes by in a substep if it goes on as it does at a substep's start.
inline real derivative_of(Fibre f, int j) { return j == 0 ? f.y0 : (j == 1 ? f.y1 : f.y2); }
inline real slope_at(Fibre f, Drive d, int j, FibreConstants k) {
    if (j + 1 < k.poles) {
        precise real slope = real(k.step) * derivative_of(f, j + 1);
        return slope;
    }
    precise real of_equation = FIBRE_ROW(highest, 0, f, d);
    return of_equation;
}

inline Straight straight_step(Fibre f, Drive d, FibreConstants k) {
    Straight s;
    s.fibre = filtered(f, d, k);
    Fibre end = s.fibre;
    Drive then;
    precise real w = d.w + d.gained;
    then.w = w;
    then.gained = d.gained;
    s.eventful = lessThan(real(1.0), real(0.0));
    precise real gained = real(0.0); // by the membrane
    precise real current = real(0.0);
    precise real current_later = real(0.0);
    for (int j = 0; j < FIBRE_OUTPUTS; ++j) {
        if ((k.outputs & (1 << j)) == 0) continue;
        real now = derivative_of(f, j);
        real later = derivative_of(end, j);
        mask turns = may_change_sign(now, later, slope_at(f, d, j, k), slope_at(end, then, j, k));
        s.eventful = either(s.eventful, turns);
        real gain = gain_of(j, now, k);
        precise real through = FIBRE_ROW(membrane_step, j, f, d);
        gained = gained + gain * through;
        current = current + gain * now;
        current_later = current_later + gain * later;
    }
    if (k.after != 0) {
        gained = gained + real(k.after_gain[0]) * f.after0 + real(k.after_gain[1]) * f.after1;
        precise real after0 = real(k.after_keep[0]) * f.after0;
        precise real after1 = real(k.after_keep[1]) * f.after1;
        s.fibre.after0 = flush(after0);
        s.fibre.after1 = flush(after1);
        current = current + f.after0 + f.after1;
        current_later = current_later + after0 + after1;
    }
    precise real v = real(k.keep) * f.membrane + gained;
    precise real rises = real(k.loss) * (current - f.membrane);
    precise real falls = real(k.loss) * (v - current_later);
    precise real highest = greater(f.membrane, v) + real(2.0) * greater(rises, falls);
    mask peaks = both(both(lessThan(real(0.0), rises), lessThan(real(0.0), falls)), lessThan(real(1.0), highest));
    mask resting = lessThan(real(0.0), f.rest);
    mask throughout = negated(lessThan(f.rest, real(k.step)));
    s.eventful = both(either(either(s.eventful, resting), either(lessThan(real(1.0), v), peaks)), negated(throughout));
    precise real remains = f.rest - real(k.step);
    s.fibre.membrane = mix(flush(v), real(k.reset), throughout);
    s.fibre.rest = mix(real(0.0), remains, throughout);
    return s;
}
