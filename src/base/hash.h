/* SPDX-License-Identifier: Apache-2.0 */
#ifndef BASE_HASH_H
#define BASE_HASH_H

#include <stddef.h>
#include <stdint.h>

/* FNV-1a, 64 bits: recognises changed files; no defence against someone who wants a collision.
 * Start with HASH_START and feed pieces in order. */
#define HASH_START 0xCBF29CE484222325u

static inline uint64_t hash_bytes(uint64_t h, const void *bytes, size_t size)
{
    const unsigned char *b = bytes;
    for (size_t i = 0; i < size; i++) h = (h ^ b[i]) * 0x100000001B3u;
    return h;
}

#endif
