# SPDX-License-Identifier: Apache-2.0
"""Plugins of Mitsuba 0.x that Mitsuba 3 lacks, written anew in Python for Mitsuba 3: register(mi).

From the formulas of the papers and of the 0.6 manual, not from our C code, so that both can be
compared: phong (Lafortune and Willems 1994), blinnphong (Blinn's lobe normalised as by Gotanda and
Giesen), roughdiffuse (Oren and Nayar 1994, their full formula), mixturebsdf, gridtexture, scale.
Directions are drawn by the cosine, which is plain and always right; mixtures draw by their parts.
"""
import math
import xml.etree.ElementTree as ElementTree

import numpy as np


def as_mixtures(text):
    """The XML text with blends by a number as mixtures."""
    root = ElementTree.fromstring(text)
    for bsdf in root.iter("bsdf"):
        if bsdf.get("type") != "blendbsdf":
            continue
        bsdf.set("type", "mixturebsdf")
        weight = next(node for node in bsdf if node.get("name") == "weight")
        w = float(weight.get("value"))
        weight.tag = "string"
        weight.attrib.update(name="weights", value=f"{1 - w}, {w}")
    return ElementTree.tostring(root, encoding="unicode")


def register(mi):
    import drjit as dr

    class Matte(mi.BSDF):
        """Something that reflects on its front, drawn by the cosine; value() is f without cosine."""

        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            flags = mi.BSDFFlags.DiffuseReflection | mi.BSDFFlags.FrontSide
            self.m_components = [flags]
            self.m_flags = flags

        @staticmethod
        def is_lit(wi, wo):
            return (mi.Frame3f.cos_theta(wi) > 0) & (mi.Frame3f.cos_theta(wo) > 0)

        def sample(self, ctx, si, sample1, sample2, active):
            bs = dr.zeros(mi.BSDFSample3f)
            bs.wo = mi.warp.square_to_cosine_hemisphere(sample2)
            bs.pdf = mi.warp.square_to_cosine_hemisphere_pdf(bs.wo)
            bs.eta = 1.0
            bs.sampled_type = mi.UInt32(+mi.BSDFFlags.DiffuseReflection)
            bs.sampled_component = 0
            active &= self.is_lit(si.wi, bs.wo) & (bs.pdf > 0)
            return bs, dr.select(active, self.value(si, bs.wo, active) * dr.pi, 0.0)

        def eval(self, ctx, si, wo, active):
            active &= self.is_lit(si.wi, wo)
            return dr.select(active, self.value(si, wo, active) * mi.Frame3f.cos_theta(wo), 0.0)

        def pdf(self, ctx, si, wo, active):
            pdf = mi.warp.square_to_cosine_hemisphere_pdf(wo)
            return dr.select(self.is_lit(si.wi, wo), pdf, 0.0)

        def eval_pdf(self, ctx, si, wo, active):
            return self.eval(ctx, si, wo, active), self.pdf(ctx, si, wo, active)

    class Glossy(Matte):
        def __init__(self, props):
            super().__init__(props)
            self.exponent = props.get("exponent", 30.0)
            self.diffuse = props.get_texture("diffuse_reflectance", 0.5)
            self.specular = props.get_texture("specular_reflectance", 0.2)

        def value(self, si, wo, active):
            return (self.diffuse.eval(si, active) / dr.pi
                    + self.specular.eval(si, active) * self.lobe(si.wi, wo))

    class Phong(Glossy):
        def lobe(self, wi, wo):
            mirrored = mi.Vector3f(-wi.x, -wi.y, wi.z)
            n = self.exponent
            return (n + 2) / (2 * math.pi) * dr.maximum(dr.dot(mirrored, wo), 0)**n

    class BlinnPhong(Glossy):
        def lobe(self, wi, wo):
            n = self.exponent
            scale = (n + 2) * (n + 4) / (8 * math.pi * (2**(-n / 2) + n))
            return scale * dr.maximum(dr.normalize(wi + wo).z, 0)**n

    class RoughDiffuse(Matte):
        def __init__(self, props):
            super().__init__(props)
            self.reflectance = props.get_texture("reflectance", 0.5)
            self.sigma = props.get("alpha", 0.2) / math.sqrt(2)

        def value(self, si, wo, active):
            s2, rho = self.sigma**2, self.reflectance.eval(si, active)
            theta_i, theta_o = dr.acos(si.wi.z), dr.acos(wo.z)
            a, b = dr.maximum(theta_i, theta_o), dr.minimum(theta_i, theta_o)
            cosine = dr.cos(dr.atan2(si.wi.y, si.wi.x) - dr.atan2(wo.y, wo.x))
            c1 = 1 - 0.5 * s2 / (s2 + 0.33)
            c2 = 0.45 * s2 / (s2 + 0.09) * (dr.sin(a) - dr.select(cosine >= 0, 0.0,
                                                                   (2 * b / dr.pi)**3))
            c3 = 0.125 * s2 / (s2 + 0.09) * (4 * a * b / dr.pi**2)**2
            once = (c1 + cosine * c2 * dr.tan(b)
                    + (1 - dr.abs(cosine)) * c3 * dr.tan((a + b) / 2))
            twice = 0.17 * s2 / (s2 + 0.13) * (1 - cosine * (2 * b / dr.pi)**2)
            return (rho * once + rho * rho * twice) / dr.pi

    mi.register_bsdf("phong", Phong)
    mi.register_bsdf("blinnphong", BlinnPhong)
    mi.register_bsdf("roughdiffuse", RoughDiffuse)

    class Mixture(mi.BSDF):
        """Parts by weight; what the weights leave of 1 is black."""

        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            self.parts = [props[k] for k in props.keys() if isinstance(props[k], mi.BSDF)]
            self.weights = [float(x) for x in props["weights"].replace(",", " ").split()]
            self.m_components = [part.flags(i) for part in self.parts
                                 for i in range(part.component_count())]
            self.m_flags = 0
            for flags in self.m_components:
                self.m_flags |= flags

        def sample(self, ctx, si, sample1, sample2, active):
            bs, value, low = dr.zeros(mi.BSDFSample3f), mi.Color3f(0), 0.0
            total = sum(self.weights)
            for part, weight in zip(self.parts, self.weights):
                share = weight / total
                mine = active & (sample1 >= low) & (sample1 < low + share)
                one, v = part.sample(ctx, si, (sample1 - low) / share, sample2, mine)
                bs[mine] = one
                value[mine] = v * total
                bs.pdf[mine] = one.pdf * share
                low += share
            is_delta = mi.has_flag(bs.sampled_type, mi.BSDFFlags.Delta)
            is_smooth = active & ~is_delta & (bs.pdf > 0)
            all_values, all_pdf = self.eval_pdf(ctx, si, bs.wo, is_smooth)
            value[is_smooth] = all_values / all_pdf
            bs.pdf[is_smooth] = all_pdf
            return bs, value

        def eval(self, ctx, si, wo, active):
            return self.eval_pdf(ctx, si, wo, active)[0]

        def pdf(self, ctx, si, wo, active):
            return self.eval_pdf(ctx, si, wo, active)[1]

        def eval_pdf(self, ctx, si, wo, active):
            value, pdf, total = mi.Color3f(0), mi.Float(0), sum(self.weights)
            for part, weight in zip(self.parts, self.weights):
                v, p = part.eval_pdf(ctx, si, wo, active)
                value += weight * v
                pdf += weight / total * p
            return value, pdf

    mi.register_bsdf("mixturebsdf", Mixture)

    class Scaled(mi.Texture):
        def __init__(self, props):
            mi.Texture.__init__(self, props)
            self.factor = props.get("scale", 1.0)
            self.inner = [props[k] for k in props.keys() if isinstance(props[k], mi.Texture)][0]

        def eval(self, si, active):
            return self.inner.eval(si, active) * self.factor

        def mean(self):
            return self.inner.mean() * self.factor

        def is_spatially_varying(self):
            return True

    class Grid(mi.Texture):
        """Lines of color1, line_width of a cell on either side of whole numbers, on color0."""

        def __init__(self, props):
            mi.Texture.__init__(self, props)
            self.colors = props.get_texture("color0", 0.2), props.get_texture("color1", 0.4)
            self.width = props.get("line_width", 0.01)
            place = np.array(props.get("to_uv", mi.ScalarTransform4f()).matrix)
            self.uv_scale = mi.ScalarVector2f(place[0, 0], place[1, 1])

        def eval(self, si, active):
            uv = si.uv * self.uv_scale
            uv = uv - dr.floor(uv)
            x = dr.minimum(uv.x, 1 - uv.x)
            y = dr.minimum(uv.y, 1 - uv.y)
            is_line = (x < self.width) | (y < self.width)
            return dr.select(is_line, self.colors[1].eval(si, active),
                             self.colors[0].eval(si, active))

        def mean(self):
            return self.colors[0].mean()

        def is_spatially_varying(self):
            return True

    mi.register_texture("scale", Scaled)
    mi.register_texture("gridtexture", Grid)
