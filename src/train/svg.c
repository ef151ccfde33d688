/* SPDX-License-Identifier: Apache-2.0 */
#include "train/svg.h"

#include <math.h>

#include "base/file.h"

void svg_add_fixed(struct str *s, double v, int decimals)
{
    long long scale = 1, n;
    for (int i = 0; i < decimals; i++) scale *= 10;
    n = llround(fmin(fabs(v), 1e12) * (double)scale);
    str_add(s, "%s%lld", v < 0 && n > 0 ? "-" : "", n / scale);
    if (decimals > 0) str_add(s, ".%0*lld", decimals, n % scale);
}

void svg_add_count(struct str *s, double v, double high)
{
    double unit = high >= 1e6 ? 1e6 : high >= 1e4 ? 1e3 : 1;
    int decimals = 0;
    v /= unit;
    while (decimals < 3 && fabs(v * pow(10, decimals) - round(v * pow(10, decimals))) > 1e-6)
        decimals++;
    svg_add_fixed(s, v, decimals);
    if (v > 0 && unit > 1) str_add(s, unit == 1e6 ? "M" : "k");
}

void svg_add_duration(struct str *s, double seconds)
{
    static const struct {
        double size;
        const char *name;
    } units[] = {{3600, "h"}, {60, "min"}, {1, "s"}};
    for (int i = 0; i < 3; i++) {
        double v = seconds / units[i].size;
        if (v < 1.5 && i < 2) continue;
        svg_add_fixed(s, v, v < 9.95 && v > 0 ? 1 : 0);
        str_add(s, " %s", units[i].name);
        return;
    }
}

void svg_add_escaped(struct str *s, const char *text)
{
    for (const unsigned char *c = (const unsigned char *)text; *c; c++) {
        switch (*c) {
        case '&':
            str_add(s, "&amp;");
            break;
        case '<':
            str_add(s, "&lt;");
            break;
        case '>':
            str_add(s, "&gt;");
            break;
        case '"':
            str_add(s, "&quot;");
            break;
        default:
            if (*c >= 0x20) str_add_bytes(s, c, 1); /* XML knows no control characters */
        }
    }
}

void svg_begin_text(struct str *s, double x, double y, const char *anchor, const char *css)
{
    str_add(s, "<text class=\"%s\" text-anchor=\"%s\" x=\"", css, anchor);
    svg_add_fixed(s, x, 1);
    str_add(s, "\" y=\"");
    svg_add_fixed(s, y, 1);
    str_add(s, "\">");
}

void svg_add_text(struct str *s, double x, double y, const char *anchor, const char *css,
                  const char *text)
{
    svg_begin_text(s, x, y, anchor, css);
    svg_add_escaped(s, text);
    str_add(s, "</text>\n");
}

void svg_add_line(struct str *s, double x0, double y0, double x1, double y1, const char *css)
{
    str_add(s, "<path class=\"%s\" d=\"M", css);
    svg_add_fixed(s, x0, 1);
    str_add(s, " ");
    svg_add_fixed(s, y0, 1);
    str_add(s, "L");
    svg_add_fixed(s, x1, 1);
    str_add(s, " ");
    svg_add_fixed(s, y1, 1);
    str_add(s, "\"/>\n");
}

lmn_status svg_write_page(const struct str *body, int width, int height, const char *path,
                          struct error *err)
{
    lmn_status status = LMN_OK;
    struct file_writer w = {0};
    if (body->failed) return fail_memory(err, "a plot");
    TRY(file_writer_open(&w, path, err));
    fprintf(w.f, /* a short write shows at the commit */
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %d %d\" width=\"%d\" "
            "height=\"%d\">\n"
            "<style>text{font-family:Helvetica,Arial,'DejaVu Sans',sans-serif;fill:#212529}"
            ".head{font-size:18px;font-weight:bold}.title{font-size:14px;font-weight:bold}"
            ".label{font-size:12px}.tick{font-size:11px;fill:#5c636a}"
            ".grid{stroke:#e3e6e8;fill:none}.axis{stroke:#868e96;fill:none}</style>\n"
            "<rect width=\"100%%\" height=\"100%%\" rx=\"8\" fill=\"#ffffff\"/>\n",
            width, height, width, height);
    fwrite(body->text, 1, body->length, w.f);
    fputs("</svg>\n", w.f);
    TRY(file_writer_commit(&w, err));
done:
    file_writer_release(&w);
    return status;
}
