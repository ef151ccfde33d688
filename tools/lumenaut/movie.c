/* SPDX-License-Identifier: Apache-2.0 */
#include "movie.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* The only number that a pattern may ask for: %d, %4d or %04d. */
static bool is_pattern(const char *name)
{
    const char *at = strchr(name, '%');
    if (!at) return false;
    at++;
    if (*at == '0') at++;
    if (*at >= '1' && *at <= '9') at++;
    return *at == 'd' && !strchr(at, '%');
}

static bool ends_with(const char *text, const char *end)
{
    const size_t n = strlen(text), m = strlen(end);
    return n >= m && strcmp(text + n - m, end) == 0;
}

/* The name of a file, of which is_pattern() is true. */
static void name_of(const char *pattern, uint32_t frame, char *to, size_t size)
{
    const char *at = strchr(pattern, '%'), *end = strchr(at, 'd');
    const bool has_zeros = at[1] == '0';
    const int width = end > at + 1 && end[-1] != '0' ? end[-1] - '0' : 0;
    char number[24];
    snprintf(number, sizeof number, has_zeros ? "%0*u" : "%*u", width, frame);
    snprintf(to, size, "%.*s%s%s", (int)(at - pattern), pattern, number, end + 1);
}

int movie_init(struct movie *m, struct app *app, const struct picture_args *picture)
{
    const char *output = picture->output;
    char first[700];
    *m = (struct movie){.picture = picture};
    if (!output) return app_error(app, EXIT_USAGE, "no output: give -o NAME_%%04d.png or NAME.y4m");
    m->is_stream = picture->format ? strcmp(picture->format, "y4m") == 0
                                   : ends_with(output, ".y4m");
    if (picture->json && strcmp(output, "-") == 0)
        return app_error(app, EXIT_USAGE, "--json and -o - both want standard output");
    if (m->is_stream) return strcmp(output, "-") == 0 ? EXIT_OK : app_check_output(app, output);
    if (strlen(output) >= sizeof m->pattern || !is_pattern(output))
        return app_error(app, EXIT_USAGE,
                         "-o %s: frames of a path need a number in their names, as "
                         "frame_%%04d.png, or one stream: NAME.y4m",
                         output);
    snprintf(m->pattern, sizeof m->pattern, "%s", output);
    name_of(m->pattern, 0, first, sizeof first);
    return app_check_image(app, first, picture->format);
}

/* ---- YUV4MPEG2 ------------------------------------------------------------------------------- */

static uint8_t byte_of(double x)
{
    return (uint8_t)(x < 0 ? 0 : x > 255 ? 255 : x + 0.5);
}

/* BT.709 of sRGB bytes, limited range: planes [3][n]. */
static void split_planes(const uint8_t *rgb, size_t n, uint8_t *planes)
{
    for (size_t i = 0; i < n; i++, rgb += 3) {
        const double r = rgb[0], g = rgb[1], b = rgb[2];
        const double y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        planes[i] = byte_of(16.0 + y * (219.0 / 255.0));
        planes[n + i] = byte_of(128.0 + (b - y) * (224.0 / 255.0 / 1.8556));
        planes[2 * n + i] = byte_of(128.0 + (r - y) * (224.0 / 255.0 / 1.5748));
    }
}

static int refuse_stream(const struct movie *m, struct app *app)
{
    return app_error(app, EXIT_FAILED, "%s: cannot write: %s", m->picture->output, strerror(errno));
}

static int open_stream(struct movie *m, struct app *app, const struct camera_path *path,
                       const lmn_image *image)
{
    const char *output = m->picture->output;
    m->stream = strcmp(output, "-") == 0 ? stdout : fopen(output, "wb");
    if (!m->stream ||
        fprintf(m->stream, "YUV4MPEG2 W%u H%u F%ld:1000 Ip A1:1 C444 XCOLORRANGE=LIMITED\n",
                lmn_image_width(image), lmn_image_height(image),
                (long)(1000 * path->fps + 0.5)) < 0)
        return refuse_stream(m, app);
    return EXIT_OK;
}

static int add_to_stream(struct movie *m, struct app *app, const struct camera_path *path,
                         const lmn_image *image)
{
    const size_t n = (size_t)lmn_image_width(image) * lmn_image_height(image);
    uint8_t *rgb = malloc(n * 3), *planes = malloc(n * 3);
    int code = rgb && planes ? EXIT_OK : app_error(app, EXIT_FAILED, "out of memory");
    if (code == EXIT_OK && !m->stream) code = open_stream(m, app, path, image);
    if (code == EXIT_OK &&
        lmn_image_tone(app->context, image, m->picture->exposure, LMN_TONE_SRGB, rgb) != LMN_OK)
        code = app_failed(app, LMN_ERR_ARGUMENT, BLAME_USER);
    if (code == EXIT_OK) {
        split_planes(rgb, n, planes);
        if (fputs("FRAME\n", m->stream) < 0 || fwrite(planes, 1, n * 3, m->stream) != n * 3)
            code = refuse_stream(m, app);
    }
    free(rgb);
    free(planes);
    return code;
}

/* ---- Frames ---------------------------------------------------------------------------------- */

int movie_add(struct movie *m, struct app *app, const struct camera_path *path, uint32_t frame,
              const lmn_image *image)
{
    char name[700];
    if (m->is_stream) return add_to_stream(m, app, path, image);
    name_of(m->pattern, frame, name, sizeof name);
    const lmn_status status = lmn_image_save(app->context, image, name, m->picture->format,
                                             m->picture->exposure);
    return status == LMN_OK ? EXIT_OK : app_failed(app, status, BLAME_WORK);
}

int movie_end(struct movie *m, struct app *app, const struct camera_path *path)
{
    FILE *f = m->stream;
    m->stream = NULL;
    if (f && ((f == stdout ? fflush(f) : fclose(f)) != 0)) return refuse_stream(m, app);
    if (!m->is_stream)
        app_say(app, "a film: ffmpeg -framerate %g -i %s -pix_fmt yuv420p movie.mp4", path->fps,
                m->pattern);
    else if (strcmp(m->picture->output, "-") != 0)
        app_say(app, "a film: ffmpeg -i %s -pix_fmt yuv420p movie.mp4", m->picture->output);
    return EXIT_OK;
}
