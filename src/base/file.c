/* SPDX-License-Identifier: Apache-2.0 */
#include "base/file.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/mem.h"
#include "base/str.h"

lmn_status file_read(const char *path, size_t max_size, char **out, size_t *size, struct error *err)
{
    lmn_status status = LMN_OK;
    char *text = NULL;
    struct stat st;
    /* Without O_NONBLOCK, opening a pipe waits for a writer, perhaps for ever. */
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    FILE *f = fd >= 0 ? fdopen(fd, "rb") : NULL;
    if (!f) {
        status = fail(err, LMN_ERR_IO, "%s: cannot open: %s", path, strerror(errno));
        if (fd >= 0) close(fd);
        goto done;
    }
    if (fstat(fd, &st) != 0 || !S_ISREG(st.st_mode)) {
        status = fail(err, LMN_ERR_IO, "%s: not a regular file", path);
        goto done;
    }
    if ((uint64_t)st.st_size > max_size) {
        status = fail(err, LMN_ERR_PARSE, "%s: file of %lld bytes is larger than the limit of %zu",
                      path, (long long)st.st_size, max_size);
        goto done;
    }
    text = mem_new((size_t)st.st_size + 1, 1);
    if (!text) {
        status = fail_memory(err, path);
        goto done;
    }
    *size = fread(text, 1, (size_t)st.st_size, f);
    if (*size != (size_t)st.st_size) {
        status = fail(err, LMN_ERR_IO, "%s: cannot read: %s", path,
                      ferror(f) ? strerror(errno) : "file changed while being read");
        goto done;
    }
    *out = text;
    text = NULL; /* ownership moved to the caller */
done:
    mem_free(text);
    if (f) fclose(f);
    return status;
}

lmn_status file_writer_open(struct file_writer *w, const char *path, struct error *err)
{
    *w = (struct file_writer){0};
    if (strcmp(path, "-") == 0) {
        w->f = stdout;
        return LMN_OK;
    }
    struct str name = {0};
    str_add(&name, "%s.tmp%ld", path, (long)getpid());
    w->path = mem_strdup(path);
    w->temporary = name.text;
    if (name.failed || !w->path) return fail_memory(err, path);
    w->f = fopen(w->temporary, "wb");
    if (!w->f) return fail(err, LMN_ERR_IO, "%s: cannot write: %s", path, strerror(errno));
    return LMN_OK;
}

lmn_status file_writer_commit(struct file_writer *w, struct error *err)
{
    if (w->f == stdout) {
        w->f = NULL;
        if (fflush(stdout) == 0) return LMN_OK;
        return fail(err, LMN_ERR_IO, "standard output: cannot write: %s", strerror(errno));
    }
    FILE *f = w->f;
    w->f = NULL;
    int bad = ferror(f) || fflush(f) != 0 || fsync(fileno(f)) != 0;
    bad |= fclose(f) != 0;
    if (bad || rename(w->temporary, w->path) != 0)
        return fail(err, LMN_ERR_IO, "%s: cannot write: %s", w->path, strerror(errno));
    mem_free(w->temporary);
    w->temporary = NULL;
    return LMN_OK;
}

void file_writer_release(struct file_writer *w)
{
    if (w->f && w->f != stdout) fclose(w->f);
    if (w->temporary) unlink(w->temporary);
    mem_free(w->temporary);
    mem_free(w->path);
    *w = (struct file_writer){0};
}

/* "NAME.tmp123" of a process 123 that is no more. */
static bool is_leftover(const char *entry, const char *name)
{
    const size_t n = strlen(name);
    char *end;
    if (strncmp(entry, name, n) != 0 || strncmp(entry + n, ".tmp", 4) != 0) return false;
    const char *digits = entry + n + 4;
    const long pid = strtol(digits, &end, 10);
    return *digits >= '1' && *digits <= '9' && *end == '\0' && pid > 0 &&
           kill((pid_t)pid, 0) != 0 && errno == ESRCH;
}

void file_remove_leftovers(const char *path)
{
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    struct str folder = {0};
    str_add(&folder, "%.*s", slash ? (int)(slash - path) + 1 : 2, slash ? path : "./");
    DIR *d = folder.failed ? NULL : opendir(folder.text);
    for (struct dirent *e; d && (e = readdir(d)) != NULL;)
        if (is_leftover(e->d_name, name)) unlinkat(dirfd(d), e->d_name, 0);
    if (d) closedir(d);
    str_release(&folder);
}
