# SPDX-License-Identifier: Apache-2.0
"""Spack recipe. In a checkout: spack repo add packaging/spack && spack dev-build grtx-tlm@1.1.0

Not built. Names, and that each range below holds a version, were checked against spack-packages at 1e8cf059 (2026-07-01):
of SystemC it has 2.3.3 alone, of pagmo2 2.18.0, of toml++ 3.4.0; of fmt versions to 12.1.0, of which the tests have run
with 9 and 10.
"""
from spack.package import *


class GrtxTlm(CMakePackage):
    """Transaction-level model of ray-tracing hardware for 3D Gaussians: a tracer in C++20 writes what every ray did, and a
    SystemC model replays it, cycle by cycle, on a GPU with caches and DRAM, and prices it in area and energy."""

    homepage = "https://grtx-tlm.invalid"  # RELEASING.md, "Before the first"
    git = "https://grtx-tlm.invalid/grtx-tlm.git"

    license("Apache-2.0")

    version("1.1.0", tag="v1.1.0")

    variant("shared", default=False, description="Build the libraries as shared ones")
    variant("frontend", default=True, description="Build scenes and tracer")
    variant("program", default=True, when="+frontend", description="Build the program grtx, sweeps and searches")

    depends_on("cxx", type="build")
    depends_on("cmake@3.25:", type="build")
    depends_on("ninja", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("python@3.9:", type="build")

    depends_on("systemc@2.3.3: cxxstd=17")
    depends_on("fmt@9:")
    depends_on("zstd@1.5:")
    depends_on("xxhash@0.8:")
    depends_on("nlohmann-json@3.11:")
    depends_on("tomlplusplus@3.3:")
    with when("+frontend"):
        depends_on("embree@3.13:4")
        depends_on("glm@0.9.9.8:")
        depends_on("intel-tbb@2021:")  # the virtual package tbb has no versions; pagmo2 asks for this one, too
        depends_on("libpng@1.6:")
        depends_on("openexr@3.1:")
        depends_on("zlib-api")
        depends_on("libwebp@1.2:")
        depends_on("libzip@1.7:")
    with when("+program"):
        depends_on("sqlite@3.40:")
        depends_on("pagmo2@2.18:")
        depends_on("cli11@2.1:")

    generator("ninja")
    conflicts("%gcc@:11", msg="GCC 12 or later is needed")
    conflicts("%clang@:13", msg="Clang 14 or later is needed")

    def cmake_args(self):
        program = self.spec.satisfies("+program")
        parts = ["LAB", "VIEW", "STUDY", "APPS"]
        return [
            self.define_from_variant("BUILD_SHARED_LIBS", "shared"),
            self.define_from_variant("GRTX_BUILD_FRONTEND", "frontend"),
            self.define("GRTX_BUILD_TESTS", False),
            self.define("GRTX_REPORT_CHARTS", False),  # they come by npm
            self.define("CMAKE_UNITY_BUILD", True),
        ] + [self.define("GRTX_BUILD_" + part, program) for part in parts]
