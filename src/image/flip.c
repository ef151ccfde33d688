/* SPDX-License-Identifier: Apache-2.0 */
#include "image/flip.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/mem.h"
#include "image/select.h"

/* Numbers of Andersson et al. 2020, section 4, and its Table 1. */
static const double pixels_per_degree = 0.7 * (3840 / 0.7) * (3.14159265358979 / 180);
static const double q_color = 0.7, p_color = 0.4, p_target = 0.95, w_feature = 0.082,
                    q_feature = 0.5;

/* Contrast sensitivity of the channel as a sum of Gaussians a * sqrt(pi/b) * exp(-pi^2 x^2 / b), x
 * in degrees. The blue-yellow channel needs two. */
static const struct {
    double a, b;
} csf_y = {1, 0.0047}, csf_cx = {1, 0.0053}, csf_cz[2] = {{34.1, 0.04}, {13.5, 0.025}};

enum { RADIUS = 10, N_TAPS = 2 * RADIUS + 1 }; /* 3 sigma of the widest filter: 9.05 pixels */
enum { FEATURE_RADIUS = 9 };                   /* 3 sigma of 2.75 pixels */

/* D65 white, the row sums of the RGB to XYZ matrix. */
static const float white[3] = {0.950428545f, 1.0f, 1.088900371f};

enum { N_PLANES = 4 }; /* Y, Cx, Cz by the first Gaussian, Cz by the second */

/* Two of everything: [0] is the reference's, [1] the test's. All planes are width * height. */
struct flip {
    uint32_t width, height;
    float taps[N_PLANES][N_TAPS];                     /* the contrast sensitivity filters */
    float gauss[N_TAPS], edge[N_TAPS], point[N_TAPS]; /* feature filters, 0 beyond their radius */
    float max_color;                                  /* the largest possible colour difference */
    float *opponent[2][3];                            /* Y, Cx, Cz of the images */
    float *filtered[2][N_PLANES];
    float *feature[2][2]; /* edge and point strengths */
    float *scratch, *row; /* one plane; one row and 2 * RADIUS more */
    float *exposed[2];    /* width * height * 3: HDR's images at one exposure */
    float *map, *worst;   /* HDR's maps: of one exposure, the largest so far */
};

/* ---- Colours ------------------------------------------------------------------------------ */

static void rgb_to_xyz(const float rgb[3], float xyz[3])
{
    /* sRGB primaries, D65, as exact fractions */
    static const float m[3][3] = {
        {10135552.0f / 24577794, 8788810.0f / 24577794, 4435075.0f / 24577794},
        {2613072.0f / 12288897, 8788810.0f / 12288897, 887015.0f / 12288897},
        {1425312.0f / 73733382.0f, 8788810.0f / 73733382.0f, 70074185.0f / 73733382.0f}};
    for (int i = 0; i < 3; i++) xyz[i] = m[i][0] * rgb[0] + m[i][1] * rgb[1] + m[i][2] * rgb[2];
}

static void xyz_to_rgb(const float xyz[3], float rgb[3])
{
    static const float m[3][3] = {{3.241003275f, -1.537398934f, -0.498615861f},
                                  {-0.969224334f, 1.875930071f, 0.041554224f},
                                  {0.055639423f, -0.204011202f, 1.057148933f}};
    for (int i = 0; i < 3; i++) rgb[i] = m[i][0] * xyz[0] + m[i][1] * xyz[1] + m[i][2] * xyz[2];
}

/* CIELAB without its cube roots: linear, so that filtering it is filtering light. */
static void xyz_to_opponent(const float xyz[3], float out[3])
{
    float x = xyz[0] / white[0], y = xyz[1] / white[1], z = xyz[2] / white[2];
    out[0] = 116 * y - 16;
    out[1] = 500 * (x - y);
    out[2] = 200 * (y - z);
}

static void opponent_to_xyz(const float in[3], float xyz[3])
{
    float y = (in[0] + 16) / 116;
    xyz[0] = (y + in[1] / 500) * white[0];
    xyz[1] = y * white[1];
    xyz[2] = (y - in[2] / 200) * white[2];
}

static float lab_root(float t)
{
    const float delta = 6.0f / 29;
    return t > delta * delta * delta ? cbrtf(t) : t / (3 * delta * delta) + 4.0f / 29;
}

/* CIELAB with the Hunt effect: colours of dark pixels count less. */
static void rgb_to_hunt_lab(const float rgb[3], float lab[3])
{
    float xyz[3];
    rgb_to_xyz(rgb, xyz);
    float x = lab_root(xyz[0] / white[0]), y = lab_root(xyz[1] / white[1]);
    float z = lab_root(xyz[2] / white[2]);
    lab[0] = 116 * y - 16;
    lab[1] = 0.01f * lab[0] * 500 * (x - y);
    lab[2] = 0.01f * lab[0] * 200 * (y - z);
}

/* HyAB distance to the power q_color. */
static float color_distance(const float a[3], const float b[3])
{
    float da = a[1] - b[1], db = a[2] - b[2];
    return powf(fabsf(a[0] - b[0]) + sqrtf(da * da + db * db), (float)q_color);
}

/* ---- Filters ------------------------------------------------------------------------------ */

static void set_gaussian(float *taps, double b, double scale)
{
    const double pi = 3.14159265358979;
    for (int i = 0; i < N_TAPS; i++) {
        double x = (i - RADIUS) / pixels_per_degree;
        taps[i] = (float)(scale * exp(-pi * pi * x * x / b));
    }
}

static double sum_of(const float *taps)
{
    double total = 0;
    for (int i = 0; i < N_TAPS; i++) total += (double)taps[i];
    return total;
}

static void divide(float *taps, double by)
{
    for (int i = 0; i < N_TAPS; i++) taps[i] = (float)((double)taps[i] / by);
}

static void set_color_filters(struct flip *f)
{
    const double pi = 3.14159265358979;
    set_gaussian(f->taps[0], csf_y.b, csf_y.a);
    set_gaussian(f->taps[1], csf_cx.b, csf_cx.a);
    divide(f->taps[0], sum_of(f->taps[0]));
    divide(f->taps[1], sum_of(f->taps[1]));
    /* A sum of two separable filters, each applied along rows and then columns: one-dimensional
     * taps take the root of the two-dimensional factor, and both together sum to 1 in two
     * dimensions. */
    for (int i = 0; i < 2; i++)
        set_gaussian(f->taps[2 + i], csf_cz[i].b, sqrt(csf_cz[i].a * sqrt(pi / csf_cz[i].b)));
    double s2 = sum_of(f->taps[2]), s3 = sum_of(f->taps[3]), norm = sqrt(s2 * s2 + s3 * s3);
    divide(f->taps[2], norm);
    divide(f->taps[3], norm);
}

/* Gaussian and its first two derivatives; positive and negative parts sum to 1 and -1. */
static void set_feature_filters(struct flip *f)
{
    double sd = 0.5 * w_feature * pixels_per_degree, sum = 0, edge = 0, up = 0, down = 0;
    double g[N_TAPS] = {0}, d[N_TAPS] = {0}, dd[N_TAPS] = {0};
    for (int x = -FEATURE_RADIUS; x <= FEATURE_RADIUS; x++) {
        int i = x + RADIUS;
        g[i] = exp(-x * x / (2 * sd * sd));
        d[i] = -x * g[i];
        dd[i] = (x * x / (sd * sd) - 1) * g[i];
        sum += g[i];
        edge += d[i] > 0 ? d[i] : 0;
        up += dd[i] > 0 ? dd[i] : 0;
        down -= dd[i] < 0 ? dd[i] : 0;
    }
    for (int i = 0; i < N_TAPS; i++) {
        f->gauss[i] = (float)(g[i] / sum);
        f->edge[i] = (float)(d[i] / edge);
        f->point[i] = (float)(dd[i] / (dd[i] > 0 ? up : down));
    }
}

/* out = in filtered along rows; the edge pixels repeat outside. */
static void filter_rows(const struct flip *f, const float *taps, const float *in, float *out)
{
    uint32_t w = f->width;
    for (uint32_t y = 0; y < f->height; y++) {
        const float *from = in + (size_t)y * w;
        float *to = out + (size_t)y * w;
        memcpy(f->row + RADIUS, from, w * sizeof *from);
        for (int i = 0; i < RADIUS; i++) {
            f->row[i] = from[0];
            f->row[RADIUS + w + (uint32_t)i] = from[w - 1];
        }
        memset(to, 0, w * sizeof *to);
        for (int t = 0; t < N_TAPS; t++) {
            const float tap = taps[t], *row = f->row + t;
            for (uint32_t x = 0; x < w; x++) to[x] += tap * row[x];
        }
    }
}

static void filter_columns(const struct flip *f, const float *taps, const float *in, float *out)
{
    uint32_t w = f->width;
    int64_t last = (int64_t)f->height - 1;
    for (int64_t y = 0; y <= last; y++) {
        float *to = out + (size_t)y * w;
        memset(to, 0, w * sizeof *to);
        for (int t = 0; t < N_TAPS; t++) {
            int64_t from = y + t - RADIUS;
            from = from < 0 ? 0 : from > last ? last : from;
            const float tap = taps[t], *row = in + (size_t)from * w;
            for (uint32_t x = 0; x < w; x++) to[x] += tap * row[x];
        }
    }
}

/* out = the length of the gradient whose components are `a` along rows and along columns. */
static void find_features(struct flip *f, const float *taps, const float *in, float *out)
{
    /* filtered[0][0] and [1] are free until the colours are filtered */
    float *dx = f->filtered[0][0], *dy = f->filtered[0][1];
    size_t n = (size_t)f->width * f->height;
    filter_rows(f, taps, in, f->scratch);
    filter_columns(f, f->gauss, f->scratch, dx);
    filter_rows(f, f->gauss, in, f->scratch);
    filter_columns(f, taps, f->scratch, dy);
    for (size_t i = 0; i < n; i++) out[i] = sqrtf(dx[i] * dx[i] + dy[i] * dy[i]) / 116;
}

/* ---- LDR ---------------------------------------------------------------------------------- */

lmn_status flip_new(uint32_t width, uint32_t height, struct flip **out, struct error *err)
{
    struct flip *f = mem_new(1, sizeof *f);
    *out = NULL;
    if (!f) return fail_memory(err, "FLIP");
    f->width = width;
    f->height = height;
    set_color_filters(f);
    set_feature_filters(f);
    float green[3], blue[3]; /* the two colours that are furthest apart */
    rgb_to_hunt_lab((const float[3]){0, 1, 0}, green);
    rgb_to_hunt_lab((const float[3]){0, 0, 1}, blue);
    f->max_color = color_distance(green, blue);

    size_t n = (size_t)width * height;
    bool ok = true;
    for (int i = 0; i < 2; i++) {
        for (int c = 0; c < 3; c++) ok &= (f->opponent[i][c] = mem_new(n, sizeof(float))) != NULL;
        for (int c = 0; c < N_PLANES; c++)
            ok &= (f->filtered[i][c] = mem_new(n, sizeof(float))) != NULL;
        for (int c = 0; c < 2; c++) ok &= (f->feature[i][c] = mem_new(n, sizeof(float))) != NULL;
        ok &= (f->exposed[i] = mem_new(n, 3 * sizeof(float))) != NULL;
    }
    ok &= (f->scratch = mem_new(n, sizeof(float))) != NULL;
    ok &= (f->row = mem_new((size_t)width + 2 * RADIUS, sizeof(float))) != NULL;
    ok &= (f->map = mem_new(n, sizeof(float))) != NULL;
    ok &= (f->worst = mem_new(n, sizeof(float))) != NULL;
    if (!ok) {
        flip_free(f);
        return fail_memory(err, "FLIP");
    }
    *out = f;
    return LMN_OK;
}

void flip_free(struct flip *f)
{
    if (!f) return;
    for (int i = 0; i < 2; i++) {
        for (int c = 0; c < 3; c++) mem_free(f->opponent[i][c]);
        for (int c = 0; c < N_PLANES; c++) mem_free(f->filtered[i][c]);
        for (int c = 0; c < 2; c++) mem_free(f->feature[i][c]);
        mem_free(f->exposed[i]);
    }
    mem_free(f->scratch);
    mem_free(f->row);
    mem_free(f->map);
    mem_free(f->worst);
    mem_free(f);
}

static float clamp01(float v)
{
    return v > 0 ? (v < 1 ? v : 1) : 0;
}

/* What the eye makes of pixel i after filtering: Hunt-adjusted CIELAB. */
static void seen_color(const struct flip *f, int which, size_t i, float lab[3])
{
    float *const *p = f->filtered[which];
    float opponent[3] = {p[0][i], p[1][i], p[2][i] + p[3][i]}, xyz[3], rgb[3];
    opponent_to_xyz(opponent, xyz);
    xyz_to_rgb(xyz, rgb);
    for (int c = 0; c < 3; c++) rgb[c] = clamp01(rgb[c]);
    rgb_to_hunt_lab(rgb, lab);
}

double flip_ldr(struct flip *f, const float *reference, const float *test, float *map)
{
    const float *images[2] = {reference, test};
    size_t n = (size_t)f->width * f->height;
    for (int which = 0; which < 2; which++) {
        for (size_t i = 0; i < n; i++) {
            float rgb[3], xyz[3], opponent[3];
            for (int c = 0; c < 3; c++) rgb[c] = clamp01(images[which][3 * i + (size_t)c]);
            rgb_to_xyz(rgb, xyz);
            xyz_to_opponent(xyz, opponent);
            for (int c = 0; c < 3; c++) f->opponent[which][c][i] = opponent[c];
        }
    }
    for (int which = 0; which < 2; which++) {
        find_features(f, f->edge, f->opponent[which][0], f->feature[which][0]);
        find_features(f, f->point, f->opponent[which][0], f->feature[which][1]);
    }
    for (int which = 0; which < 2; which++) {
        for (int c = 0; c < N_PLANES; c++) {
            filter_rows(f, f->taps[c], f->opponent[which][c < 2 ? c : 2], f->scratch);
            filter_columns(f, f->taps[c], f->scratch, f->filtered[which][c]);
        }
    }

    const float knee = (float)p_color * f->max_color, target = (float)p_target;
    double total = 0;
    for (size_t i = 0; i < n; i++) {
        float lab[2][3];
        for (int which = 0; which < 2; which++) seen_color(f, which, i, lab[which]);
        float color = color_distance(lab[0], lab[1]);
        /* most of the range is for the differences that occur, the rest for the very large ones */
        if (color < knee)
            color *= target / knee;
        else
            color = target + (color - knee) / (f->max_color - knee) * (1 - target);
        float edge = fabsf(f->feature[0][0][i] - f->feature[1][0][i]);
        float point = fabsf(f->feature[0][1][i] - f->feature[1][1][i]);
        float feature = powf(fmaxf(edge, point) * 0.70710678f, (float)q_feature);
        map[i] = powf(color, 1 - feature);
        total += (double)map[i];
    }
    return total / (double)n;
}

/* ---- HDR ---------------------------------------------------------------------------------- */

/* ACES as Narkowicz 2015 fits it, its exposure of 0.6 taken out: (a0 x^2 + a1 x) / (b0 x^2 + b1 x +
 * b2). */
static const double a0 = 0.36 * 2.51, a1 = 0.6 * 0.03, b0 = 0.36 * 2.43, b1 = 0.6 * 0.59, b2 = 0.14;

static float tone_curve(float x)
{
    x = x > 0 ? x : 0;
    /* beyond 1e9 the curve is flat, and x * x would overflow before long */
    x = x < 1e9f ? x : 1e9f;
    return clamp01((x * x * (float)a0 + x * (float)a1) /
                   (x * x * (float)b0 + x * (float)b1 + (float)b2));
}

/* From the brightest pixel at 85 % of the display's white to the median pixel there (Andersson et
 * al. 2021, section 3). */
static void find_exposures(struct flip *f, const float *reference, double *start, double *stop)
{
    size_t n = (size_t)f->width * f->height;
    float max = 0;
    for (size_t i = 0; i < n; i++) {
        const float *rgb = reference + 3 * i;
        float luminance = 0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2];
        f->scratch[i] = luminance;
        if (luminance > max) max = luminance;
    }
    float median = select_kth(f->scratch, n, n / 2);
    double a = a0 - 0.85 * b0, b = a1 - 0.85 * b1, c = -0.85 * b2, half = -0.5 * b / a;
    double x = half + sqrt(half * half - c / a);
    *start = log2(x / (double)fmaxf(max, FLT_EPSILON)); /* black images have exposures, too */
    *stop = log2(x / (double)fmaxf(median, FLT_EPSILON));
}

double flip_hdr(struct flip *f, const float *reference, const float *test)
{
    const float *images[2] = {reference, test};
    size_t n = (size_t)f->width * f->height;
    double start, stop;
    find_exposures(f, reference, &start, &stop);
    int n_exposures = (int)ceil(stop - start);
    if (n_exposures < 2) n_exposures = 2;
    memset(f->worst, 0, n * sizeof *f->worst);
    for (int e = 0; e < n_exposures; e++) {
        float gain = (float)exp2(start + e * (stop - start) / (n_exposures - 1));
        for (int which = 0; which < 2; which++)
            for (size_t i = 0; i < 3 * n; i++)
                f->exposed[which][i] = tone_curve(gain * images[which][i]);
        flip_ldr(f, f->exposed[0], f->exposed[1], f->map);
        for (size_t i = 0; i < n; i++)
            if (f->map[i] > f->worst[i]) f->worst[i] = f->map[i];
    }
    double total = 0;
    for (size_t i = 0; i < n; i++) total += (double)f->worst[i];
    return total / (double)n;
}
