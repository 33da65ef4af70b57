# shellcheck shell=bash
# Makes the machine and the workspace ready: distribution packages, .venv, catkin build. bringup.sh sources this file
# and sets `root` and `log_file`. Every step does only what is missing. .venv needs a single package of the
# distribution. So it is made while the other packages are installed. The build needs only the first of these, so it
# runs while the others are installed.

: "${root:?is set by bringup.sh}" "${log_file:?is set by bringup.sh}"
# shellcheck source=scripts/platform.sh
source "$(dirname "${BASH_SOURCE[0]}")/platform.sh"
readonly interfaces=(geographic_msgs gazebo_msgs trajectory_msgs mavros_msgs octomap_msgs)
readonly venv_package=python3-venv not_for_build="# Not for the build" only_for_tests="# Only for the tests"
readonly apt_install="apt-get install -y --no-install-recommends" apt_patience=(-o DPkg::Lock::Timeout=600 -o Acquire::Retries=3)
# Delete the archives (0.3 GB) and their index (50 MB)
readonly apt_tidy=(-o APT::Keep-Downloaded-Packages=false -o Dir::Cache::pkgcache= -o Dir::Cache::srcpkgcache=)
readonly packages_need_mb=1500 tests_need_mb=500 venv_needs_mb=1800 build_needs_mb=100 # greatest need, with archives; 2020 MB stay

# set_up [--first-flight | --tests]: with the first, numba compiles only what the first flight needs. Every launch
# compiles what is missing for it. With the second, what only the tests need is installed, too.
set_up() {
  [[ $root != *[[:space:]]* ]] || fail "catkin cannot build in a folder with a space in its path: $root. Move the workspace."
  if ! mkdir -p logs 2>/dev/null || [[ ! -w logs || ! -w . ]]; then
    fail "$(id -un) may not write to $root. Change its owner, or clone it elsewhere."
  fi
  exec 9>>logs/.setup.lock
  flock -n 9 || { say "another set-up is at work in this folder; waiting for it" && flock 9; }
  echo "==== $(date '+%F %T') set-up of $root" >>"$log_file"
  check_python_path
  detect_platform
  wanted_until=$only_for_tests
  [[ ${1:-} != --tests ]] || { wanted_until="" && shift; }
  check_disk
  remove_bad_venv
  find_missing_packages
  install_packages "${missing_for_venv[@]}"
  start_python "$@"
  install_packages "${missing_for_build[@]}"
  start_packages "${missing[@]}"
  check_names
  load_underlay
  build_workspace
  finish_packages "${missing[@]}"
  finish_python "$@"
  exec 9>&-
}

# --- the distribution's packages -------------------------------------------------------------------------------

# missing_packages: prints the packages of the list, up to `wanted_until`, that are not installed, one per line
missing_packages() {
  # shellcheck disable=SC2016  # dpkg-query expands it
  local wanted format='${db:Status-Status} ${Package}\n'
  wanted=$(listed_packages "$wanted_until")
  comm -23 <(echo "$wanted") <(xargs <<<"$wanted" dpkg-query -W -f "$format" 2>/dev/null | sed -n 's/^installed //p' | sort)
}

# find_missing_packages: sets `missing_for_venv`, `missing_for_build` and `missing`, makes the package manager ready
# for them
find_missing_packages() {
  missing_for_venv=() missing_for_build=()
  mapfile -t missing < <(missing_packages)
  ((${#missing[@]} > 0)) || return 0
  as_root=(env)
  if ((EUID != 0)); then
    sudo -n true 2>/dev/null || fail "${#missing[@]} packages are missing and this is not root. Run these lines, then call again:" \
      "sudo apt-get update" "sudo $apt_install ${missing[*]}"
    as_root=(sudo -n env)
  fi
  as_root+=(DEBIAN_FRONTEND=noninteractive LC_ALL=C)
  mapfile -t missing_for_build < <(comm -12 <(printf '%s\n' "${missing[@]}") <(listed_packages "$not_for_build"))
  mapfile -t missing < <(comm -23 <(printf '%s\n' "${missing[@]}") <(listed_packages "$not_for_build"))
  [[ " ${missing_for_build[*]} " != *" $venv_package "* ]] || missing_for_venv=("$venv_package")
  "${as_root[@]}" dpkg --configure -a >>"$log_file" 2>&1 || true # in case an earlier call was interrupted
  # Go on after a failed update: the fault of another source may not matter. The installation would fail.
  run_step "looking for the newest packages" "${as_root[@]}" apt-get "${apt_patience[@]}" "${apt_tidy[@]}" update || true
}

# install_packages PACKAGE...
install_packages() {
  start_packages "$@"
  finish_packages "$@"
}

# start_packages, finish_packages PACKAGE...: install them in parallel to the code between both calls
start_packages() {
  (($# > 0)) || return 0
  # shellcheck disable=SC2086  # the same words are printed to users without root rights
  start_step "installing $# package(s) of $platform and what they need" \
    "${as_root[@]}" $apt_install "${apt_patience[@]}" "${apt_tidy[@]}" "$@"
  packages_step=$step
}

finish_packages() {
  (($# > 0)) || return 0
  finish_step "$packages_step" || explain_failure "The distribution's packages could not be installed." "sudo $apt_install $*"
  local not_there
  mapfile -t not_there < <(missing_packages | grep -Fx "$(printf '%s\n' "$@")")
  ((${#not_there[@]} == 0)) || fail "apt-get did not complain, and yet these are not installed: ${not_there[*]}. See $log_file."
}

# check_names: ROS nodes reach each other by host names
check_names() {
  getent hosts localhost >/dev/null && return 0
  local line="127.0.0.1 localhost"
  [[ -w /etc/hosts ]] || fail "The name localhost does not resolve, and ROS needs it. Run: echo '$line' | sudo tee -a /etc/hosts"
  echo "$line" >>/etc/hosts && say "added '$line' to /etc/hosts: ROS needs that name"
}

# check_python_path: Python takes what a folder of PYTHONPATH holds in place of .venv's
check_python_path() {
  local folder package folders
  IFS=: read -ra folders <<<"${PYTHONPATH:-}"
  for folder in "${folders[@]}"; do
    while read -r package; do
      [[ ! -d $folder/$package && ! -f $folder/$package.py ]] || fail \
        "PYTHONPATH names $folder, which holds another $package than .venv: all nodes would take that one. Call: env -u PYTHONPATH ./bringup.sh"
    done < <(sed -n 's/^ *\([A-Za-z0-9_.-]*\)==.*/\1/p' requirements.txt)
  done
}

# --- Python packages -------------------------------------------------------------------------------------------

# venv_inputs: prints a digest of .venv's inputs, with its path, because .venv cannot be moved
venv_inputs() { cat requirements.txt <("$system_python" --version 2>/dev/null) <(echo "$root") | sha256sum; }

# is_current STAMP_FILE DIGEST: whether a step was done with its present inputs
is_current() { [[ -f $1 && $(<"$1") == "$2" ]]; }

# start_python, finish_python [--first-flight]: make .venv and compile numba's kernels, in parallel to the code between
# both calls
start_python() {
  venv_step= kernels_step=
  ! is_current .venv/.bringup "$(venv_inputs)" || return 0
  name_other_python
  growing=.venv start_step "installing Python packages into .venv" make_venv
  venv_step=$step
  start_step "compiling the inner loops" compile_in_new_venv "${step_children[$venv_step]}" "$@"
  kernels_step=$step
}

# finish_venv: waits until .venv is there, which the build needs
finish_venv() {
  [[ -n $venv_step ]] || return 0
  finish_step "$venv_step" || explain_failure "The Python packages of requirements.txt could not be installed."
  venv_step=
  start_step "making the Python packages smaller (their tests and debug symbols)" slim_python # after the compiler's package, which contains `strip`
  slimming_step=$step
}

finish_python() {
  finish_venv
  if [[ -n $kernels_step ]]; then
    finish_step "$kernels_step" || explain_failure "The inner loops could not be compiled."
    finish_step "$slimming_step" || true
  elif [[ ${1:-} != --first-flight ]]; then
    compile_kernels || fail "The inner loops could not be compiled; the reason stands above."
  fi
}

# compile_in_new_venv PROCESS [--first-flight]: waits for the process that makes .venv
compile_in_new_venv() {
  while kill -0 "$1" 2>/dev/null; do sleep 0.5; done
  is_current .venv/.bringup "$(venv_inputs)" || return
  compile_imported && compile_kernels --every 1 "${@:2}"
}

make_venv() {
  local options=()
  # A moved or incomplete environment cannot be repaired. One that works is only updated.
  [[ $(.venv/bin/python -c 'import sys; print(sys.prefix)' 2>/dev/null) == "$root/.venv" ]] || options=(--clear)
  # First without the distribution's Python packages, which may change. Then these become visible, for ROS.
  "$system_python" -m venv "${options[@]}" .venv && install_python_packages &&
    "$system_python" -m venv --system-site-packages --without-pip --upgrade .venv && venv_inputs >.venv/.bringup
}

install_python_packages() {
  local pip=(env -u PYTHONPATH .venv/bin/python -m pip install --no-input --disable-pip-version-check --prefer-binary)
  # Keep archives until all are installed, so that a call after an interruption does not load them again. If the user
  # already has a cache of pip, they stay there.
  [[ -d ${PIP_CACHE_DIR:-${XDG_CACHE_HOME:-$HOME/.cache}/pip} ]] || pip+=(--cache-dir "$root/.venv/.pip")
  "${pip[@]}" --no-compile -r requirements.txt && rm -rf .venv/.pip
}

# slim_python: deletes 0.5 GB of unused parts of packages: example data, debug symbols, their own tests, and pymavlink's
# dialects of rare autopilots
slim_python() {
  local packages package library
  packages=$(.venv/bin/python -c 'import sysconfig; print(sysconfig.get_path("platlib"))') || return
  rm -rf "$packages"/pybullet_data "$packages"/pybullet_envs
  for package in numba numpy pandas scipy matplotlib; do
    # numpy 2 imports a module of its own core's tests in numpy.testing, and scipy imports that
    find "$packages/$package" -depth -type d -name tests -not -path '*/numpy/_core/tests' -exec rm -rf {} +
  done
  find "$packages/pymavlink/dialects" -type f -not -name '__init__.py' -not -name 'all.*' \
    -not -name 'ardupilotmega.*' -not -name 'common.*' -not -name 'minimal.*' -not -name 'standard.*' -delete
  for library in "$packages"/{pybullet,eglRenderer}*.so "$packages"/llvmlite/binding/*.so; do
    # Into a new file, because a process that uses the old one would crash. If stripping fails, it keeps its size.
    if strip --strip-unneeded -o "$library.slim" "$library" 2>/dev/null; then
      chmod --reference="$library" "$library.slim" && mv -f "$library.slim" "$library"
    else
      rm -f "$library.slim"
    fi
  done
}

# compile_imported: compiles our libraries' imports to byte code, so that nodes start faster (all packages: 0.15 GB more)
compile_imported() {
  local libraries=(src/*/src src/{helpers,extensions}/*/src)
  # matplotlib caches its list of fonts. Some may not be installed yet, so do not use the cache in the user's folder
  env PYTHONPATH="$(IFS=: && echo "${libraries[*]/#/$root/}")" MPLCONFIGDIR="$root/.venv/.matplotlib" \
    .venv/bin/python scripts/import_all.py src/*/src/*/ src/{helpers,extensions}/*/src/*/ && rm -rf .venv/.matplotlib
}

# compile_kernels [ARGUMENT...]: lets numba compile what no earlier call has compiled; see machine_code's own help
compile_kernels() {
  local libraries=(src/*/{src,ros} src/{helpers,extensions}/*/{src,ros})
  env PYTHONPATH="$(IFS=: && echo "${libraries[*]/#/$root/}")" .venv/bin/python -m flights_ros.launch.machine_code "$@"
}

# --- the build -------------------------------------------------------------------------------------------------

# load_underlay: lets the workspaces that this one was built upon count in a new shell, too
load_underlay() {
  local prefix
  while read -r prefix; do
    [[ -d $prefix && $prefix != "$root/devel" && :${CMAKE_PREFIX_PATH:-}: != *:$prefix:* ]] || continue
    export CMAKE_PREFIX_PATH=${CMAKE_PREFIX_PATH:+$CMAKE_PREFIX_PATH:}$prefix
  done < <(sed -n "s/^ *CMAKE_PREFIX_PATH = r'\(.*\)'.split.*/\1/p" devel/_setup_util.py 2>/dev/null | tr ';' '\n')
}

# upstream_interfaces: prints our message packages that upstream has installed here; ours are then not built
upstream_interfaces() {
  local package prefix prefixes
  IFS=: read -ra prefixes <<<"${CMAKE_PREFIX_PATH:-}:/usr"
  for package in "${interfaces[@]}"; do
    for prefix in "${prefixes[@]}"; do
      [[ $prefix != "$root/devel" ]] || continue
      # installed packages have the first file, those in another workspace's devel space the second
      if [[ -f $prefix/share/$package/package.xml || -d $prefix/share/$package/cmake ]]; then
        echo "$package"
        break
      fi
    done
  done
}

# build_inputs PRESENT: prints catkin's inputs: a line for what concerns all packages, then one for each package, its
# digest and its folder. Python code is used in place, so it does not count.
build_inputs() {
  local folder
  echo "$root $* $(declare -f write_interpreter build_alone | sha256sum)"
  while read -r folder; do
    echo "$(package_inputs "$folder" | sha256sum | cut -d ' ' -f 1) $folder"
  done < <(find src -name package.xml -printf '%h\n' | sort)
}

# package_inputs FOLDER
package_inputs() {
  find "$1" -type f \( -name package.xml -o -name 'CMakeLists.txt' -o -name setup.py -o -name '*.msg' -o -name '*.srv' \
    -o -name '*.action' -o -name '*.cfg' -o -path '*/env-hooks/*' \) -print0 | sort -z | xargs -0 sha256sum
  find "$1" -path '*/nodes/*' -type f -not -name '*.pyc' | sort
}

# packages_to_build INPUTS: prints the folders of the packages that alone have changed since the last build, or are new.
# Fails if the workspace must be built: never built, another place, a package gone, or one changed that others need.
packages_to_build() {
  local line folder name
  is_built_here && [[ $(head -n 1 <<<"$1") == "$(head -n 1 build/.bringup)" ]] || return
  while read -r _ folder; do [[ -f $folder/package.xml ]] || return; done < <(tail -n +2 build/.bringup)
  while read -r line; do
    folder=${line#* }
    name=$(package_name "$folder")
    # shellcheck disable=SC2046 # no path has spaces
    ! grep -qsE "<[a-z_]*depend[^>]*>\s*$name\s*<" $(find src -name package.xml) || return
    echo "$folder"
  done < <(comm -23 <(tail -n +2 <<<"$1" | sort) <(tail -n +2 build/.bringup | sort))
}

# package_name FOLDER
package_name() { sed -n 's/.*<name>\s*\([^< ]*\)\s*<.*/\1/p' "$1/package.xml" | head -n 1; }

# build_alone FOLDER...: builds packages that no other needs, each with a build folder of its own and the same devel/
build_alone() {
  local folder name
  for folder in "$@"; do
    name=$(package_name "$folder")
    # shellcheck disable=SC1091
    (unset CATKIN_TEST_RESULTS_DIR && set +u && source devel/setup.bash && set -u &&
      cmake -S "$folder" -B "build/alone/$name" -DCATKIN_DEVEL_PREFIX="$root/devel" "${cmake_options[@]}" &&
      cmake --build "build/alone/$name") || return
  done
  echo -n "$root/src" >devel/.catkin # catkin adds each folder that it has built
}

# write_interpreter: makes the interpreter of all nodes. It is .venv's, or says what to do when .venv was deleted.
# Its name and folder are a python3's, because an environment hook may put them on the PATH.
write_interpreter() {
  mkdir -p devel/interpreter
  cat >devel/interpreter/python3 <<TEXT
#!/bin/sh
if [ ! -x "$root/.venv/bin/python" ]; then
  echo "There is no interpreter $root/.venv/bin/python. Call $root/bringup.sh setup, which makes it again." >&2
  exit 127
fi
exec "$root/.venv/bin/python" "\$@"
TEXT
  chmod +x devel/interpreter/python3
}

# leave_out PACKAGES: hides our subsets of these packages (with ; between) from rospack and rosmsg, too
leave_out() {
  local package
  for package in "${interfaces[@]}"; do
    rm -f "src/interfaces/$package/CATKIN_IGNORE"
    [[ ";$1;" != *";$package;"* ]] || touch "src/interfaces/$package/CATKIN_IGNORE"
  done
}

# remove_relays: removes the programs of devel/ whose script is no longer in its package; catkin leaves them there
remove_relays() {
  local relay script
  while IFS=: read -r relay script; do
    script=${script#*\'}
    [[ -f ${script%\'*} ]] || rm -f "$relay"
  done < <(grep -sH "^python_script = '" devel/lib/*/*)
}

# all_sources_exist: whether each package that was built is still in its folder
all_sources_exist() {
  local folder
  while read -r folder; do
    [[ -f $folder/CMakeLists.txt ]] || return # Python leaves its caches in the folder
  done < <(sed -n 's/^[A-Za-z0-9_]*_SOURCE_DIR:STATIC=//p' build/CMakeCache.txt build/alone/*/CMakeCache.txt 2>/dev/null)
}

# is_built_here: whether the last build succeeded, in this folder
is_built_here() { [[ -f build/.bringup ]] && grep -qsx "CMAKE_HOME_DIRECTORY:INTERNAL=$root/src" build/CMakeCache.txt; }

build_workspace() {
  local present inputs
  present=$(upstream_interfaces | paste -sd ';')
  inputs=$(build_inputs "$present")
  ! is_current build/.bringup "$inputs" || return 0
  finish_venv
  # Messages for Python and C++ only, because other languages take time and have no nodes here. Debian 12's catkin reads
  # the first name of the interpreter, Debian 13's the second.
  local changed cmake_options=(-DPYTHON_EXECUTABLE="$root/devel/interpreter/python3"
    -DPython_EXECUTABLE="$root/devel/interpreter/python3" -DCOMPILE_KERNELS=OFF)
  export ROS_LANG_DISABLE=genlisp:geneus:gennodejs
  if changed=$(packages_to_build "$inputs"); then
    mapfile -t changed <<<"$changed"
    remove_relays
    run_step "building ${changed[*]}" build_alone "${changed[@]}" || explain_failure "The build failed."
    echo "$inputs" >build/.bringup
    return
  fi
  [[ -z $present ]] || say "built against the machine's own ${present//;/, }"
  if [[ -f build/CMakeCache.txt ]] && ! grep -qx "CMAKE_HOME_DIRECTORY:INTERNAL=$root/src" build/CMakeCache.txt; then
    rm -rf build devel # from the workspace's earlier place
  fi
  # catkin leaves what it has built before, and our subset would hide upstream's package
  [[ ! -d build || $present == "$(cat build/.upstream 2>/dev/null)" ]] || rm -rf build devel
  # nor does it delete the programs of a package that lies in another folder now
  [[ ! -d build ]] || all_sources_exist || rm -rf build devel
  remove_relays
  write_interpreter
  leave_out "$present"
  run_step "building the workspace" env -u CATKIN_TEST_RESULTS_DIR catkin_make --directory "$root" "${cmake_options[@]}" \
    -DCATKIN_BLACKLIST_PACKAGES="$present" ||
    explain_failure "The build failed."
  echo "$present" >build/.upstream
  echo "$inputs" >build/.bringup
}

# --- when something is missing ---------------------------------------------------------------------------------

# check_disk: checks first that the disk has room for everything missing
check_disk() {
  local on_system=0 on_workspace=0
  [[ -z $(missing_packages) ]] || on_system=$((packages_need_mb + (${#wanted_until} ? 0 : tests_need_mb)))
  [[ -d build ]] || on_workspace=$build_needs_mb
  is_current .venv/.bringup "$(venv_inputs)" || on_workspace=$((on_workspace + venv_needs_mb))
  if [[ $(df -P / | tail -n 1) == "$(df -P "$root" | tail -n 1)" ]]; then
    on_system=$((on_system + on_workspace)) on_workspace=0
  fi
  require_disk / "$on_system"
  require_disk "$root" "$on_workspace"
}

# require_disk FOLDER MEGABYTES
require_disk() {
  local free
  free=$(df -Pm "$1" | awk 'NR == 2 {print $4}')
  ((free >= $2)) || fail "Not enough disk: the set-up needs some $2 MB, and the disk that holds $1 has $free MB left."
}

# explain_failure SENTENCE [COMMAND]: prints the usual reason that matches the log of the last step
explain_failure() {
  local said
  said=$(awk '/^== / { text = "" } { text = text $0 "\n" } END { printf "%s", text }' "$log_file")
  if grep -qiE 'no space left|enough free space' <<<"$said"; then
    fail "$1 The disk is full." "Details: $log_file"
  elif grep -qiE 'temporary failure|could not resolve|unable to connect|could not connect|cannot initiate the connection|failed to establish a new connection|network is unreachable|connection timed out|failed to fetch|unable to locate package|\(from versions: none\)' <<<"$said"; then
    fail "$1 No package registry answers: check the network, or the proxy settings, and call again." "Details: $log_file"
  elif grep -qE 'Could not get lock' <<<"$said"; then
    fail "$1 Another package manager is at work; call again when it is done." "Details: $log_file"
  fi
  tail -n 15 "$log_file" >&2
  fail "$1 The lines above are the end of $log_file." "${@:2}"
}
