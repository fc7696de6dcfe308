# shellcheck shell=bash
# SPDX-License-Identifier: Apache-2.0
# Sourced by tools/run and tools/test: brings a fresh machine to where the project works.
# All of it lands in build/, progress goes to stderr, and what is there already costs nothing.

camturn_root=$(cd -P "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/.." && pwd)

# The matrices here are small: threads of the linear algebra would only wait for each other, and how
# many there are would show in last digits.
export OPENBLAS_NUM_THREADS=1

# Python compiles a module once, into build/, whatever the environment asks for.
unset PYTHONDONTWRITEBYTECODE
export PYTHONPYCACHEPREFIX=$camturn_root/build/pycache

# Our modules only: another path would come before the packages of build/venv.
export PYTHONPATH=$camturn_root/tools:$camturn_root

# Results are equal to the bit by the project's own options alone.
unset CFLAGS CPPFLAGS LDFLAGS

# cmake unpacks archives by wrong names in a path with an umlaut, when the locale is C.
export LC_ALL=C.UTF-8

camturn_say() { printf 'camturn: %s\n' "$*" >&2; }

# A tree of somebody else, or one in which another user has built before, cannot be built in.
camturn_writable() {
    local place
    for place in "$camturn_root/build" "$camturn_root"/build/{venv,host}{,.lock}; do
        [[ -e $place || -L $place ]] || continue
        [[ -w $place ]] && continue
        camturn_say "$place cannot be written by $(id -un), it belongs to $(stat -c %U "$place" 2>/dev/null):" \
            "use a clone of your own, or let the owner give it to you (chown -R)"
        exit 2
    done
    if ! mkdir -p "$camturn_root/build" 2>/dev/null; then
        camturn_say "$camturn_root cannot be written by $(id -un), it belongs to $(stat -c %U "$camturn_root"):" \
            "use a clone of your own, in a folder that you may write to"
        exit 2
    fi
}
camturn_writable

# What proves that a Debian package is not needed: its command or library, wherever it came from.
camturn_has() {
    case $1 in
    ninja-build) command -v ninja ;;
    xz-utils) command -v xz ;;
    busybox-static) command -v busybox ;;
    iproute2) command -v ip || command -v /sbin/ip ;;
    can-utils) command -v candump ;;
    libc6-dev) gcc -E -x c - <<<'#include <stdio.h>' ;;
    gcc-arm-none-eabi) command -v arm-none-eabi-gcc ;;
    libnewlib-arm-none-eabi) arm-none-eabi-gcc -E -x c - <<<'#include <stdio.h>' ;;
    frama-c-base) command -v frama-c ;;
    libclang-rt-14-dev) clang -fsanitize=fuzzer -x c -o /dev/null - <<<'int LLVMFuzzerTestOneInput(void) { return 0; }' ;;
    libcjson-dev) pkg-config --exists libcjson ;;
    libinih-dev) pkg-config --exists inih ;;
    dpkg-dev) command -v dpkg-shlibdeps ;;
    libgpiod-dev) pkg-config --exists libgpiod ;;
    gpiod) command -v gpioset ;;
    python3-venv) "$(camturn_python)" -c 'import ensurepip, venv' ;;
    *) command -v "$1" ;;
    esac >/dev/null 2>&1
}

# camturn_apt PKG...: install those Debian packages that are missing, or say which they are.
camturn_apt() {
    local package sudo=() missing=()
    for package in "$@"; do
        camturn_has "$package" || missing+=("$package")
    done
    ((${#missing[@]})) || return 0

    if [[ $EUID -ne 0 ]]; then
        sudo=(sudo -n)
    fi
    if ! command -v apt-get >/dev/null || ! "${sudo[@]}" true 2>/dev/null; then
        camturn_say "please install (names of Debian packages): ${missing[*]}"
        exit 2
    fi
    camturn_say "installing ${missing[*]}"
    local apt=("${sudo[@]}" env "DEBIAN_FRONTEND=noninteractive" apt-get -qq -o "DPkg::Lock::Timeout=300")
    if ! { "${apt[@]}" update && "${apt[@]}" install -y --no-install-recommends "${missing[@]}"; } \
        </dev/null >"$camturn_root/build/apt.log" 2>&1; then
        tail -n 5 "$camturn_root/build/apt.log" >&2
        camturn_say "apt-get could not install: ${missing[*]} (all of it in build/apt.log)"
        exit 2
    fi
}

# The first Python on the path that is new enough.
camturn_python() {
    local python
    for python in python3 python3.14 python3.13 python3.12 python3.11; do
        if "$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
            command -v "$python"
            return
        fi
    done
    return 1
}

# camturn_venv GROUP...: build/venv with the packages of tools/locked.py's groups; exports CAMTURN_PYTHON.
# tools/requirements.lock names all of it, so pip need not look for more.
camturn_venv() {
    export CAMTURN_PYTHON=$camturn_root/build/venv/bin/python
    (
        flock 9
        # Twice: a group that changed starts over, without what an earlier group had put there.
        for group in "$@" "$@"; do
            camturn_venv_group "$group"
        done
    ) 9>"$camturn_root/build/venv.lock"
}

camturn_venv_group() {
    local venv=$camturn_root/build/venv lock=$camturn_root/tools/requirements.lock
    local want stamp=$camturn_root/build/venv/$1.stamp unfinished=$camturn_root/build/venv/unfinished

    want="$(sha256sum <"$lock") $("$CAMTURN_PYTHON" -V 2>/dev/null || true)"
    if [[ ! -e $unfinished && -f $stamp && $(<"$stamp") == "$want" ]]; then
        return 0
    fi
    # A stamp that differs or an interrupted installation: start over, since pip does not repair.
    if [[ -e $unfinished || -f $stamp || ! -x $CAMTURN_PYTHON ]]; then
        camturn_apt python3
        camturn_python >/dev/null || {
            camturn_say "please install Python 3.11 or newer"
            exit 2
        }
        camturn_apt python3-venv
        camturn_say "creating build/venv"
        rm -rf "$venv"
        mkdir "$venv"
        touch "$unfinished"
        "$(camturn_python)" -m venv --without-pip "$venv"
    fi
    camturn_say "installing the Python packages of the group $1"
    touch "$unfinished"
    "$CAMTURN_PYTHON" "$camturn_root/tools/locked.py" "$1" >"$venv/$1.txt"
    if ! camturn_install "$venv/$1.txt"; then
        camturn_say "the packages of the group $1 could not be installed; when the network is back, just start again"
        exit 2
    fi
    printf '%s %s' "$(sha256sum <"$lock")" "$("$CAMTURN_PYTHON" -V)" >"$stamp"
    rm "$unfinished"
}

# Of a list take what it pins, as wheels.
camturn_pinned=(--require-hashes --no-deps --only-binary :all:)

# camturn_pip FILE: install the packages of a list by pip out of the wheel that comes with Python's
# ensurepip or Debian's python3-venv. Unpacking pip costs more processor time than all packages of the
# group base.
camturn_pip() {
    local bundled wheel
    bundled=$("$CAMTURN_PYTHON" -c 'import ensurepip; print(*ensurepip.__path__)')/_bundled
    for wheel in "$bundled"/pip-*.whl /usr/share/python-wheels/pip-*.whl; do
        [[ ! -e $wheel ]] || break
    done
    "$CAMTURN_PYTHON" "$wheel/pip" install -q --no-compile --disable-pip-version-check --no-input \
        "${camturn_pinned[@]}" -r "$1" </dev/null >&2
}

# camturn_install FILE: install the packages of a list by uv, or by pip where uv does not come through.
camturn_install() {
    local uv=$camturn_root/build/venv/bin/uv
    if [[ ! -x $uv ]]; then
        "$CAMTURN_PYTHON" "$camturn_root/tools/locked.py" install >"$1.uv" && camturn_pip "$1.uv" || true
    fi
    "$uv" pip install -q --no-cache --python "$CAMTURN_PYTHON" "${camturn_pinned[@]}" -r "$1" \
        </dev/null >"$1.log" 2>&1 || camturn_pip "$1"
}

# camturn_build PRESET [TARGET]: configure when needed, and build everything or one target.
camturn_build() {
    local log=$camturn_root/build/$1.log
    (
        flock 9
        if ! camturn_cmake "$@" 3>&2 >"$log" 2>&1; then
            cat "$log" >&2
            camturn_say "build/$1 failed (see above, or build/$1.log); rm -r build/$1 if a file in it is damaged"
            exit 1
        fi
    ) 9>"$camturn_root/build/$1.lock"
}

camturn_cmake() {
    local dir=$camturn_root/build/$1
    cd "$camturn_root" || return
    # The simulator alone needs neither Unity nor the programs of the tests. A build folder that was left
    # half-configured or is damaged, or that moved with its clone, starts afresh.
    local testing=ON
    [[ ${2-} == @(simulator|judge_library) ]] && testing=OFF
    if ! ninja -C "$dir" -t query all >/dev/null 2>&1 ||
        ! grep -sqxF "CMAKE_HOME_DIRECTORY:INTERNAL=$camturn_root" "$dir/CMakeCache.txt"; then
        camturn_say "configuring and building build/$1" 2>&3
        cmake --preset "$1" --fresh -D "BUILD_TESTING=$testing" || return
    elif [[ $testing == ON ]] && grep -qxF BUILD_TESTING:BOOL=OFF "$dir/CMakeCache.txt"; then
        cmake --preset "$1" -D BUILD_TESTING=ON || return
    fi
    cmake --build --preset "$1" -j "$(nproc)" ${2:+--target "$2"}
}

# camturn_setup GROUP...: what every command of ours needs, with the Python packages of the groups.
camturn_setup() {
    camturn_apt gcc libc6-dev cmake ninja-build git pkg-config xz-utils libcjson-dev libinih-dev
    camturn_venv "$@"
    export CAMTURN_BUILD=$camturn_root/build/host
}
