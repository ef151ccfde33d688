/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/file.h"
#include "scene/reader_mitsuba_private.h"
#include "scene/spectrum.h"

/* Colours: <rgb>, <srgb>, <spectrum>, <blackbody>. */

static int hex_digit(char c)
{
    const char *digits = "0123456789abcdef", *at = strchr(digits, c | 0x20);
    return c && at ? (int)(at - digits) : -1;
}

/* "#rrggbb": each byte / 255, taken as linear, as Mitsuba's <rgb> had it. */
static bool read_hex(const char *text, struct vec3 *out)
{
    float c[3];
    if (strlen(text) != 7) return false;
    for (int i = 0; i < 3; i++) {
        int hi = hex_digit(text[1 + 2 * i]), lo = hex_digit(text[2 + 2 * i]);
        if (hi < 0 || lo < 0) return false;
        c[i] = (float)(16 * hi + lo) / 255.0f;
    }
    *out = vec3(c[0], c[1], c[2]);
    return true;
}

/* ---- Spectra ------------------------------------------------------------------------------- */

/* One sample more; wavelengths must increase. */
static lmn_status add_sample(struct reader *r, const struct xml_node *node,
                             struct spectrum_sample **samples, size_t *n, size_t *capacity,
                             const double v[2])
{
    void *block = *samples;
    bool ok = mem_grow(&block, capacity, *n + 1, sizeof **samples);
    *samples = block;
    if (!ok) return fail_memory(r->err, "a spectrum");
    if (*n > 0 && !(v[0] > (*samples)[*n - 1].nm))
        return fail_node(r, node, "<spectrum>: wavelengths must increase");
    (*samples)[(*n)++] = (struct spectrum_sample){v[0], v[1]};
    return LMN_OK;
}

/* The numbers of a spectrum by wavelength: "400:0.1, 500:0.2", or a file of lines "400 0.1" with
 * comments from # on. The caller frees *samples, also on failure. */
static lmn_status read_curve(struct reader *r, const struct xml_node *node, const char *text,
                             struct spectrum_sample **samples, size_t *n)
{
    static const char separators[] = " \t\r\n,;:";
    lmn_status status = LMN_OK;
    size_t capacity = 0;
    uint32_t n_values = 0;
    double v[2];
    for (text += strspn(text, separators); *text; text += strspn(text, separators)) {
        char token[64];
        if (*text == '#') {
            text += strcspn(text, "\n");
            continue;
        }
        size_t length = strcspn(text, " \t\r\n,;:#");
        snprintf(token, sizeof token, "%.*s", length < sizeof token ? (int)length : 0, text);
        if (!str_to_double(token, &v[n_values]) || fabs(v[n_values]) > 1e30)
            return fail_node(r, node, "<spectrum>: \"%.*s\" is not a number",
                             length < 40 ? (int)length : 40, text);
        text += length;
        if (++n_values == 2) {
            TRY(add_sample(r, node, samples, n, &capacity, v));
            n_values = 0;
        }
    }
    if (n_values != 0 || *n < 2)
        return fail_node(r, node, "<spectrum> needs pairs of wavelength and value, two or more");
done:
    return status;
}

static struct vec3 not_negative(struct vec3 c)
{
    return vec3(max_float(c.x, 0.0f), max_float(c.y, 0.0f), max_float(c.z, 0.0f));
}

static lmn_status read_by_wavelength(struct reader *r, const struct xml_node *node,
                                     struct vec3 *out, bool is_light)
{
    enum { MAX_SPECTRUM_FILE = 1 << 22 };
    lmn_status status = LMN_OK;
    const char *name = xml_attribute(node, "filename"), *path;
    const char *property = xml_attribute(node, "name");
    char *text = NULL;
    struct spectrum_sample *samples = NULL;
    size_t n = 0, size;
    if (name) {
        TRY(find_file(r, node, name, &path));
        TRY(file_read(path, MAX_SPECTRUM_FILE, &text, &size, r->err));
        builder_hash(r->b, text, size);
    }
    TRY(read_curve(r, node, name ? text : read_value(node), &samples, &n));
    struct vec3 c = not_negative(spectrum_to_rgb(samples, n, is_light));
    if (!is_light && strcmp(property, "eta") != 0 && strcmp(property, "k") != 0)
        c = vec3(min_float(c.x, 1.0f), min_float(c.y, 1.0f), min_float(c.z, 1.0f));
    *out = c;
done:
    mem_free(samples);
    mem_free(text);
    return status;
}

/* <blackbody temperature="5000K" scale="..."/> of 0.x. */
static lmn_status read_blackbody(struct reader *r, const struct xml_node *node, struct vec3 *out)
{
    lmn_status status = LMN_OK;
    double kelvin, scale = 1.0;
    char number[32];
    const char *text = xml_attribute(node, "temperature");
    size_t n = text ? strlen(text) : 0;
    if (n > 0 && (text[n - 1] == 'K' || text[n - 1] == 'k')) n--;
    snprintf(number, sizeof number, "%.*s", n < sizeof number ? (int)n : 0, text ? text : "");
    if (!str_to_double(number, &kelvin) || !(kelvin >= 100.0 && kelvin <= 1e6))
        return fail_node(r, node, "<blackbody> needs a temperature like \"5000K\", 100 to 1e6");
    if (xml_attribute(node, "scale")) TRY(read_number(r, node, "scale", &scale));
    *out = vec3_scale(not_negative(spectrum_blackbody(kelvin)), (float)scale);
done:
    return status;
}

/* One number, three numbers, or #rrggbb. */
static lmn_status read_triplet(struct reader *r, const struct xml_node *node, struct vec3 *out)
{
    const char *text = read_value(node);
    double v[3];
    uint32_t n;
    text += strspn(text, " \t\r\n");
    if (text[0] == '#') {
        if (read_hex(text, out)) return LMN_OK;
        return fail_node(r, node, "<%s>: \"%.40s\" is not a colour like #ff8000", node->name, text);
    }
    lmn_status status = read_numbers(r, node, "value", v, 3, &n);
    if (status != LMN_OK) return status;
    if (n == 2) return fail_node(r, node, "<%s> takes one or three numbers", node->name);
    if (n == 1) v[1] = v[2] = v[0];
    *out = vec3((float)v[0], (float)v[1], (float)v[2]);
    return LMN_OK;
}

lmn_status read_colour(struct reader *r, const struct xml_node *node, struct vec3 *out,
                       bool is_light)
{
    lmn_status status = LMN_OK;
    double v[3];
    uint32_t n;
    if (node->element == EL_BLACKBODY) return read_blackbody(r, node, out);
    if (node->element == EL_SPECTRUM) {
        if (xml_attribute(node, "filename") || strchr(read_value(node), ':'))
            return read_by_wavelength(r, node, out, is_light);
        TRY(read_numbers(r, node, "value", v, 3, &n));
        /* Three numbers are a colour to the RGB builds of 0.x. */
        if (n != 1 && node->is_legacy) return read_triplet(r, node, out);
        if (n != 1)
            return fail_node(r, node, "<spectrum> takes one number; use <rgb> for a colour");
        /* Light of equal energy at all wavelengths is not white in sRGB, whose white is D65. */
        *out = is_light ? vec3_scale(vec3(1.2047939f, 0.9482910f, 0.9089161f), (float)v[0])
                        : vec3_splat((float)v[0]);
        return LMN_OK;
    }
    TRY(read_triplet(r, node, out));
    if (node->element == EL_SRGB)
        *out = vec3(srgb_decode(out->x), srgb_decode(out->y), srgb_decode(out->z));
done:
    return status;
}
