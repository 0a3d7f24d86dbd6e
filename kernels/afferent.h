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

// A fibre at a substep's end, and the share at which it fired: negative if it did not.
struct Fired {
    Fibre fibre;
    real share;
};

// One substep, from event to event.
inline Fired through_events(Fibre begin, Drive d, FibreConstants k) {
    Fibre end = filtered(begin, d, k);
    Fibre f = begin;
    Fired fired;
    fired.share = real(-1.0);
    real side[FIBRE_OUTPUTS];
    side[0] = side_of(f.y0, end.y0);
    side[1] = side_of(f.y1, end.y1);
    side[2] = side_of(f.y2, end.y2);
    precise real rest = f.rest * real(k.per_step);
    precise real at = real(0.0);
    for (int event = 0; event < k.events; ++event) {
        mask going = lessThan(at, real(1.0));
        if (!some(going)) break;
        precise real left = real(1.0) - at;
        Drive here;
        precise real w = d.w + d.gained * at;
        here.w = w;
        here.gained = d.gained;
        Derivatives y = derivatives_of(f, here, k);
        // The next event: the refractory time ends, or a derivative changes its sign.
        mask quiet = lessThan(real(0.0), rest);
        real to = mix(left, rest, both(quiet, lessThan(rest, left)));
        mask last = negated(both(quiet, lessThan(rest, left)));
        real turned[FIBRE_OUTPUTS];
        for (int j = 0; j < FIBRE_OUTPUTS; ++j) {
            turned[j] = side[j];
            if ((k.outputs & (1 << j)) == 0) continue;
            Fall change = first_fall(course_of(y, j, side[j], k), to, k.turn_bisections);
            to = change.at;
            last = both(last, negated(change.found));
            for (int i = 0; i < j; ++i) turned[i] = mix(turned[i], side[i], change.found);
            precise real other = -side[j];
            turned[j] = mix(side[j], other, change.found);
        }
        Course after0 = decay_course(f.after0, k.after_loss[0], k);
        Course after1 = decay_course(f.after1, k.after_loss[1], k);
        Course v = membrane_course(f.membrane, y, side, after0, after1, k);
        Course below = v; // 1 - V
        for (int i = 1; i <= COURSE_DEGREE; ++i) {
            precise real c = -v.c[i];
            below.c[i] = c;
        }
        precise real first = real(1.0) - v.c[0];
        below.c[0] = first;
        Fall crossing = first_fall(below, to, k.bisections);
        mask fires = both(both(crossing.found, going), negated(quiet));
        real s = mix(to, crossing.at, fires);
        Fibre next = filter_at(f, y, s, k);
        precise real when = at + s;
        fired.share = mix(fired.share, when, fires);
        next.membrane = mix(mix(course_at(v, s), real(k.reset), quiet), real(k.reset), fires);
        next.after0 = mix(course_at(after0, s), real(k.amplitude[0]), fires);
        next.after1 = mix(course_at(after1, s), real(k.amplitude[1]), fires);
        precise real remains = rest - s;
        rest = mix(rest, mix(mix(real(0.0), remains, lessThan(real(0.0), remains)), real(k.refractory), fires), going);
        for (int j = 0; j < FIBRE_OUTPUTS; ++j) side[j] = mix(side[j], mix(turned[j], side[j], fires), going);
        f.y0 = mix(f.y0, next.y0, going);
        f.y1 = mix(f.y1, next.y1, going);
        f.y2 = mix(f.y2, next.y2, going);
        f.membrane = mix(f.membrane, next.membrane, going);
        f.after0 = mix(f.after0, next.after0, going);
        f.after1 = mix(f.after1, next.after1, going);
        at = mix(at, mix(when, real(1.0), both(last, negated(fires))), going);
    }
    precise real seconds = rest * real(k.step);
    end.membrane = flush(f.membrane);
    end.rest = flush(seconds);
    end.after0 = flush(f.after0);
    end.after1 = flush(f.after1);
    fired.fibre = end;
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
        real gain = mix(real(k.gain[2 * j]), real(k.gain[2 * j + 1]), lessThan(now, real(0.0)));
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
