/* SPDX-License-Identifier: Apache-2.0 */
#ifndef APP_H
#define APP_H

#include <lumenaut/lumenaut.h>

#include "args.h"
#include "progress.h"

/* What every command that computes shares: the context, progress, and how failures are told. */
struct app {
    const struct common_args *common;
    lmn_context *context;
    struct progress progress;
    double units;       /* progress callbacks count fractions of these */
    bool ignore_signal; /* a signal does not stop the work under way: training ends its step */
    bool is_silent;     /* progress of the calls under way is not shown */
    /* Work that nobody wants any more stops, too: asked while it goes on; NULL: never. */
    bool (*is_stale)(void *user);
    void *stale_user;
    double part_start, part_size; /* which part of the whole they are; size 0: all of it */
};

/* Makes the context and installs the signal handlers. Returns an exit code. */
int app_open(struct app *app, const struct common_args *common);
void app_close(struct app *app);

/* Whose fault a failure is: a file that was read, what the command line names, or the work. */
enum blame { BLAME_INPUT, BLAME_USER, BLAME_WORK };

/* Prints the context's message as one line and returns the exit code that fits. */
int app_failed(struct app *app, lmn_status status, enum blame blame);

/* The same for a text of the tool's own. */
__attribute__((format(printf, 3, 4))) int app_error(struct app *app, int code, const char *format,
                                                    ...);

/* Talk on stderr, unless --quiet. app_detail() only with --verbose. */
__attribute__((format(printf, 2, 3))) void app_say(struct app *app, const char *format, ...);
__attribute__((format(printf, 2, 3))) void app_detail(struct app *app, const char *format, ...);

/* Shows progress of the calls that follow, as fractions of `units`. */
void app_begin(struct app *app, const char *phase, const char *unit, double units);
void app_end(struct app *app);

/* The signal that asked to stop, or 0. A second one ends the process at once. */
int app_signal(void);

/* Flushes stdout; says so and returns EXIT_FAILED when what was written did not get through. */
int app_flush(int code);

/* Bytes of memory that the process had at most. */
uint64_t app_peak_memory(void);

/* Looks, before the work is done, for what would make saving its result fail: a folder that is
 * missing or closed; for images, an unknown format (may be NULL: by extension). Return an exit
 * code after saying why. */
int app_check_output(struct app *app, const char *path);
int app_check_image(struct app *app, const char *path, const char *format);

#endif
