# shellcheck shell=bash
# Finds launch files of all packages, starts one, and prints what its run has left. bringup.sh sources this file.

# launch_files: prints the path of each launch file that a user starts; those in moved/ only lead to their new place
launch_files() { find src -path '*/launch/*.launch' -not -path '*/launch/include/*' -not -path '*/launch/moved/*' | sort; }

# package_of LAUNCH_FILE: prints the name of its package, which is its folder's
package_of() { basename "$(dirname "$(dirname "$1")")"; }

# find_launch_file [PACKAGE/]NAME[.launch]: prints the path of the only launch file of that name
find_launch_file() {
  local asked=${1%.launch}.launch file found=() calls=()
  while read -r file; do
    case "$(package_of "$file")/$(basename "$file")" in
      "$asked" | */"$asked")
        found+=("$file")
        calls+=("./bringup.sh $(package_of "$file")/$(basename "$file")")
        ;;
    esac
  done < <(launch_files)
  case ${#found[@]} in
    1) echo "${found[0]}" ;;
    0) fail "There is no launch file '$asked' in a package of src, and no other call of that name. See ./bringup.sh --help." ;;
    *) fail "Several packages have a launch file '$asked'. Call one of them:" "${calls[@]}" ;;
  esac
}

# takes_argument LAUNCH_FILE NAME
takes_argument() { grep -q "<arg name=\"$2\"" "$1"; }

# path_of_caller LAUNCH_FILE NAME VALUE: prints the value, as a path from the caller's folder if it is one, because nodes run
# in another folder. The argument's doc tells that it is one: it begins with "file" or "folder", or it speaks of them
# and the value is there, or has a file's ending.
path_of_caller() {
  local doc
  doc=$(tr '\n' ' ' <"$1" | grep -oP "<arg name=\"$2\"[^>]*?doc=\"\K[^\"]*" | head -n 1)
  if [[ $3 == @(./*|../*|"~/"*) ]] || [[ -n $3 && $doc =~ ^((YAML|SDF)\ )?(world\ )?[Ff](ile|older) ]] ||
    { [[ -n $3 && $doc =~ (file|folder|mesh|plan|program) ]] && [[ -e $caller/$3 || $3 =~ \.[a-z]+[0-9]*$ ]]; }; then
    absolute "$3"
  else
    echo "$3"
  fi
}

# check_logs: ends the call if ROS cannot write its logs. roslaunch itself would end in a traceback.
check_logs() {
  local logs=${ROS_LOG_DIR:-${ROS_HOME:-$HOME/.ros}/log}
  { mkdir -p "$logs" && [[ -w $logs ]]; } 2>/dev/null ||
    fail "ROS cannot write its logs to $logs; set ROS_HOME or ROS_LOG_DIR to a folder of yours."
}

# launch FILE [arg:=value ...]: flies, then prints the results; the exit code tells whether the run succeeded
launch() {
  local file=$1 name argument arguments=() given=" " child code=0 package
  name=$(basename "$file")
  package=$(package_of "$file")
  shift
  for argument in "$@"; do
    argument=${argument%%:=*}:=$(path_of_caller "$file" "${argument%%:=*}" "${argument#*:=}")
    given+="${argument%%:=*} "
    arguments+=("$argument")
  done
  check_logs
  set_up --first-flight
  load_workspace
  if takes_argument "$file" results && [[ $given != *" results "* ]]; then
    arguments+=("results:=$root/results")
  fi
  if takes_argument "$file" headless && [[ -z ${DISPLAY:-} && $given != *" headless "* ]]; then
    say "no display is there, so this runs headless"
    arguments+=(headless:=true)
  fi
  if [[ $package == @(flights|master_thesis) ]]; then # those of other packages check their arguments themselves, or take any
    .venv/bin/python -m "${package}_ros.launch.request" "$file" "${arguments[@]}" || exit 1
    export LAUNCH_CHECKED=1
  fi
  RESULTS_NAMED_IN=$(mktemp) # the experiment's node writes its folder there
  export RESULTS_NAMED_IN
  say "roslaunch $package $name ${arguments[*]}"
  set -m # a separate process group, so that Ctrl-C works as roslaunch expects
  roslaunch --no-summary "$package" "$name" "${arguments[@]}" &
  child=$!
  set +m
  trap 'kill -INT "$child" 2>/dev/null' INT TERM
  wait "$child" || code=$?
  while kill -0 "$child" 2>/dev/null; do wait "$child" || code=$?; done
  trap - INT TERM
  report_results "$file" "$code"
}

# report_results LAUNCH_FILE CODE: prints the results of the run that has named its folder in RESULTS_NAMED_IN.
# The exit code is 0 only if roslaunch ended well (CODE 0) and result.json tells a success.
report_results() {
  local folder
  folder=$(<"$RESULTS_NAMED_IN")
  rm -f "$RESULTS_NAMED_IN"
  if [[ -n $folder && -f $folder/result.json ]]; then
    .venv/bin/python scripts/summarise.py "$folder/result.json" "$2"
  elif (($2 != 0)); then
    fail "roslaunch gave up with code $2; the reason stands above."
  elif takes_argument "$1" results; then
    fail "The run ended without a result; ROS's own logs are in ${ROS_LOG_DIR:-${ROS_HOME:-$HOME/.ros}/log}/latest."
  fi
}
