#!/bin/sh
# Installs the header libraries that a wheel is built with, for cibuildwheel's machines. The
# versions are the same everywhere: another Eigen sums in another order, and searches end elsewhere.
set -eu

install_headers() { # a repository, a tag, CMake's options
  folder=$(mktemp -d)
  git -c advice.detachedHead=false clone -q --depth 1 --branch "$2" "$1" "$folder/source"
  repository=$1 tag=$2
  shift 2
  # These versions ask for policies older than those CMake 4 still has.
  cmake -S "$folder/source" -B "$folder/build" -DBUILD_TESTING=OFF \
    -DCMAKE_POLICY_VERSION_MINIMUM=3.5 "$@" >/dev/null
  cmake --install "$folder/build" --prefix "${HEADERS_PREFIX:-/usr/local}" >/dev/null
  rm -rf "$folder"
  echo "installed $repository, $tag"
}

install_headers https://gitlab.com/libeigen/eigen.git 3.4.0 -DEIGEN_BUILD_DOC=OFF
install_headers https://github.com/nlohmann/json.git v3.11.3 -DJSON_BuildTests=OFF
install_headers https://github.com/CLIUtils/CLI11.git v2.1.2 -DCLI11_BUILD_TESTS=OFF \
  -DCLI11_BUILD_EXAMPLES=OFF -DCLI11_BUILD_DOCS=OFF
