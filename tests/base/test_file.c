/* SPDX-License-Identifier: Apache-2.0 */
/* Reading whole files, and writing them so that a reader sees the old or the new one. */
#include "base/file.h"

#include <dirent.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "cmocka_all.h"

#include "base/mem.h"
#include "base/str.h"

static char folder[64], path[128];

static int setup(void **state)
{
    (void)state;
    strcpy(folder, "/tmp/lmn-test-XXXXXX");
    if (!mkdtemp(folder)) return -1;
    snprintf(path, sizeof path, "%s/file", folder);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    unlink(path);
    return rmdir(folder); /* fails when a temporary file is left */
}

static size_t count_files(void)
{
    size_t n = 0;
    DIR *d = opendir(folder);
    for (struct dirent *e; (e = readdir(d));) n += e->d_name[0] != '.';
    closedir(d);
    return n;
}

static void check_content(const char *want)
{
    char *text = NULL;
    size_t size = 0;
    struct error err = {0};
    if (file_read(path, 1000, &text, &size, &err) != LMN_OK) fail_msg("%s", err.text);
    assert_int_equal(size, strlen(want));
    assert_string_equal(text, want); /* it ends with a NUL */
    mem_free(text);
}

static void test_commit(void **state)
{
    (void)state;
    struct file_writer w;
    struct error err = {0};
    assert_int_equal(file_writer_open(&w, path, &err), LMN_OK);
    fputs("old", w.f);
    fflush(w.f);
    assert_int_not_equal(access(path, F_OK), 0); /* not there before the commit */
    assert_int_equal(file_writer_commit(&w, &err), LMN_OK);
    file_writer_release(&w);
    check_content("old");
    assert_int_equal(count_files(), 1);

    assert_int_equal(file_writer_open(&w, path, &err), LMN_OK);
    for (int i = 0; i < 100000; i++) fputs("new, unfinished", w.f);
    check_content("old");    /* the old one until the commit */
    file_writer_release(&w); /* and after giving up */
    check_content("old");
    assert_int_equal(count_files(), 1);

    assert_int_equal(file_writer_open(&w, path, &err), LMN_OK);
    fputs("new", w.f);
    assert_int_equal(file_writer_commit(&w, &err), LMN_OK);
    file_writer_release(&w);
    check_content("new");
    assert_int_equal(count_files(), 1);
}

static void test_write_failures(void **state)
{
    (void)state;
    struct file_writer w;
    struct error err = {0};
    assert_int_equal(file_writer_open(&w, "/nowhere/file", &err), LMN_ERR_IO);
    assert_string_equal(err.text, "/nowhere/file: cannot write: No such file or directory");
    file_writer_release(&w);
    /* a full disk shows at the commit */
    if (access("/dev/full", W_OK) == 0) {
        assert_int_equal(file_writer_open(&w, path, &err), LMN_OK);
        fclose(w.f);
        w.f = fopen("/dev/full", "wb");
        for (int i = 0; i < 10000; i++) fputs("0123456789", w.f);
        assert_int_equal(file_writer_commit(&w, &err), LMN_ERR_IO);
        assert_true(str_starts(err.text, path));
        file_writer_release(&w);
    }
    /* the folder is gone at the commit */
    char sub[160], inside[200];
    snprintf(sub, sizeof sub, "%s/sub", folder);
    snprintf(inside, sizeof inside, "%s/file", sub);
    assert_int_equal(mkdir(sub, 0700), 0);
    assert_int_equal(file_writer_open(&w, inside, &err), LMN_OK);
    assert_int_equal(unlink(w.temporary), 0);
    assert_int_equal(rmdir(sub), 0);
    assert_int_equal(file_writer_commit(&w, &err), LMN_ERR_IO);
    file_writer_release(&w);
    for (uint64_t n = 1; n <= 2; n++) {
        mem_fail_after(n);
        assert_int_equal(file_writer_open(&w, path, &err), LMN_ERR_MEMORY);
        mem_fail_after(0);
        file_writer_release(&w);
    }
}

static void test_read_failures(void **state)
{
    (void)state;
    char *text = NULL;
    size_t size = 0;
    struct error err = {0};
    char missing[160];
    snprintf(missing, sizeof missing, "%s/none", folder);
    assert_int_equal(file_read(missing, 10, &text, &size, &err), LMN_ERR_IO);
    assert_non_null(strstr(err.text, "/none: cannot open: No such file"));
    assert_int_equal(file_read(folder, 10, &text, &size, &err), LMN_ERR_IO);
    assert_non_null(strstr(err.text, "not a regular file"));
    assert_int_equal(file_read("/dev/zero", 10, &text, &size, &err), LMN_ERR_IO);
    FILE *f = fopen(path, "wb");
    fputs("eleven char", f);
    fclose(f);
    assert_int_equal(file_read(path, 10, &text, &size, &err), LMN_ERR_PARSE);
    assert_non_null(strstr(err.text, "file of 11 bytes is larger than the limit of 10"));
    assert_int_equal(file_read(path, 11, &text, &size, &err), LMN_OK);
    assert_true(size == 11 && text[11] == 0);
    mem_free(text);
    mem_fail_after(1);
    assert_int_equal(file_read(path, 11, &text, &size, &err), LMN_ERR_MEMORY);
    mem_fail_after(0);
}

/* A reader that looks all the time never sees a part. */
static void test_atomic(void **state)
{
    (void)state;
    enum { SIZE = 200000, ROUNDS = 30 };
    struct error err = {0};
    char *block = mem_new(SIZE + 1, 1);
    for (int round = 0; round < ROUNDS; round++) {
        struct file_writer w;
        memset(block, 'a' + round % 26, SIZE);
        assert_int_equal(file_writer_open(&w, path, &err), LMN_OK);
        for (size_t at = 0; at < SIZE; at += SIZE / 10) {
            fwrite(block + at, 1, SIZE / 10, w.f);
            fflush(w.f);
            char *text = NULL;
            size_t size = 0;
            if (round == 0) continue;
            assert_int_equal(file_read(path, SIZE, &text, &size, &err), LMN_OK);
            assert_true(size == SIZE && text[0] == text[SIZE - 1]);
            assert_true(text[0] == 'a' + (round - 1) % 26);
            mem_free(text);
        }
        assert_int_equal(file_writer_commit(&w, &err), LMN_OK);
        file_writer_release(&w);
    }
    mem_free(block);
}

/* A temporary file of a process that is no more goes; others stay. */
static void test_leftovers(void **state)
{
    (void)state;
    char names[5][160];
    pid_t child = fork();
    if (child == 0) _exit(0);
    assert_true(child > 0);
    assert_int_equal(waitpid(child, NULL, 0), child);
    snprintf(names[0], sizeof names[0], "%s.tmp%ld", path, (long)child);
    snprintf(names[1], sizeof names[1], "%s.tmp%ld", path, (long)getpid());
    snprintf(names[2], sizeof names[2], "%s.tmp%ldx", path, (long)child);
    snprintf(names[3], sizeof names[3], "%s.tmp", path);
    snprintf(names[4], sizeof names[4], "%s2.tmp%ld", path, (long)child);
    for (int i = 0; i < 5; i++) {
        FILE *f = fopen(names[i], "w");
        assert_non_null(f);
        fclose(f);
    }
    const size_t before = count_files();
    file_remove_leftovers(path);
    assert_int_equal(access(names[0], F_OK), -1);
    assert_int_equal(count_files(), before - 1);
    file_remove_leftovers("/nowhere/at/all");
    for (int i = 1; i < 5; i++) assert_int_equal(unlink(names[i]), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_commit, setup, teardown),
        cmocka_unit_test_setup_teardown(test_write_failures, setup, teardown),
        cmocka_unit_test_setup_teardown(test_read_failures, setup, teardown),
        cmocka_unit_test_setup_teardown(test_atomic, setup, teardown),
        cmocka_unit_test_setup_teardown(test_leftovers, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
