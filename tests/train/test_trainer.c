/* SPDX-License-Identifier: Apache-2.0 */
#include <malloc.h>
#include <math.h>
#include <string.h>

#include "base/mem.h"
#include "tiny.h"
#include "train/checkpoint.h"
#include "train/layout.h"
#include "train/trainer_inside.h"

/* cmocka last: it makes fail() a macro. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

static struct trainer *make(const lmn_train_options *o)
{
    struct error err = {0};
    struct trainer *t = NULL;
    if (trainer_new(&tiny.place, o, &t, &err) != LMN_OK) fail_msg("%s", err.text);
    return t;
}

static void run(struct trainer *t, uint32_t n)
{
    struct error err = {0};
    for (uint32_t i = 0; i < n; i++)
        if (trainer_step(t, NULL, &err) != LMN_OK) fail_msg("%s", err.text);
}

static struct trainer *resume(const char *path)
{
    struct error err = {0};
    struct trainer *t = NULL;
    if (trainer_resume(&tiny.place, path, false, &t, &err) != LMN_OK) fail_msg("%s", err.text);
    return t;
}

static void save(const struct trainer *t, const char *path)
{
    struct error err = {0};
    if (trainer_save(t, path, &err) != LMN_OK) fail_msg("%s", err.text);
}

/* Model and state. */
static void assert_same_files(const char *a, const char *b)
{
    char *paths[4] = {mem_strdup(a), mem_strdup(b), state_path(a), state_path(b)};
    for (int i = 0; i < 4; i += 2) {
        size_t n_a, n_b;
        char *bytes_a = tiny_read(paths[i], &n_a), *bytes_b = tiny_read(paths[i + 1], &n_b);
        assert_int_equal(n_a, n_b);
        assert_memory_equal(bytes_a, bytes_b, n_a);
        mem_free(bytes_a);
        mem_free(bytes_b);
    }
    for (int i = 0; i < 4; i++) mem_free(paths[i]);
}

static void resolution_grows_at_the_start_of_epochs(void **state)
{
    (void)state;
    lmn_train_options o = {.resolution_start = 128,
                           .resolution_max = 600,
                           .resolution_step = 4,
                           .resolution_every = 2000};
    assert_int_equal(trainer_resolution(&o, 0), 132);
    assert_int_equal(trainer_resolution(&o, 1999), 132);
    assert_int_equal(trainer_resolution(&o, 2000), 136);
    assert_int_equal(trainer_resolution(&o, 117 * 2000), 600);
    assert_int_equal(trainer_resolution(&o, 117 * 2000 - 1), 596);
    assert_int_equal(trainer_resolution(&o, UINT64_MAX), 600);
    o.no_growth = 1;
    assert_int_equal(trainer_resolution(&o, 4000), 128);
}

static void training_lowers_the_loss(void **state)
{
    (void)state;
    lmn_train_options o = tiny_options();
    struct trainer *t = make(&o);
    double first = 0, last = 0;
    for (int i = 0; i < 300; i++) { /* losses are of few patches: one of ten may be twice another */
        run(t, 1);
        if (i < 10) first += t->loss / 10;
        if (i >= 200) last += t->loss / 100;
    }
    if (!(last < 0.6 * first)) fail_msg("loss %.3f, was %.3f", last, first);
    trainer_free(t);
}

/* The bookkeeping of a fresh step, chain by chain. */
static void fresh_batches_hold_states_and_what_was_refused(void **state)
{
    (void)state;
    lmn_train_options o = tiny_options();
    o.no_reuse = 0;
    struct trainer *t = make(&o);
    uint32_t n_refused = 0;
    for (int event = 0; event < 5; event++) {
        float u[64];
        memcpy(u, t->explorer.u, 4 * t->explorer.options.dim * sizeof *u);
        uint64_t added = t->replay.n_added;
        run(t, 1);
        assert_true(t->is_fresh);
        uint32_t refused = 0;
        size_t at = 0, patch = (size_t)t->n_pixels * GENERATOR_INPUTS;
        for (uint32_t i = 0; i < 4; i++, at++) {
            uint64_t serial = added + i;
            uint32_t slot = replay_slot(&t->replay, serial);
            assert_memory_equal(t->replay.inputs + slot * patch, t->proposals.inputs + i * patch,
                                patch * sizeof(float));
            assert_ptr_equal(t->batch.inputs[at], t->states.inputs + i * patch);
            if (!t->is_accepted[i]) {
                refused++;
                assert_ptr_equal(t->batch.inputs[++at], t->proposals.inputs + i * patch);
                assert_true(t->serials[i] < added);
            } else {
                assert_int_equal(t->serials[i], serial);
                assert_memory_equal(t->states.inputs + i * patch, t->proposals.inputs + i * patch,
                                    patch * sizeof(float));
            }
            assert_true(t->replay.losses[slot] == t->batch.losses[at]);
            uint32_t mine = replay_slot(&t->replay, t->serials[i]);
            size_t own = t->is_accepted[i] ? at : at - 1;
            assert_true(t->replay.losses[mine] == t->batch.losses[own]);
        }
        assert_int_equal(t->batch.n, 4 + refused);
        if (event == 0) assert_int_equal(refused, 0);
        n_refused += refused;
    }
    assert_true(n_refused > 0);
    assert_int_equal(t->n_traced, 20);
    trainer_free(t);
}

static void baselines_do_what_they_say(void **state)
{
    (void)state;
    lmn_train_options o = tiny_options();
    o.explore = LMN_EXPLORE_UNIFORM;
    o.no_reuse = 1;
    o.no_growth = 1;
    struct trainer *t = make(&o);
    for (int i = 0; i < 8; i++) {
        run(t, 1);
        lmn_train_stats s;
        trainer_get_stats(t, &s);
        assert_true(s.fresh && s.batch == 4 && s.resolution == 32 && s.reuse_probability == 0);
        for (int k = 0; k < 4; k++) assert_true(t->explorer.is_large[k]);
    }
    assert_int_equal(t->replay.capacity, 0);
    trainer_free(t);

    /* Without the Adam step the target is the loss itself. */
    o = tiny_options();
    o.explore = LMN_EXPLORE_LOSS_ONLY;
    o.no_reuse = 1;
    t = make(&o);
    run(t, 6);
    assert_true(t->is_fresh);
    for (uint32_t i = 0; i < 4; i++) assert_true(t->p[i] > 0);
    trainer_free(t);
}

/* Sec. 7.3's ablation stays cut off however long it trains. */
static void position_layer_stays_cut_off(void **state)
{
    (void)state;
    lmn_train_options o = tiny_options();
    o.no_preconditioning = 1;
    struct trainer *t = make(&o);
    run(t, 25);
    struct layout_tensor first;
    layout_get(&t->config, 2, &first);
    const float *w = generator_weights(t->generator);
    for (size_t i = 0; i < first.at; i++) assert_true(w[i] == 0);
    bool has_rest = false;
    for (uint32_t row = 0; row < first.n_out; row++)
        for (uint32_t k = 0; k < first.n_in; k++) {
            float x = w[first.at + (size_t)row * first.n_in + k];
            if (k < o.width) assert_true(x == 0);
            has_rest |= x != 0;
        }
    assert_true(has_rest);
    trainer_free(t);
}

static void threads_do_not_matter(void **state)
{
    (void)state;
    lmn_train_options o = tiny_options();
    for (uint32_t n = 1; n <= 3; n++) {
        tiny_set_threads(&tiny, n);
        struct trainer *t = make(&o);
        run(t, 30);
        save(t, tiny_path(&tiny, n == 1 ? "1.lmn" : "n.lmn"));
        trainer_free(t);
        if (n > 1) assert_same_files(tiny_path(&tiny, "1.lmn"), tiny_path(&tiny, "n.lmn"));
    }
    tiny_set_threads(&tiny, 2);
}

static void resuming_changes_nothing(void **state)
{
    (void)state;
    lmn_train_options o = tiny_options();
    struct trainer *whole = make(&o);
    run(whole, 60); /* the replay memory of 50 patches has gone round by then */
    assert_true(whole->replay.n_added > 50 && whole->replay.n_added < 240);
    save(whole, tiny_path(&tiny, "whole.lmn"));
    trainer_free(whole);

    struct trainer *t = make(&o);
    for (uint32_t n = 0; n < 60; n += 20) { /* three pieces: within warm-up's end, and after */
        run(t, 20);
        save(t, tiny_path(&tiny, "part.lmn"));
        trainer_free(t);
        t = resume(tiny_path(&tiny, "part.lmn"));
        assert_int_equal(t->step, n + 20);
    }
    save(t, tiny_path(&tiny, "part.lmn"));
    trainer_free(t);
    assert_same_files(tiny_path(&tiny, "whole.lmn"), tiny_path(&tiny, "part.lmn"));
}

static void resuming_counts_the_time_before(void **state)
{
    (void)state;
    lmn_train_options o = tiny_options();
    struct trainer *t = make(&o);
    char *path = metrics_path(tiny_path(&tiny, "timed.lmn"));
    assert_string_equal(path, tiny_path(&tiny, "timed.metrics.jsonl"));
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    const char *line = trainer_metrics_line(t);
    assert_non_null(strstr(line, "{\"run\":"));
    fprintf(f, "%s\n", line);
    for (int i = 0; i < 7; i++) {
        run(t, 1);
        fprintf(f, "%s\n", trainer_metrics_line(t));
        if (i == 4) save(t, tiny_path(&tiny, "timed.lmn"));
    }
    fprintf(f, "{\"step\":5,\"cpu_");
    fclose(f);
    double at_5, at_7, trace_s, network_s;
    metrics_times(path, 5, &at_5, &trace_s, &network_s);
    metrics_times(path, 100, &at_7, NULL, NULL);
    assert_true(at_7 == t->cpu_s && at_5 > 0 && at_5 < at_7);
    assert_true(fabs(trace_s + network_s - at_5) < 1e-9);
    trainer_free(t);
    t = resume(tiny_path(&tiny, "timed.lmn"));
    assert_true(t->cpu_s == at_5 && t->step == 5);
    trainer_free(t);
    assert_int_equal(remove(path), 0);
    mem_free(path);
    t = resume(tiny_path(&tiny, "timed.lmn"));
    assert_true(t->cpu_s == 0);
    trainer_free(t);
}

/* Lines of any length, a short one first, none, and what is no file of lines. */
static void times_are_found_from_the_end(void **state)
{
    (void)state;
    const char *path = tiny_path(&tiny, "long.metrics.jsonl");
    double cpu_s, trace_s, network_s;
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    fprintf(f, "{}\n{\"step\":1,\"cpu_s\":2.5,\"note\":\"%09000d\"}\n\n", 0);
    for (int i = 2; i < 400; i++) fprintf(f, "{\"step\":%d,\"cpu_s\":%d}\n", i, 2 * i);
    fprintf(f, "{\"step\":400,\"cpu_s\":800,\"trace_s\":500,\"network_s\":300}");
    fclose(f);
    metrics_times(path, 1, &cpu_s, NULL, NULL);
    assert_true(cpu_s == 2.5);
    metrics_times(path, 399, &cpu_s, NULL, NULL);
    assert_true(cpu_s == 798);
    metrics_times(path, 400, &cpu_s, &trace_s, &network_s);
    assert_true(cpu_s == 800 && trace_s == 500 && network_s == 300);
    metrics_times(path, 0, &cpu_s, NULL, NULL);
    assert_true(cpu_s == 0);
    metrics_times("/", 1, &cpu_s, NULL, NULL);
    assert_true(cpu_s == 0);
}

static void evaluation_goes_into_the_next_line(void **state)
{
    (void)state;
    lmn_train_options o = tiny_options();
    struct trainer *t = make(&o);
    struct error err;
    lmn_metrics m, again;
    const lmn_eval_options test = {.n = 2, .resolution = 24, .spp = 8, .seed = 5};
    run(t, 3);
    assert_int_equal(trainer_eval(t, &test, NULL, NULL, &m, &err), LMN_OK);
    assert_true(m.mape > 0 && isfinite(m.flip));
    double cpu_s = t->cpu_s;
    assert_int_equal(trainer_eval(t, &test, NULL, NULL, &again, &err), LMN_OK);
    assert_memory_equal(&m, &again, sizeof m);
    assert_true(t->cpu_s == cpu_s);
    assert_non_null(strstr(trainer_metrics_line(t), "\"eval\":{\"n\":2,"));
    run(t, 1);
    assert_null(strstr(trainer_metrics_line(t), "\"eval\""));
    trainer_free(t);
}

static double heap_size(void)
{
    struct mallinfo2 m = mallinfo2();
    return (double)(m.uordblks + m.hblkhd);
}

/* What the trainer says it takes is what the heap gave, but for the views' acceleration structures,
 * which are Embree's: all at creation, nothing later. */
static void memory_is_reported(void **state)
{
    (void)state;
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    skip(); /* their heaps do not count for mallinfo2() */
#endif
    lmn_train_options o = tiny_options();
    o.replay_capacity = 3000;
    trainer_free(make(&o)); /* whatever is cached on the way is cached now */
    struct view *views[2];
    double before = heap_size();
    for (int i = 0; i < 2; i++) assert_int_equal(view_new(tiny.world, &views[i], NULL), LMN_OK);
    double of_views = heap_size() - before;
    for (int i = 0; i < 2; i++) view_free(views[i]);

    before = heap_size();
    struct trainer *t = make(&o);
    double taken = heap_size() - before - of_views;
    assert_true(taken > 3000 * 16 * 16 * 19 * 4);
    /* Two blocks are aligned to huge pages of 2 MiB, which costs addresses, not memory. */
    double excess = taken - (double)t->memory_size;
    assert_true(excess > -0.01 * taken && excess < 0.01 * taken + 2 * (2 << 20));
    before = heap_size();
    run(t, 20);
    assert_true(fabs(heap_size() - before) < 65536); /* top levels over instances may breathe */
    trainer_free(t);
}

static void bad_options_are_refused(void **state)
{
    (void)state;
    struct error err;
    struct trainer *t = NULL;
    lmn_train_options o = tiny_options();
    o.memory_mib = 1;
    o.patch_size = 256;
    o.resolution_start = o.resolution_max = 256;
    assert_int_equal(trainer_new(&tiny.place, &o, &t, &err), LMN_ERR_ARGUMENT);
    assert_non_null(strstr(err.text, "memory_mib"));
    o = tiny_options();
    o.memory_mib = 1 << 20;
    o.replay_capacity = 100000000;
    assert_int_equal(trainer_new(&tiny.place, &o, &t, &err), LMN_ERR_MEMORY);
    assert_null(t);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(resolution_grows_at_the_start_of_epochs),
        cmocka_unit_test(training_lowers_the_loss),
        cmocka_unit_test(fresh_batches_hold_states_and_what_was_refused),
        cmocka_unit_test(baselines_do_what_they_say),
        cmocka_unit_test(position_layer_stays_cut_off),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(resuming_changes_nothing),
        cmocka_unit_test(resuming_counts_the_time_before),
        cmocka_unit_test(times_are_found_from_the_end),
        cmocka_unit_test(evaluation_goes_into_the_next_line),
        cmocka_unit_test(memory_is_reported),
        cmocka_unit_test(bad_options_are_refused),
    };
    return cmocka_run_group_tests_name("trainer", tests, tiny_setup, tiny_teardown);
}
