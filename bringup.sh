#!/usr/bin/env bash
# The entry: makes the machine ready (once), then flies, tests or measures. See `./bringup.sh --help`.
set -euo pipefail

caller=$PWD # relative paths of arguments are the caller's
root=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd -P)
log_file=$root/logs/bringup.log
# Debian's ROS needs Debian's Python, even if another one is first on the user's PATH.
# shellcheck disable=SC2034  # name_other_python reads it
caller_path=$PATH
export PATH="/usr/sbin:/usr/bin:/sbin:/bin:$PATH"
unset PYTHONHOME
export HOME=${HOME:-$(getent passwd "$(id -u)" | cut -d: -f6)} # ROS and pip need it; services and containers may have none
# Images for containers often set this. Then every node would compile its own sources at each start.
unset PYTHONDONTWRITEBYTECODE
cd "$root"
# shellcheck source=scripts/console.sh
source scripts/console.sh
# shellcheck source=scripts/setup.sh
source scripts/setup.sh
# shellcheck source=scripts/launch.sh
source scripts/launch.sh
# shellcheck source=scripts/docs.sh
source scripts/docs.sh

usage() {
  cat <<'TEXT'
./bringup.sh                                     fly Experiment 1 in the forest with CEPA's algorithm dynamic; print where the results are
./bringup.sh <launch file> [arg:=value ...]      start a launch file with its arguments (PACKAGE/FILE where two packages have one)
./bringup.sh test [pytest arguments]             run the tests, four at a time; arguments go to pytest (-n 0: one at a time)
./bringup.sh test --all                          run the long flights and more examples of each property, too, as CI does
./bringup.sh test --changed [REF]                run the tests that changes since REF (main) can touch; say what is left out
./bringup.sh bench [name [arguments]]            run all benchmarks, or one (--help lists them; NAME --help prints its arguments)
./bringup.sh report [--quick] [--only NAME ...]  fly every experiment of the thesis; write our results beside the thesis's as HTML
./bringup.sh docs                                build the handbook: all pages as HTML, with search, in results/handbook; no server is needed
./bringup.sh setup                               set up only; then `source devel/setup.bash` and use roslaunch, rosrun, ...

Each call first sets up what is missing: distribution packages, .venv, build. Details go to logs/bringup.log.
TEXT
  echo
  echo "Launch files (\`roslaunch --ros-args PACKAGE FILE\` prints the arguments of one):"
  local file
  for file in $(launch_files); do # the first sentence of its comment
    printf '  %-38s %s\n' "$(package_of "$file")/$(basename "$file")" "$(tr '\n' ' ' <"$file" | sed -E 's/^[^-]*<!-- *//; s/ *-->.*//; s/ +/ /g; s/\. .*/./')"
  done
}

# load_workspace: does `source devel/setup.bash` and gives ROS an address that resolves
load_workspace() {
  set +u
  # shellcheck disable=SC1091
  source devel/setup.bash
  set -u
  if [[ -z ${ROS_IP:-}${ROS_HOSTNAME:-} ]] && ! getent hosts "$(hostname)" >/dev/null; then
    export ROS_IP=127.0.0.1 # the machine's own name does not resolve
  fi
  export PYTHONUNBUFFERED=1 # so that a node's output appears at once, also in a pipe or a file
}

# absolute PATH: makes a path absolute, from the caller's folder
absolute() {
  # shellcheck disable=SC2088 # after an argument's := the shell does not expand a tilde
  case $1 in
    /*) echo "$1" ;;
    "~/"*) echo "$HOME/${1#"~/"}" ;;
    *) echo "$caller/$1" ;;
  esac
}

# run_tests [--changed [REF]] [ARGUMENT ...]: runs the tests, or those that changes since REF can touch
run_tests() {
  local since=() chosen
  set_up --tests
  (set_up_docs) || say "the tests that build the handbook are skipped"
  if [[ ${1:-} == --changed ]]; then
    shift
    [[ -z ${1:-} || $1 == -* ]] || { since=("$1") && shift; }
    chosen=$(env PYTHONPATH=scripts .venv/bin/python -m changed_tests "${since[@]}") || exit 1
    [[ -n $chosen ]] || return 0
    mapfile -t chosen <<<"$chosen"
    set -- "${chosen[@]}" "$@"
  fi
  load_workspace
  # Tests write only here, and their scripts run on .venv's Python, like the nodes.
  rm -rf logs/test
  export ROS_HOME=$root/logs/test ROS_LOG_DIR=$root/logs/test/log PATH="$root/.venv/bin:$PATH"
  mkdir -p "$ROS_LOG_DIR"
  # conftest.py orders the files and says how many at a time. The caller's arguments take precedence: -n 0 for --pdb, ...
  exec .venv/bin/python -m pytest -n auto --dist loadfile --no-loadscope-reorder "$@"
}

# list_benchmarks: prints the name of each benchmark, and the first line of what it says of itself
list_benchmarks() {
  local file
  echo "./bringup.sh bench            run all, shortened"
  echo "./bringup.sh bench NAME ...   run one; NAME --help prints its arguments"
  echo
  for file in benchmarks/[!_]*.py; do
    printf '  %-18s %s\n' "$(basename "$file" .py)" "$(sed -n '1s/^"""//;1s/"""$//;1p' "$file")"
  done
}

# run_benchmarks [NAME [ARGUMENT ...]]: runs benchmarks/NAME.py; without a name all, shortened
run_benchmarks() {
  local name='[!_]*' benchmarks benchmark code=0
  case ${1:-} in
    -h | --help) list_benchmarks && return ;;
    --soak*) set -- sim "$@" ;;
  esac
  if [[ -n ${1:-} && $1 != -* ]]; then
    name=$1
    shift
  else
    set -- --brief "$@"
  fi
  mapfile -t benchmarks < <(find benchmarks -maxdepth 1 -name "$name.py" 2>/dev/null | sort)
  ((${#benchmarks[@]} > 0)) || fail "There is no benchmark of the name $name: benchmarks/ holds no $name.py. See ./bringup.sh bench --help."
  set_up
  load_workspace
  for benchmark in "${benchmarks[@]}"; do
    benchmark=$(basename "$benchmark" .py)
    say "benchmark $benchmark"
    # As a module, because benchmarks/cepa.py, run by its path, would hide the package cepa
    .venv/bin/python -m "benchmarks.$benchmark" "$@" || code=1
  done
  return "$code"
}

# run_report [ARGUMENT ...]: see its --help
run_report() {
  local arguments=(--out "$root/results/report") argument previous=""
  for argument in "$@"; do
    case $previous$argument in
      --out=?*) argument=--out=$(absolute "${argument#--out=}") ;;
      --out?*) argument=$(absolute "$argument") ;;
    esac
    arguments+=("$argument")
    previous=
    [[ $argument != --out ]] || previous=--out
  done
  set_up
  load_workspace
  exec .venv/bin/python -m master_thesis.chapter_8 "${arguments[@]}"
}

main() {
  case ${1:-} in
    "") launch src/master_thesis/launch/experiment_1.launch scenario:=forest algorithm:=dynamic ${DISPLAY:+rviz:=true} ;;
    -h | --help | help) usage ;;
    setup)
      set_up
      say "ready; 'source devel/setup.bash' and use roslaunch, rosrun, rosbag as you like"
      ;;
    test) run_tests "${@:2}" ;;
    bench) run_benchmarks "${@:2}" ;;
    report) run_report "${@:2}" ;;
    docs) run_docs "${@:2}" ;;
    *)
      local file
      file=$(find_launch_file "$1") || exit 1
      launch "$file" "${@:2}"
      ;;
  esac
}

main "$@"
