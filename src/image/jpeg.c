/* SPDX-License-Identifier: Apache-2.0 */
/* JPEG, baseline and progressive, through libjpeg-turbo. Read only. */
#include "image/codecs.h"

#include <string.h>

#include <turbojpeg.h>

#include "base/mem.h"

bool jpeg_is(const void *bytes, size_t size)
{
    return size >= 3 && memcmp(bytes, "\xff\xd8\xff", 3) == 0;
}

/* Whether the picture is whole all the same. Files in the wild often draw such warnings. Missing
 * pixels are a warning to the library, too, and an error after a warning still has a warning's
 * code: only the text tells. */
static bool is_harmless(const char *message)
{
    static const char *const texts[] = {"extraneous bytes before marker", "Invalid SOS parameters",
                                        "unknown JFIF revision", "Unknown Adobe color transform"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
        if (strstr(message, texts[i])) return true;
    return false;
}

lmn_status jpeg_decode(const char *path, const void *bytes, size_t size, struct bitmap *out,
                       struct error *err)
{
    lmn_status status = LMN_OK;
    struct bitmap b = {.is_srgb = true};
    int width = 0, height = 0, sampling = 0, space = 0;
    tjhandle tj = tjInitDecompress();
    if (!tj) {
        status = fail_memory(err, path);
        goto done;
    }
    if (tjDecompressHeader3(tj, bytes, size, &width, &height, &sampling, &space) != 0) {
        status = fail(err, LMN_ERR_PARSE, "%s: JPEG: %s", path, tjGetErrorStr2(tj));
        goto done;
    }
    if (width < 1 || height < 1) { /* what the library says of a file cut off before the frame */
        status = fail(err, LMN_ERR_PARSE, "%s: JPEG: file is truncated", path);
        goto done;
    }
    if (space == TJCS_CMYK || space == TJCS_YCCK) {
        status = fail(err, LMN_ERR_PARSE, "%s: CMYK JPEG images are not supported", path);
        goto done;
    }
    b.width = (uint32_t)width;
    b.height = (uint32_t)height;
    b.n_channels = space == TJCS_GRAY ? 1 : 3;
    TRY(codec_check_size(path, b.width, b.height, b.n_channels, 1, size, err));
    b.u8 = mem_new((size_t)b.width * b.height, b.n_channels);
    if (!b.u8) {
        status = fail_memory(err, path);
        goto done;
    }
    if (tjDecompress2(tj, bytes, size, b.u8, width, 0, height,
                      space == TJCS_GRAY ? TJPF_GRAY : TJPF_RGB, TJFLAG_LIMITSCANS) != 0 &&
        !is_harmless(tjGetErrorStr2(tj))) {
        status = fail(err, LMN_ERR_PARSE, "%s: JPEG: %s", path, tjGetErrorStr2(tj));
        goto done;
    }
    *out = b;
    b = (struct bitmap){0}; /* ownership moved to the caller */
done:
    if (tj) tjDestroy(tj);
    bitmap_release(&b);
    return status;
}
