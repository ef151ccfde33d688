/* SPDX-License-Identifier: Apache-2.0 */
#include "stored.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/mem.h"
#include "toy.h"

void stored_load(struct stored *r, const char *name)
{
    const char *root = getenv("LMN_REFERENCES");
    char path[512], *bytes;
    size_t size;
    struct error err = {{0}};
    json_error_t why;
    snprintf(path, sizeof path, "%s/%s.json", root ? root : LMN_SOURCE_DIR "/tests/nn/data", name);
    if (root) snprintf(path, sizeof path, "%s/nn/%s.json", root, name);
    r->json = json_load_file(path, 0, &why);
    if (!r->json) fail_msg("%s:%d: %s", path, why.line, why.text);
    memcpy(path + strlen(path) - 4, "bin", 4);
    if (file_read(path, 64 << 20, &bytes, &size, &err) != LMN_OK) fail_msg("%s", err.text);
    r->floats = (float *)(void *)bytes;
    r->n_floats = size / sizeof *r->floats;
}

void stored_release(struct stored *r)
{
    json_decref(r->json);
    mem_free(r->floats);
}

uint32_t stored_number(const struct stored *r, const char *name)
{
    return (uint32_t)json_integer_value(json_object_get(r->json, name));
}

const float *stored_values(const struct stored *r, const char *name, size_t n)
{
    json_t *array = json_object_get(json_object_get(r->json, "arrays"), name);
    size_t offset = (size_t)json_integer_value(json_array_get(array, 0));
    size_t count = (size_t)json_integer_value(json_array_get(array, 1));
    if (!array || count != n || offset + count > r->n_floats)
        fail_msg("references: %s: %zu values wanted, %zu there", name, n, count);
    return r->floats + offset;
}

void check_close(const char *what, const float *got, const float *want, size_t n, double relative)
{
    double largest = 0.0, worst = 0.0;
    for (size_t i = 0; i < n; i++) {
        double error = fabs((double)got[i] - (double)want[i]);
        if (fabs((double)want[i]) > largest) largest = fabs((double)want[i]);
        if (!(error <= worst)) worst = error;
    }
    if (!(worst <= relative * largest)) fail_msg("%s: off by %.3g of %.3g", what, worst, largest);
}
