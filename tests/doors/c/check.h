/* SPDX-License-Identifier: MIT */
/* A claim that does not hold ends the test with its line and the last error. */
#pragma once

#include <dermis/dermis.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void check(int holds, const char* claim, const char* file, int line) {
    if (holds) return;
    fprintf(stderr, "%s:%d: %s; last error: %s\n", file, line, claim, dermis_last_error());
    exit(1);
}

/* Whether a relative difference is at most 1e-6. */
static int near(double a, double b) { return fabs(a - b) <= 1e-6 * fabs(b); }

#define CHECK(claim) check((claim) != 0, #claim, __FILE__, __LINE__)
/* The call is refused as bad input, and the last error has this text in it. */
#define REFUSED(call, text)                                                                                            \
    CHECK((call) == DERMIS_BAD_INPUT);                                                                                 \
    check(strstr(dermis_last_error(), text) != NULL, text, __FILE__, __LINE__)
