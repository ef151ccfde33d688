/* SPDX-License-Identifier: Apache-2.0 */
/* Public measurements of the paper's network. */
#include "api/bench_private.h"
#include "nn/bench_nn.h"

/* As many variables as the paper's richest scene has. */
enum { N_VARIABLES = 12, PATCH_SIZE = 32 };

static struct generator_config config_of(const struct bench_options *o, uint32_t n_variables)
{
    return (struct generator_config){.n_variables = n_variables,
                                     .width = o->width ? o->width : BENCH_WIDTH,
                                     .depth = o->depth != BENCH_ANY ? o->depth : BENCH_DEPTH,
                                     .patch_size = PATCH_SIZE};
}

static void put_result(struct json *j, const char *name, const struct nn_bench_result *r,
                       double peak)
{
    json_begin_object(j, NULL);
    json_put_string(j, "name", name);
    json_put_number(j, "seconds", r->seconds);
    json_put_number(j, "gflop", r->gflop);
    json_put_number(j, "gflops", r->gflops);
    json_put_number(j, "share_of_peak", r->gflops / peak);
    json_end(j);
}

lmn_status bench_train(lmn_context *context, const struct bench_options *o, struct json *j,
                       struct error *err)
{
    lmn_status status = LMN_OK;
    const struct generator_config config = config_of(o, N_VARIABLES);
    struct nn_bench_result r;
    const double peak = nn_bench_peak_gflops(context->cpu, context->pool);
    TRY(bench_progress(context, 1, 3, err));
    TRY(nn_bench_step(&config, context->pool, context->cpu, o->patches, o->runs, &r, err));
    /* The peak again, so that a machine whose clock or load changed meanwhile shows. */
    const double peak_after = nn_bench_peak_gflops(context->cpu, context->pool);
    const double best = peak > peak_after ? peak : peak_after;
    TRY(bench_progress(context, 3, 3, err));
    json_begin_array(j, "results");
    json_begin_object(j, NULL);
    json_put_string(j, "kernels", nn_bench_kernels(context->cpu));
    json_put_integer(j, "width", config.width);
    json_put_integer(j, "depth", config.depth);
    json_put_integer(j, "patches", o->patches);
    json_put_integer(j, "patch_size", PATCH_SIZE);
    json_put_integer(j, "weights", (int64_t)r.n_weights);
    json_put_integer(j, "memory_bytes", (int64_t)r.memory_size);
    json_put_number(j, "step_s", r.seconds);
    json_put_number(j, "gflop", r.gflop);
    json_put_number(j, "gflops", r.gflops);
    json_put_number(j, "peak_gflops", best);
    json_put_number(j, "share_of_peak", r.gflops / best);
    json_end(j);
    json_end(j);
done:
    return status;
}

lmn_status bench_kernels(lmn_context *context, const struct bench_options *o, struct json *j,
                         struct error *err)
{
    lmn_status status = LMN_OK;
    const struct generator_config config = config_of(o, N_VARIABLES);
    struct nn_bench_result r;
    const double peak = nn_bench_peak_gflops(context->cpu, context->pool);
    json_put_string(j, "kernels", nn_bench_kernels(context->cpu));
    json_put_integer(j, "width", config.width);
    json_put_integer(j, "depth", config.depth);
    json_put_number(j, "peak_gflops", peak);
    json_begin_array(j, "results");
    TRY(nn_bench_render(&config, context->pool, context->cpu, 65536, o->runs, &r, err));
    put_result(j, "render 65536 pixels", &r, peak);
    TRY(bench_progress(context, 1, 3, err));
    TRY(nn_bench_step(&config, context->pool, context->cpu, o->patches, o->runs, &r, err));
    put_result(j, "step", &r, peak);
    TRY(bench_progress(context, 2, 3, err));
    TRY(nn_bench_probe(&config, context->pool, context->cpu, o->patches, o->runs, &r, err));
    put_result(j, "probe", &r, peak);
    TRY(bench_progress(context, 3, 3, err));
    json_end(j);
done:
    return status;
}
