/* SPDX-License-Identifier: Apache-2.0 */
/* Files that are cut off, damaged or lie about their size: one line that starts with the path, no
 * crash, no more memory than the file justifies; and every allocation failing in turn. */
#include "image/image.h"

#include <sys/resource.h>

#include <turbojpeg.h>

#include "cmocka_all.h"
#include "temp.h"

#include "base/file.h"
#include "base/mem.h"
#include "base/rng.h"
#include "base/str.h"

struct file {
    const char *name;
    char *bytes;
    size_t size;
};

enum { N_FILES = 7 };
static struct file files[N_FILES];

static void add_file(int i, const char *name, const char *path)
{
    struct error err = {0};
    files[i].name = name;
    if (file_read(path, 1 << 20, &files[i].bytes, &files[i].size, &err) != LMN_OK)
        fail_msg("%s", err.text);
}

/* One small good file of each kind. */
static int setup(void **state)
{
    if (temp_setup(state) != 0) return -1;
    struct image im;
    char path[512];
    if (image_init(&im, 11, 9, 3, NULL, NULL) != LMN_OK) return -1;
    for (int i = 0; i < 11 * 9 * 3; i++) im.data[i] = (float)(i % 97) / 97;
    if (image_set_attribute(&im, "seed", "1", NULL) != LMN_OK) return -1;
    static const char *const written[] = {"a.exr", "a.png", "a.pfm"};
    for (int i = 0; i < 3; i++) {
        if (image_save(&im, temp_path(written[i]), NULL, 1, NULL) != LMN_OK) return -1;
        add_file(i, written[i], temp_path(written[i]));
        unlink(temp_path(written[i]));
    }
    static const char *const kept[] = {"piz", "b44a", "tiled_zip"};
    for (int i = 0; i < 3; i++) {
        snprintf(path, sizeof path, "%s/tests/image/data/%s.exr", LMN_SOURCE_DIR, kept[i]);
        add_file(3 + i, "a.exr", path);
    }
    uint8_t grey[64 * 48];
    for (int i = 0; i < 64 * 48; i++) grey[i] = (uint8_t)(i * 7);
    unsigned char *jpeg = NULL;
    unsigned long size = 0;
    tjhandle tj = tjInitCompress();
    if (tjCompress2(tj, grey, 64, 0, 48, TJPF_GRAY, &jpeg, &size, TJSAMP_GRAY, 80,
                    TJFLAG_PROGRESSIVE) != 0)
        return -1;
    add_file(6, "a.jpg", temp_write("a.jpg", jpeg, size));
    unlink(temp_path("a.jpg"));
    tjFree(jpeg);
    tjDestroy(tj);
    image_release(&im);
    return 0;
}

static int teardown(void **state)
{
    for (int i = 0; i < N_FILES; i++) mem_free(files[i].bytes);
    return temp_teardown(state);
}

/* Loads in both ways. Returns whether the image was good; else checks what was said. */
static bool try_load(const char *name, const void *bytes, size_t size)
{
    struct image im;
    struct bitmap b;
    struct error err = {0};
    const char *path = temp_write(name, bytes, size);
    lmn_status status = image_load(path, &im, &err);
    if (status != LMN_OK) {
        assert_true(status == LMN_ERR_PARSE || status == LMN_ERR_MEMORY);
        if (!str_starts(err.text, path) || strlen(err.text) < strlen(path) + 8)
            fail_msg("message without path or reason: %s", err.text);
        for (const char *c = err.text; *c; c++) assert_true((unsigned char)*c >= 0x20);
        assert_null(im.data);
    }
    image_release(&im);
    if (bitmap_load(path, &b, &err) != LMN_OK) assert_true(!b.u8 && !b.f32);
    bitmap_release(&b);
    unlink(path);
    return status == LMN_OK;
}

static void test_truncated(void **state)
{
    (void)state;
    for (int i = 0; i < N_FILES; i++) {
        const struct file *f = &files[i];
        assert_true(try_load(f->name, f->bytes, f->size));
        size_t n_good = 0;
        for (size_t size = 0; size < f->size; size += size < 700 ? 1 : 53)
            n_good += try_load(f->name, f->bytes, size);
        /* a JPEG may lose its end mark; all else is needed */
        if (n_good > (i == 6 ? 2 : 0))
            fail_msg("%s %d: %zu cut files are good", f->name, i, n_good);
    }
}

static void test_damaged(void **state)
{
    (void)state;
    for (int i = 0; i < N_FILES; i++) {
        const struct file *f = &files[i];
        char *copy = mem_new(f->size, 1);
        for (uint64_t trial = 0; trial < 600; trial++) {
            struct rng r = rng_keyed(3, (uint64_t)i, trial);
            memcpy(copy, f->bytes, f->size);
            /* headers are where damage matters most */
            uint32_t reach = trial % 2 && f->size > 400 ? 400 : (uint32_t)f->size;
            for (uint32_t k = 1 + rng_below(&r, 4); k > 0; k--)
                copy[rng_below(&r, reach)] = (char)rng_u32(&r);
            try_load(f->name, copy, f->size);
        }
        mem_free(copy);
    }
}

static void check_message(const char *name, const void *bytes, size_t size, const char *message)
{
    struct image im;
    struct error err = {0};
    const char *path = temp_write(name, bytes, size);
    assert_int_equal(image_load(path, &im, &err), LMN_ERR_PARSE);
    if (!strstr(err.text, message)) fail_msg("\"%s\" lacks \"%s\"", err.text, message);
    unlink(path);
}

#define CHECK_TEXT(name, text, message) check_message(name, text, sizeof(text) - 1, message)

static void test_lies(void **state)
{
    (void)state;
    CHECK_TEXT("a.png", "", "a.png: empty file");
    CHECK_TEXT("a.png", "hello there", "a.png: not an image that can be read");
    CHECK_TEXT("a.pfm", "PF\n1", "PFM header is truncated");
    CHECK_TEXT("a.pfm", "PF\n3 4\n-1", "PFM header is truncated");
    CHECK_TEXT("a.pfm", "PF\n3 x\n-1\n", "PFM header is truncated or malformed");
    CHECK_TEXT("a.pfm", "PF\n3 -4\n-1\n", "makes no sense");
    CHECK_TEXT("a.pfm", "PF\n3 4\n0\n", "makes no sense");
    CHECK_TEXT("a.pfm", "PF\n3 4\nnan\n", "malformed");
    CHECK_TEXT("a.pfm", "PF\n0 4\n-1\n", "image without pixels");
    CHECK_TEXT("a.pfm", "PF\n99999 4\n-1\n", "a side can have 32768 at most");
    CHECK_TEXT("a.pfm", "PF\n1e5000 4\n-1\n", "malformed");
    CHECK_TEXT("a.pfm", "PF\n32768 32768\n-1\n", "too large");
    CHECK_TEXT("a.pfm", "PF\n10000 10000\n-1\n", "is too short for 10000x10000 pixels");
    CHECK_TEXT("a.pfm", "PF\n2 2\n-1\n01234567", "file ends after 8 of 48 bytes of pixels");
    CHECK_TEXT("a.pfm", "Pf 333333333333333333333333333333333333333333 1 1\n", "malformed");
    /* a PNG of 2^31 - 1 by 20000 pixels, with a right checksum and the start of some data */
    CHECK_TEXT("a.png",
               "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\x7f\xff\xff\xff\0\0\x4e\x20\x08\x02\0\0\0"
               "\xf7\x90\x7c\x3d\0\0\0\x09IDAT",
               "a.png: image of 2147483647x20000 pixels; a side can have 32768 at most");
    CHECK_TEXT("a.jpg", "\xff\xd8\xff\xe0\0\x04xx", "a.jpg: JPEG: ");
    CHECK_TEXT("a.exr", "\x76\x2f\x31\x01\x02\0\0\0", "a.exr: OpenEXR: ");

    struct image im;
    struct error err = {0};
    assert_int_equal(image_load("/nowhere/a.png", &im, &err), LMN_ERR_IO);
    assert_string_equal(err.text, "/nowhere/a.png: cannot open: No such file or directory");
    assert_int_equal(image_load("/tmp", &im, &err), LMN_ERR_IO);
    assert_string_equal(err.text, "/tmp: not a regular file");
}

/* A header that claims a large image, in a file of a few hundred bytes, takes no memory. */
static void test_large_claims(void **state)
{
    (void)state;
    struct rusage before, after;
    getrusage(RUSAGE_SELF, &before);
    struct file f = files[0];
    char *copy = mem_new(f.size, 1);
    memcpy(copy, f.bytes, f.size);
    for (size_t i = 0; i + 36 < f.size; i++) {
        /* "dataWindow" NUL "box2i" NUL size 16, then four integers */
        if (memcmp(copy + i, "dataWindow\0box2i\0\x10\0\0\0", 21) != 0) continue;
        memcpy(copy + i + 21 + 8, "\xff\x7f\0\0\xff\x7f\0\0", 8);
        assert_false(try_load("a.exr", copy, f.size));
        memcpy(copy + i + 21, "\0\0\0\x80\0\0\0\x80\xff\xff\xff\x7f\xff\xff\xff\x7f", 16);
        assert_false(try_load("a.exr", copy, f.size));
        break;
    }
    mem_free(copy);
    f = files[1];
    copy = mem_new(f.size, 1);
    memcpy(copy, f.bytes, f.size);
    memcpy(copy + 16, "\0\0\x4e\x20\0\0\x4e\x20", 8); /* the checksum is wrong then, too */
    assert_false(try_load("a.png", copy, f.size));
    mem_free(copy);
    getrusage(RUSAGE_SELF, &after);
    assert_true(after.ru_maxrss - before.ru_maxrss < 64 * 1024); /* KiB */
}

static void test_memory(void **state)
{
    (void)state;
    struct image im;
    char path[128], saved[128];
    for (int i = 0; i < N_FILES; i++) {
        snprintf(path, sizeof path, "%s", temp_write(files[i].name, files[i].bytes, files[i].size));
        lmn_status status = LMN_ERR_MEMORY;
        for (uint64_t n = 1; status != LMN_OK; n++) {
            struct error err = {0};
            assert_true(n < 2000);
            mem_fail_after(n);
            status = image_load(path, &im, &err);
            mem_fail_after(0);
            if (status != LMN_OK) assert_true(err.text[0] && !im.data);
        }
        unlink(path);
        static const char *const formats[] = {"b.exr", "b.png", "b.pfm"};
        for (int k = 0; k < 3; k++) {
            if (k == 1 && image_channel(&im, "R") < 0 && image_channel(&im, "Y") < 0) continue;
            snprintf(saved, sizeof saved, "%s", temp_path(formats[k]));
            status = LMN_ERR_MEMORY;
            for (uint64_t n = 1; status != LMN_OK; n++) {
                struct error err = {0};
                assert_true(n < 2000);
                mem_fail_after(n);
                status = image_save(&im, saved, NULL, 1, &err);
                mem_fail_after(0);
                if (status != LMN_OK) assert_int_equal(access(saved, F_OK), -1);
            }
            unlink(saved);
        }
        image_release(&im);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_truncated), cmocka_unit_test(test_damaged),
        cmocka_unit_test(test_lies),      cmocka_unit_test(test_large_claims),
        cmocka_unit_test(test_memory),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
