/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_SAFETENSORS_H
#define TRAIN_SAFETENSORS_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "base/error.h"

/*
 * The safetensors file layout: 8 bytes little-endian length of the header, the header (JSON: tensor
 * name -> dtype, shape, byte range; "__metadata__": strings), then the tensors' bytes, without
 * gaps. Any safetensors reader opens what is written here.
 */

enum tensor_type { TENSOR_F32, TENSOR_F64, TENSOR_I64, TENSOR_U8 };
enum { TENSOR_MAX_RANK = 4 };

/* Reading: the expected type and shape, and where the values go. Writing: where they come from. */
struct tensor {
    const char *name;
    enum tensor_type type;
    uint32_t rank;
    uint64_t shape[TENSOR_MAX_RANK];
    void *data;
};

struct tensor_text {
    const char *key, *value;
};

/* Writes the file as base/file.h does: under a temporary name, then renamed. */
lmn_status safetensors_save(const char *path, const struct tensor_text *texts, uint32_t n_texts,
                            const struct tensor *tensors, uint32_t n_tensors, struct error *err);

struct json_t;

/* An open file whose header has been checked whole: known types, shapes that match byte ranges,
 * ranges that fill the file without gap or overlap. Tensors are read one by one when asked for. */
struct safetensors {
    char *path;
    FILE *f;
    struct json_t *header;
    uint64_t data_at; /* bytes into the file */
};

lmn_status safetensors_open(struct safetensors *st, const char *path, struct error *err);
void safetensors_release(struct safetensors *st);

/* A text of the metadata, NULL when there is none of that key. */
const char *safetensors_text(const struct safetensors *st, const char *key);

/* The first dimension of a tensor of that name, 0 when there is none: to learn how many rows a
 * tensor has before asking for it. */
uint64_t safetensors_n_rows(const struct safetensors *st, const char *name);

/* Whether a tensor of that name, type and shape is there. */
lmn_status safetensors_check(const struct safetensors *st, const struct tensor *t,
                             struct error *err);

/* Reads t->data after comparing type and shape. Values of F32 and F64 tensors must be finite
 * unless `may_be_nan`. */
lmn_status safetensors_read(const struct safetensors *st, const struct tensor *t, bool may_be_nan,
                            struct error *err);

#endif
