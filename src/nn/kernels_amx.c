/* SPDX-License-Identifier: Apache-2.0 */
#include "nn/kernels.h"

#include <string.h>

#include <immintrin.h>

/*
 * AMX multiplies tiles of BF16 with sums in fp32, sixteen times faster than AVX-512 multiplies
 * floats. A float x is split into BF16 numbers hi + lo (8 bits each, rounded: what is lost is below
 * 2^-16 x), and
 *
 *     x w  ~  hi hi + lo hi + hi lo          (lo lo is below 2^-16 x w, too)
 *
 * which keeps about 16 bits of every product, summed in fp32. Products of a layer are blocks of
 * 32 x 32 sums in four tile registers; each step adds 32 products to each sum: 12 tile products.
 *
 * A step's operand takes 4 KiB: four tiles of 16 rows x 64 bytes, hi of rows 0-15, hi of rows
 * 16-31, lo of 0-15, lo of 16-31.
 *
 *     left operand    rows are rows of the result; word i holds the inputs k_i (low half), k_(i+16)
 *     right operand   row i holds, for each column of the result, a word of inputs k_i, k_(i+16)
 *
 * Which inputs share a word does not matter as long as both sides agree; (i, i + 16) is what two
 * vectors give without shuffles.
 */

enum {
    LANES = 16,
    PANEL = 32,
    ROWS = 32,
    STEP = 32,                 /* inputs per step */
    STEP_FLOATS = 4 * 16 * 16, /* an operand of one step, counted in floats */
    TILE_FLOATS = 16 * 16,
};

#define INLINE static inline __attribute__((always_inline))

static uint32_t n_steps(uint32_t n)
{
    return (n + STEP - 1) / STEP;
}

/* ---- Tiles ---- */

/* All eight registers as 16 rows of 64 bytes. */
static void tiles_begin(void)
{
    struct {
        uint8_t palette, start_row, reserved[14];
        uint16_t row_size[16];
        uint8_t n_rows[16];
    } config __attribute__((aligned(64))) = {.palette = 1};
    for (int i = 0; i < 8; i++) {
        config.row_size[i] = 64;
        config.n_rows[i] = 16;
    }
    _tile_loadconfig(&config);
}

/* Adds n steps to the sums. n_left, n_right: 2, or 1 for half a block. Registers: sums 0 1 (rows
 * 0-15) and 2 3 (rows 16-31), left operand 4 5, right operand 6 7. The order saves loads: they, not
 * the products, are what there is too little of. */
INLINE void add_steps(const int n_left, const int n_right, const float *left, const float *right,
                      uint32_t n)
{
    enum { HALF = TILE_FLOATS, LO = 2 * TILE_FLOATS };
    for (; n > 0; n--, left += STEP_FLOATS, right += STEP_FLOATS) {
        _tile_loadd(4, left, 64);
        _tile_loadd(6, right, 64);
        if (n_left > 1) _tile_loadd(5, left + HALF, 64);
        if (n_right > 1) _tile_loadd(7, right + HALF, 64);
        /* hi hi */
        _tile_dpbf16ps(0, 4, 6);
        if (n_right > 1) _tile_dpbf16ps(1, 4, 7);
        if (n_left > 1) _tile_dpbf16ps(2, 5, 6);
        if (n_left > 1 && n_right > 1) _tile_dpbf16ps(3, 5, 7);
        /* lo hi */
        _tile_loadd(4, left + LO, 64);
        _tile_dpbf16ps(0, 4, 6);
        if (n_right > 1) _tile_dpbf16ps(1, 4, 7);
        if (n_left > 1) {
            _tile_loadd(4, left + LO + HALF, 64);
            _tile_dpbf16ps(2, 4, 6);
            if (n_right > 1) _tile_dpbf16ps(3, 4, 7);
        }
        /* hi lo */
        _tile_loadd(4, left, 64);
        _tile_loadd(6, right + LO, 64);
        _tile_dpbf16ps(0, 4, 6);
        if (n_left > 1) _tile_dpbf16ps(2, 5, 6);
        if (n_right > 1) {
            _tile_loadd(7, right + LO + HALF, 64);
            _tile_dpbf16ps(1, 4, 7);
            if (n_left > 1) _tile_dpbf16ps(3, 5, 7);
        }
    }
}

/* ---- Splitting ---- */

/* Words of (u in the low half, v in the high half), hi parts and lo parts. Rounding adds half of
 * the last bit kept, as integers. */
INLINE void split_pair(__m512 u, __m512 v, __m512i *hi, __m512i *lo)
{
    const __m512i half = _mm512_set1_epi32(0x8000), top = _mm512_set1_epi32((int)0xFFFF0000u);
    __m512i u_hi = _mm512_and_si512(_mm512_add_epi32(_mm512_castps_si512(u), half), top);
    __m512i v_hi = _mm512_and_si512(_mm512_add_epi32(_mm512_castps_si512(v), half), top);
    __m512 u_rest = _mm512_sub_ps(u, _mm512_castsi512_ps(u_hi));
    __m512 v_rest = _mm512_sub_ps(v, _mm512_castsi512_ps(v_hi));
    __m512i u_lo = _mm512_add_epi32(_mm512_castps_si512(u_rest), half);
    __m512i v_lo = _mm512_and_si512(_mm512_add_epi32(_mm512_castps_si512(v_rest), half), top);
    *hi = _mm512_or_si512(_mm512_srli_epi32(u_hi, 16), v_hi);
    *lo = _mm512_or_si512(_mm512_srli_epi32(u_lo, 16), v_lo);
}

/* The first n lanes. */
INLINE __mmask16 first_lanes(uint32_t n)
{
    return n >= LANES ? 0xFFFF : (__mmask16)((1u << n) - 1);
}

INLINE uint32_t less(uint32_t n, uint32_t by)
{
    return n > by ? n - by : 0;
}

/* One step of ROWS rows (a row is PANEL floats on) as left operand: n <= STEP inputs, zeros after.
 */
INLINE void split_left(float *to, const float *x, uint32_t n)
{
    __mmask16 mask_u = first_lanes(n), mask_v = first_lanes(less(n, LANES));
    for (uint32_t r = 0; r < ROWS; r++, x += PANEL, to += LANES) {
        __m512i hi, lo;
        split_pair(_mm512_maskz_loadu_ps(mask_u, x), _mm512_maskz_loadu_ps(mask_v, x + LANES), &hi,
                   &lo);
        _mm512_store_si512(to, hi);
        _mm512_store_si512(to + 2 * TILE_FLOATS, lo);
    }
}

/* ROWS rows of x (n_x features) and q (n_q) as left operand: [steps]. */
static void split_rows(float *to, const float *x, size_t stride, uint32_t n_x, const float *q,
                       uint32_t n_q)
{
    for (uint32_t k = 0; k < n_x; k += STEP, to += STEP_FLOATS)
        split_left(to, x + k / PANEL * stride, n_x - k < STEP ? n_x - k : STEP);
    if (n_q > 0) split_left(to, q, n_q);
}

/* One panel of features, rows being the inputs, as right operand: [steps of STEP rows]. */
static void split_columns(float *to, uint32_t n_rows, const float *x)
{
    for (uint32_t r = 0; r < n_rows; r += STEP, x += STEP * PANEL, to += STEP_FLOATS) {
        for (uint32_t i = 0; i < LANES; i++) {
            for (uint32_t j = 0; j < 2; j++) {
                const float *from = x + i * PANEL + j * LANES;
                float *word = to + j * TILE_FLOATS + i * LANES;
                __m512i hi, lo;
                split_pair(_mm512_loadu_ps(from), _mm512_loadu_ps(from + LANES * PANEL), &hi, &lo);
                _mm512_store_si512(word, hi);
                _mm512_store_si512(word + 2 * TILE_FLOATS, lo);
            }
        }
    }
}

/* Transposes 16 x 16 words in place: blocks of 1, 2, 4 and 8 words change sides in turn. */
INLINE void transpose(__m512i m[LANES])
{
    __m512i t[LANES];
    _Pragma("GCC unroll 8") for (int i = 0; i < LANES; i += 2)
    {
        t[i] = _mm512_unpacklo_epi32(m[i], m[i + 1]);
        t[i + 1] = _mm512_unpackhi_epi32(m[i], m[i + 1]);
    }
    _Pragma("GCC unroll 4") for (int i = 0; i < LANES; i += 4)
    {
        m[i] = _mm512_unpacklo_epi64(t[i], t[i + 2]);
        m[i + 1] = _mm512_unpackhi_epi64(t[i], t[i + 2]);
        m[i + 2] = _mm512_unpacklo_epi64(t[i + 1], t[i + 3]);
        m[i + 3] = _mm512_unpackhi_epi64(t[i + 1], t[i + 3]);
    }
    _Pragma("GCC unroll 4") for (int i = 0; i < 4; i++)
    {
        t[i] = _mm512_shuffle_i32x4(m[i], m[i + 4], 0x88);
        t[i + 4] = _mm512_shuffle_i32x4(m[i], m[i + 4], 0xDD);
        t[i + 8] = _mm512_shuffle_i32x4(m[i + 8], m[i + 12], 0x88);
        t[i + 12] = _mm512_shuffle_i32x4(m[i + 8], m[i + 12], 0xDD);
    }
    _Pragma("GCC unroll 4") for (int i = 0; i < 4; i++)
    {
        m[i] = _mm512_shuffle_i32x4(t[i], t[i + 8], 0x88);
        m[i + 4] = _mm512_shuffle_i32x4(t[i + 4], t[i + 12], 0x88);
        m[i + 8] = _mm512_shuffle_i32x4(t[i], t[i + 8], 0xDD);
        m[i + 12] = _mm512_shuffle_i32x4(t[i + 4], t[i + 12], 0xDD);
    }
}

/* The transpose of one panel of features as left operand: features become rows, rows inputs. */
static void split_transposed(float *to, uint32_t n_rows, const float *x)
{
    for (uint32_t r = 0; r < n_rows; r += STEP, x += STEP * PANEL, to += STEP_FLOATS) {
        for (uint32_t j = 0; j < 2; j++) {
            __m512i hi[LANES], lo[LANES];
            for (int i = 0; i < LANES; i++) {
                const float *from = x + i * PANEL + j * LANES;
                split_pair(_mm512_loadu_ps(from), _mm512_loadu_ps(from + LANES * PANEL), &hi[i],
                           &lo[i]);
            }
            transpose(hi);
            transpose(lo);
            for (int i = 0; i < LANES; i++) {
                float *word = to + j * TILE_FLOATS + i * LANES;
                _mm512_store_si512(word, hi[i]);
                _mm512_store_si512(word + 2 * TILE_FLOATS, lo[i]);
            }
        }
    }
}

/* ---- Forward and backward ---- */

/* to [ROWS][PANEL] = bias + left right; bias NULL: 0. */
INLINE void product(const int n_right, const float *left, const float *right, uint32_t n,
                    const float *bias, float *to)
{
    static const float zeros[PANEL];
    const float *start = bias ? bias : zeros;
    _tile_loadd(0, start, 0); /* the same row sixteen times */
    _tile_loadd(2, start, 0);
    if (n_right > 1) {
        _tile_loadd(1, start + LANES, 0);
        _tile_loadd(3, start + LANES, 0);
    }
    add_steps(2, n_right, left, right, n);
    _tile_stored(0, to, PANEL * sizeof *to);
    _tile_stored(2, to + LANES * PANEL, PANEL * sizeof *to);
    if (n_right > 1) {
        _tile_stored(1, to + LANES, PANEL * sizeof *to);
        _tile_stored(3, to + LANES * PANEL + LANES, PANEL * sizeof *to);
    }
}

INLINE void activate(float *y)
{
    const __m512 slope = _mm512_set1_ps(NN_SLOPE);
    for (int i = 0; i < ROWS * PANEL; i += LANES) {
        __m512 x = _mm512_load_ps(y + i);
        _mm512_store_ps(y + i, _mm512_max_ps(x, _mm512_mul_ps(x, slope)));
    }
}

/* Row blocks outside, panels inside: what is read from afar is read once, the weights of a layer
 * stay in the second-level cache. */
static void forward(const struct nn_forward *a)
{
    uint32_t n = n_steps(a->n_in) + n_steps(a->n_q);
    tiles_begin();
    for (size_t r = 0; r < (size_t)a->n_rows * PANEL; r += ROWS * PANEL) {
        split_rows(a->scratch, a->x + r, a->stride, a->n_in, a->q + r, a->n_q);
        const float *right = a->w;
        for (uint32_t first = 0; first < a->n_out; first += PANEL) {
            float *y = a->y + first / PANEL * a->stride + r;
            if (a->n_out - first > LANES)
                product(2, a->scratch, right, n, a->b + first, y);
            else
                product(1, a->scratch, right, n, a->b + first, y);
            if (!a->linear) activate(y);
            right += (size_t)n * STEP_FLOATS;
        }
    }
    _tile_release();
}

INLINE void derive(float *dh, const float *h)
{
    const __m512 slope = _mm512_set1_ps(NN_SLOPE), zero = _mm512_setzero_ps();
    for (int i = 0; i < ROWS * PANEL; i += LANES) {
        __m512 x = _mm512_load_ps(dh + i);
        __mmask16 low = _mm512_cmp_ps_mask(_mm512_load_ps(h + i), zero, _CMP_LE_OQ);
        _mm512_store_ps(dh + i, _mm512_mask_mul_ps(x, low, x, slope));
    }
}

static void backward(const struct nn_backward *a)
{
    uint32_t n = n_steps(a->n_out);
    tiles_begin();
    for (size_t r = 0; r < (size_t)a->n_rows * PANEL; r += ROWS * PANEL) {
        split_rows(a->scratch, a->dy + r, a->stride, a->n_out, NULL, 0);
        const float *right = a->w;
        for (uint32_t first = 0; first < a->n_in; first += PANEL) {
            size_t at = first / PANEL * a->stride + r;
            if (a->n_in - first > LANES)
                product(2, a->scratch, right, n, NULL, a->dh + at);
            else
                product(1, a->scratch, right, n, NULL, a->dh + at);
            derive(a->dh + at, a->h + at);
            right += (size_t)n * STEP_FLOATS;
        }
    }
    _tile_release();
}

/* ---- Weight gradient ---- */

/* Where a block of sums goes: n_rows x n_columns of it, the rest is padding. */
struct target {
    float *dw;
    size_t ld;
    uint32_t n_rows, n_columns;
    bool add;
};

/* A tile that sticks out of its target, through `spare`. */
static void add_part(const struct target *t, uint32_t row, uint32_t column, const float *spare)
{
    __mmask16 mask = first_lanes(less(t->n_columns, column));
    for (uint32_t i = 0; i < LANES && row + i < t->n_rows; i++) {
        float *to = t->dw + (row + i) * t->ld + column;
        __m512 sum = _mm512_load_ps(spare + i * LANES);
        if (t->add) sum = _mm512_add_ps(sum, _mm512_maskz_loadu_ps(mask, to));
        _mm512_mask_storeu_ps(to, mask, sum);
    }
}

/* Whole tiles start from what is there and go straight back. */
#define IS_WHOLE(t, row, column) \
    ((t)->n_rows >= (row) + LANES && (t)->n_columns >= (column) + LANES)
#define BEGIN_SUM(reg, t, row, column)                                                       \
    do {                                                                                     \
        if ((t)->add && IS_WHOLE(t, row, column))                                            \
            _tile_loadd(reg, (t)->dw + (row) * (t)->ld + (column), (t)->ld * sizeof(float)); \
        else                                                                                 \
            _tile_zero(reg);                                                                 \
    } while (0)
#define END_SUM(reg, t, row, column, spare)                                                   \
    do {                                                                                      \
        if (IS_WHOLE(t, row, column)) {                                                       \
            _tile_stored(reg, (t)->dw + (row) * (t)->ld + (column), (t)->ld * sizeof(float)); \
        } else {                                                                              \
            _tile_stored(reg, spare, 64);                                                     \
            add_part(t, row, column, spare);                                                  \
        }                                                                                     \
    } while (0)

INLINE void outer_block(const int n_left, const int n_right, const struct target *t,
                        const float *left, const float *right, uint32_t n, float *spare)
{
    BEGIN_SUM(0, t, 0, 0);
    if (n_right > 1) BEGIN_SUM(1, t, 0, LANES);
    if (n_left > 1) BEGIN_SUM(2, t, LANES, 0);
    if (n_left > 1 && n_right > 1) BEGIN_SUM(3, t, LANES, LANES);
    add_steps(n_left, n_right, left, right, n);
    END_SUM(0, t, 0, 0, spare);
    if (n_right > 1) END_SUM(1, t, 0, LANES, spare);
    if (n_left > 1) END_SUM(2, t, LANES, 0, spare);
    if (n_left > 1 && n_right > 1) END_SUM(3, t, LANES, LANES, spare);
}

/* One panel of x (or q): its columns of dw. `left` is dy's transpose, all panels. */
static void outer_panel(const struct nn_outer *a, const float *x, uint32_t n_columns, float *dw,
                        size_t ld, bool add, const float *left, float *right, float *spare)
{
    uint32_t n = n_steps(a->n_rows);
    split_columns(right, a->n_rows, x);
    for (uint32_t o = 0; o < a->n_out; o += PANEL, left += (size_t)n * STEP_FLOATS) {
        struct target t = {dw + o * ld, ld, a->n_out - o, n_columns, add};
        if (t.n_rows > LANES && n_columns > LANES)
            outer_block(2, 2, &t, left, right, n, spare);
        else if (t.n_rows > LANES)
            outer_block(2, 1, &t, left, right, n, spare);
        else if (n_columns > LANES)
            outer_block(1, 2, &t, left, right, n, spare);
        else
            outer_block(1, 1, &t, left, right, n, spare);
    }
}

static void outer(const struct nn_outer *a)
{
    size_t n = n_steps(a->n_rows), n_o = n_steps(a->n_out);
    float *left = a->scratch, *right = left + n_o * n * STEP_FLOATS;
    float *spare = right + n * STEP_FLOATS;
    for (uint32_t i = 0; i < n_o; i++)
        split_transposed(left + i * n * STEP_FLOATS, a->n_rows, a->dy + i * a->stride);
    tiles_begin();
    for (uint32_t first = 0; first < a->n_in; first += PANEL)
        outer_panel(a, a->x + first / PANEL * a->stride, a->n_in - first, a->dw + first, a->ld_w,
                    a->add_w, left, right, spare);
    if (a->n_q > 0) outer_panel(a, a->q, a->n_q, a->dq, a->ld_q, a->add_q, left, right, spare);
    _tile_release();
}

/* ---- Packing ---- */

static size_t forward_count(uint32_t n_in, uint32_t n_q)
{
    return (size_t)(n_steps(n_in) + n_steps(n_q)) * STEP_FLOATS;
}

/* Outputs are columns of the right operand; inputs come from `n` columns of w. */
static float *pack_outputs(float *packed, const float *w, size_t ld, uint32_t n_lanes, uint32_t n)
{
    for (uint32_t k = 0; k < n; k += STEP, packed += STEP_FLOATS) {
        float block[STEP * PANEL] __attribute__((aligned(64))) = {0};
        for (uint32_t lane = 0; lane < n_lanes; lane++)
            for (uint32_t i = 0; i < STEP && k + i < n; i++)
                block[i * PANEL + lane] = w[lane * ld + k + i];
        split_columns(packed, STEP, block);
    }
    return packed;
}

static void pack_forward(float *packed, const float *w, size_t ld, uint32_t n_out, uint32_t n_in,
                         uint32_t n_q, uint32_t index)
{
    uint32_t first = index * PANEL, n_lanes = n_out - first < PANEL ? n_out - first : PANEL;
    packed = pack_outputs(packed, w + first * ld, ld, n_lanes, n_in);
    pack_outputs(packed, w + first * ld + n_in, ld, n_lanes, n_q);
}

static size_t backward_count(uint32_t n_out)
{
    return (size_t)n_steps(n_out) * STEP_FLOATS;
}

static void pack_backward(float *packed, const float *w, size_t ld, uint32_t n_out, uint32_t n_in,
                          uint32_t index)
{
    uint32_t first = index * PANEL, n_lanes = n_in - first < PANEL ? n_in - first : PANEL;
    for (uint32_t o = 0; o < n_out; o += STEP, packed += STEP_FLOATS) {
        float block[STEP * PANEL] __attribute__((aligned(64))) = {0};
        for (uint32_t i = 0; i < STEP && o + i < n_out; i++)
            memcpy(block + i * PANEL, w + (o + i) * ld + first, n_lanes * sizeof *block);
        split_columns(packed, STEP, block);
    }
}

/* The larger of: rows of x and q; all of dy's transpose, one panel's columns, a spare tile. */
static size_t scratch_count(uint32_t n_rows, uint32_t n)
{
    return (size_t)n_steps(n_rows) * (n_steps(n) + 1) * STEP_FLOATS + TILE_FLOATS;
}

static void exponentials(const float *x, uint32_t n, float *y)
{
    nn_kernels_avx512.exponentials(x, n, y);
}

static double peak(uint64_t n)
{
    return nn_kernels_avx512.peak(n);
}

const struct nn_kernels nn_kernels_amx = {
    .name = "amx",
    .panel = PANEL,
    .rows = ROWS,
    .error = 0x1p-14f,
    .forward = forward,
    .backward = backward,
    .outer = outer,
    .exponentials = exponentials,
    .forward_count = forward_count,
    .pack_forward = pack_forward,
    .backward_count = backward_count,
    .pack_backward = pack_backward,
    .scratch_count = scratch_count,
    .peak = peak,
};
