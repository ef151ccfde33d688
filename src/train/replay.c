/* SPDX-License-Identifier: Apache-2.0 */
#include "train/replay.h"

#include <math.h>
#include <string.h>

#include "base/mem.h"
#include "nn/generator.h"

enum { MAX_CAPACITY = 1 << 28 };

size_t replay_patch_size(uint32_t n_pixels, uint32_t n_variables)
{
    return ((size_t)n_pixels * (GENERATOR_INPUTS + 3) + n_variables + 1) * sizeof(float) +
           sizeof(bool) + 2 * sizeof(double); /* the tree has about two nodes a leaf */
}

lmn_status replay_init(struct replay *m, uint32_t capacity, uint32_t n_pixels, uint32_t n_variables,
                       struct error *err)
{
    if (capacity > MAX_CAPACITY)
        return fail(err, LMN_ERR_ARGUMENT, "cannot remember more than %d patches", MAX_CAPACITY);
    *m = (struct replay){
        .capacity = capacity, .n_pixels = n_pixels, .n_variables = n_variables, .n_leaves = 1};
    while (m->n_leaves < capacity) m->n_leaves *= 2;
    size_t n_inputs = (size_t)n_pixels * GENERATOR_INPUTS, n_targets = (size_t)n_pixels * 3;
    m->inputs = mem_new(capacity, n_inputs * sizeof *m->inputs);
    m->targets = mem_new(capacity, n_targets * sizeof *m->targets);
    m->v = mem_new(capacity, n_variables * sizeof *m->v);
    m->losses = mem_new(capacity, sizeof *m->losses);
    m->is_large = mem_new(capacity, sizeof *m->is_large);
    m->sums = mem_new(2 * (size_t)m->n_leaves, sizeof *m->sums);
    if (!m->inputs || !m->targets || !m->v || !m->losses || !m->is_large || !m->sums) {
        replay_release(m);
        return fail(err, LMN_ERR_MEMORY, "not enough memory to remember %u patches", capacity);
    }
    size_t patch = (n_inputs + n_targets + n_variables + 1) * sizeof(float) + sizeof(bool);
    m->memory_size = capacity * (uint64_t)patch + 2 * (uint64_t)m->n_leaves * sizeof *m->sums;
    return LMN_OK;
}

void replay_release(struct replay *m)
{
    mem_free(m->inputs);
    mem_free(m->targets);
    mem_free(m->v);
    mem_free(m->losses);
    mem_free(m->is_large);
    mem_free(m->sums);
    *m = (struct replay){0};
}

uint64_t replay_add(struct replay *m, const float *inputs, const float *targets, const float *v,
                    float loss, bool is_large)
{
    uint64_t serial = m->n_added++;
    if (m->capacity == 0) return serial;
    uint32_t slot = (uint32_t)(serial % m->capacity);
    size_t n_inputs = (size_t)m->n_pixels * GENERATOR_INPUTS, n_targets = (size_t)m->n_pixels * 3;
    memcpy(m->inputs + slot * n_inputs, inputs, n_inputs * sizeof *inputs);
    memcpy(m->targets + slot * n_targets, targets, n_targets * sizeof *targets);
    if (m->n_variables > 0)
        memcpy(m->v + (size_t)slot * m->n_variables, v, m->n_variables * sizeof *v);
    m->is_large[slot] = is_large;
    if (m->n < m->capacity) m->n++;
    replay_set_loss(m, slot, loss);
    return serial;
}

uint32_t replay_slot(const struct replay *m, uint64_t serial)
{
    bool is_held = serial < m->n_added && m->n_added - serial <= m->n;
    return is_held ? (uint32_t)(serial % m->capacity) : UINT32_MAX;
}

void replay_set_loss(struct replay *m, uint32_t slot, float loss)
{
    m->losses[slot] = loss > 0.0f && isfinite(loss) ? loss : 0.0f;
    uint32_t node = m->n_leaves + slot;
    m->sums[node] = m->losses[slot];
    while (node > 1) {
        node /= 2;
        m->sums[node] = m->sums[2 * node] + m->sums[2 * node + 1];
    }
}

uint32_t replay_draw(const struct replay *m, struct rng *r)
{
    double x = rng_double(r) * m->sums[1];
    if (!(m->sums[1] > 0)) return rng_below(r, m->n);
    uint32_t node = 1;
    while (node < m->n_leaves) {
        node *= 2;
        /* Rounding can bring x to the very end of a sum: never step into an empty half. */
        if (x < m->sums[node] || !(m->sums[node + 1] > 0)) continue;
        x -= m->sums[node];
        node++;
    }
    return node - m->n_leaves;
}

void replay_rebuild(struct replay *m)
{
    for (uint32_t i = 0; i < m->n_leaves; i++)
        m->sums[m->n_leaves + i] = i < m->n ? m->losses[i] : 0.0;
    for (uint32_t i = m->n_leaves - 1; i >= 1; i--)
        m->sums[i] = m->sums[2 * i] + m->sums[2 * i + 1];
}
