# SPDX-License-Identifier: Apache-2.0
# The same bytes from any number of threads; with any instruction set the same picture up to rounding,
# which moves few paths: 1e-4 of the whole, 1e-3 of a pixel on average.
root=$here/../..
trace() { # trace OUT OPTION...
    out=$1
    shift
    "$lumenaut" trace -o "$out" -q --size 64x64 --spp 16 "$@"
}
apart() { # apart A.pfm B.pfm
    /usr/bin/python3 -c 'import array, sys
def pixels(path):
    with open(path, "rb") as f:
        head = [f.readline() for _ in range(3)]
        return array.array("f", f.read())
a, b = map(pixels, sys.argv[1:])
each = sum(abs(x - y) / max(abs(y), 1e-3) for x, y in zip(a, b)) / len(a)
whole = abs(sum(a) / sum(b) - 1)
if len(a) != len(b) or not each < 1e-3 or not whole < 1e-4:
    sys.exit(f"{sys.argv[1:]}: pixels are {each:.1e} apart, the whole {whole:.1e}")' "$@"
}
for scene in "$root/scenes/demo/scene.xml" "$root/scenes/tests/roughdielectric_ggx.xml" \
    "$root/scenes/tests/principled_glass.xml" "$root/scenes/tests/instance.xml" \
    "$root/scenes/tests/envmap.xml"; do
    trace one.pfm -t 1 "$scene"
    for threads in 2 3 0; do
        trace many.pfm -t $threads "$scene"
        cmp one.pfm many.pfm
    done
    for mask in baseline avx2 avx512 avx512bf16 amx; do
        trace mask.pfm --cpu-mask $mask "$scene"
        apart mask.pfm one.pfm
    done
done
scene=$root/scenes/demo/scene.xml
for options in "--buffers --half-buffers" "--light-groups" "--sampler independent" "--integrator path+photons"; do
    trace one.exr -t 1 $options "$scene"
    trace two.exr -t 2 $options "$scene"
    cmp one.exr two.exr
done
echo "all agree"
