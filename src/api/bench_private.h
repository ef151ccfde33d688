/* SPDX-License-Identifier: Apache-2.0 */
#ifndef API_BENCH_PRIVATE_H
#define API_BENCH_PRIVATE_H

#include "api/handles.h"
#include "base/json.h"

/* The paper's network where nothing else is asked for; a depth of any kind. */
enum { BENCH_WIDTH = 512, BENCH_DEPTH = 8, BENCH_ANY = 1 << 30 };

/* What lmn_bench() was asked for; lumenaut-bench(1) has the meanings. */
struct bench_options {
    uint32_t runs;            /* 5 */
    uint32_t width, depth;    /* of the network: 0, BENCH_ANY: the kind's default */
    bool is_faithful;         /* frames by the paper's network */
    uint32_t patches;         /* 32 */
    uint32_t size[2];         /* 0: the kind's default */
    uint32_t spp;             /* 0: the kind's default */
    int32_t max_depth;        /* SCENE_NONE: the scene's */
    int32_t rr_depth;         /* SCENE_NONE: the scene's */
    const char *const *files; /* scenes */
    uint32_t n_files;
    const char *const *sets; /* "name=value": buffers, frame */
    uint32_t n_sets;
};

/* Each adds the members of its document to an open object; "results" is an array. */
lmn_status bench_trace(lmn_context *context, const struct bench_options *o, struct json *j,
                       struct error *err);
lmn_status bench_buffers(lmn_context *context, const struct bench_options *o, struct json *j,
                         struct error *err);
lmn_status bench_frame(lmn_context *context, const struct bench_options *o, struct json *j,
                       struct error *err);
lmn_status bench_train(lmn_context *context, const struct bench_options *o, struct json *j,
                       struct error *err);
lmn_status bench_kernels(lmn_context *context, const struct bench_options *o, struct json *j,
                         struct error *err);

/* Sorts the n > 0 times and returns the median. */
double bench_median(double *times, uint32_t n);

/* Fills u with the defaults, changed as o->sets says. */
lmn_status bench_values(lmn_context *context, const lmn_scene *scene, const struct bench_options *o,
                        float *u, struct error *err);

/* Fills u with the index-th of a stream of configurations. */
void bench_configuration(const struct scene *s, uint64_t index, float *u);

/* Tells progress; LMN_ERR_CANCELLED when it asks to stop. */
lmn_status bench_progress(lmn_context *context, double done, double total, struct error *err);

#endif
