/* SPDX-License-Identifier: Apache-2.0 */
#include "progress.h"

#include "json_out.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { BAR_WIDTH = 24 };

double clock_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

void progress_init(struct progress *p, enum progress_mode mode, bool is_quiet)
{
    const char *term = getenv("TERM"), *no_color = getenv("NO_COLOR");
    const bool is_terminal = isatty(STDERR_FILENO) && term && strcmp(term, "dumb") != 0;
    *p = (struct progress){.mode = mode};
    if (mode == PROGRESS_AUTO) p->mode = is_terminal ? PROGRESS_BAR : PROGRESS_PLAIN;
    if (is_quiet && p->mode != PROGRESS_JSON) p->mode = PROGRESS_NONE;
    p->has_colour = is_terminal && !(no_color && *no_color);
}

void progress_begin(struct progress *p, const char *phase, const char *unit)
{
    p->phase = phase;
    p->unit = unit;
    p->start_s = p->last_s = clock_s();
    if (p->mode == PROGRESS_JSON) p->last_s = 0.0; /* programs see the first one at once */
    p->first = -1.0;
    p->is_active = p->mode != PROGRESS_NONE;
}

bool progress_is_due(const struct progress *p)
{
    if (!p->is_active) return false;
    const double interval = p->mode == PROGRESS_BAR ? 0.1 : p->mode == PROGRESS_JSON ? 0.5 : 5.0;
    return clock_s() - p->last_s >= interval;
}

/* 75 s as 1:15, 4000 s as 1:06:40. */
static void format_time(double s, char text[24])
{
    const unsigned long t = s < 0.0 ? 0 : s > 3.6e8 ? 360000000ul : (unsigned long)(s + 0.5);
    if (t >= 3600)
        snprintf(text, 24, "%lu:%02lu:%02lu", t / 3600, t / 60 % 60, t % 60);
    else
        snprintf(text, 24, "%lu:%02lu", t / 60, t % 60);
}

static void format_rate(double rate, const char *unit, char text[48])
{
    const char *factor = "";
    if (rate >= 1e6) {
        rate *= 1e-6;
        factor = "M";
    } else if (rate >= 1e4) {
        rate *= 1e-3;
        factor = "k";
    }
    snprintf(text, 48, "%.3g %s%s/s", rate, factor, unit);
}

static void show_bar(const struct progress *p, double fraction, const char *line)
{
    char bar[BAR_WIDTH + 1];
    const int full = fraction < 0 ? 0 : (int)(fraction * BAR_WIDTH);
    for (int i = 0; i < BAR_WIDTH; i++) bar[i] = i < full ? '=' : i == full ? '>' : ' ';
    bar[BAR_WIDTH] = '\0';
    if (p->has_colour)
        fprintf(stderr, "\r%s [\033[32m%s\033[0m] %s\033[K", p->phase, bar, line);
    else
        fprintf(stderr, "\r%s [%s] %s\033[K", p->phase, bar, line);
    fflush(stderr);
}

void progress_update(struct progress *p, double fraction, double units, const char *text,
                     const char *json)
{
    char line[512], rate_text[48] = "", eta_text[24] = "";
    if (!p->is_active) return;
    if (p->first < 0.0) {
        p->first = fraction > 0.0 ? fraction : 0.0;
        p->first_units = units;
    }
    if (!progress_is_due(p)) return;
    p->last_s = clock_s();
    const double elapsed = p->last_s - p->start_s;
    const double rate = elapsed > 0.0 ? (units - p->first_units) / elapsed : 0.0;
    const double eta = fraction > p->first ? elapsed * (1.0 - fraction) / (fraction - p->first)
                                           : -1.0;
    if (fraction > 1.0) fraction = 1.0;
    if (p->mode == PROGRESS_JSON) {
        struct json_out j = {.f = stderr};
        jo_object(&j, NULL);
        jo_string(&j, "event", "progress");
        jo_string(&j, "phase", p->phase);
        jo_number(&j, "fraction", fraction >= 0.0 ? fraction : 0.0);
        jo_number(&j, "elapsed_s", elapsed);
        if (eta >= 0.0) jo_number(&j, "eta_s", eta);
        if (p->unit) jo_number(&j, "rate", rate);
        if (json) {
            fputc(',', stderr);
            fputs(json, stderr);
        }
        jo_end(&j);
        return;
    }
    if (p->unit) format_rate(rate, p->unit, rate_text);
    if (eta >= 0.0) format_time(eta, eta_text);
    int n = 0;
    if (fraction >= 0.0) n += snprintf(line, sizeof line, "%3.0f %%", 100.0 * fraction);
    snprintf(line + n, sizeof line - (size_t)n, "%s%s%s%s%s%s", text ? "  " : "", text ? text : "",
             rate_text[0] ? "  " : "", rate_text, eta_text[0] ? "  ETA " : "", eta_text);
    if (p->mode == PROGRESS_BAR) {
        show_bar(p, fraction, line);
        p->is_line_open = true;
    } else {
        fprintf(stderr, "lumenaut: %s: %s\n", p->phase, line);
    }
}

void progress_end(struct progress *p)
{
    if (!p->is_active) return;
    if (p->mode == PROGRESS_JSON) {
        struct json_out j = {.f = stderr};
        jo_object(&j, NULL);
        jo_string(&j, "event", "end");
        jo_string(&j, "phase", p->phase);
        jo_number(&j, "elapsed_s", clock_s() - p->start_s);
        jo_end(&j);
    }
    if (p->is_line_open) fputs("\r\033[K", stderr);
    p->is_line_open = false;
    p->is_active = false;
}

void progress_say(struct progress *p, const char *text)
{
    if (p->mode == PROGRESS_JSON) {
        struct json_out j = {.f = stderr};
        jo_object(&j, NULL);
        jo_string(&j, "event", "note");
        jo_string(&j, "text", text);
        jo_end(&j);
        return;
    }
    if (p->is_line_open) fputs("\r\033[K", stderr);
    p->is_line_open = false;
    fprintf(stderr, "lumenaut: %s\n", text);
}
