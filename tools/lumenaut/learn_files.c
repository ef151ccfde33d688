/* SPDX-License-Identifier: Apache-2.0 */
/* Files and folders of bench learn. */
#include "learn.h"

#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

void learn_path(char out[LEARN_PATH], const char *format, ...)
{
    va_list list;
    va_start(list, format);
    vsnprintf(out, LEARN_PATH, format, list);
    va_end(list);
}

int learn_make_folder(struct app *app, const char *path)
{
    char part[LEARN_PATH];
    struct stat s;
    learn_path(part, "%s", path);
    for (char *c = part + 1;; c++) {
        const char kept = *c;
        if (kept != '/' && kept != '\0') continue;
        *c = '\0';
        if (mkdir(part, 0777) != 0 && errno != EEXIST)
            return app_error(app, EXIT_FAILED, "%s: cannot make the folder: %s", part,
                             strerror(errno));
        *c = kept;
        if (kept == '\0') break;
    }
    if (stat(part, &s) == 0 && S_ISDIR(s.st_mode)) return EXIT_OK;
    return app_error(app, EXIT_FAILED, "%s: is no folder", path);
}

int learn_lock(struct app *app, const char *folder, int *lock)
{
    char path[LEARN_PATH];
    learn_path(path, "%s/.lock", folder);
    *lock = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (*lock < 0)
        return app_error(app, EXIT_FAILED, "%s: cannot write: %s", path, strerror(errno));
    if (flock(*lock, LOCK_EX | LOCK_NB) == 0) return EXIT_OK;
    const int reason = errno;
    close(*lock);
    *lock = -1;
    if (reason == EWOULDBLOCK)
        return app_error(app, EXIT_FAILED, "%s: another bench learn is at work there", folder);
    return app_error(app, EXIT_FAILED, "%s: cannot lock: %s", path, strerror(reason));
}

int learn_save_text(struct app *app, const char *path, const char *text, size_t size)
{
    char temporary[LEARN_PATH];
    learn_path(temporary, "%s.part", path);
    FILE *f = fopen(temporary, "w");
    bool is_good = f && fwrite(text, 1, size, f) == size && fflush(f) == 0 && fsync(fileno(f)) == 0;
    if (f && fclose(f) != 0) is_good = false;
    if (is_good && rename(temporary, path) == 0) return EXIT_OK;
    const int reason = errno;
    if (f) unlink(temporary);
    return app_error(app, EXIT_FAILED, "%s: cannot write: %s", path, strerror(reason));
}

char *learn_load_text(const char *path)
{
    char *text = NULL;
    size_t size = 0;
    FILE *f = fopen(path, "r");
    if (!f) return NULL;
    const ssize_t n = getdelim(&text, &size, '\0', f); /* a text holds no such byte */
    fclose(f);
    if (n > 0) return text;
    free(text);
    return NULL;
}

void learn_picture_size(const lmn_scene *scene, uint32_t longer, uint32_t size[2])
{
    lmn_scene_info info;
    lmn_scene_get_info(scene, &info);
    const double w = info.width ? info.width : 1.0, h = info.height ? info.height : 1.0;
    const double scale = longer / (w > h ? w : h);
    size[0] = (uint32_t)(w * scale + 0.5);
    size[1] = (uint32_t)(h * scale + 0.5);
    if (size[0] == 0) size[0] = 1;
    if (size[1] == 0) size[1] = 1;
}

bool learn_read_channels(lmn_image *image, const char *prefix, float *out)
{
    const uint32_t n = lmn_image_n_channels(image);
    const size_t n_pixels = (size_t)lmn_image_width(image) * lmn_image_height(image);
    const float *data = lmn_image_data(image);
    char name[16];
    for (uint32_t k = 0; k < 3; k++) {
        uint32_t c = 0;
        snprintf(name, sizeof name, "%s%c", prefix, "RGB"[k]);
        while (c < n && strcmp(lmn_image_channel_name(image, c), name) != 0) c++;
        if (c == n) return false;
        for (size_t i = 0; i < n_pixels; i++) out[3 * i + k] = data[i * n + c];
    }
    return true;
}

lmn_status learn_trace(struct app *app, const lmn_scene *scene, const double *values,
                       const uint32_t size[2], uint32_t spp, uint64_t seed, const char *integrator,
                       lmn_image **out)
{
    const lmn_trace_options o = {.struct_size = sizeof o,
                                 .width = size[0],
                                 .height = size[1],
                                 .spp = spp,
                                 .seed = seed,
                                 .half_buffers = 1,
                                 .integrator = integrator};
    return lmn_scene_trace(app->context, scene, values, &o, out, NULL);
}
