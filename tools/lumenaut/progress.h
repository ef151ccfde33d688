/* SPDX-License-Identifier: Apache-2.0 */
#ifndef PROGRESS_H
#define PROGRESS_H

#include <stdbool.h>

/*
 * How far long work is, on stderr: a bar on a terminal, a plain line every few seconds elsewhere,
 * or one JSON object a line for programs:
 *
 *   {"event":"progress","phase":"train","fraction":0.5,"elapsed_s":8.1,"eta_s":8.1,"step":100,...}
 *   {"event":"note","text":"..."}      {"event":"end","phase":"train","elapsed_s":16.2}
 */
enum progress_mode { /* order of the words of --progress */
                     PROGRESS_AUTO,
                     PROGRESS_NONE,
                     PROGRESS_BAR,
                     PROGRESS_PLAIN,
                     PROGRESS_JSON
};

struct progress {
    enum progress_mode mode;
    bool has_colour, is_active, is_line_open;
    const char *phase, *unit;
    double start_s, last_s; /* clock at begin, and when last shown */
    double first;           /* fraction at the first update: a resumed run starts above 0 */
    double units, first_units;
};

void progress_init(struct progress *p, enum progress_mode mode, bool is_quiet);

/* unit: what the rate counts, "paths"; NULL: no rate. */
void progress_begin(struct progress *p, const char *phase, const char *unit);

/* True when it is time to show something again; formatting can be skipped otherwise. */
bool progress_is_due(const struct progress *p);

/* fraction in [0,1], negative when unknown; units done so far. text and json (members such as
 * "\"step\":3", may be NULL) go to the modes they are for. Shows it when it is due. */
void progress_update(struct progress *p, double fraction, double units, const char *text,
                     const char *json);
void progress_end(struct progress *p);

/* A line of talk that does not tear the bar. */
void progress_say(struct progress *p, const char *text);

/* Seconds on a clock that only goes forward. */
double clock_s(void);

#endif
