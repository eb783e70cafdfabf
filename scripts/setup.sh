#!/usr/bin/env bash
# Installs the packages of Debian 12 that Tetrec needs and that are missing; touches nothing else.
# Exit codes: 0 all are installed, 4 something is missing and cannot be installed from here.
set -euo pipefail

# One package per line: its name, then what needs it.
packages() {
  cat <<'LIST'
make                        chains the stages
cmake                       build
ninja-build                 build
g++                         build
ccache                      build: makes the next one quick
git                         the revision that manifests record; the list of files to check
python3                     scripts/check_includes, scripts/fetch_dataset
python3-jsonschema          scripts/check_datasets: the descriptions of data sets
ca-certificates             fetching data sets over https
libfmt-dev                  core: formatting
nlohmann-json3-dev          core: JSON
libcli11-dev                command: command lines
libssl-dev                  core: SHA-256
libsqlite3-dev              colmap: its database
zlib1g-dev                  volume: compressed volumes; image: colour profiles in PNG files
libglm-dev                  geometry: vectors and matrices
libopencv-core-dev          image, eval: images
libopencv-imgproc-dev       image, eval: images
libopencv-imgcodecs-dev     image, eval: image files
libjpeg-dev                 image: finds damage that OpenCV passes over
libtiff-dev                 image: TIFF files
liblcms2-dev                image: colour profiles
libboost-dev                start: minimum cuts
libcgal-dev                 mesh: Delaunay tetrahedralization
libopenmesh-dev             surface: clean-up
libnanoflann-dev            eval: nearest points
libjs-three                 eval: the report's 3-D scene
pkg-config                  build: finds cpp-httplib
libcpp-httplib-dev          view: the web server
libvulkan-dev               gpu: headers and loader
mesa-vulkan-drivers         gpu: lavapipe, a Vulkan device for machines without a GPU
glslang-tools               shaders: GLSL to SPIR-V
vulkan-validationlayers     tests: any message of the validation layer fails a test
libgtest-dev                tests
libgmock-dev                tests
librapidcheck-dev           tests: random cases
libceres-dev                tests: automatic derivatives
libeigen3-dev               eval: alignment; required by Ceres and CGAL
libbenchmark-dev            benchmarks
assimp-utils                tests: reads exported surfaces
python3-meshio              tests: reads exported fields
chromium-driver             tests: opens the report in a browser
python3-selenium            tests: opens the report in a browser
clang                       tests: sanitizers and fuzz targets
libclang-rt-14-dev          tests: their runtime libraries
llvm                        tests: names of functions in their reports
clang-format                tests: format check
colmap                      tetrec-sfm runs it
libheif-examples            tetrec-sfm runs its heif-convert for HEIC photos; tests: heif-enc
tetgen                      tetrec-tetrahedralize --start tetgen runs it
gnuplot-nox                 tetrec-chart runs it
ffmpeg                      tetrec-sfm VIDEO and tetrec-render --path run it
LIST
}

is_installed() {
  [ "$(dpkg-query -W -f '${db:Status-Abbrev}' "$1" 2>/dev/null | cut -c1-2)" = ii ]
}

all=$(packages | awk '{print $1}')

if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
  echo "setup: this is not a Debian system; install the counterparts of these packages of Debian 12:"
  packages | sed 's/^/  /'
  exit 4
fi

missing=()
for package in $all; do
  is_installed "$package" || missing+=("$package")
done
if [ ${#missing[@]} -eq 0 ]; then
  echo "setup: all $(wc -w <<<"$all") packages are installed"
  exit 0
fi

. /etc/os-release
if [ "${ID:-}" != debian ] || [ "${VERSION_ID:-}" != 12 ]; then
  echo "setup: this is ${PRETTY_NAME:-unknown}, not Debian 12; package names may differ" >&2
fi

install="apt-get install -y --no-install-recommends ${missing[*]}"
if [ "$(id -u)" -eq 0 ]; then
  as_root=()
elif command -v sudo >/dev/null && sudo -n true 2>/dev/null; then
  as_root=(sudo -n)
else
  echo "setup: ${#missing[@]} packages are missing, and installing them requires root; run this, then try again:" >&2
  echo "  sudo sh -c 'apt-get update && $install'" >&2
  exit 4
fi

echo "setup: installing ${#missing[@]} packages: ${missing[*]}"
export DEBIAN_FRONTEND=noninteractive
# sudo drops the environment, hence `env`.
run_apt() { "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q "$@"; }
if ! run_apt update || ! run_apt install -y --no-install-recommends "${missing[@]}"; then
  echo "setup: apt-get failed (see above); fix the cause and run: $install" >&2
  exit 4
fi
for package in "${missing[@]}"; do
  if ! is_installed "$package"; then
    echo "setup: $package is still missing after apt-get; run: $install" >&2
    exit 4
  fi
done
echo "setup: done"
