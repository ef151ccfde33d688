#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# install.sh SOURCE_DIR BUILD_DIR: installs into an empty prefix, moves the prefix, builds
# examples/minimal.c with it by pkg-config and by CMake, and runs it on a scene of two rectangles.
set -eu
source=$(cd "$1" && pwd)
build=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cmake --install "$build" --prefix "$work/first" >"$work/install.log"
mv "$work/first" "$work/prefix"
prefix=$work/prefix

cat >"$work/scene.xml" <<'XML'
<scene version="3.0.0">
    <integrator type="path"><integer name="max_depth" value="4"/></integrator>
    <sensor type="perspective">
        <transform name="to_world">
            <lookat origin="0, 3, 6" target="0, 1, 0" up="0, 1, 0"/>
        </transform>
    </sensor>
    <shape type="rectangle">
        <transform name="to_world"><rotate x="1" angle="-90"/><scale value="4"/></transform>
        <bsdf type="diffuse"/>
    </shape>
    <shape type="rectangle">
        <transform name="to_world">
            <rotate x="1" angle="90"/><translate x="0" y="4" z="0"/>
        </transform>
        <emitter type="area"><rgb name="radiance" value="5"/></emitter>
    </shape>
</scene>
XML

picture() { # picture PROGRAM NAME
    LD_LIBRARY_PATH="$prefix/lib" "$1" "$work/scene.xml" "$work/$2.png"
    [ -s "$work/$2.png" ]
}

# A user's prefix is not where the compiler looks, so pkg-config has to say it.
export PKG_CONFIG_PATH="$prefix/lib/pkgconfig"
cc -std=c99 -Wall -Wextra -pedantic -Werror "$source/examples/minimal.c" \
    $(pkg-config --cflags --libs lumenaut) -o "$work/by_pkg_config"
picture "$work/by_pkg_config" first

mkdir "$work/consumer"
cat >"$work/consumer/CMakeLists.txt" <<'CMAKE'
cmake_minimum_required(VERSION 3.25)
project(consumer LANGUAGES C)
find_package(lumenaut 0.1 REQUIRED)
add_executable(by_cmake ${EXAMPLE})
target_link_libraries(by_cmake PRIVATE lumenaut::lumenaut)
CMAKE
cmake -G Ninja -S "$work/consumer" -B "$work/consumer/build" -DCMAKE_PREFIX_PATH="$prefix" \
    -DEXAMPLE="$source/examples/minimal.c" >"$work/cmake.log"
cmake --build "$work/consumer/build" >>"$work/cmake.log"
picture "$work/consumer/build/by_cmake" second
cmp "$work/first.png" "$work/second.png"

# The tool runs from the prefix, with the prefix's library.
LD_LIBRARY_PATH= "$prefix/bin/lumenaut" --version
