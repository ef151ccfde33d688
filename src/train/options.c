/* SPDX-License-Identifier: Apache-2.0 */
#include "train/options.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum field_type { FIELD_U32, FIELD_U64, FIELD_I32, FIELD_DOUBLE };

struct field {
    const char *name;
    enum field_type type;
    size_t offset;
    double initial, min, max;
};

#define FIELD(type, name, initial, min, max)                                      \
    {                                                                             \
#name, FIELD_##type, offsetof(lmn_train_options, name), initial, min, max \
    }

/* Defaults are the paper's, with its authors' README where the paper is silent. */
static const struct field fields[] = {
    FIELD(U64, seed, 0, 0, 0),
    FIELD(U32, width, 512, 1, 1024),
    FIELD(U32, depth, 8, 0, 32),
    FIELD(DOUBLE, learning_rate, 1e-4, 1e-12, 1),
    FIELD(U32, legacy_ssim, 0, 0, 1),
    FIELD(U32, explore, LMN_EXPLORE_ACTIVE, 0, 2),
    FIELD(U32, n_chains, 16, 1, 1024),
    FIELD(DOUBLE, large_step, 0.3, 0, 1),
    FIELD(DOUBLE, step_min, 1.0 / 25, 1e-6, 0.5),
    FIELD(DOUBLE, step_max, 1.0 / 20, 1e-6, 0.5),
    FIELD(U32, no_preconditioning, 0, 0, 1),
    FIELD(U32, no_reuse, 0, 0, 1),
    FIELD(DOUBLE, reuse_bias, 4.6, -100, 100),
    FIELD(DOUBLE, reuse_ema, 0.9, 0, 0.999999),
    FIELD(U32, reuse_warmup, 100, 1, 1e9),
    FIELD(U32, reuse_batch, 16, 1, 4096),
    FIELD(U32, replay_capacity, 100000, 1, 1e8),
    FIELD(U32, memory_mib, 1024, 1, 1048576),
    FIELD(U32, no_growth, 0, 0, 1),
    FIELD(U32, patch_size, 32, 4, 256),
    FIELD(U32, resolution_start, 128, 4, 16384),
    FIELD(U32, resolution_max, 600, 4, 16384),
    FIELD(U32, resolution_step, 4, 0, 16384),
    FIELD(U32, resolution_every, 2000, 1, 1e9),
    FIELD(U32, spp, 0, 0, 16777216),
    FIELD(U32, has_max_depth, 0, 0, 1),
    FIELD(U32, has_rr_depth, 0, 0, 1),
    FIELD(I32, max_depth, 0, -1, 1e9),
    FIELD(I32, rr_depth, 0, 0, 1e9),
    FIELD(U32, integrator, LMN_INTEGRATOR_PATH, 0, 2),
    FIELD(U32, method, LMN_METHOD_FAITHFUL, 0, 1),
    FIELD(U32, without, 0, 0, 1023),
};
enum { N_FIELDS = sizeof fields / sizeof fields[0] };

/* Younger than files: left out where it has its initial value. */
static bool may_be_missing(const struct field *f)
{
    return f->offset == offsetof(lmn_train_options, integrator) ||
           f->offset == offsetof(lmn_train_options, method) ||
           f->offset == offsetof(lmn_train_options, without);
}

static double get(const lmn_train_options *o, const struct field *f)
{
    const char *at = (const char *)o + f->offset;
    uint32_t u32;
    int32_t i32;
    double real;
    switch (f->type) {
    case FIELD_U32:
        memcpy(&u32, at, sizeof u32);
        return u32;
    case FIELD_I32:
        memcpy(&i32, at, sizeof i32);
        return i32;
    case FIELD_DOUBLE:
        memcpy(&real, at, sizeof real);
        return real;
    case FIELD_U64:
        break;
    }
    return 0; /* only the seed is 64 bits wide, and any is good */
}

/* `value` fits the field. */
static void set(lmn_train_options *o, const struct field *f, double value)
{
    char *at = (char *)o + f->offset;
    uint64_t u64 = 0;
    uint32_t u32 = 0;
    int32_t i32 = 0;
    switch (f->type) {
    case FIELD_U32:
        u32 = (uint32_t)value;
        memcpy(at, &u32, sizeof u32);
        break;
    case FIELD_U64:
        u64 = (uint64_t)value;
        memcpy(at, &u64, sizeof u64);
        break;
    case FIELD_I32:
        i32 = (int32_t)value;
        memcpy(at, &i32, sizeof i32);
        break;
    case FIELD_DOUBLE:
        memcpy(at, &value, sizeof value);
        break;
    }
}

void options_init(lmn_train_options *o)
{
    memset(o, 0, sizeof *o); /* padding too: options are compared and hashed as bytes */
    o->struct_size = sizeof *o;
    for (size_t i = 0; i < N_FIELDS; i++) set(o, &fields[i], fields[i].initial);
}

void options_init_method(lmn_train_options *o, uint32_t method)
{
    options_init(o);
    o->method = method;
    if (method != LMN_METHOD_IMPROVED) return;
    o->width = 64;
    o->depth = 3;
    o->learning_rate = 5e-3;
    o->spp = 8;
    o->integrator = LMN_INTEGRATOR_AUTO;
    o->resolution_max = 16384; /* pixels that are points */
    o->memory_mib = 256;
}

/* What goes together in the improved method. */
static lmn_status check_improved(const lmn_train_options *o, struct error *err)
{
    if (o->depth < 1 || o->depth > 16 || o->width > 512)
        return fail(err, LMN_ERR_ARGUMENT,
                    "training options width = %u, depth = %u: the improved method takes widths up "
                    "to 512 and depths of 1 to 16",
                    o->width, o->depth);
    if (o->explore == LMN_EXPLORE_LOSS_ONLY)
        return fail(err, LMN_ERR_ARGUMENT,
                    "training option explore = %u: the improved method has no chains whose target "
                    "could be the loss alone",
                    o->explore);
    return LMN_OK;
}

lmn_status options_check(const lmn_train_options *o, struct error *err)
{
    for (size_t i = 0; i < N_FIELDS; i++) {
        const struct field *f = &fields[i];
        double value = get(o, f);
        if (f->type != FIELD_U64 && !(value >= f->min && value <= f->max))
            return fail(err, LMN_ERR_ARGUMENT, "training option %s = %g is not between %g and %g",
                        f->name, value, f->min, f->max);
    }
    if (o->method == LMN_METHOD_IMPROVED) return check_improved(o, err);
    if (o->step_min > o->step_max)
        return fail(err, LMN_ERR_ARGUMENT, "training option step_min = %g is above step_max = %g",
                    o->step_min, o->step_max);
    if (o->patch_size > o->resolution_start)
        return fail(err, LMN_ERR_ARGUMENT,
                    "training option patch_size = %u is above resolution_start = %u", o->patch_size,
                    o->resolution_start);
    if (o->resolution_start > o->resolution_max)
        return fail(err, LMN_ERR_ARGUMENT,
                    "training option resolution_start = %u is above resolution_max = %u",
                    o->resolution_start, o->resolution_max);
    return LMN_OK;
}

lmn_status options_assign(lmn_train_options *o, const char *assignment, struct error *err)
{
    const char *names[N_FIELDS], *equals = strchr(assignment, '=');
    char name[48] = "", *end = NULL;
    if (!equals || equals[1] == '\0')
        return fail(err, LMN_ERR_ARGUMENT, "\"%.200s\": expected OPTION=NUMBER, as spp=4",
                    assignment);
    const size_t n = (size_t)(equals - assignment);
    if (n < sizeof name) memcpy(name, assignment, n); /* longer ones are unknown in any case */
    for (size_t i = 0; i < N_FIELDS; i++) {
        const struct field *f = &fields[i];
        names[i] = f->name;
        if (strcmp(f->name, name) != 0) continue;
        const double value = strtod(equals + 1, &end);
        const bool is_seed = f->type == FIELD_U64;
        const bool is_whole = f->type == FIELD_DOUBLE || value == floor(value);
        const double max = is_seed ? 9e15 : f->max; /* what a double holds exactly */
        if (*end != '\0' || !is_whole || !(value >= f->min && value <= max))
            return fail(err, LMN_ERR_ARGUMENT,
                        "training option %s = \"%.100s\" is no %snumber between %g and %g", name,
                        equals + 1, f->type == FIELD_DOUBLE ? "" : "whole ", f->min, max);
        set(o, f, value);
        return LMN_OK;
    }
    const char *closest = name[0] ? str_closest(name, names, N_FIELDS) : NULL;
    return fail(err, LMN_ERR_ARGUMENT, "unknown training option \"%.*s\"%s%s%s",
                n < 100 ? (int)n : 100, assignment, closest ? "; did you mean \"" : "",
                closest ? closest : "", closest ? "\"?" : "");
}

void options_write(const lmn_train_options *o, struct json *j)
{
    for (size_t i = 0; i < N_FIELDS; i++) {
        const struct field *f = &fields[i];
        if (may_be_missing(f) && get(o, f) == f->initial) continue;
        if (f->type == FIELD_DOUBLE)
            json_put_number(j, f->name, get(o, f));
        else if (f->type == FIELD_U64)
            json_put_integer(j, f->name, (int64_t)o->seed);
        else
            json_put_integer(j, f->name, (int64_t)get(o, f));
    }
}

static lmn_status read_field(const json_t *member, const struct field *f, const char *where,
                             lmn_train_options *o, struct error *err)
{
    if (!member)
        return fail(err, LMN_ERR_PARSE, "%s: training option \"%s\" is missing", where, f->name);
    if (f->type == FIELD_DOUBLE ? !json_is_number(member) : !json_is_integer(member))
        return fail(err, LMN_ERR_PARSE, "%s: training option \"%s\" is not %s", where, f->name,
                    f->type == FIELD_DOUBLE ? "a number" : "an integer");
    if (f->type == FIELD_U64) {
        o->seed = (uint64_t)json_integer_value(member);
        return LMN_OK;
    }
    double value = json_number_value(member);
    if (!(value >= f->min && value <= f->max))
        return fail(err, LMN_ERR_PARSE, "%s: training option \"%s\" = %g is not between %g and %g",
                    where, f->name, value, f->min, f->max);
    set(o, f, value);
    return LMN_OK;
}

lmn_status options_read(const char *text, const char *where, lmn_train_options *o,
                        struct error *err)
{
    lmn_status status = LMN_OK;
    lmn_train_options read;
    struct error inner;
    json_error_t reason;
    json_t *root = json_loads(text, JSON_REJECT_DUPLICATES, &reason);
    if (!json_is_object(root)) {
        status = fail(err, LMN_ERR_PARSE, "%s: training options are no JSON object%s%s", where,
                      root ? "" : ": ", root ? "" : reason.text);
        goto done;
    }
    options_init(&read);
    size_t n_read = 0;
    for (size_t i = 0; i < N_FIELDS; i++) {
        const json_t *member = json_object_get(root, fields[i].name);
        if (!member && may_be_missing(&fields[i])) continue;
        TRY(read_field(member, &fields[i], where, &read, err));
        n_read++;
    }
    if (json_object_size(root) != n_read) {
        status = fail(err, LMN_ERR_PARSE, "%s: unknown training options beside the %d known", where,
                      (int)N_FIELDS);
        goto done;
    }
    if (options_check(&read, &inner) != LMN_OK) {
        status = fail(err, LMN_ERR_PARSE, "%s: %s", where, inner.text);
        goto done;
    }
    *o = read;
done:
    json_decref(root);
    return status;
}
