/* SPDX-License-Identifier: Apache-2.0 */
#ifndef NN_FIELD_H
#define NN_FIELD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/error.h"
#include "nn/adam.h"
#include "nn/grid.h"

/*
 * The compact network: radiance of a surface point from learnt encodings of its positions, what its
 * buffers tell, and the configuration v.
 *
 *   e  = [grid_0(p_0), ..., grid_(G-1)(p_(G-1)), features]   G positions: in the world, and in the
 *                                                             frames of what moves (method 2.3)
 *   h1 = lrelu(W1 [e, v] + b1)                               E + D -> W
 *   hk = lrelu(Wk h(k-1) + bk)                               `depth` layers in all
 *   o  = Wo h + bo                                           W -> 3 L + 1; o within [-10, 12]
 *   f  = scale * sum over l of light_l * exp(o_l)            per channel
 *   s  = exp(o_(3 L))                                        the loss expected of the pixel
 *
 * scale is what radiance is known to be proportional to, the diffuse albedo. light_l is the power
 * of the l-th group of lights, to which radiance is proportional as well (method 2.3). v and the
 * lights are constant over a run of pixels; v's columns fold into one bias per run: exact, in
 * training too.
 *
 * Training minimises a relative squared error of linear radiance. Of two independent estimates a, b
 * of it, with means in y = (a + b) / 2,
 *
 *   1/2 (f - a)^2 / D(b) + 1/2 (f - b)^2 / D(a),
 *   D(x) = lum(f) ((1 - c) lum(f) + c lum(x)) + 0.01,
 *
 * denominators held constant. The noise of neither half meets its own denominator, so that the
 * minimum is the mean of noisy estimates: L1 of logarithms loses rare bright samples (method 3.2).
 * lum(f)^2 alone (NRC 2021, Eq. 6) takes ten times too bright for no worse than black, and paints
 * what it cannot resolve, the sharp image of a lamp, over its surroundings; lum(x) makes less of
 * light that it cannot resolve. The gradient by an output is bounded, by 12 / c where 2 stands for
 * twice as much light as there is: a single sample in thousands must not upset Adam. But a bound
 * takes light from what few samples bring. So there is a caution c: 3/4 at first, then less where
 * the network will resolve what it sees.
 *
 * Beside it s learns the mean of that loss, noise included, by the likelihood of an exponential
 * distribution, log s + loss / s; it reads the last layer and teaches it nothing.
 *
 * The layers run on the kernels of kernels.h. All weights lie in one block: the grids' tables, then
 * layer after layer W row-major [n_out][n_in], columns in the order above, and b [n_out].
 */
enum { FIELD_MAX_LIGHTS = 8 };
#define FIELD_CAUTION 0.75f /* c at first */

struct field_config {
    uint32_t n_grids; /* G, 0 .. 64, all of the same kind */
    struct grid_config grid;
    uint32_t n_features;  /* 0 .. 1024 */
    uint32_t n_variables; /* D, 0 .. 65536 */
    uint32_t n_lights;    /* L, 1 .. FIELD_MAX_LIGHTS */
    uint32_t width;       /* W, 1 .. 512 */
    uint32_t depth;       /* 1 .. 16 */
    uint32_t max_pixels;  /* of a batch for training; 0: no training, and no memory for it */
    bool ignores_halves;  /* training: D(x) = lum(f)^2 + 0.01, with the bounds of c */
};

/* Pixels of one configuration. The arrays are the caller's. */
struct field_run {
    uint32_t n;             /* 1 or more */
    const float *positions; /* [n][G][3], clamped to [0,1] */
    const float *features;  /* [n][n_features] */
    const float *scale;     /* [n][3] */
    const float *v;         /* [D] */
    const float *lights;    /* [L][3]; NULL: all 1 */

    /* Training only. */
    const float *targets;  /* [n][3], radiance: y */
    const float *weights;  /* [n] in the mean of the loss; NULL: all 1 */
    const float *halves;   /* [n][3]: (a - b) / 2; NULL: 0 */
    const float *cautions; /* [n]: c, above 0; NULL: all FIELD_CAUTION */
};

struct pool;
struct field;

/* cpu: flags of base/cpu.h that kernels may use. The pool must outlive the field. All memory is
 * taken here. */
lmn_status field_new(const struct field_config *config, struct pool *pool, uint32_t cpu,
                     struct field **out, struct error *err);
void field_free(struct field *f);

/* Tables U(+-1e-4); layers as generator_init(), but for the last, whose weights start at a tenth
 * of that and whose biases at 0: f starts near `scale`. */
void field_init(struct field *f, uint64_t seed);

uint32_t field_n_variables(const struct field *f);
size_t field_n_weights(const struct field *f);
size_t field_n_table_weights(const struct field *f); /* the first ones */

/* Whoever writes to them calls field_weights_changed() before the next call that uses them. */
float *field_weights(struct field *f);
void field_weights_changed(struct field *f);
uint64_t field_memory_size(const struct field *f); /* bytes */

/* out [n][3]: radiance of the run's pixels, on the pool. */
void field_render(struct field *f, const struct field_run *run, float *out);

/* expected: s of the runs' pixels, one run after another, on the pool. */
void field_expect(struct field *f, const struct field_run *runs, uint32_t n_runs, float *expected);

/* groups: radiance [n][L][3] that each group of lights brings the runs' pixels at a power of 1, one
 * run after another, on the pool. */
void field_render_groups(struct field *f, const struct field_run *runs, uint32_t n_runs,
                         float *groups);

/*
 * The same in parts, from within a loop of the field's pool, so that a part's inputs need never
 * leave the cache: field_begin() sets the configuration v [D] and whether products may be rounded
 * where that is faster (rounded.h), then each field_render_part() works on the calling thread,
 * which is `worker` of that loop. run->v is not read. Parts of a multiple of FIELD_PART pixels
 * leave no lanes empty: whole vectors of points in the grids, whole blocks of rows in the layers.
 */
enum { FIELD_PART = 144 };

void field_begin(struct field *f, const float *v, bool may_round);
void field_render_part(const struct field *f, uint32_t worker, const struct field_run *run,
                       float *out);

/* What field_render_part() cost since field_begin(), all workers together, in ticks of
 * clock_ticks(): grids and features to tiles; layers and outputs. */
void field_ticks(const struct field *f, uint64_t *encode, uint64_t *layers);

/* Floating-point operations of the layers for one pixel: multiply-adds as two. v, which is folded,
 * and the grids count for nothing. */
double field_flop(const struct field *f);

/*
 * The mean loss of all pixels of the runs, at most config.max_pixels, and its exact gradient.
 *
 * losses    [n_runs], the mean of each
 * errors    [n_runs], the mean of (f - a) (f - b) / (lum(f)^2 + 0.01), to which noise adds nothing:
 *           may be negative by chance. May be NULL
 * gradient  [n_weights], exact but for its bound; may be NULL
 * The result has the same bytes for any number of threads.
 */
void field_gradient(struct field *f, const struct field_run *runs, uint32_t n_runs, float *losses,
                    float *errors, float *gradient);

#endif
