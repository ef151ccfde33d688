/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The kernels over registers full of sums, included once by each instruction set's file, which
 * defines before:
 *
 *   LANES, VECTORS     floats per vector, vectors per panel
 *   ROWS, SHORT_ROWS   rows of a block; what is left of a panel after blocks of ROWS
 *   vec                the vector type, and the operations used below
 *
 * A block of ROWS pixels x one panel of sums lives in registers. Each step over k loads VECTORS
 * vectors of weights and broadcasts one value per row. Loops over rows and vectors are unrolled
 * whole, so that the sums never leave the registers; n_vectors < VECTORS serves a last panel that
 * is not full.
 */

#include "nn/exponential.h"
#include "nn/unroll.h"

enum { PANEL = LANES * VECTORS };

typedef vec block[ROWS][VECTORS];

#define EACH_ROW    UNROLL for (int i = 0; i < ROWS; i++)
#define EACH_VECTOR UNROLL for (int j = 0; j < n_vectors; j++)

/* sum[i][j] += x[i][k] w[k][j] for k < n, all x in one panel. */
INLINE void multiply(const int n_vectors, block sum, const float *x, const float *w, uint32_t n)
{
    UNROLL_BY4 for (uint32_t k = 0; k < n; k++, w += PANEL)
    {
        vec wk[VECTORS];
        EACH_VECTOR wk[j] = vec_load(w + j * LANES);
        EACH_ROW
        {
            vec xi = vec_set1(x[i * PANEL + k]);
            EACH_VECTOR sum[i][j] = vec_fma(xi, wk[j], sum[i][j]);
        }
    }
}

/* The same for n features across panels. */
INLINE void multiply_panels(const int n_vectors, block sum, const float *x, size_t stride,
                            const float *w, uint32_t n)
{
    for (uint32_t k = 0; k < n; k += PANEL, x += stride, w += PANEL * PANEL)
        multiply(n_vectors, sum, x, w, n - k < PANEL ? n - k : PANEL);
}

INLINE void forward_panel(const int n_vectors, const struct nn_forward *a, const float *w,
                          const float *b, float *y)
{
    /* lrelu(s) = max(s, slope s); with slope 1 nothing happens. */
    const vec slope = vec_set1(a->linear ? 1.0f : NN_SLOPE);
    for (size_t r = 0; r < a->n_rows; r += ROWS) {
        block sum;
        EACH_ROW EACH_VECTOR sum[i][j] = vec_load(b + j * LANES);
        multiply_panels(n_vectors, sum, a->x + r * PANEL, a->stride, w, a->n_in);
        multiply(n_vectors, sum, a->q + r * PANEL, w + (size_t)a->n_in * PANEL, a->n_q);
        float *to = y + r * PANEL;
        EACH_ROW EACH_VECTOR vec_store(to + i * PANEL + j * LANES,
                                       vec_max(sum[i][j], vec_mul(sum[i][j], slope)));
    }
}

static void forward(const struct nn_forward *a)
{
    for (uint32_t first = 0; first < a->n_out; first += PANEL) {
        const float *w = a->w + (size_t)first * (a->n_in + a->n_q), *b = a->b + first;
        float *y = a->y + first / PANEL * a->stride;
        switch ((a->n_out - first + LANES - 1) / LANES) {
        case 1:
            forward_panel(1, a, w, b, y);
            break;
#if VECTORS > 2
        case 2:
            forward_panel(2, a, w, b, y);
            break;
        case 3:
            forward_panel(3, a, w, b, y);
            break;
#endif
        default:
            forward_panel(VECTORS, a, w, b, y);
            break;
        }
    }
}

INLINE void backward_panel(const int n_vectors, const struct nn_backward *a, const float *w,
                           const float *h, float *dh)
{
    const vec slope = vec_set1(NN_SLOPE);
    for (size_t r = 0; r < a->n_rows; r += ROWS) {
        block sum;
        EACH_ROW EACH_VECTOR sum[i][j] = vec_set1(0.0f);
        multiply_panels(n_vectors, sum, a->dy + r * PANEL, a->stride, w, a->n_out);
        const float *from = h + r * PANEL;
        float *to = dh + r * PANEL;
        EACH_ROW EACH_VECTOR
        {
            int at = i * PANEL + j * LANES;
            vec_store(to + at, vec_mul_unless_positive(sum[i][j], vec_load(from + at), slope));
        }
    }
}

static void backward(const struct nn_backward *a)
{
    for (uint32_t first = 0; first < a->n_in; first += PANEL) {
        const float *w = a->w + (size_t)first * a->n_out;
        size_t at = first / PANEL * a->stride;
        switch ((a->n_in - first + LANES - 1) / LANES) {
        case 1:
            backward_panel(1, a, w, a->h + at, a->dh + at);
            break;
#if VECTORS > 2
        case 2:
            backward_panel(2, a, w, a->h + at, a->dh + at);
            break;
        case 3:
            backward_panel(3, a, w, a->h + at, a->dh + at);
            break;
#endif
        default:
            backward_panel(VECTORS, a, w, a->h + at, a->dh + at);
            break;
        }
    }
}

/* What dy is multiplied with: x or q. */
struct side {
    const float *x;
    float *dw;
    size_t ld;
    uint32_t n_in;
    bool add;
};

/* n_block (ROWS or SHORT_ROWS) outputs x one panel of inputs, summed over the tile's rows. */
INLINE void outer_block(const int n_block, const int n_vectors, const struct nn_outer *a,
                        const struct side *s, uint32_t o, uint32_t first)
{
    const float *dy = a->dy + o / PANEL * a->stride + o % PANEL;
    const float *x = s->x + first / PANEL * a->stride;
    float *dw = s->dw + o * s->ld + first;
    uint32_t n_o = a->n_out - o, n = s->n_in - first;
    block sum;
    EACH_ROW
    {
        if (i >= n_block) continue;
        /* dw comes from far away: ask for it now, the sums take longer than the way. */
        const char *line = (const char *)(dw + (size_t)i * s->ld);
        EACH_VECTOR
        {
            _mm_prefetch(line + j * LANES * sizeof(float), _MM_HINT_T0);
            sum[i][j] = vec_set1(0.0f);
        }
        _mm_prefetch(line + (n_vectors * LANES - 1) * sizeof(float), _MM_HINT_T0);
    }
    UNROLL_BY4 for (uint32_t r = 0; r < a->n_rows; r++, dy += PANEL, x += PANEL)
    {
        vec xr[VECTORS];
        EACH_VECTOR xr[j] = vec_load(x + j * LANES);
        EACH_ROW
        {
            if (i >= n_block) continue;
            vec di = vec_set1(dy[i]);
            EACH_VECTOR sum[i][j] = vec_fma(di, xr[j], sum[i][j]);
        }
    }
    EACH_VECTOR
    {
        vec_mask mask = vec_mask_first(n - (uint32_t)j * LANES);
        EACH_ROW
        {
            if (i >= n_block || (uint32_t)i >= n_o) continue;
            float *to = dw + (size_t)i * s->ld + j * LANES;
            if (s->add) sum[i][j] = vec_add(sum[i][j], vec_load_part(to, mask));
            vec_store_part(to, mask, sum[i][j]);
        }
    }
}

INLINE void outer_panel(const int n_vectors, const struct nn_outer *a, const struct side *s,
                        uint32_t first)
{
    for (uint32_t o = 0; o < a->n_out;) {
        if (PANEL - o % PANEL > SHORT_ROWS && a->n_out - o > SHORT_ROWS) {
            outer_block(ROWS, n_vectors, a, s, o, first);
            o += ROWS;
        } else {
            outer_block(SHORT_ROWS, n_vectors, a, s, o, first);
            o += SHORT_ROWS;
        }
    }
}

static void outer_side(const struct nn_outer *a, const struct side *s)
{
    for (uint32_t first = 0; first < s->n_in; first += PANEL) {
        switch ((s->n_in - first + LANES - 1) / LANES) {
        case 1:
            outer_panel(1, a, s, first);
            break;
#if VECTORS > 2
        case 2:
            outer_panel(2, a, s, first);
            break;
        case 3:
            outer_panel(3, a, s, first);
            break;
#endif
        default:
            outer_panel(VECTORS, a, s, first);
            break;
        }
    }
}

static void outer(const struct nn_outer *a)
{
    struct side x = {.x = a->x, .dw = a->dw, .ld = a->ld_w, .n_in = a->n_in, .add = a->add_w};
    struct side q = {.x = a->q, .dw = a->dq, .ld = a->ld_q, .n_in = a->n_q, .add = a->add_q};
    outer_side(a, &x);
    outer_side(a, &q);
}

static void exponentials(const float *x, uint32_t n, float *y)
{
    exponentials_loop(x, n, y);
}

static size_t forward_count(uint32_t n_in, uint32_t n_q)
{
    return (size_t)(n_in + n_q) * PANEL;
}

static void pack_forward(float *packed, const float *w, size_t ld, uint32_t n_out, uint32_t n_in,
                         uint32_t n_q, uint32_t index)
{
    nn_pack_forward(PANEL, packed, w, ld, n_out, n_in + n_q, index);
}

static size_t backward_count(uint32_t n_out)
{
    return (size_t)n_out * PANEL;
}

static void pack_backward(float *packed, const float *w, size_t ld, uint32_t n_out, uint32_t n_in,
                          uint32_t index)
{
    nn_pack_backward(PANEL, packed, w, ld, n_out, n_in, index);
}

static size_t scratch_count(uint32_t n_rows, uint32_t n)
{
    (void)n_rows;
    (void)n;
    return 0;
}

static double peak(uint64_t n)
{
    enum { CHAINS = ROWS * VECTORS };
    vec chain[CHAINS], f = vec_set1(0.5f);
    UNROLL for (int j = 0; j < CHAINS; j++) chain[j] = vec_set1((float)j);
    UNROLL_BY4 for (uint64_t i = 0; i < n; i++)
    {
        UNROLL for (int j = 0; j < CHAINS; j++) chain[j] = vec_fma(chain[j], f, f);
    }
    float sink[LANES] __attribute__((aligned(64)));
    volatile float total = 0.0f;
    UNROLL for (int j = 0; j < CHAINS; j++)
    {
        vec_store(sink, chain[j]);
        total = total + sink[0];
    }
    return 2.0 * LANES * CHAINS * (double)n;
}
